"""Aq time (Fig. 2): the sampling clock of 400 Hz."""

from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out


class AqTime(wiring.Component):
    """Marks sampling instants: `start` is one, and then every `period` clocks while `running`."""

    def __init__(self, period: int) -> None:
        self._period = period
        super().__init__({"start": In(1), "running": In(1), "sample": Out(1)})

    def elaborate(self, platform: object) -> Module:
        """Build the counter."""
        m = Module()
        left = Signal(range(self._period))
        m.d.comb += self.sample.eq(self.running & (left == 0))
        with m.If(self.start | self.sample):
            m.d.sync += left.eq(self._period - 1)
        with m.Else():
            m.d.sync += left.eq(left - 1)
        with m.If(self.start):
            m.d.sync += left.eq(0)
        return m
