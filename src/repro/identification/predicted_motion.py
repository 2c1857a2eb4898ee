"""Error of the position that the recorded torque makes the model move to.

An arm without its controller, above all one that hangs and swings, forgets where it started within seconds, whatever
the parameters; so the model starts anew from the recorded state at the beginning of each window, and the error
is that within windows.
"""

from itertools import pairwise

import numpy as np

from repro.identification.filtering import FilterSettings, motion
from repro.logs.log import Log, period
from repro.model.dynamics import forward_dynamics
from repro.model.parameters import Array, is_positive_definite

#: Length of a window, s.
WINDOW = 0.5
#: Windows looked at, evenly spread over the log.
MOST_WINDOWS = 40
#: Longest step of the integration, s, and its largest product with the fastest decay of friction.
STEP = 2.5e-3
STABLE = 1.0
#: Steps that a sample is divided into at most: M(q) that asks for more is nearly singular.
MOST_PARTS = 40


def position_errors(log: Log, settings: FilterSettings, betas: Array) -> list[tuple[float, float] | None]:
    """RMS error of the re-simulated position for several parameter sets.

    Parameters
    ----------
    log : Log
        Uniformly sampled.
    settings : FilterSettings
        Filter of the states that windows begin from, delay of the torque and lambda of Eq. 1.
    betas : array of shape (m, 9)
        Parameter sets.

    Returns
    -------
    list of (float, float) or None
        Median over the windows of the RMS within one, of each joint, rad; None where M(q) is not positive definite or
        nearly singular, or the model runs away in half of the windows. Negative friction is simulated as it is.
    """
    h = period(log)
    parts = np.array([_parts(b, h, settings.friction_steepness) for b in betas])
    able = parts <= MOST_PARTS
    errors: list[tuple[float, float] | None] = [None] * len(betas)
    if able.any():
        found = _simulate(log, settings, betas[able], int(parts[able].max()))
        for k, error in zip(np.flatnonzero(able), found, strict=True):
            if np.isfinite(error).all():
                errors[k] = (float(error[0]), float(error[1]))
    return errors


def _parts(beta: Array, h: float, steepness: float) -> float:
    """Steps that a sample is divided into, by the fastest decay of friction; infinity if M(q) is not definite."""
    if not is_positive_definite(np.concatenate([beta[:5], np.maximum(beta[5:], 0.0)])):
        return np.inf
    i1, i2, i3 = beta[:3]
    smallest = min(i3 - 0.25 * i2**2 / (i1 - i3), i1 - i3 - 0.25 * i2**2 / i3)  # of a joint with the other free
    decay = float(np.max(np.abs(beta[5:7]) + steepness * np.abs(beta[7:9]))) / smallest
    return float(np.ceil(h * max(1.0 / STEP, decay / STABLE)))


def _simulate(log: Log, settings: FilterSettings, betas: Array, parts: int) -> Array:
    """Median over the windows of the RMS position error, shape (m, 2); all of them are simulated side by side."""
    h = period(log)
    margin = max(round(settings.cut / h), 1)
    moved = [motion(piece.q, h, settings) for piece in log.pieces]
    q, dq, _ = (np.concatenate(signal, axis=1) for signal in zip(*moved, strict=True))
    length = max(round(WINDOW / h), 1)
    edges = pairwise((0, *log.breaks, log.t.size))
    starts = np.concatenate([np.arange(begin + margin, end - margin - length, length) for begin, end in edges])
    if not starts.size:
        return np.full((len(betas), 2), np.nan)
    starts = starts[np.linspace(0, starts.size - 1, min(starts.size, MOST_WINDOWS)).astype(int)]
    parameters = betas[:, None, :]
    shape = (len(betas), starts.size, 2)
    x, v = (np.broadcast_to(s[:, starts].T, shape).copy() for s in (q, dq))
    squares = np.zeros(shape)
    with np.errstate(over="ignore", invalid="ignore"):
        for k in range(length):
            # The torque in the middle of the step: a drive that holds each sample has a delay of half a period.
            at = log.t[starts + k] + 0.5 * h - settings.delay
            held = np.broadcast_to(np.stack([np.interp(at, log.t, joint) for joint in log.tau], -1), shape)
            for _ in range(parts):
                x, v = _step(x, v, held, parameters, h / parts, settings.friction_steepness)
            if not (np.isfinite(x).all() and np.isfinite(v).all()):
                run_away = ~(np.isfinite(x).all(-1) & np.isfinite(v).all(-1))
                squares[run_away] = np.inf
                x[run_away], v[run_away] = 0.0, 0.0
            squares += (x - q[:, starts + k + 1].T) ** 2
    error: Array = np.median(np.sqrt(squares / length), axis=1)
    return error


def _step(x: Array, v: Array, tau: Array, beta: Array, h: float, steepness: float) -> tuple[Array, Array]:
    """One step of the classical Runge-Kutta method of order 4."""
    a1 = forward_dynamics(x, v, tau, beta, steepness)
    v2 = v + 0.5 * h * a1
    a2 = forward_dynamics(x + 0.5 * h * v, v2, tau, beta, steepness)
    v3 = v + 0.5 * h * a2
    a3 = forward_dynamics(x + 0.5 * h * v2, v3, tau, beta, steepness)
    v4 = v + h * a3
    a4 = forward_dynamics(x + h * v3, v4, tau, beta, steepness)
    return x + h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4), v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
