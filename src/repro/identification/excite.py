"""A motion to identify an arm by: a finite Fourier series within the arm's limits that tells most of the parameters.

Each joint moves by whole multiples of one frequency and begins and ends at rest. The coefficients maximise the
determinant of the information Y'Y / sigma^2 of the nine parameters (D-optimal): the volume of their common confidence
region is smallest, whatever units they are in.
"""

from collections.abc import Callable

import numpy as np
from scipy.linalg import null_space
from scipy.optimize import minimize

from repro.identification.envelope import Envelope, Moved
from repro.identification.excitation import SAME
from repro.identification.solve import unit_columns
from repro.model.dynamics import regressor
from repro.model.parameters import Array
from repro.signals.trajectories import Motion, identification_trajectory, sample_times

#: Samples in a period of the fastest harmonic: of the search, and of the check of the limits.
_COARSE, _FINE = 14, 200
#: Starts that are drawn, those that are searched from, and the weights of what is beyond a limit, one after the other.
_DRAWS, _BEST, _PENALTIES, _ITERATIONS = 32, 3, (10.0, 1000.0), 60
_STEP = 1e-7
#: Log-determinant, with columns of unit length, of a motion that tells nothing.
_NOTHING = -300.0
#: Paces at which Eq. 10 is tried.
_PACES = 16
#: 95 % of a normal distribution lie within so many standard deviations.
_NORMAL_95 = 1.959964


def expected(moved: Moved, noise: Array, friction_steepness: float) -> tuple[Array, float, float]:
    """What least squares on a motion would tell, if Eq. 1 held and the torque's noise were white.

    Parameters
    ----------
    moved : tuple of 3 arrays of shape (2, N)
        Position (rad), velocity, acceleration.
    noise : array of shape (2,)
        Standard deviation of the torque of each joint, N m; independent from sample to sample.
    friction_steepness : float
        lambda of Eq. 1, s/rad.

    Returns
    -------
    half_widths : array of shape (9,)
        Of the 95 % intervals, SI; infinite where the motion does not tell the parameters apart.
    condition : float
        Of the regressor in units of the noise with columns of unit length.
    log_det : float
        Logarithm of the determinant of the information matrix.
    """
    a, scale = unit_columns(regressor(*moved, friction_steepness) / noise[:, None, None])
    singular, right = np.linalg.svd(a, full_matrices=False)[1:]
    if not singular[-1] > SAME * singular[0]:
        return np.full(scale.shape, np.inf), np.inf, -np.inf
    half = _NORMAL_95 * np.linalg.norm(right / singular[:, None], axis=0) / scale
    return half, float(singular[0] / singular[-1]), 2.0 * float(np.log(singular * scale).sum())


