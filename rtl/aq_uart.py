"""Aq uart (Fig. 2): the 64-bit register with positions and torques, sent most significant byte first.

::

    63..56      55..40            39..24            23..13          12..2           1..0
    identifier  joint-1 position  joint-2 position  joint-1 torque  joint-2 torque  zero
"""

from amaranth.hdl import Cat, Const, Module, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from rtl.uart import Transmitter

IDENTIFIER = 0xA5


class AqUart(wiring.Component):
    """Sends a frame when `start`; positions are sent modulo 2^16."""

    def __init__(self, divisor: int) -> None:
        self._divisor = divisor
        super().__init__(
            {
                "start": In(1),
                "position": In(signed(32)).array(2),
                "tau": In(signed(11)).array(2),
                "tx": Out(1, init=1),
            }
        )

    def elaborate(self, platform: object) -> Module:
        """Build the register and count its bytes."""
        m = Module()
        m.submodules.transmitter = transmitter = Transmitter(self._divisor)
        frame, left = Signal(64), Signal(range(9))
        m.d.comb += [
            transmitter.data.eq(frame[56:]),
            transmitter.valid.eq(left != 0),
            self.tx.eq(transmitter.tx),
        ]
        with m.If(self.start):
            zero, identifier = Const(0, 2), Const(IDENTIFIER, 8)
            positions = (self.position[1][:16], self.position[0][:16])
            m.d.sync += [frame.eq(Cat(zero, self.tau[1], self.tau[0], *positions, identifier)), left.eq(8)]
        with m.Elif(transmitter.ready & (left != 0)):
            m.d.sync += [frame.eq(frame << 8), left.eq(left - 1)]
        return m
