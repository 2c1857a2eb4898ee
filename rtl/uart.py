"""The serial line of Aq uart and Write Ram: 8 data bits, no parity, one stop bit, least significant bit first."""

from amaranth.hdl import Cat, Const, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.cdc import FFSynchronizer
from amaranth.lib.wiring import In, Out


class Transmitter(wiring.Component):
    """Sends `data` when `valid` and `ready`; `divisor` clocks a bit."""

    def __init__(self, divisor: int) -> None:
        self._divisor = divisor
        super().__init__({"data": In(8), "valid": In(1), "ready": Out(1), "tx": Out(1, init=1)})
        # Bits still to send and clocks until the next; what follows the bit that is sent.
        self.bits, self.left, self.shift = Signal(range(11)), Signal(range(divisor)), Signal(9)

    def elaborate(self, platform: object) -> Module:
        """Build the shift register."""
        m = Module()
        bits, left, shift = self.bits, self.left, self.shift
        m.d.comb += self.ready.eq(bits == 0)
        with m.If(bits == 0):
            with m.If(self.valid):
                m.d.sync += [self.tx.eq(0), shift.eq(Cat(self.data, Const(1, 1)))]
                m.d.sync += [bits.eq(10), left.eq(self._divisor - 1)]
        with m.Elif(left == 0):
            m.d.sync += [bits.eq(bits - 1), left.eq(self._divisor - 1)]
            with m.If(bits != 1):
                m.d.sync += [self.tx.eq(shift[0]), shift.eq(shift >> 1)]
        with m.Else():
            m.d.sync += left.eq(left - 1)
        return m


class Receiver(wiring.Component):
    """Puts each byte into `data` and keeps it `valid` until `ready`; a byte without its stop bit is dropped.

    Bits are read at their middle, counted from the edge of the start bit. So the two clocks may differ by half a bit
    within ten, 5 %.
    """

    def __init__(self, divisor: int) -> None:
        self._divisor = divisor
        super().__init__({"rx": In(1), "data": Out(8), "valid": Out(1), "ready": In(1)})
        # Bits still to read and clocks until the next; the newest eight bits.
        self.bits, self.left, self.shift = Signal(range(11)), Signal(range(divisor)), Signal(8)

    def elaborate(self, platform: object) -> Module:
        """Build the shift register."""
        m = Module()
        rx = Signal(init=1)
        m.submodules.synchronizer = FFSynchronizer(self.rx, rx, init=1, stages=2)
        bits, left, shift = self.bits, self.left, self.shift
        with m.If(self.ready):
            m.d.sync += self.valid.eq(0)
        with m.If(bits == 0):
            with m.If(~rx):
                m.d.sync += [bits.eq(10), left.eq(self._divisor // 2 - 1)]
        with m.Elif(left == 0):
            m.d.sync += [bits.eq(bits - 1), left.eq(self._divisor - 1)]
            with m.If((bits == 10) & rx):  # a disturbance, no start bit
                m.d.sync += bits.eq(0)
            with m.Elif(bits == 1):
                with m.If(rx):
                    m.d.sync += [self.data.eq(shift), self.valid.eq(1)]
            with m.Else():
                m.d.sync += shift.eq(Cat(shift[1:], rx))
        with m.Else():
            m.d.sync += left.eq(left - 1)
        return m
