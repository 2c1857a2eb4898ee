"""Proofs for all inputs and all time, each of which fails once its block is broken."""

import pytest
from amaranth.hdl import Assert, Assume, Cat, Module, Mux, ResetSignal, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In

from rtl import decoder, h_bridge, pd, uart
from rtl.tests.proof import broken, verdict


class Property(wiring.Component):
    """A module that is never reset but at power-up."""

    def module(self):
        m = Module()
        m.d.comb += Assume(~ResetSignal())
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

    DIVISOR = 8

    def __init__(self, make_transmitter, make_receiver):
        self._blocks = make_transmitter(self.DIVISOR), make_receiver(self.DIVISOR)
        super().__init__({"data": In(8), "valid": In(1)})

    def elaborate(self, platform):
        m = self.module()
        m.submodules.transmitter, m.submodules.receiver = transmitter, receiver = self._blocks
        m.d.comb += [
            transmitter.data.eq(self.data),
            transmitter.valid.eq(self.valid),
            receiver.rx.eq(transmitter.tx),
            receiver.ready.eq(1),
        ]
        end = 10 * self.DIVISOR
        clock, byte = Signal(range(end + 1)), Signal(8)  # clocks since a byte was taken, 0 for none
        with m.If(transmitter.ready & self.valid):
            m.d.sync += [clock.eq(1), byte.eq(self.data)]
        with m.Elif((clock == 0) | (clock == end)):
            m.d.sync += clock.eq(0)
        with m.Else():
            m.d.sync += clock.eq(clock + 1)
        bit = (clock - 1)[3:7]
        frame = Cat(0, byte, 1)
        m.d.comb += [
            # The statement.
            Assert(receiver.valid == (clock == end)),
            Assert((receiver.data == byte) | ~receiver.valid),
            # The states that can be reached.
            Assert(clock <= end),
            Assert(receiver.bits == Mux(clock < 4, 0, 10 - clock[3:])),
        ]
        with m.If((clock == 0) | (transmitter.bits == 0)):
            m.d.comb += [Assert(transmitter.ready & transmitter.tx), Assert((clock == 0) | (clock > end - 1))]
        with m.Else():
            m.d.comb += [
                Assert(transmitter.bits == 10 - bit),
                Assert(transmitter.left == 7 - (clock - 1)[:3]),
                Assert(transmitter.tx == frame.bit_select(bit, 1)),
                Assert((transmitter.shift << (bit + 1))[:10] == (frame >> (bit + 1)) << (bit + 1)),
            ]
        with m.If(receiver.bits != 0):
            m.d.comb += Assert(receiver.left == 7 - clock[:3])
        read = (clock >> 3) - 1  # data bits that have been read
        with m.If((clock >= 2 * self.DIVISOR) & (read <= 8)):
            m.d.comb += Assert(receiver.shift >> (8 - read)[:4] == byte & ((1 << read[:4]) - 1))
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


PROOFS = {
    "every edge": (EveryEdge, decoder.Decoder, 8),
    "one side": (OneSide, h_bridge.HBridge, 8),
    "torque": (TorqueWithin, pd.PD, 2),
    "receiver": (lambda block: EveryByte(uart.Transmitter, block), uart.Receiver, 6),
    "transmitter": (lambda block: EveryByte(block, uart.Receiver), uart.Transmitter, 6),
}
BROKEN = {
    "every edge": ("decoder", "now[0] ^ before[1]", "now[0] ^ before[0]"),
    "one side": ("h_bridge", "own.eq(self._pause - 1)", "own.eq(self._pause - 2)"),
    "torque": ("pd", "Mux(value > LIMIT,", "Mux(value > LIMIT + 1,"),
    "receiver": ("uart", "self._divisor // 2 - 1", "self._divisor // 4 - 1"),
    "transmitter": ("uart", "shift.eq(shift >> 1)", "shift.eq(shift >> 2)"),
}


@pytest.mark.parametrize("name", PROOFS)
def test_property_holds_and_fails_for_a_broken_block(name, tmp_path):
    make, block, depth = PROOFS[name]
    assert verdict(tmp_path, make(block), "prove", depth) == "PASS"
    worse = broken(*BROKEN[name])[block.__name__]
    assert verdict(tmp_path, make(worse), "bmc", 2 * depth + 10) == "FAIL"
