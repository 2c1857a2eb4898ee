"""Decoder (Fig. 2): the position of a joint from its quadrature encoder, in a 32-bit register.

The encoder's channels A and B change one at a time, in the order 00, 10, 11, 01 for a rising position: every change is
one count. Two flip-flops bring each channel into the clock domain. Both channels changing within one clock is no
motion that an encoder can make, and is not counted. Counting begins once the synchronisers have the level of the pins.
"""

from amaranth.hdl import Cat, Module, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.cdc import FFSynchronizer
from amaranth.lib.wiring import In, Out


class Decoder(wiring.Component):
    """Counts the edges of one encoder; an edge is in `position` three clocks after it came."""

    def __init__(self) -> None:
        super().__init__({"a": In(1), "b": In(1), "position": Out(signed(32))})

    def elaborate(self, platform: object) -> Module:
        """Build synchronisers and counter."""
        m = Module()
        now, before = Signal(2), Signal(2)
        m.submodules.synchronizer = FFSynchronizer(Cat(self.a, self.b), now, stages=2)
        m.d.sync += before.eq(now)
        # In the order of a rising position the new A differs from the old B, in the order of a falling one it does not.
        changed = (now ^ before).xor()
        settling = Signal(2, init=3)
        with m.If(settling != 0):
            m.d.sync += settling.eq(settling - 1)
        with m.Elif(changed & (now[0] ^ before[1])):
            m.d.sync += self.position.eq(self.position + 1)
        with m.Elif(changed):
            m.d.sync += self.position.eq(self.position - 1)
        return m
