"""A motion to identify an arm by: a finite Fourier series within the arm's limits that is most informative.

Each joint begins and ends at rest. The coefficients maximise the determinant of the information Y'Y / sigma^2 of the
nine parameters (D-optimal): the volume of their common confidence region is smallest, whatever units they are in.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import null_space
from scipy.optimize import minimize

from repro.errors import InputError
from repro.identification.armfile import Arm, read_arm
from repro.identification.excitation import MIN_SINGULAR_RATIO
from repro.identification.filtering import Moved
from repro.identification.regression import unit_columns
from repro.model.dynamics import LAMBDA, ArmGeometry, forward_kinematics, regressor
from repro.model.parameters import Array, is_positive_definite
from repro.progress import over
from repro.signals.trajectories import Motion, identification_trajectory, sample_times

#: Samples in a period of the fastest harmonic: of the search and of the check of the limits.
_SEARCH_SAMPLES, _CHECK_SAMPLES = 200, 1000
_EVERY, _SEGMENT = 10, 20  # the information is of every so many samples; samples of which the peak is one constraint
_DRAWS, _STARTS = 32, 3  # random motions, and those of them from which a search starts
_STEP, _TOLERANCE = 1e-6, 1e-4  # of position, speed or acceleration, for differences; of the log-determinant
_PACES = 16  # paces at which Eq. 10 is tried
_NORMAL_95 = 1.959964  # 95 % of a normal distribution lie within so many standard deviations
MAX_UTILISATION = 0.999  # fraction of each limit that is used, so that nothing between two samples exceeds it
_MAX_SAMPLES, _MAX_HARMONICS = 100_000, 20
_MAX_NUMBER, _MIN_NOISE = 1e6, 1e-9  # magnitude of a guess or of a noise, in their units, and of a noise
_MAX_START = 0.9  # fraction of the way from the middle of a range to its end within which a motion may begin


@dataclass(frozen=True)
class Envelope:
    """Limits of an arm; InputError if a key that is needed is missing, or the arm at rest is outside of a limit."""

    arm: Arm  # with position and speed limits; a workspace counts with link lengths
    beta: Array | None = None  # guess of the parameters (9,), with which the torque limit counts

    def __post_init__(self) -> None:
        arm, required = self.arm, {"position_limit": "two ranges, rad", "speed_limit": "two numbers above 0, rad/s"}
        if self.beta is not None:
            required["torque_limit"] = "two numbers above 0, N m, because there is a guess"
        if arm.workspace is not None:
            required["link_lengths"] = "two numbers above 0, m, because there is a workspace"
        for key, expected in required.items():
            if getattr(arm, key) is None:
                raise InputError.at(f"{arm.file}: {key}", "nothing", expected)
        still = self.rest[:, None]
        exceeded = np.abs(self.utilisation((still, 0.0 * still, 0.0 * still)))[4:, 0] >= MAX_UTILISATION
        if exceeded.any():
            key = "torque_limit" if self.beta is not None and exceeded[:2].any() else "workspace"
            at = ", ".join(f"{angle:.4g}" for angle in self.rest)
            raise InputError.at(f"{arm.file}: {key}", getattr(arm, key), f"room for the arm at rest at {at} rad")

    @property
    def rest(self) -> Array:
        """Where a motion begins and ends, rad: hanging, or in the middle of the range of a joint that cannot."""
        low, high = self.position
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        return np.where(np.abs(middle) < _MAX_START * half, 0.0, middle)

    @property
    def position(self) -> Array:
        """Lowest and highest position, shape (2, joint), rad."""
        return np.array(self.arm.position_limit, dtype=np.float64).T

    @property
    def steepness(self) -> float:
        """Steepness of Coulomb friction, s/rad."""
        return self.arm.friction_steepness or LAMBDA

    def utilisation(self, moved: Moved) -> Array:
        """Compute the fraction (..., L, N) of each limit that a motion uses at each sample, -1 to 1 within it."""
        arm, (q, dq, _) = self.arm, moved
        used = [_within(q, *self.position), dq / np.array(arm.speed_limit)[:, None]]
        if self.beta is not None:
            used.append(regressor(*moved, self.steepness) @ self.beta / np.array(arm.torque_limit)[:, None])
        if arm.workspace is not None and arm.link_lengths is not None:
            points = forward_kinematics(q, ArmGeometry(*arm.link_lengths))
            used += [_within(point, *np.array(arm.workspace).T) for point in points]
        return np.concatenate(used, axis=-2)

    def largest_factor(self, shape: Moved, centre: Array) -> Array:
        """Find the factors (..., 1, 1) by which shapes about a centre (2,) reach a limit."""
        high = 1.0 / np.abs(shape[1] / np.array(self.arm.speed_limit)[:, None]).max(axis=(-2, -1), keepdims=True)
        low = np.zeros_like(high)
        for _ in range(30):  # by halves
            factor = 0.5 * (low + high)
            q, dq, ddq = (factor * x for x in shape)
            used = np.abs(self.utilisation((centre[:, None] + q, dq, ddq))).max(axis=(-2, -1), keepdims=True)
            low, high = np.where(used <= MAX_UTILISATION, (factor, high), (low, factor))
        return np.asarray(low)


def _within(value: Array, low: Array, high: Array) -> Array:
    """Distance from the middle of bounds over that of a bound from it."""
    return np.asarray((2.0 * value - (low + high)[:, None]) / (high - low)[:, None])


def expected_accuracy(moved: Moved, noise: Array, friction_steepness: float) -> tuple[Array, float, float]:
    """Compute what least squares on a motion (2, N) would determine with white torque noise (2,), N m.

    Returns the half-widths (9,) of the 95 % intervals, infinite if they cannot be separated; the condition number of
    the regressor over the noise with columns of unit length; the log-determinant of the information.
    """
    a, scale = unit_columns(regressor(*moved, friction_steepness) / noise[:, None, None])
    singular, right = np.linalg.svd(a, full_matrices=False)[1:]
    if not singular[-1] > MIN_SINGULAR_RATIO * singular[0]:
        return np.full(scale.shape, np.inf), np.inf, -np.inf
    half = _NORMAL_95 * np.linalg.norm(right / singular[:, None], axis=0) / scale
    return half, float(singular[0] / singular[-1]), 2.0 * float(np.log(singular * scale).sum())


def excite(
    arm: str | Path | Arm,
    *,
    duration: float = 20.0,
    rate: float = 400.0,
    harmonics: int = 12,
    noise: ArrayLike = (0.05, 0.05),
    guess: ArrayLike | None = None,
    seed: int = 1,
) -> Motion:
    """Design a motion to identify an arm by, within its limits.

    Parameters
    ----------
    arm : path or Arm
        With ``position_limit`` and ``speed_limit``; a workspace needs link lengths.
    duration : float
        Of the motion, s.
    rate : float
        Samples per second.
    harmonics : int
        Highest multiple of 1/duration in it, 3 to 20.
    noise : float or pair of float
        Standard deviation of a sample of each torque, N m.
    guess : array_like of shape (9,), optional
        Rough parameters, such as ``result.beta``; with them the motion stays within ``torque_limit``.
    seed : int
        Of the starts of the search.

    Returns
    -------
    Motion
        ``time`` (N,), s, and ``q``, ``dq``, ``ddq`` (2, N), angles of Eq. 1.

    Raises
    ------
    InputError
        If the arm lacks a limit, or is outside of one at rest, the motion has too few or too many samples, the guess is
        not physically possible, or another argument is not valid.

    Examples
    --------
    >>> arm = repro.Arm(position_limit=((-1.0, 1.0), (-2.0, 2.0)), speed_limit=(3.0, 4.0))
    >>> motion = repro.excite(arm, duration=5.0, rate=100.0, harmonics=4, noise=0.05)
    >>> motion.q.shape, bool(np.abs(motion.q[0]).max() < 1.0)
    ((2, 501), True)
    """
    steps = check_samples(duration, rate, harmonics)
    if not isinstance(arm, str | Path | Arm):
        raise InputError.at("arm", type(arm).__name__, "a path or an Arm")
    beta = None if guess is None else check_guess(guess)
    pair = [noise, noise] if isinstance(noise, int | float) else noise
    sigma = _numbers("noise", pair, 2, _MIN_NOISE, f"one or two numbers from {_MIN_NOISE:g} to {_MAX_NUMBER:g}, N m")
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
        raise InputError.at("seed", repr(seed)[:60], "a whole number of 0 or more")
    limits = Envelope(arm if isinstance(arm, Arm) else read_arm(Path(arm)), beta)
    return design(limits, (steps, 1.0 / rate), harmonics, sigma, np.random.default_rng(seed))


def check_guess(guess: ArrayLike) -> Array:
    """Return a guess (9,) as float64; refuse what is not nine numbers, or what no arm can have."""
    expected = f"nine numbers of at most {_MAX_NUMBER:g}, such as result.beta; the command reads parameters.json, too"
    beta = _numbers("guess", guess, 9, -_MAX_NUMBER, expected)
    if not is_positive_definite(beta):
        possible = "parameters that an arm can have: I3 > 0, I3 (I1 - I3) > I2^2 / 4, no negative friction"
        raise InputError.at("guess", beta.tolist(), possible)
    return beta


def _numbers(name: str, value: ArrayLike, n: int, least: float, expected: str) -> Array:
    try:
        numbers = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        numbers = np.empty(0)
    if numbers.shape != (n,) or not ((least <= numbers) & (numbers <= _MAX_NUMBER)).all():
        raise InputError.at(name, " ".join(repr(value).split())[:200], expected)
    return numbers


def check_samples(duration: float, rate: float, harmonics: int) -> int:
    """Give the sampling periods of a motion; refuse too few or too many of them, or of the harmonics."""
    for name, value in (("duration", duration), ("rate", rate), ("harmonics", harmonics)):
        kind, what = (int | np.integer, "whole ") if name == "harmonics" else (int | float | np.number, "")
        if isinstance(value, bool) or not isinstance(value, kind) or not 0.0 < value < np.inf:
            raise InputError.at(name, repr(value)[:60], f"a {what}number above 0")
    steps = round(duration * rate)
    if not 3 <= harmonics <= _MAX_HARMONICS:
        raise InputError.at("harmonics", harmonics, f"3 to {_MAX_HARMONICS}")
    if not 4 * harmonics <= steps < _MAX_SAMPLES:
        expected = f"{4 * harmonics} to {_MAX_SAMPLES - 1} with these harmonics"
        raise InputError.at("rate times duration", f"{steps} samples", expected)
    return steps


def design(
    limits: Envelope, times: tuple[int, float], harmonics: int, noise: Array, rng: np.random.Generator
) -> Motion:
    """Find the motion with the largest information from random starts, by sequential quadratic programming (SLSQP).

    It has `times[0]` periods of `times[1]` s and rests at both ends. `harmonics` is the highest multiple of its lowest
    frequency. Each limit binds the peak in each segment of time: a search learns to hide peaks between fixed samples.
    """
    (steps, h), rest = times, limits.rest
    # Series that are zero at time 0 with both derivatives are the null space of their values there.
    free = null_space(np.concatenate(_waves(harmonics, 1.0, np.zeros(1)))).T
    free = free * 0.5 * np.ptp(limits.position, axis=0)[:, None, None]

    def basis(t: Array) -> Array:
        return np.stack([free @ w.T for w in _waves(harmonics, steps * h, t)])

    def shape(x: Array, on: Array) -> Moved:
        q, dq, ddq = np.einsum("...jm,djmn->d...jn", x.reshape(*x.shape[:-1], 2, -1), on)
        return q, dq, ddq

    def differentiated(function: Callable[[Moved], Array], x: Array, on: Array) -> tuple[Array, Array]:
        """Value of a function of the motion at each sample, and its derivatives (3, 2, ...) by the motion there."""
        q, dq, ddq = np.stack(shape(x, on))[:, None] + _STEP * np.eye(6, 7, 1).reshape(3, 2, 7, 1).swapaxes(1, 2)
        value = function((rest[:, None] + q, dq, ddq))
        return value[0], (value[1:] - value[0]).reshape(3, 2, *value.shape[1:]) / _STEP

    def objective(x: Array) -> tuple[float, Array]:
        """Minus the log-determinant per parameter, and its derivatives."""
        y, dy = differentiated(lambda moved: regressor(*moved, limits.steepness) / noise[:, None, None], x, coarse)
        a, scale = unit_columns(y)
        left, singular, right = np.linalg.svd(a, full_matrices=False)
        singular, factor = np.maximum(singular, np.finfo(np.float64).eps), -2.0 / scale.size
        slope = np.einsum("djinp,inp->djn", dy, (left / singular @ right / scale).reshape(y.shape))
        return factor * float(np.log(singular * scale).sum()), factor * np.einsum("djn,djmn->jm", slope, coarse).ravel()

    def use(x: Array) -> Array:
        q, dq, ddq = shape(x, fine)
        return np.abs(limits.utilisation((rest[:, None] + q, dq, ddq))).reshape(-1, _SEGMENT)  # a row for each segment

    def margin_derivatives(x: Array) -> Array:
        peak = use(x).argmax(axis=-1)
        limit, sample = np.divmod(peak + _SEGMENT * np.arange(peak.size), fine.shape[-1])
        on, each = fine[..., sample], np.arange(peak.size)
        slope = differentiated(lambda moved: np.abs(limits.utilisation(moved))[..., limit, each], x, on)[1]
        return np.asarray(-np.einsum("djn,djmn->njm", slope, on).reshape(peak.size, -1))

    fine = basis(steps * h * np.linspace(0.0, 1.0, _SEARCH_SAMPLES * harmonics, False))
    coarse, check = fine[..., ::_EVERY], basis(steps * h * np.linspace(0.0, 1.0, _CHECK_SAMPLES * harmonics))
    margins = {"type": "ineq", "fun": lambda x: MAX_UTILISATION - use(x).max(axis=-1), "jac": margin_derivatives}
    search = partial(minimize, objective, method="SLSQP", jac=True, constraints=margins, tol=_TOLERANCE)
    drawn = rng.normal(size=(_DRAWS, 2 * free.shape[1]))
    drawn *= limits.largest_factor(shape(drawn, coarse), rest)[..., 0]
    starts = sorted(drawn, key=lambda x: objective(x)[0])[:_STARTS]
    ends = np.stack([*starts, *(search(x).x for x in over(starts, "searching for a motion"))])
    ends *= limits.largest_factor(shape(ends, check), rest)[..., 0]
    t = np.arange(steps + 1, dtype=np.float64) * h
    q, dq, ddq = shape(min(ends, key=lambda x: objective(x)[0]), basis(t))
    return Motion(t, rest[:, None] + q, dq, ddq)


def published(limits: Envelope, times: tuple[int, float], highest: float, noise: Array) -> Motion:
    """Find the most informative pace and amplitude of Eq. 10's motion within the limits and up to `highest`, Hz.

    It is about the middle of the positions or about the rest, each joint with an amplitude in proportion to its range.
    """
    n, h = times
    once = 3.0 * np.pi / (n * h)  # phase per second of one pass; the faster of its two sines has 2.5 times the phase
    best, most = Motion(sample_times(n * h, h), *np.zeros((3, 2, n))), -np.inf
    for pace in np.geomspace(once, max(once, 2.0 * np.pi * highest / 2.5), _PACES):
        duration = 3.0 * np.pi / pace
        played = identification_trajectory(duration, h, max(0, -(-(n - round(duration / h)) // 2)))
        size = np.ptp(limits.position, axis=0)[:, None] / np.ptp(played.q[:, :n], axis=1, keepdims=True)
        shape = size * played.q[:, :n], size * played.dq[:, :n], size * played.ddq[:, :n]
        for centre in (limits.position.mean(axis=0), limits.rest):
            factor = limits.largest_factor(shape, centre)
            moved = centre[:, None] + factor * shape[0], factor * shape[1], factor * shape[2]
            if (log_det := expected_accuracy(moved, noise, limits.steepness)[2]) > most:
                best, most = Motion(best.time, *moved), log_det
    return best


def _waves(harmonics: int, duration: float, t: Array) -> tuple[Array, Array, Array]:
    """Constant, cosines and sines at times t and their two derivatives, each of shape (N, 2 K + 1)."""
    w = 2.0 * np.pi / duration * np.arange(1, harmonics + 1)
    c, s = np.cos(np.outer(t, w)), np.sin(np.outer(t, w))
    one, none = np.ones((len(t), 1)), np.zeros((len(t), 1))
    return np.hstack([one, c, s]), np.hstack([none, -w * s, w * c]), np.hstack([none, -w * w * c, -w * w * s])
