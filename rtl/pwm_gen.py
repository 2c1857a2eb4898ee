"""PWM gen (Fig. 2): two pulsed signals from the torque of a joint, one for each direction.

A 32-bit phase advances by round(f x 2^32 / f_clock) a clock, so the PWM frequency f is exact on average and its period
to one clock. With 1023 slots in a period, slot = floor(phase x 1023 / 2^32), the output is high in |tau| of them: one
count is 1/1023 = 0.0978 % of the duty cycle.
"""

from amaranth.hdl import Module, Mux, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out


class PwmGen(wiring.Component):
    """Pulses of one joint: `forward` for a positive torque, `backward` for a negative one."""

    def __init__(self) -> None:
        super().__init__({"tau": In(signed(11)), "phase_step": In(32), "forward": Out(1), "backward": Out(1)})

    def elaborate(self, platform: object) -> Module:
        """Build phase and comparison."""
        m = Module()
        phase, slot, high = Signal(32), Signal(10), Signal()
        m.d.sync += [phase.eq(phase + self.phase_step), slot.eq(((phase << 10) - phase) >> 32)]
        magnitude = Signal(10)
        m.d.comb += magnitude.eq(Mux(self.tau < 0, -self.tau, self.tau))
        m.d.comb += high.eq(slot < magnitude)
        m.d.sync += [self.forward.eq(high & (self.tau > 0)), self.backward.eq(high & (self.tau < 0))]
        return m