def design(
    limits: Envelope,
    times: tuple[int, float],
    harmonics: int,
    noise: Array,
    rng: np.random.Generator,
    report: Callable[[int, int], None],
) -> Motion:
    """Motion with the largest information, found from random starts by L-BFGS with penalties.

    Parameters
    ----------
    limits : Envelope
        Kept everywhere, also between samples.
    times : tuple of int and float
        Sampling periods that the motion lasts, and the period, s.
    harmonics : int
        Highest multiple of the lowest frequency, at least 3.
    noise : array of shape (2,)
        Standard deviation of each torque, N m.
    rng : numpy.random.Generator
        Source of the starts.
    report : callable
        Told how many searches of how many are over.

    Returns
    -------
    Motion
        One sample more than periods; at `limits.rest` without speed and acceleration at both ends.

    Raises
    ------
    ValueError
        If there are fewer than 3 harmonics.
    """
    if harmonics < 3:
        raise ValueError(f"harmonics: must be at least 3, got {harmonics}.")
    (steps, h), rest = times, limits.rest
    # Series that are zero at time 0 with both derivatives are the null space of their values there.
    free = null_space(np.concatenate(_waves(harmonics, 1.0, np.zeros(1)))).T
    free = free[None] * 0.5 * np.ptp(limits.position, axis=0)[:, None, None]

    def basis(t: Array) -> list[Array]:
        return [free @ w.T for w in _waves(harmonics, steps * h, t)]

    def shape(x: Array, on: list[Array]) -> Moved:
        q, dq, ddq = ((x.reshape(*x.shape[:-1], 2, 1, -1) @ b)[..., 0, :] for b in on)
        return q, dq, ddq

    coarse, fine = (basis(steps * h * np.linspace(0.0, 1.0, n * harmonics, False)) for n in (_COARSE, _FINE))

    def fitted(x: Array) -> Array:
        """Enlarge until a limit is reached."""
        return x * limits.largest(shape(x, fine), rest)[..., 0]

    def judged(x: Array, penalty: float = 0.0) -> Array:
        """Minus the log-determinant per parameter, and the penalty."""
        q, dq, ddq = shape(x, coarse)
        y = regressor(rest[:, None] + q, dq, ddq, limits.steepness)
        beyond = np.maximum(np.abs(limits.shares((rest[:, None] + q, dq, ddq), y)) - 1.0, 0.0)
        rows = (y / noise[:, None, None]).reshape(*x.shape[:-1], -1, y.shape[-1])
        length = np.linalg.norm(rows, axis=-2, keepdims=True)
        a = rows / length
        apart = np.maximum(np.linalg.slogdet(np.swapaxes(a, -1, -2) @ a)[1], _NOTHING)
        volume = apart + 2.0 * np.log(length).sum(axis=(-2, -1))
        return np.asarray(penalty * (beyond**2).mean(axis=-1).sum(axis=-1) - volume / y.shape[-1])

    def slope(x: Array, penalty: float) -> tuple[float, Array]:
        """Judgement and its derivatives, by differences of one batch."""
        value = judged(np.concatenate([x[None], x + _STEP * np.eye(x.size)]), penalty)
        return float(value[0]), (value[1:] - value[0]) / _STEP

    starts = fitted(rng.normal(size=(_DRAWS, 2 * free.shape[1])))
    found = starts[np.argsort(judged(starts))[:_BEST]]
    for k, start in enumerate(found):
        report(k, _BEST)
        end = start
        for penalty in _PENALTIES:
            end = minimize(slope, end, (penalty,), "L-BFGS-B", jac=True, options={"maxiter": _ITERATIONS}).x
        both = np.stack([start, fitted(end)])
        found[k] = both[np.argmin(judged(both))]
    report(_BEST, _BEST)
    t = np.arange(steps + 1, dtype=np.float64) * h
    q, dq, ddq = shape(found[np.argmin(judged(found))], basis(t))
    return Motion(t, rest[:, None] + q, dq, ddq)


def published(limits: Envelope, times: tuple[int, float], highest: float, noise: Array) -> Motion:
    """Eq. 10's motion made as good as its shape allows: the pace and the amplitude within the limits that tell most.

    Parameters
    ----------
    limits : Envelope
        Kept everywhere.
    times : tuple of int and float
        Samples, and the period, s.
    highest : float
        Largest frequency that may occur, Hz.
    noise : array of shape (2,)
        Standard deviation of each torque, N m.

    Returns
    -------
    Motion
        About the middle of the positions, or about the rest, each joint with an amplitude in proportion to its range.
    """
    n, h = times
    once = 3.0 * np.pi / (n * h)  # phase per second of one pass; the faster of its two sines has 2.5 times the phase
    best, most = Motion(sample_times(n * h, h), *np.zeros((3, 2, n))), -np.inf
    for pace in np.geomspace(once, max(once, 2.0 * np.pi * highest / 2.5), _PACES):
        whole = 3.0 * np.pi / pace
        played = identification_trajectory(whole, h, max(0, -(-(n - round(whole / h)) // 2)))
        size = np.ptp(limits.position, axis=0)[:, None] / np.ptp(played.q[:, :n], axis=1, keepdims=True)
        shape = size * played.q[:, :n], size * played.dq[:, :n], size * played.ddq[:, :n]
        for centre in (limits.position.mean(axis=0), limits.rest):
            factor = limits.largest(shape, centre)
            moved = centre[:, None] + factor * shape[0], factor * shape[1], factor * shape[2]
            if (told := expected(moved, noise, limits.steepness)[2]) > most:
                best, most = Motion(best.time, *moved), told
    return best


def _waves(harmonics: int, duration: float, t: Array) -> tuple[Array, Array, Array]:
    """Constant, cosines and sines at times t and their two derivatives, each of shape (N, 2 K + 1)."""
    w = 2.0 * np.pi / duration * np.arange(1, harmonics + 1)
    c, s = np.cos(np.outer(t, w)), np.sin(np.outer(t, w))
    one, none = np.ones((len(t), 1)), np.zeros((len(t), 1))
    return np.hstack([one, c, s]), np.hstack([none, -w * s, w * c]), np.hstack([none, -w * w * c, -w * w * s])
