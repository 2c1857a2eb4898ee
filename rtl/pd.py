"""PD (Fig. 3): Eq. 2 with saturation for one joint after the other, on the shared floating-point unit.

For each joint, with every line rounded to single precision::

    q   = float(position) x (2 pi / 8400)
    u   = K_p x (q_d - q) - K_v x (q - q_before)        q_before = q at the first sample: the arm starts at rest
    tau = saturate(round(u), L)                         L = 1023

and the step of the PWM's phase per clock, round(f x 2^32 / f_clock), from the PWM frequency f (see `pwm_gen`).
"""

import math
import struct
from enum import IntEnum

from amaranth.hdl import Array, Module, Mux, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from rtl.fp_ops import Op

#: Largest torque, PWM counts: L_1 and L_2 of Fig. 3.
LIMIT = 1023
#: Encoder counts in a turn of a joint.
COUNTS_PER_TURN = 8400


def single(value: float) -> int:
    """Give the bits of a number in single precision."""
    return int.from_bytes(struct.pack(">f", value))


class Step(IntEnum):
    """Operations of one joint, in their order."""

    CONVERT = 0
    SCALE = 1
    ERROR = 2
    PROPORTIONAL = 3
    MOTION = 4
    DERIVATIVE = 5
    CONTROL = 6
    ROUND = 7
    FREQUENCY = 8
    PHASE = 9


class PD(wiring.Component):
    """Controller: `start` takes one sample of both joints, `done` marks the clock in which the torques are new."""

    def __init__(self, clock_hz: float) -> None:
        self._phase_per_hz = single(2**32 / clock_hz)
        super().__init__(
            {
                "start": In(1),
                "first": In(1),  # this is the first sample of a motion
                "position": In(signed(32)).array(2),
                "desired": In(32).array(2),  # tryd
                "kp": In(32).array(2),  # of ctrlv, as are the next two
                "kv": In(32).array(2),
                "pwm_hz": In(32).array(2),
                "fp_op": Out(3),
                "fp_a": Out(32),
                "fp_b": Out(32),
                "fp_start": Out(1),
                "fp_done": In(1),
                "fp_result": In(32),
                "tau": Out(signed(11)).array(2),
                "phase_step": Out(32).array(2),
                "done": Out(1),
            }
        )

    def elaborate(self, platform: object) -> Module:
        """Build the sequence of operations."""
        m = Module()
        step, joint = Signal(range(len(Step))), Signal()
        q, held, u = Signal(32), Signal(32), Signal(32)  # held: the operand that a later step needs
        before = Array([Signal(32, name="before_1"), Signal(32, name="before_2")])
        position, desired, kp, kv, pwm_hz = (
            Mux(joint, pair[1], pair[0]) for pair in (self.position, self.desired, self.kp, self.kv, self.pwm_hz)
        )
        result = self.fp_result
        resolution = single(2.0 * math.pi / COUNTS_PER_TURN)
        operations = {
            Step.CONVERT: (Op.FROM_INT, position, 0, q),
            Step.SCALE: (Op.MUL, q, resolution, q),
            Step.ERROR: (Op.SUB, desired, q, u),
            Step.PROPORTIONAL: (Op.MUL, kp, u, held),
            Step.MOTION: (Op.SUB, q, Mux(self.first, q, before[joint]), u),
            Step.DERIVATIVE: (Op.MUL, kv, u, u),
            Step.CONTROL: (Op.SUB, held, u, u),
            Step.ROUND: (Op.TO_INT, u, 0, u),
            Step.FREQUENCY: (Op.MUL, pwm_hz, self._phase_per_hz, u),
            Step.PHASE: (Op.TO_INT, u, 0, u),
        }
        with m.Switch(step):
            for name, (op, a, b, target) in operations.items():
                with m.Case(name):
                    m.d.comb += [self.fp_op.eq(op), self.fp_a.eq(a), self.fp_b.eq(b)]
                    with m.If(self.fp_done):
                        m.d.sync += target.eq(result)
        m.d.sync += [self.done.eq(0), self.fp_start.eq(0)]
        with m.If(self.start):
            m.d.sync += [step.eq(0), joint.eq(0), self.fp_start.eq(1)]
        with m.Elif(self.fp_done):
            m.d.sync += [step.eq(step + 1), self.fp_start.eq(1)]
            for i in range(2):
                with m.If(joint == i):
                    with m.If(step == Step.MOTION):
                        m.d.sync += before[i].eq(q)
                    with m.If(step == Step.ROUND):
                        m.d.sync += self.tau[i].eq(saturate(result.as_signed()))
                    with m.If(step == Step.PHASE):
                        m.d.sync += self.phase_step[i].eq(result)
            with m.If(step == Step.PHASE):
                m.d.sync += [step.eq(0), joint.eq(1)]
                with m.If(joint):
                    m.d.sync += [self.fp_start.eq(0), self.done.eq(1)]
        return m


def saturate(value: Signal) -> Mux:
    """Limit a torque to +-`LIMIT` counts."""
    return Mux(value > LIMIT, LIMIT, Mux(value < -LIMIT, -LIMIT, value[:11].as_signed()))
