"""The simulated arm: Eq. 1 and, where the caller sets them, what Eq. 1 does not model."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import DOP853

from repro.model.dynamics import LAMBDA
from repro.model.parameters import FEASIBILITY, Array, check_beta

#: Substeps of a sampling period, and while a joint is slower than `SLOW`, where friction bends most.
STEPS, SLOW_STEPS = 1, 3
SLOW = 0.2


@dataclass(frozen=True)
class Unmodelled:
    """Disturbances that Eq. 1 does not model."""

    stribeck: tuple[float, float] = (0.0, 0.0)  # relative increase of each Coulomb friction near standstill
    stribeck_velocity: float = 0.2  # velocity at which that increase fades, rad/s
    ripple: tuple[float, float] = (0.0, 0.0)  # amplitude of the torque ripple of each joint, N m
    ripple_cycles: float = 17.0  # ripple cycles in one turn of the joint
    load_friction: tuple[float, float] = (0.0, 0.0)  # Coulomb friction for each N m of commanded torque
    dead_band: int = 0  # PWM counts that do not move the motor


#: Coefficients of the classic method of order 4.
_A4, _B4 = np.diag([0.5, 0.5, 1.0], -1), np.array([1.0, 2.0, 2.0, 1.0]) / 6.0
#: Levels of both joints.
_OF_JOINTS = ("stribeck", "ripple", "load_friction")
#: No such effects: Eq. 1 alone.
NOTHING = Unmodelled()


class Plant:
    r"""One arm or a batch of arms under a torque that is constant over each sampling period.

    .. math::
        M \ddot q + C \dot q + g + B \dot q + K [(1 + s) \tanh \lambda \dot q - s \tanh(\dot q / v_s)]
        + a \sin(n q + \varphi) + \mu |\tau| \tanh \lambda \dot q = \tau

    with Stribeck share s and velocity v_s, ripple a, n cycles a turn and phase phi, and load-dependent friction mu.
    With s = a = mu = 0 it is Eq. 1.

    Dormand and Prince's method of order 8, coefficients from SciPy. Halving its substeps changes no encoder count of
    the stored identification recording, and counts of T1 and T2 by 1. Arms of one batch share their substeps.

    The quick way for many arms is the classic method of order 4, always with the substeps of slow joints. An arm's
    counts do not depend on the others of its batch then.
    """

    def __init__(
        self,
        beta: ArrayLike,
        h: float,
        unmodelled: Unmodelled | Sequence[Unmodelled] = NOTHING,
        ripple_phase: ArrayLike = (0.0, 0.0),
        quick: bool = False,
    ) -> None:
        arms = np.atleast_2d(check_beta(np.asarray(beta)))
        if not FEASIBILITY["positive-definite"](arms).all():
            raise ValueError("beta: the inertia matrix must be positive definite in every pose and friction positive.")
        batch = len(arms)
        each = [unmodelled] * batch if isinstance(unmodelled, Unmodelled) else list(unmodelled)
        if len(each) != batch or len({e.dead_band for e in each}) > 1:
            raise ValueError("unmodelled: must be one for each arm, with the same dead band.")
        stribeck, ripple, load = (np.array([getattr(e, name) for e in each]).T for name in _OF_JOINTS)  # (2, batch)
        i1, i2, i3, g1, g2, b1, b2, k1, k2 = np.ascontiguousarray(arms.T)
        self._dead_band, self.state = each[0].dead_band, np.zeros((4, batch))
        # Arguments of sin and tanh and the velocities are linear in the state (q1, q2, dq1, dq2).
        self._linear = np.array(
            [
                *([1, 0, 0, 0], [1, 1, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 1, 0, 0]),
                *([0, 0, LAMBDA, 0], [0, 0, 0, LAMBDA], [0, 0, 1, 0], [0, 0, 0, 1]),
                *([0, 0, 1, 0], [0, 0, 0, 1], [0, 0, 2, 1], [0, 0, -1, 0]),
            ],
            dtype=np.float64,
        )
        # Each arm has cycles of its ripple and a velocity of its Stribeck friction.
        self._cycles = np.array([e.ripple_cycles for e in each])
        self._fading = np.array([1.0 / e.stribeck_velocity for e in each])
        self._phase = np.zeros((5, batch))
        self._phase[2:4] = np.broadcast_to(np.asarray(ripple_phase, dtype=np.float64), (batch, 2)).T
        # Weights of those features in gravity, ripple, Coulomb and viscous friction, subtracted from the torque.
        weight = np.zeros((2, 11, batch))
        weight[0, 0], weight[:, 1] = g1, g2
        weight[0, 2], weight[1, 3] = ripple
        for j, (b, k) in enumerate(((b1, k1), (b2, k2))):
            weight[j, 5 + j], weight[j, 7 + j], weight[j, 9 + j] = k * (1 + stribeck[j]), -k * stribeck[j], b
        # Both rows of Eq. 1 are divided by I3.
        self._weight, self._per_i3, self._load = -weight / i3, 1.0 / i3, load
        self._tanh_weight = self._weight[(0, 1), (5, 6)].copy()  # (2, batch), without the friction of the load
        self._coupling, self._determinant = 0.5 * i2 / i3, i1 / i3 - 1.0
        self._quick = quick
        a, b = (_A4, _B4) if quick else (DOP853.A, DOP853.B)
        self._tableau = {steps: _tableau(a, b, h / steps) for steps in (STEPS, SLOW_STEPS)}
        # Work space with its views, made once: a recording takes some 100,000 derivatives.
        f, r = np.empty((13, batch)), np.empty((2, batch))
        self._features = (f, f[:5], f[5:9], f[:11], f[4], f[11:8:-2], f[10:13:2])
        self._of_arm = (f[2:4], f[7:9])
        self._torque = (r, r[0], r[1])
        self._stages = np.empty((len(b) + 1, 4, batch))  # the state, then the slope of each stage
        flat = self._stages.reshape(len(b) + 1, -1)
        self._known = [flat[: i + 1] for i in range(len(b) + 1)]
        self._point = np.empty((4, batch))
        # One arm takes BLAS, which is quick on so little; a batch takes sums that no processor changes.
        self._product = np.dot if batch == 1 else _einsum

    def derivative(self, x: Array, tau: Array, out: Array) -> None:
        """Fill `out` with the derivative of ``x = (q1, q2, dq1, dq2)`` under the torque `tau` over I3, rad/s^2."""
        f, sines, tanhs, weighed, sin_q2, left, right = self._features
        r, r1, r2 = self._torque
        self._product(self._linear, x, f)
        turned, faded = self._of_arm
        turned *= self._cycles
        faded *= self._fading
        sines += self._phase
        np.sin(sines, out=sines)
        np.tanh(tanhs, out=tanhs)
        if len(r1) == 1:
            np.dot(self._weight[:, :, 0], weighed, out=r)
        else:
            np.einsum("jfb,fb->jb", self._weight, weighed, out=r)
        r += tau
        # Centrifugal and Coriolis torque: I2/2 sin q2 times ((2 dq1 + dq2) dq2, -dq1^2).
        r += left * right * (self._coupling * sin_q2)
        # M / I3 = [[D + 1 + 2m, 1 + m], [1 + m, 1]] with m = I2 / (2 I3) cos q2, so its determinant is D - m^2.
        m = np.cos(x[1])
        m *= self._coupling
        determinant = self._determinant - m * m
        m += 1.0
        out[:2] = x[2:]
        np.divide(r1 - m * r2, determinant, out=out[2])
        np.subtract(r2, m * out[2], out=out[3])

    def advance(self, pwm: NDArray[np.int32], torque_per_count: Array) -> None:
        """Advance the state by one sampling period at the given PWM counts (2, B)."""
        if band := self._dead_band:
            pwm = np.sign(pwm) * np.maximum(np.abs(pwm) - band, 0)
        tau = pwm * torque_per_count[:, np.newaxis] * self._per_i3
        # The torque is constant over the period, and so is the friction that it causes.
        self._weight[(0, 1), (5, 6)] = self._tanh_weight - self._load * np.abs(tau)
        steps = SLOW_STEPS if self._quick or np.abs(self.state[2:]).min() < SLOW else STEPS
        *inner, last = self._tableau[steps]
        stages, known, point = self._stages, self._known, self._point
        flat_point = point.reshape(-1)
        stages[0] = self.state
        for _ in range(steps):
            self.derivative(stages[0], tau, stages[1])
            for i, row in enumerate(inner, start=1):
                self._product(row, known[i], flat_point)
                self.derivative(point, tau, stages[i + 1])
            self._product(last, known[-1], flat_point)
            stages[0] = point
        self.state = stages[0].copy()


def _einsum(a: Array, b: Array, out: Array) -> None:
    """``a @ b`` into `out` without BLAS, whose kernels add in different orders."""
    np.einsum("...s,sb->...b", a, b, out=out)


def _tableau(a: Array, b: Array, h: float) -> list[Array]:
    """Weights of (state, slopes so far) that give each stage's point, and last the end of the step."""
    inner = [np.concatenate([[1.0], h * a[i, :i]]) for i in range(1, len(b))]
    return [*inner, np.concatenate([[1.0], h * b])]
