"""Fp ops (Fig. 2): the floating-point operations that the PD block shares, one at a time.

Numbers are IEEE 754 binary, single precision unless the format is given, with subnormals; results are rounded to
nearest, ties to even. Every operation works on one register pair, a bit a clock, because the board has 250,000 clocks
for some twenty operations.

The working value is (-1)^sign x (acc / 2^(W-1)) x 2^(exponent - bias) with the W-bit integer `acc`, so `acc` with its
top bit set is a normal significand. Bits shifted out on the right are OR-ed into the lowest bit ("sticky").
"""

import enum

from amaranth.hdl import Cat, Const, Module, Mux, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out


class Op(enum.IntEnum):
    """Operation of the unit."""

    ADD = 0
    SUB = 1
    MUL = 2
    FROM_INT = 3  # two's complement integer to float
    TO_INT = 4  # float to integer; saturates, NaN gives 0


class FpOps(wiring.Component):
    """Sequential unit: `start` takes the operands, `done` marks the one clock in which `result` is new."""

    def __init__(self, exponent_bits: int = 8, fraction_bits: int = 23, integer_bits: int = 32) -> None:
        self._e, self._f, self._i = exponent_bits, fraction_bits, integer_bits
        self.width = max(1 + exponent_bits + fraction_bits, integer_bits)
        super().__init__(
            {
                "op": In(3),
                "a": In(self.width),
                "b": In(self.width),
                "start": In(1),
                "done": Out(1),
                "result": Out(self.width),
            }
        )

    def elaborate(self, platform: object) -> Module:
        """Build the state machine."""
        m = Module()
        e, f, i = self._e, self._f, self._i
        w = max(2 * (f + 1), i + 2)  # a whole product, or an integer with two bits to round by
        bias, special = 2 ** (e - 1) - 1, 2**e - 1
        whole = bias + i - 1  # exponent at which the top `i` bits of acc are an integer

        op, a, b = Signal(3), Signal(self.width), Signal(self.width)
        # The operands: sign, exponent (a subnormal has that of the smallest normal), significand with hidden bit.
        sign_a, sign_b = a[e + f], b[e + f] ^ (op == Op.SUB)
        field_a, field_b = a[f : f + e], b[f : f + e]
        exponent_a, exponent_b = field_a | (field_a == 0), field_b | (field_b == 0)
        significand_a = Cat(a[:f], field_a != 0)
        significand_b = Cat(b[:f], field_b != 0)
        nan_a, nan_b = ((x[f : f + e] == special) & x[:f].any() for x in (a, b))
        inf_a, inf_b = ((x[f : f + e] == special) & ~x[:f].any() for x in (a, b))

        sign, sign_of_zero, subtract = Signal(), Signal(), Signal()
        exponent = Signal(signed(e + 2))
        acc, other = Signal(w), Signal(w)
        distance = Signal(range(max(2**e, f + 2)))
        half, sticky = acc[w - f - 2], acc[: w - f - 2].any()
        rounded = Signal(e + f + 2)  # exponent field and fraction; a carry of the fraction raises the exponent
        m.d.sync += rounded.eq(((exponent - 1) << f) + acc[w - f - 1 :] + (half & (sticky | acc[w - f - 1])))
        magnitude = Signal(i + 1)
        m.d.sync += magnitude.eq(acc[w - i :] + (acc[w - i - 1] & (acc[: w - i - 1].any() | acc[w - i])))
        largest = Signal(i)  # of the integer's magnitudes
        m.d.comb += largest.eq(2 ** (i - 1) - 1 + sign)
        difference = Signal(w + 1)
        m.d.comb += difference.eq(Mux(subtract, acc - other, acc + other))
        infinity, nan = Const(special << f, e + f), (special << f) | (1 << (f - 1))

        m.d.sync += self.done.eq(0)
        with m.FSM():
            with m.State("IDLE"):
                with m.If(self.start):
                    m.d.sync += [op.eq(self.op), a.eq(self.a), b.eq(self.b)]
                    m.next = "UNPACK"
            with m.State("UNPACK"):
                m.d.sync += [sign.eq(sign_a), exponent.eq(exponent_a), subtract.eq(0)]
                m.next = "IDLE"
                with m.Switch(op):
                    with m.Case(Op.FROM_INT):
                        m.d.sync += [sign.eq(0), sign_of_zero.eq(0), exponent.eq(whole), acc.eq(a[:i] << (w - i))]
                        m.next = "NORMALISE"
                        with m.If(a[i - 1]):
                            m.next = "NEGATE"
                    with m.Case(Op.TO_INT):
                        m.d.sync += acc.eq(significand_a << (w - f - 1))
                        m.next = "SHIFT"
                        with m.If(nan_a):
                            m.d.sync += [self.result.eq(0), self.done.eq(1)]
                            m.next = "IDLE"
                    with m.Case(Op.MUL):
                        m.d.sync += [
                            sign.eq(sign_a ^ sign_b),
                            sign_of_zero.eq(sign_a ^ sign_b),
                            exponent.eq(exponent_a + exponent_b - (bias - 1)),
                            acc.eq(significand_b),
                            other.eq(significand_a),
                            distance.eq(f + 1),
                        ]
                        m.next = "MULTIPLY"
                        zero = ~significand_a.any() | ~significand_b.any()
                        with m.If(nan_a | nan_b | ((inf_a | inf_b) & zero)):
                            m.d.sync += [self.result.eq(nan), self.done.eq(1)]
                            m.next = "IDLE"
                        with m.Elif(inf_a | inf_b):
                            m.d.sync += [self.result.eq(Cat(infinity, sign_a ^ sign_b)), self.done.eq(1)]
                            m.next = "IDLE"
                    with m.Default():
                        # The operand with the larger exponent goes to acc, one bit below the top for a carry.
                        swap = exponent_a < exponent_b
                        m.d.sync += [
                            sign.eq(Mux(swap, sign_b, sign_a)),
                            sign_of_zero.eq(sign_a & sign_b),
                            subtract.eq(sign_a ^ sign_b),
                            exponent.eq(Mux(swap, exponent_b, exponent_a) + 1),
                            acc.eq(Mux(swap, significand_b, significand_a) << (w - f - 2)),
                            other.eq(Mux(swap, significand_a, significand_b) << (w - f - 2)),
                            distance.eq(Mux(swap, exponent_b - exponent_a, exponent_a - exponent_b)),
                        ]
                        m.next = "ALIGN"
                        with m.If(nan_a | nan_b | (inf_a & inf_b & (sign_a ^ sign_b))):
                            m.d.sync += [self.result.eq(nan), self.done.eq(1)]
                            m.next = "IDLE"
                        with m.Elif(inf_a | inf_b):
                            m.d.sync += [self.result.eq(Cat(infinity, Mux(inf_a, sign_a, sign_b))), self.done.eq(1)]
                            m.next = "IDLE"
            with m.State("MULTIPLY"):
                # The lowest bit of the second factor decides whether the first is added to the upper half.
                upper = acc[f + 1 : 2 * f + 2] + Mux(acc[0], other[: f + 1], 0)
                m.d.sync += [acc.eq(Cat(acc[1 : f + 1], upper)), distance.eq(distance - 1)]
                with m.If(distance == 1):
                    m.next = "PLACE"
            with m.State("PLACE"):
                m.d.sync += acc.eq(acc << (w - 2 * (f + 1)))
                m.next = "NORMALISE"
            with m.State("ALIGN"):
                with m.If((distance == 0) | ~other[1:].any()):
                    m.next = "ADD"
                with m.Else():
                    m.d.sync += [other.eq(Cat(other[1] | other[0], other[2:])), distance.eq(distance - 1)]
            with m.State("ADD"):
                m.d.sync += acc.eq(difference)
                m.next = "NORMALISE"
                with m.If(subtract & difference[w]):
                    m.next = "NEGATE"
            with m.State("NEGATE"):
                m.d.sync += [acc.eq(-acc), sign.eq(~sign)]
                m.next = "NORMALISE"
            with m.State("NORMALISE"):
                with m.If(acc == 0):
                    m.d.sync += [exponent.eq(1), sign.eq(sign_of_zero)]
                    m.next = "ROUND"
                with m.Elif(exponent < 1):  # a subnormal result
                    m.d.sync += [acc.eq(Cat(acc[1] | acc[0], acc[2:])), exponent.eq(exponent + 1)]
                with m.Elif(~acc[w - 1] & (exponent > 1)):
                    m.d.sync += [acc.eq(acc << 1), exponent.eq(exponent - 1)]
                with m.Else():
                    m.next = "ROUND"
            with m.State("ROUND"):
                m.next = "PACK"
            with m.State("PACK"):
                overflow = rounded[f:] >= special
                m.d.sync += self.result.eq(Cat(Mux(overflow, infinity, rounded)[: e + f], sign))
                m.d.sync += self.done.eq(1)
                m.next = "IDLE"
            with m.State("SHIFT"):
                with m.If((exponent == whole) | (acc[1:] == 0)):
                    m.next = "INTEGER"
                with m.Elif(exponent > whole):  # beyond every integer
                    m.d.sync += acc.eq(2**w - 1)
                    m.next = "INTEGER"
                with m.Else():
                    m.d.sync += [acc.eq(Cat(acc[1] | acc[0], acc[2:])), exponent.eq(exponent + 1)]
            with m.State("INTEGER"):
                m.next = "LIMIT"
            with m.State("LIMIT"):
                limited = Mux(magnitude > largest, largest, magnitude)[:i]
                m.d.sync += [self.result.eq(Mux(sign, -limited, limited)), self.done.eq(1)]
                m.next = "IDLE"
        return m
