"""A recording at evenly spaced instants: jitter is interpolated away, short gaps are bridged, long ones cut."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator

from repro.errors import InputError
from repro.logs.checks import FEWEST, SHORTEST
from repro.logs.log import Log
from repro.logs.speed import period
from repro.model.parameters import Array

#: Most samples in a row that may be missing and are bridged.
LONGEST_BRIDGE = 5
#: Period from one sample to the next, in typical ones, above which samples are missing.
GAP = 2.5
#: Deviation from even spacing, in periods, that is none.
_EVEN = 1e-3
#: Samples that follow sooner, in periods, tell nothing new but a wild slope.
_TOO_CLOSE = 0.25


def missing_samples(log: Log) -> Array:
    """How many samples are missing before each but the first.

    Parameters
    ----------
    log : Log
        Recording of N samples.

    Returns
    -------
    array of shape (N - 1,)
        Whole numbers; zero where the time to the next sample is at most 2.5 typical periods.
    """
    periods = np.diff(log.t) / period(log)
    return np.where(periods > GAP, np.rint(periods) - 1.0, 0.0)


def uniform(log: Log) -> Log:
    """Resample to the typical period.

    Parameters
    ----------
    log : Log
        Recording of N samples.

    Returns
    -------
    Log
        Evenly spaced; notes say what was done. `log` itself if it is evenly spaced.

    Raises
    ------
    InputError
        If no stretch without a long gap is long enough.
    """
    piece, notes = longest_stretch(log)
    n, h = piece.t.size, period(piece)
    even = _line(piece.t)
    deviation = float(np.abs(piece.t - even).max())
    step = _resolution(piece.t)
    if deviation <= _EVEN * h:
        return log if piece is log else replace(piece, notes=(*log.notes, *notes))
    if deviation <= 1.01 * step:
        rate = (n - 1) / (even[-1] - even[0])
        notes.append(f"times are rounded to {step:g} s; samples are taken as evenly spaced at {rate:.6g} Hz")
        return replace(piece, t=even - even[0], notes=(*log.notes, *notes))
    bridged = int(missing_samples(piece).sum())
    if bridged:
        notes.append(f"{bridged} missing samples are bridged by interpolation")
    kept = _apart(piece.t, _TOO_CLOSE * h)
    if kept.size < n:
        notes.append(f"{n - kept.size} samples less than {1e3 * _TOO_CLOSE * h:.2g} ms after another are left out")
    last = piece.t[kept[-1]]
    t = np.asarray(h * np.arange(int((last - piece.t[0]) / h + _EVEN) + 1), dtype=np.float64)
    at = np.minimum(piece.t[0] + t, last)
    # Positions are smooth; torques may jump, and a cubic without overshoot keeps them within their limits.
    q = CubicSpline(piece.t[kept], piece.q[:, kept], axis=1)(at)
    tau = PchipInterpolator(piece.t[kept], piece.tau[:, kept], axis=1)(at)
    dq = None if piece.dq is None else CubicSpline(piece.t[kept], piece.dq[:, kept], axis=1)(at)
    notes.append(f"resampled to an even {1.0 / h:.6g} Hz")
    return replace(piece, t=t, q=q, tau=tau, dq=dq, notes=(*log.notes, *notes))


def longest_stretch(log: Log) -> tuple[Log, list[str]]:
    """Cut a log to its longest stretch without a long gap.

    Parameters
    ----------
    log : Log
        Recording.

    Returns
    -------
    stretch : Log
        `log` itself if it has no long gap.
    notes : list of str
        What was left out.

    Raises
    ------
    InputError
        If the stretch is too short.
    """
    breaks = np.flatnonzero(missing_samples(log) > LONGEST_BRIDGE)
    if not breaks.size:
        return log, []
    edges = [0, *(int(k) + 1 for k in breaks), log.t.size]
    begin, end = max(pairwise(edges), key=lambda piece: log.t[piece[1] - 1] - log.t[piece[0]])
    length = log.t[end - 1] - log.t[begin]
    worst = float(np.diff(log.t).max())
    if length < SHORTEST or end - begin < FEWEST:
        found = f"{breaks.size} gaps of up to {worst:.3g} s, {length:.3g} s ({end - begin} samples) between them"
        raise InputError.at(f"{log.name}: time", found, f"{SHORTEST:g} s ({FEWEST} samples) without a long gap")
    note = (
        f"{breaks.size} gaps of up to {worst:.3g} s; used are the {length:.4g} s from {log.t[begin]:.4g} s on, "
        "the longest stretch without one"
    )
    cut = slice(begin, end)
    dq = None if log.dq is None else log.dq[:, cut]
    return replace(log, t=log.t[cut] - log.t[begin], q=log.q[:, cut], tau=log.tau[:, cut], dq=dq), [note]


def _line(t: Array) -> Array:
    """Evenly spaced instants nearest to those given, in the mean square."""
    k = np.arange(t.size) - 0.5 * (t.size - 1)
    return np.asarray(t.mean() + k * (k @ t) / (k @ k))


def _resolution(t: Array) -> float:
    """Power of ten, s, that all times are multiples of; the finest looked for is 1 ns."""
    for digits in range(1, 9):
        if float(np.abs(t - np.round(t, digits)).max()) < 1e-9:
            return 10.0**-digits
    return 1e-9


def _apart(t: Array, least: float) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """Indices of samples that are all at least so far from the one before."""
    if float(np.diff(t).min()) >= least:
        return np.arange(t.size)
    kept = [0]
    for k in range(1, t.size):
        if t[k] - t[kept[-1]] >= least:
            kept.append(k)
    return np.array(kept)
