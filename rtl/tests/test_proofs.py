"""Proofs for all inputs and all time, each of which fails once its block is broken."""

import pytest
from amaranth.hdl import Assert, Cat, ClockDomain, Instance, Module, Mux, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In

from rtl import decoder, fp_ops, h_bridge, pd, uart
from rtl.tests.proof import broken, verdict


class Property(wiring.Component):
    """A module whose clock domain is never reset but at power-up."""

    def module(self):
        m = Module()
        m.domains.sync = ClockDomain(reset_less=True)
        return m


class EveryEdge(Property):
    """The decoder counts every edge, even one in every clock, three clocks after it came."""

    def __init__(self, make):
        self._make = make
        super().__init__({"edge": In(1), "up": In(1)})

    def elaborate(self, platform):
        m = self.module()
        m.submodules.decoder = block = self._make()
        age, count = Signal(3), Signal(signed(32))
        late = [Signal(signed(32), name=f"count_{i}") for i in range(3)]
        with m.If(age != 7):
            m.d.sync += age.eq(age + 1)
        with m.If(self.edge & (age == 7)):
            m.d.sync += count.eq(Mux(self.up, count + 1, count - 1))
        m.d.sync += [new.eq(old) for new, old in zip(late, [count, *late], strict=False)]
        m.d.comb += [block.a.eq(count[0] ^ count[1]), block.b.eq(count[1])]
        m.d.comb += Assert(block.position == late[2])
        return m


class EveryByte(Property):
    """What the transmitter takes the receiver gives, once, in order and within the time of a byte."""

    def __init__(self, make_transmitter, make_receiver, divisor=6):
        self._blocks = make_transmitter(divisor), make_receiver(divisor)
        self._longest = 9 * divisor + divisor // 2 + 3
        super().__init__({"data": In(8), "valid": In(1)})

    def elaborate(self, platform):
        m = self.module()
        m.submodules.transmitter, m.submodules.receiver = transmitter, receiver = self._blocks
        waiting, age, byte = Signal(), Signal(range(self._longest + 1)), Signal(8)
        m.d.comb += [
            transmitter.data.eq(self.data),
            transmitter.valid.eq(self.valid),
            receiver.rx.eq(transmitter.tx),
            receiver.ready.eq(1),
            Assert(receiver.valid == (waiting & (age == self._longest))),
        ]
        with m.If(receiver.valid):
            m.d.comb += Assert(receiver.data == byte)
            m.d.sync += waiting.eq(0)
        with m.If(waiting):
            m.d.sync += age.eq(age + 1)
        with m.If(self.valid & transmitter.ready):
            m.d.sync += [byte.eq(self.data), waiting.eq(1), age.eq(0)]
        return m


class OneSide(Property):
    """A bridge is never driven on both sides, and both are off for `PAUSE` clocks between them."""

    PAUSE = 3

    def __init__(self, make):
        self._make = make
        super().__init__({"forward": In(1), "backward": In(1)})

    def elaborate(self, platform):
        m = self.module()
        m.submodules.bridge = bridge = self._make(self.PAUSE, 2)
        m.d.comb += [bridge.forward.eq(self.forward), bridge.backward.eq(self.backward)]
        recent_1, recent_2 = Signal(self.PAUSE), Signal(self.PAUSE)
        m.d.sync += [recent_1.eq(Cat(bridge.in1, recent_1)), recent_2.eq(Cat(bridge.in2, recent_2))]
        m.d.comb += [
            Assert(~(bridge.in1 & bridge.in2)),
            Assert(~(bridge.in1 & recent_2.any())),
            Assert(~(bridge.in2 & recent_1.any())),
        ]
        return m


class TorqueWithin(Property):
    """Whatever the floating-point unit gives, no torque leaves +-1023."""

    def __init__(self, make):
        self._make = make
        super().__init__({"start": In(1), "first": In(1), "done": In(1), "result": In(32)})

    def elaborate(self, platform):
        m = self.module()
        m.submodules.pd = block = self._make(100e6)
        m.d.comb += [block.start.eq(self.start), block.first.eq(self.first)]
        m.d.comb += [block.fp_done.eq(self.done), block.fp_result.eq(self.result)]
        m.d.comb += [Assert((tau >= -1023) & (tau <= 1023)) for tau in block.tau]
        return m


class IsSymfpu(Property):
    """An operation, from reset, gives what Yosys' generated IEEE unit gives; any NaN equals any other."""

    def __init__(self, make, op, exponent_bits, fraction_bits):
        self._make, self._op, self._e, self._f = make, op, exponent_bits, fraction_bits
        width = 1 + exponent_bits + fraction_bits
        super().__init__({"a": In(width), "b": In(width)})

    def elaborate(self, platform):
        m = self.module()
        e, f = self._e, self._f
        m.submodules.unit = unit = self._make(e, f, 1 + e + f)
        expected, started = Signal(1 + e + f), Signal()
        a, b = Signal.like(self.a), Signal.like(self.b)  # as they were at the start
        m.submodules.symfpu = Instance("symfpu", i_a=a, i_b=b, i_c=0, i_rm=0, o_o=expected)
        m.d.sync += started.eq(1)
        with m.If(~started):
            m.d.sync += [a.eq(self.a), b.eq(self.b)]
        m.d.comb += [unit.a.eq(self.a), unit.b.eq(self.b), unit.op.eq(self._op), unit.start.eq(~started)]
        nan = [x[f : f + e].all() & x[:f].any() for x in (unit.result, expected)]
        with m.If(unit.done):
            m.d.comb += Assert(Mux(nan[1], nan[0], unit.result == expected))
        return m


PROOFS = {
    "every edge": (lambda block: EveryEdge(block), decoder.Decoder, 8),
    "one side": (lambda block: OneSide(block), h_bridge.HBridge, 8),
    "torque": (lambda block: TorqueWithin(block), pd.PD, 2),
    "receiver": (lambda block: EveryByte(uart.Transmitter, block), uart.Receiver, 66),
}
BROKEN = {
    "every edge": ("decoder", "now[0] ^ before[1]", "now[0] ^ before[0]"),
    "one side": ("h_bridge", "own.eq(self._pause - 1)", "own.eq(self._pause - 2)"),
    "torque": ("pd", "Mux(value > LIMIT,", "Mux(value > LIMIT + 1,"),
    "receiver": ("uart", "self._divisor // 2 - 1", "self._divisor * 2 - 1"),
}


@pytest.mark.parametrize("name", PROOFS)
def test_property_holds_and_fails_for_a_broken_block(name, tmp_path):
    make, block, depth = PROOFS[name]
    assert verdict(tmp_path, make(block), "prove", depth) == "PASS"
    worse = broken(*BROKEN[name])[block.__name__]
    assert verdict(tmp_path, make(worse), "bmc", 2 * depth + 10) == "FAIL"


OPERATIONS = {"add": fp_ops.Op.ADD, "sub": fp_ops.Op.SUB, "mul": fp_ops.Op.MUL}


@pytest.mark.parametrize("name", OPERATIONS)
def test_operation_is_symfpus(name, tmp_path):
    e, f = 3, 4
    before = f"symfpu -op {name} -eb {e} -sb {f + 1} -rm RNE\nchformal -assert -remove symfpu"
    for make, expected in (
        (fp_ops.FpOps, "PASS"),
        (broken("fp_ops", "(half & (sticky | acc[w - f - 1]))", "half")["FpOps"], "FAIL"),
    ):
        assert verdict(tmp_path, IsSymfpu(make, OPERATIONS[name], e, f), "bmc", 40, before) == expected
