"""How well parameters predict: similarity and relative error of the torque, and error of the re-simulated position."""

from collections.abc import Callable, Mapping
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from repro.identification.filtering import FilterSettings, smooth_motion
from repro.identification.log import Log, period
from repro.identification.regression import Regression
from repro.identification.term_selection import cross_validation_error, weighted_rows
from repro.model.dynamics import check_motion, forward_dynamics, rebuild_torque
from repro.model.parameters import Array, is_positive_definite
from repro.signals.metric import UNIT_FREE_METRIC, MetricSettings, metr2ev

#: Acceleration (..., 2) at a position, velocity and torque (..., 2).
Acceleration = Callable[[Array, Array, Array], Array]

MIN_DRIVE_RATIO = 0.02  # torque over the torques that it is made of, below which a joint is not driven
WINDOW, MAX_WINDOWS = 0.5, 40  # length of a window of re-simulation, s, and most windows, evenly spread over the log
#: Longest step of the integration, s, and its largest product with the fastest decay of friction.
MAX_STEP, MAX_DECAY_STEP = 2.5e-3, 1.0
MAX_STEPS_PER_SAMPLE = 40  # most steps in a sample: M(q) that needs more is nearly singular


def score(y: Array, tau: Array, estimates: Mapping[str, Any], metric: MetricSettings) -> pd.DataFrame:
    """Compute the similarity (**metr2ev**) of a torque (2, N) and its rebuilding by each ``beta``."""
    rows = []
    for method, estimate in estimates.items():
        s = metr2ev(tau, rebuild_torque(y, np.array(estimate["beta"])), metric)
        rows += [(method, j + 1, s.time[j], s.frequency[j], s.total[j]) for j in (0, 1)]
    return pd.DataFrame(rows, columns=["method", "joint", "time", "frequency", "total"])


def relative_rms(regression: Regression, beta: Array) -> tuple[float, float]:
    """Compute the RMS torque error of each joint over the RMS torque, or of a freely falling joint over its parts."""
    error = _rms(regression.tau - regression.y @ beta)
    torque = np.where(driven(regression, beta), _rms(regression.tau), _rms_of_parts(regression, beta))
    first, second = np.divide(error, torque, out=np.zeros(2), where=error > 0.0).tolist()
    return first, second


def unexplained(regression: Regression, parameters: slice = slice(None)) -> Array:
    """Compute the fraction (2,) of squared torque that these parameters leave, in blocks predicted from the others."""
    chosen = np.zeros(regression.y.shape[-1])
    chosen[parameters] = 1.0
    rows, torque = weighted_rows(regression, np.empty((*regression.tau.shape, 0)))
    energy = np.sum(torque**2, axis=-1)
    error = cross_validation_error(rows * chosen, torque)
    return np.asarray(np.divide(error, energy, out=np.zeros(2), where=energy > 0.0))


def driven(regression: Regression, beta: Array) -> NDArray[np.bool_]:
    """Check (2,) whether each joint has a torque worth comparing with."""
    return np.asarray(_rms(regression.tau) >= MIN_DRIVE_RATIO * _rms_of_parts(regression, beta))


def _rms(tau: Array) -> Array:
    return np.asarray(np.sqrt(np.mean(tau**2, axis=-1)))


def _rms_of_parts(regression: Regression, beta: Array) -> Array:
    """RMS of the torques of inertia, gravity and friction, whatever their signs."""
    return _rms(np.abs(regression.y) @ np.abs(beta))


def similarity(regression: Regression, beta: Array) -> tuple[float, float]:
    """Total of ``metr2ev`` with the energy ratio of each joint, fractions of 1; 0 where a joint has no torque."""
    first, second = (
        float(metr2ev(tau, rebuilt, UNIT_FREE_METRIC).total) if np.any(tau) else 0.0
        for tau, rebuilt in zip(regression.tau, regression.y @ beta, strict=True)
    )
    return first, second


def position_errors(log: Log, settings: FilterSettings, betas: Array) -> list[tuple[float, float] | None]:
    """Compute the RMS error of the re-simulated position, rad, for parameter sets (m, 9) on a uniformly sampled log.

    Without a controller an arm forgets its start within seconds. The simulation therefore restarts in each of several
    windows; the error is the median of their RMS. It is None where M(q) is not positive definite or nearly singular,
    or the model diverges in half of the windows.
    """
    steps = np.array([_steps_per_sample(b, period(log), settings.friction_steepness) for b in betas])
    feasible = steps <= MAX_STEPS_PER_SAMPLE
    errors = np.full((len(betas), 2), np.inf)
    if feasible.any():
        errors[feasible] = _simulate(log, settings, betas[feasible], int(steps[feasible].max()))
    return [(first, second) if np.isfinite([first, second]).all() else None for first, second in errors.tolist()]


