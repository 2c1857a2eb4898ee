"""Instants of a log: dates and clock times, counters that wrap, and signals that come at instants of their own."""

import datetime
import re

import numpy as np
from numpy.typing import NDArray

from repro.model.parameters import Array

#: A clock time, perhaps behind a date with the year first or last, perhaps with a time zone, which all rows share.
_STAMP = re.compile(
    r"(?:(\d{4}|\d{1,2})[-/.](\d{1,2})[-/.](\d{4}|\d{1,2})(?:T|,?\s+))?"
    r"(\d{1,2}):(\d{2}):(\d{2}(?:[.,]\d*|:\d{3,})?)\s*([AP]M)?(?:Z|UTC|[+-]\d{2}:?\d{2})?",
    re.IGNORECASE,
)
#: Date and clock time of ISO 8601 without separators.
_BASIC = re.compile(r"(\d{4})(\d{2})(\d{2})T(\d{2})(\d{2})(\d{2})")
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
    match = _STAMP.fullmatch(_BASIC.sub(r"\1-\2-\3T\4:\5:\6", cell.strip("[]() \t")))
    if not match:
        return None
    *date, hours, minutes, seconds, half = match.groups()
    hour = int(hours) if half is None else int(hours) % 12 + 12 * (half.lower() == "pm")
    of_day = 3600.0 * hour + 60.0 * int(minutes) + float(re.sub("[,:]", ".", seconds))
    if date[0] is None:
        return of_day
    if (len(date[0]) == 4) == (len(date[2]) == 4):  # a year of two digits could be any of the three
        return None
    year, month, day = map(int, date if len(date[0]) == 4 else date[::-1])
    if month > 12 and len(date[0]) < 4:  # the month first, as in the United States
        month, day = day, month
    try:
        return DAY_S * (datetime.date(year, month, day).toordinal() - _EPOCH) + of_day
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
            lowest = 0.0 if time.min() >= 0.0 else -modulus / 2.0  # a signed counter goes on at its lowest value
            within = time.min() >= lowest and time.max() < lowest + modulus
            if within and ((over > 0.0) & (over <= _MAX_STEPS * usual)).all():
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


#: Fraction of a power of two or ten that counts fill which wrap there, and largest step that is left.
_MIN_FILLED, _MAX_LEFT = 0.9, 0.25


def unwrapped(counts: Array) -> tuple[Array, int]:
    """Unwrap counts (N,) of an encoder that begin again at a power of two or ten; also which, 0 if they do not."""
    size = max(float(np.ptp(counts)), 1.0) + 1.0
    moduli = (2.0 ** np.ceil(np.log2(size)), 10.0 ** np.ceil(np.log10(size)))
    continued = [(x, int(modulus)) for modulus in moduli if (x := _continued_at(counts, modulus)) is not None]
    return min(continued, key=lambda pair: float(np.abs(np.diff(pair[0], 2)).sum()), default=(counts, 0))


def _continued_at(counts: Array, modulus: float) -> Array | None:
    """Continue counts (N,) that begin again at `modulus`; None if they do not."""
    steps = np.diff(counts)
    jumps = np.where(np.abs(steps) > modulus / 2.0, -np.sign(steps), 0.0)
    if not jumps.any() or np.ptp(counts) < _MIN_FILLED * modulus or (counts != np.rint(counts)).any():
        return None
    if np.abs(steps + modulus * jumps).max() > _MAX_LEFT * modulus:
        return None
    return np.asarray(counts + modulus * np.concatenate([[0.0], np.cumsum(jumps)]))
