"""H bridge (Fig. 2): the inputs of a motor's H bridge, with a pause between the directions, and the bridge's clock.

Between the two sides both are off for at least `pause` clocks, so the transistors of one leg never conduct together.
The paper names "a necessary clock signal" without its frequency: here it is a square wave of `2 x half_period` clocks.
"""

from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out


class HBridge(wiring.Component):
    """Drives one bridge: `in1` for forward, `in2` for backward."""

    def __init__(self, pause: int, half_period: int) -> None:
        self._pause, self._half_period = pause, half_period
        super().__init__({"forward": In(1), "backward": In(1), "in1": Out(1), "in2": Out(1), "clock": Out(1)})

    def elaborate(self, platform: object) -> Module:
        """Build pauses and clock."""
        m = Module()
        since_1, since_2 = (Signal(range(self._pause), name=name) for name in ("since_1", "since_2"))
        for output, request, own, other, other_output in (
            (self.in1, self.forward & ~self.backward, since_1, since_2, self.in2),
            (self.in2, self.backward & ~self.forward, since_2, since_1, self.in1),
        ):
            # `own`: clocks for which the other side must still wait after this one.
            m.d.sync += output.eq(request & (other == 0) & ~other_output)
            with m.If(output):
                m.d.sync += own.eq(self._pause - 1)
            with m.Elif(own != 0):
                m.d.sync += own.eq(own - 1)
        left = Signal(range(self._half_period))
        with m.If(left == 0):
            m.d.sync += [left.eq(self._half_period - 1), self.clock.eq(~self.clock)]
        with m.Else():
            m.d.sync += left.eq(left - 1)
        return m