def integrate(
    t: ArrayLike,
    tau: ArrayLike,
    q0: ArrayLike,
    dq0: ArrayLike,
    beta: Array,
    friction_steepness: float,
    accelerate: Acceleration | None = None,
) -> tuple[Array, Array]:
    """Integrate an acceleration, by default that of Eq. 1, from a state (2,) under a torque (2, N) at times (N,)."""
    t, (tau,) = np.asarray(t, dtype=np.float64), check_motion(tau)
    x, v = (np.asarray(state, dtype=np.float64) for state in (q0, dq0))
    if t.shape != tau.shape[1:] or x.shape != (2,) or v.shape != (2,):
        raise ValueError(f"t, tau, q0, dq0: shapes {t.shape}, {tau.shape}, {x.shape}, {v.shape} do not fit together.")
    if not (np.diff(t) > 0.0).all():
        raise ValueError("t: instants must increase.")
    if not (np.isfinite(t).all() and np.isfinite([x, v]).all()):
        raise ValueError("t, q0, dq0: every value must be finite.")
    needed = [_steps_per_sample(beta, float(span), friction_steepness) for span in np.diff(t)]
    if not np.isfinite(needed).all():
        raise ValueError("beta: the inertia matrix is not positive definite in every pose.")
    move = accelerate or partial(forward_dynamics, beta=beta, friction_steepness=friction_steepness)
    states = [(x, v)]
    for k, span in enumerate(np.diff(t)):
        steps = int(needed[k])
        for step in range(steps):
            middle = tau[:, k] + (step + 0.5) / steps * (tau[:, k + 1] - tau[:, k])
            x, v = _runge_kutta(x, v, middle, span / steps, move)
        states.append((x, v))
    q, dq = (np.stack(signal, axis=-1) for signal in zip(*states, strict=True))
    return q, dq


def _steps_per_sample(beta: Array, h: float, steepness: float) -> float:
    """Steps that a sample needs, by the fastest decay of friction; infinity if M(q) is not positive definite."""
    if not is_positive_definite(np.concatenate([beta[:5], np.maximum(beta[5:], 0.0)])):
        return np.inf
    i1, i2, i3 = beta[:3]
    determinant = i3 * (i1 - i3) - 0.25 * i2**2  # of M(q), the least of all poses
    smallest = determinant / max(i1 + abs(i2), i3)  # of a joint with the other free
    decay = float(np.max(np.abs(beta[5:7]) + steepness * np.abs(beta[7:9]))) / smallest
    return float(np.ceil(h * max(1.0 / MAX_STEP, decay / MAX_DECAY_STEP)))


def _simulate(log: Log, settings: FilterSettings, betas: Array, steps: int) -> Array:
    """Median over the windows of the RMS position error, shape (m, 2); all of them are simulated in parallel."""
    h = period(log)
    margin, length = max(round(settings.cut / h), 1), max(round(WINDOW / h), 1)
    moved = [smooth_motion(piece.q, h, settings) for piece in log.pieces]
    q, dq, _ = (np.concatenate(signal, axis=1) for signal in zip(*moved, strict=True))
    edges = pairwise((0, *log.breaks, log.t.size))
    starts = np.concatenate([np.arange(begin + margin, end - margin - length, length) for begin, end in edges])
    if not starts.size:
        return np.full((len(betas), 2), np.nan)
    starts = starts[np.linspace(0, starts.size - 1, min(starts.size, MAX_WINDOWS)).astype(int)]
    shape = (len(betas), starts.size, 2)
    move = partial(forward_dynamics, beta=betas[:, None, :], friction_steepness=settings.friction_steepness)
    x, v = (np.broadcast_to(s[:, starts].T, shape).copy() for s in (q, dq))
    squares = np.zeros(shape)
    with np.errstate(over="ignore", invalid="ignore"):
        for k in range(length):
            # The torque in the middle of the step: a drive that holds each sample has a delay of half a period.
            at = log.t[starts + k] + 0.5 * h - settings.delay
            torque = np.broadcast_to(np.stack([np.interp(at, log.t, joint) for joint in log.tau], -1), shape)
            for _ in range(steps):
                x, v = _runge_kutta(x, v, torque, h / steps, move)
            diverged = ~(np.isfinite(x).all(-1) & np.isfinite(v).all(-1))
            squares[diverged] = np.inf
            x[diverged], v[diverged] = 0.0, 0.0
            squares += (x - q[:, starts + k + 1].T) ** 2
    return np.median(np.sqrt(squares / length), axis=1)


def _runge_kutta(x: Array, v: Array, tau: Array, h: float, accelerate: Acceleration) -> tuple[Array, Array]:
    """One step of the classical Runge-Kutta method of order 4."""
    a1 = accelerate(x, v, tau)
    v2 = v + 0.5 * h * a1
    a2 = accelerate(x + 0.5 * h * v, v2, tau)
    v3 = v + 0.5 * h * a2
    a3 = accelerate(x + 0.5 * h * v2, v3, tau)
    v4 = v + h * a3
    a4 = accelerate(x + h * v3, v4, tau)
    return x + h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4), v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
