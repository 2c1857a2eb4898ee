"""The closed loop of board and arm, compiled: one recording in milliseconds.

The reference is `repro.board.plant` with its quick method behind `repro.board.controller`; a test compares the counts.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from repro.board.controller import ControlConstants
from repro.board.frames import PWM_LIMIT, RADIANS_PER_COUNT
from repro.board.plant import SLOW_STEPS, Unmodelled
from repro.model.dynamics import LAMBDA
from repro.model.parameters import Array


@njit(cache=True)
def _slope(x, tau1, tau2, p, out):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Fill `out` with the derivative of (q1, q2, dq1, dq2) under the torques; `p` is made by `record`."""
    q1, q2, dq1, dq2 = x
    s2, load = math.sin(q2), p[4] * math.sin(q1 + q2)
    r1 = tau1 - p[3] * math.sin(q1) - load - p[5] * dq1
    r2 = tau2 - load - p[6] * dq2
    # Coulomb friction with its increase near standstill, and with what the commanded torque adds.
    r1 -= (p[7] * (1.0 + p[9]) + p[15] * abs(tau1)) * math.tanh(LAMBDA * dq1) - p[7] * p[9] * math.tanh(dq1 * p[11])
    r2 -= (p[8] * (1.0 + p[10]) + p[16] * abs(tau2)) * math.tanh(LAMBDA * dq2) - p[8] * p[10] * math.tanh(dq2 * p[11])
    r1 -= p[12] * math.sin(p[14] * q1 + p[17])
    r2 -= p[13] * math.sin(p[14] * q2 + p[18])
    swing = 0.5 * p[1] * s2
    r1 += swing * (2.0 * dq1 + dq2) * dq2
    r2 -= swing * dq1 * dq1
    coupling = p[1] * math.cos(q2)
    m11, m12 = p[0] + coupling, p[2] + 0.5 * coupling
    determinant = m11 * p[2] - m12 * m12
    out[0], out[1] = dq1, dq2
    out[2] = (p[2] * r1 - m12 * r2) / determinant
    out[3] = (m11 * r2 - m12 * r1) / determinant


@njit(cache=True)
def _run(desired, p, kp, kv, per_count, h, position, pwm):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Run the loop along `desired` (2, N) in single precision and fill the counts (2, N)."""
    x, point, slopes = np.zeros(4), np.zeros(4), np.zeros((4, 4))
    before, q, command = np.zeros(2, np.float32), np.zeros(2, np.float32), np.zeros(2)
    step = h / SLOW_STEPS
    for i in range(desired.shape[1]):
        for j in range(2):
            position[j, i] = np.rint(x[j] / RADIANS_PER_COUNT)
            q[j] = np.float32(position[j, i]) * np.float32(RADIANS_PER_COUNT)
            last = before[j] if i > 0 else q[j]
            u = kp[j] * (desired[j, i] - q[j]) - kv[j] * (q[j] - last)
            before[j] = q[j]
            pwm[j, i] = min(max(np.rint(u), -PWM_LIMIT), PWM_LIMIT)
            command[j] = pwm[j, i] * per_count[j]
        for _ in range(SLOW_STEPS):  # the classic method of order 4
            for stage in range(4):
                part = 0.0 if stage == 0 else step if stage == 3 else 0.5 * step
                for k in range(4):
                    point[k] = x[k] + part * slopes[stage - 1, k]
                _slope(point, command[0], command[1], p, slopes[stage])
            for k in range(4):
                x[k] += step / 6.0 * (slopes[0, k] + 2.0 * slopes[1, k] + 2.0 * slopes[2, k] + slopes[3, k])


def record(
    beta: Array, effects: Unmodelled, phase: Array, control: ControlConstants, desired: Array, h: float
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Simulate encoder and PWM counts (2, N) of one arm (9,) along q_d (2, N), rad."""
    p = np.array(
        [
            *(*beta, *effects.stribeck, 1.0 / effects.stribeck_velocity, *effects.ripple, effects.ripple_cycles),
            *(*effects.load_friction, *phase),
        ]
    )
    position, pwm = np.empty((2, *desired.shape), dtype=np.int32)
    with np.errstate(all="ignore"):
        sent = desired.astype(np.float32)
        _run(sent, p, control.kp_counts, control.kv_counts, control.torque_per_count, h, position, pwm)
    return position, pwm
