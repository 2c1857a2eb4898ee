"""A recording in SI units, and the same at evenly spaced instants: short gaps are bridged, long ones split it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, wraps
from itertools import pairwise
from typing import Any, TypeVar, TypeVarTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline, PchipInterpolator

from repro.errors import InputError
from repro.model.parameters import Array

_SIGNALS = ("t", "q", "tau", "dq", "left_out")  # fields of a log with a value for each sample


@dataclass(frozen=True, kw_only=True, eq=False)  # identity hash, so that results can be cached per instance
class Log:
    """A recording of both joints in SI units.

    Positions are the angles of Eq. 1, unless an arm file states where the zeros are and which way is positive.

    Parameters
    ----------
    t : array of shape (N,)
        Time of each sample, s: strictly increasing, not necessarily uniform.
    q : array of shape (2, N)
        Position, rad; ``q1 = 0`` hangs down and ``q2`` is relative to link 1.
    tau : array of shape (2, N)
        Torque at the joints, N m.
    dq : array of shape (2, N), optional
        Measured velocity, rad/s.
    name : str
        How results refer to the recording.
    notes : tuple of str
        What was assumed or converted on reading, one line each.
    simulated : bool
        Whether it comes from the simulated board.
    torque_limit : array of shape (2,), optional
        Largest torque that is recorded where a drive is at its limit, N m.
    breaks : tuple of int
        Samples that begin a new piece behind a long gap, of a log that was made even.
    left_out : array of shape (2, N), optional
        Whether each torque is left out of fits, because it is not the one that acted, of a log that was made even.
    block : int
        Number of recorded samples that each sample is the mean of, of a long log that was made even.

    Raises
    ------
    InputError
        If an array has another shape, is not of finite real numbers, or time does not increase.

    Examples
    --------
    >>> t = np.arange(400) / 100
    >>> q, tau = np.stack([np.sin(t), np.cos(2 * t)]), np.stack([np.cos(t), np.sin(2 * t)])
    >>> log = repro.Log(t=t, q=q, tau=tau, name="run")
    >>> log.q.shape
    (2, 400)
    """

    t: Array
    q: Array
    tau: Array
    dq: Array | None = None
    name: str = "log"
    notes: tuple[str, ...] = ()
    simulated: bool = False
    torque_limit: Array | None = None
    breaks: tuple[int, ...] = ()
    left_out: NDArray[np.bool_] | None = None
    block: int = 1

    def __post_init__(self) -> None:
        """Check the arrays, and take them as double precision."""
        if not isinstance(self.name, str) or self.name.splitlines() != [self.name]:
            raise InputError.at("name", repr(self.name)[:60], "one line of text")
        if isinstance(self.notes, str):
            raise InputError.at(f"{self.name}: notes", repr(self.notes)[:60], "a tuple of lines")
        n = np.size(self.t)
        for field, shape in (("t", (n,)), ("q", (2, n)), ("tau", (2, n)), ("dq", (2, n)), ("torque_limit", (2,))):
            if (given := getattr(self, field)) is not None or field in ("t", "q", "tau"):
                object.__setattr__(self, field, _numbers(f"{self.name}: {field}", given, shape))
        if self.torque_limit is not None and self.torque_limit.min() <= 0.0:
            raise InputError.at(f"{self.name}: torque_limit", self.torque_limit, "numbers above 0")
        if any(not isinstance(k, int) or not 0 < k < n for k in self.breaks):
            raise InputError.at(f"{self.name}: breaks", self.breaks, f"whole numbers from 1 to {n - 1}")
        if self.left_out is not None and (self.left_out.shape, self.left_out.dtype) != ((2, n), np.dtype(np.bool_)):
            found = f"{self.left_out.dtype} of shape {self.left_out.shape}"
            raise InputError.at(f"{self.name}: left_out", found, f"bool of shape {(2, n)}")
        if not isinstance(self.block, int) or self.block < 1:
            raise InputError.at(f"{self.name}: block", self.block, "a whole number from 1")
        wrong = np.flatnonzero(np.diff(self.t) <= 0.0)
        if wrong.size:
            k = int(wrong[0]) + 1
            found = f"{self.t[k]:.10g} after {self.t[k - 1]:.10g}"
            raise InputError.at(f"{self.name}: t[{k}]", found, "time that increases")

    def piece(self, begin: int, end: int) -> "Log":
        """Cut out samples ``begin ... end - 1``."""
        cut = {name: x[..., begin:end] for name in _SIGNALS if (x := getattr(self, name)) is not None}
        return replace(self, **cut, breaks=())

    @cached_property
    def pieces(self) -> tuple["Log", ...]:
        """The log cut at its breaks."""
        edges = (0, *self.breaks, self.t.size)
        return tuple(self.piece(*pair) for pair in pairwise(edges)) if self.breaks else (self,)

    @property
    def longest(self) -> "Log":
        """The piece with the most samples."""
        return max(self.pieces, key=lambda piece: piece.t.size)


Settings = TypeVarTuple("Settings")
Computed = TypeVar("Computed")


def cached_per_log(function: Callable[[Log, *Settings], Computed]) -> Callable[[Log, *Settings], Computed]:
    """Cache a function of a log and settings, which are hashable, for as long as the log lives."""
    results: WeakKeyDictionary[Log, dict[tuple[*Settings], Computed]] = WeakKeyDictionary()

    @wraps(function)
    def cached(log: Log, *settings: *Settings) -> Computed:
        of_log = results.setdefault(log, {})
        if settings not in of_log:
            of_log[settings] = function(log, *settings)
        return of_log[settings]

    return cached


def _numbers(place: str, given: object, shape: tuple[int, ...]) -> Array:
    """Give an array of finite real numbers of this shape."""
    try:
        array = np.asarray(given)
    except ValueError:
        raise InputError.at(place, "rows of different lengths", f"shape {shape}") from None
    if np.ma.is_masked(given):
        raise InputError.at(place, "masked values", "a value for each sample")
    if array.dtype.kind not in "iuf":
        raise InputError.at(place, f"values of type {array.dtype}", "real numbers")
    if array.shape != shape:
        raise InputError.at(place, f"shape {array.shape}", f"shape {shape}")
    numbers = np.asarray(array, dtype=np.float64)
    if (bad := np.argwhere(~np.isfinite(numbers))).size:
        found = f"{len(bad)} numbers that are not finite, the first at index {bad[:, -1].min()}"
        raise InputError.at(place, found, "none; leave these samples out")
    return numbers


MIN_LENGTH_S, MIN_SAMPLES = 2.0, 200  # shortest log, and fewest samples
MIN_RANGE_RAD = 0.02  # range of positions below which a joint does not move
HALF_SPAN = 0.02  # half the time that a difference spans, s


@cached_per_log
def period(log: Log) -> float:
    """Typical time from one sample to the next, s."""
    return float(np.median(np.diff(log.t)))


def recorded_period(log: Log) -> float:
    """Typical time from one recorded sample to the next, s, also of a log that consists of means."""
    return period(log) / log.block


def half_window(log: Log) -> int:
    """Number of samples to each side that a difference spans."""
    return max(1, round(HALF_SPAN / period(log)))


def speed(log: Log) -> Array:
    """Velocity (2, N - 2 w) by central differences over about 40 ms, rad/s; w is `half_window`."""
    w = half_window(log)
    return np.asarray((log.q[:, 2 * w :] - log.q[:, : -2 * w]) / (log.t[2 * w :] - log.t[: -2 * w]))


MAX_BRIDGED_SAMPLES = 5  # most samples in a row that may be missing and are bridged
MAX_PERIOD_RATIO = 2.5  # time between samples over the typical period: above it samples are missing
_MAX_UNEVENNESS = 1e-3  # deviation from even spacing, in periods, that is ignored
_MIN_PERIOD_RATIO = 0.25  # the same below which a sample adds nothing but a wrong slope


def missing_samples(log: Log) -> Array:
    """Count the samples missing before each but the first (N - 1,)."""
    periods = np.diff(log.t) / period(log)
    return np.where(periods > MAX_PERIOD_RATIO, np.rint(periods) - 1.0, 0.0)


def uniform(log: Log) -> Log:
    """Resample to the typical period, each piece between long gaps by itself; `log` itself if it is even."""
    if log.breaks or log.left_out is not None:
        return log
    pieces = segments(log)
    if bridged := sum(int(missing_samples(piece).sum()) for piece in pieces):
        note = f"{bridged} missing samples are bridged by interpolation"
        pieces = [replace(piece, notes=(*piece.notes, note)) for piece in pieces]
    even = [_even(piece) for piece in pieces]
    if even[0] is log:
        return log
    notes = max(even, key=lambda piece: piece.t.size).notes
    return join_pieces(log, [replace(piece, t=piece.t - log.t[0], notes=notes) for piece in even])


def join_pieces(log: Log, pieces: Sequence[Log]) -> Log:
    """Replace the samples of a log by those of pieces of it, with breaks between them and the notes of the first."""
    names = [name for name in _SIGNALS if getattr(log, name) is not None]
    joined: dict[str, Any] = {
        name: np.concatenate([getattr(piece, name) for piece in pieces], axis=-1) for name in names
    }
    breaks = tuple(np.cumsum([piece.t.size for piece in pieces[:-1]], dtype=int).tolist())
    return replace(log, **joined, breaks=breaks, notes=pieces[0].notes)


MIN_BURSTS = 10  # gaps of a log that is nothing but bursts


def segments(log: Log) -> list[Log]:
    """Cut a log at its long gaps; gives the pieces that are long enough, with a note."""
    gaps = np.flatnonzero(missing_samples(log) > MAX_BRIDGED_SAMPLES)
    if not gaps.size:
        return [log]
    pieces = [log.piece(*edges) for edges in pairwise((0, *(gaps + 1).tolist(), log.t.size))]
    seconds = [float(piece.t[-1] - piece.t[0]) for piece in pieces]
    used = [s >= MIN_LENGTH_S and piece.t.size >= MIN_SAMPLES for s, piece in zip(seconds, pieces, strict=True)]
    summary = f"{gaps.size} gap{'s' * (gaps.size > 1)} of up to {float(np.diff(log.t).max()):.3g} s"
    if not any(used):
        samples = pieces[int(np.argmax(seconds))].t.size
        found = f"{summary}, {max(seconds):.3g} s ({samples} samples) between them"
        expected = f"{MIN_LENGTH_S:g} s ({MIN_SAMPLES} samples) without a long gap"
        if gaps.size > MIN_BURSTS:  # the samples are read together, long after they were taken
            first, last = gaps[0] + 1, gaps[-1] + 1  # of two bursts
            rate = (last - first) / float(log.t[last] - log.t[first])
            found += ", as where a PC reads samples in bursts"
            expected += f"; if they are evenly spaced, write into the arm file: sampling_rate: {rate:.4g}"
        raise InputError.at(f"{log.name}: time", found, expected)
    lengths = ", ".join(f"{s:.4g}" for s, is_used in zip(seconds, used, strict=True) if is_used)
    short = f"; {used.count(False)} too short, left out" if not all(used) else ""
    note = f"{summary}: the log is used in {sum(used)} piece{'s' * (sum(used) > 1)} of {lengths} s{short}"
    return [replace(piece, notes=(*log.notes, note)) for piece, is_used in zip(pieces, used, strict=True) if is_used]


def _even(piece: Log) -> Log:
    """Resample a piece without long gaps at even times, with notes; itself if it is even."""
    n, h, notes = piece.t.size, period(piece), list(piece.notes)
    k = np.arange(n) - 0.5 * (n - 1)
    even = piece.t.mean() + k * (k @ piece.t) / (k @ k)  # the line through the times by least squares
    deviation = float(np.abs(piece.t - even).max())
    if deviation <= _MAX_UNEVENNESS * h:
        return piece
    # The power of ten, s, of which all times are multiples, 1 ns at the finest
    digits = (digits for digits in range(1, 9) if np.abs(piece.t - np.round(piece.t, digits)).max() < 1e-9)
    step = 10.0 ** -next(digits, 9)
    if deviation <= 1.01 * step:
        rate = (n - 1) / (even[-1] - even[0])
        notes.append(f"times are rounded to {step:g} s; samples are taken as evenly spaced at {rate:.6g} Hz")
        return replace(piece, t=piece.t[0] + even - even[0], notes=tuple(notes))
    indices = _at_least_apart(piece.t, _MIN_PERIOD_RATIO * h)
    if indices.size < n:
        notes.append(
            f"{n - indices.size} samples less than {1e3 * _MIN_PERIOD_RATIO * h:.2g} ms after another are left out"
        )
    last = piece.t[indices[-1]]
    t = piece.t[0] + h * np.arange(int((last - piece.t[0]) / h + _MAX_UNEVENNESS) + 1)
    at = np.minimum(t, last)
    # Positions are smooth; torques may jump, and a cubic without overshoot keeps them within their limits.
    q = CubicSpline(piece.t[indices], piece.q[:, indices], axis=1)(at)
    dq = None if piece.dq is None else CubicSpline(piece.t[indices], piece.dq[:, indices], axis=1)(at)
    tau = PchipInterpolator(piece.t[indices], piece.tau[:, indices], axis=1)(at)
    notes.append(f"resampled to an even {1.0 / h:.6g} Hz")
    return replace(piece, t=t, q=q, tau=tau, dq=dq, notes=tuple(notes))


def _at_least_apart(t: Array, least: float) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """Pick samples each at least so far from the one before."""
    indices = [0]
    for k in range(1, t.size):
        if t[k] - t[indices[-1]] >= least:
            indices.append(k)
    return np.array(indices)
