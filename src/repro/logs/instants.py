"""Instants of a log: dates and clock times, counters that wrap, and signals that come at instants of their own."""

import datetime
import re

import numpy as np
from numpy.typing import NDArray

from repro.model.parameters import Array

#: A clock time, perhaps behind a date, perhaps with a time zone, which all rows share.
_STAMP = re.compile(
    r"(?:(\d{4})[-/.](\d{1,2})[-/.](\d{1,2})(?:T|\s+))?(\d{1,2}):(\d{2}):(\d{2}(?:[.,]\d*)?)\s*(?:Z|UTC|[+-]\d{2}:?\d{2})?"
)
_EPOCH = datetime.date(1970, 1, 1).toordinal()
DAY_S = 86400.0
#: Where counters begin again, in their own unit: of 32 and 16 bits, also with ms or us as s, and a clock at midnight.
_WRAPS = {
    "a counter of 32 bits": (2.0**32, 2.0**32 * 1e-3, 2.0**32 * 1e-6),
    "a counter of 16 bits": (2.0**16, 2.0**16 * 1e-3),
    "a clock at midnight": (DAY_S,),
}
#: Largest step over a wrap, in usual steps.
_MAX_STEPS = 20.0
#: Fraction of full rows below which signals come at instants of their own.
_MIN_FULL = 0.5


def seconds_of(cell: str) -> float | None:
    """Give a date with a clock time as s since 1970, a clock time as s since midnight; None for anything else."""
    match = _STAMP.fullmatch(cell.strip())
    if not match:
        return None
    *date, hours, minutes, seconds = match.groups()
    of_day = 3600.0 * int(hours) + 60.0 * int(minutes) + float(seconds.replace(",", "."))
    if date[0] is None:
        return of_day
    try:
        return DAY_S * (datetime.date(*map(int, date)).toordinal() - _EPOCH) + of_day
    except ValueError:  # no such day
        return None


def continued(time: Array) -> tuple[Array, str]:
    """Continue a counter (N,) that wraps; also what it is, empty if it does not wrap."""
    steps = np.diff(time)
    back = steps < 0.0
    if not back.any() or back.mean() > 0.1:
        return time, ""
    usual = float(np.median(steps[~back]))
    for name, moduli in _WRAPS.items():
        for modulus in moduli:
            over = steps[back] + modulus
            if time.max() < modulus and time.min() >= 0.0 and ((over > 0.0) & (over <= _MAX_STEPS * usual)).all():
                return time + modulus * np.concatenate([[0.0], np.cumsum(back)]), name
    return time, ""


def merged(values: Array, needed: NDArray[np.bool_], time: int) -> tuple[Array, NDArray[np.intp], str]:
    """Merge rows of one instant (k, N), then interpolate signals at different instants to those of the fewest.

    Returns the values, the rows that they begin in, and how they were made, empty where they stay. Signals that are not
    `needed`, such as velocities, are interpolated where they can be.
    """
    rows = np.arange(values.shape[1])
    others = needed & (np.arange(len(values)) != time)
    if not others.any() or _full(values[others]).mean() >= _MIN_FULL or np.isnan(values[time]).any():
        return values, rows, ""
    first = np.concatenate([[True], np.diff(values[time]) != 0.0])
    if not first.all():
        group, whole = np.cumsum(first) - 1, np.full((len(values), int(first.sum())), np.nan)
        for k, signal in enumerate(values):
            there = np.flatnonzero(~np.isnan(signal))[::-1]  # backwards, so that the first value stays
            whole[k, group[there]] = signal[there]
        values, rows = whole, rows[first]
        if _full(values[others]).mean() >= _MIN_FULL:
            return values, rows, "rows of one instant are merged"
    known = [np.flatnonzero(~np.isnan(signal)) for signal in values]
    if (np.diff(values[time]) <= 0.0).any() or min(known[k].size for k in np.flatnonzero(others)) < 2:
        return values, rows, ""
    fewest = min(np.flatnonzero(others), key=lambda k: known[k].size)
    begin = max(known[k][0] for k in np.flatnonzero(others))
    end = min(known[k][-1] for k in np.flatnonzero(others))
    grid = known[fewest][(known[fewest] >= begin) & (known[fewest] <= end)]
    made = np.full((len(values), grid.size), np.nan)
    for k, signal in enumerate(values):
        if known[k].size > 1:
            made[k] = np.interp(values[time, grid], values[time, known[k]], signal[known[k]], left=np.nan, right=np.nan)
    return made, rows[grid], "signals come at different instants; all are interpolated to those of one of them"


def _full(values: Array) -> NDArray[np.bool_]:
    """Whether each row has a value of every signal."""
    return np.asarray(~np.isnan(values).any(axis=0))


#: Fraction of a power of two that counts fill which wrap there, and largest step that is left.
_MIN_FILLED, _MAX_LEFT = 0.9, 0.25


def unwrapped(counts: Array) -> tuple[Array, int]:
    """Unwrap counts (N,) of an encoder that begin again at a power of two; also which, 0 if they do not."""
    span = float(np.ptp(counts))
    modulus = 2.0 ** np.ceil(np.log2(max(span, 1.0) + 1.0))
    steps = np.diff(counts)
    jumps = np.where(np.abs(steps) > modulus / 2.0, -np.sign(steps), 0.0)
    if not jumps.any() or span < _MIN_FILLED * modulus or (counts != np.rint(counts)).any():
        return counts, 0
    if np.abs(steps + modulus * jumps).max() > _MAX_LEFT * modulus:
        return counts, 0
    return counts + modulus * np.concatenate([[0.0], np.cumsum(jumps)]), int(modulus)
