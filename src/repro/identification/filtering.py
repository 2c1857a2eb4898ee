"""A log made into a linear regression, tau = Y beta, with torque and regressor through one filter.

The position is smoothed and differentiated with a wide filter, so that Eq. 1's sines and signs see the motion as it
was; then each column of the regressor and the torque go through the narrow one ("parallel filtering"), which
keeps their relation exactly because it is linear. The torque also goes through the wide filter, as the motion did.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.fft import prev_fast_len
from scipy.interpolate import CubicSpline
from scipy.ndimage import spline_filter1d

from repro.identification.filters import FILTERS
from repro.identification.regression import Regression, joined
from repro.logs.log import Log, period
from repro.model.dynamics import LAMBDA, regressor
from repro.model.parameters import Array

#: Samples of a log that is long enough to be shortened to a length that is quickly transformed.
LONG = 4096


@dataclass(frozen=True)
class FilterSettings:
    """How a log is filtered.

    Attributes
    ----------
    name : str
        Key of `repro.identification.filters.FILTERS`.
    cutoff : float
        Half-power frequency of torque and regressor, Hz.
    width : float
        Half-power frequency of the motion's own filter over `cutoff`.
    delay : float
        The torque acts this much later than it was recorded, s.
    friction_steepness : float
        lambda of Eq. 1, s/rad.
    cut : float
        Length left out at each end, s.
    samples_per_cycle : float
        Samples kept in a period of the cut-off: the rest repeat what these say.
    """

    name: str = "dct"
    cutoff: float = 5.0
    width: float = 4.0
    delay: float = 0.0
    friction_steepness: float = LAMBDA
    cut: float = 0.3
    samples_per_cycle: float = 8.0


def wide(settings: FilterSettings, h: float) -> float:
    """Half-power frequency of the motion's own filter, Hz."""
    return min(settings.width * settings.cutoff, 0.45 / h)


def motion(q: Array, h: float, settings: FilterSettings) -> tuple[Array, Array, Array]:
    """Smoothed position and its derivatives.

    Parameters
    ----------
    q : array of shape (2, N)
        Position, rad.
    h : float
        Sampling period, s.
    settings : FilterSettings
        Filter.

    Returns
    -------
    q, dq, ddq : arrays of shape (2, N)
        rad, rad/s, rad/s^2.
    """
    smooth = FILTERS[settings.name].apply
    top = wide(settings, h)
    return smooth(q, h, top, 0), smooth(q, h, top, 1), smooth(q, h, top, 2)


def narrow(columns: Array, h: float, settings: FilterSettings) -> Array:
    """Columns of shape (2, N, k) through the narrow filter."""
    return np.moveaxis(FILTERS[settings.name].apply(np.moveaxis(columns, -1, 0), h, settings.cutoff, 0), 0, -1)


def filtered_regressor(moved: tuple[Array, Array, Array], h: float, settings: FilterSettings) -> Array:
    """Regressor of a motion through the narrow filter, shape (2, N, 9)."""
    return narrow(regressor(*moved, settings.friction_steepness), h, settings)


def filtered_torque(tau: Array, h: float, settings: FilterSettings) -> Array:
    """Torque through both filters and moved by the delay, shape (2, N)."""
    smooth = FILTERS[settings.name].apply
    tau = smooth(smooth(tau, h, wide(settings, h), 0), h, settings.cutoff, 0)
    if settings.delay == 0.0:
        return tau
    t = h * np.arange(tau.shape[-1])
    moved: Array = CubicSpline(t, tau, axis=-1)(t - settings.delay)
    return moved


def kept(log: Log, settings: FilterSettings) -> tuple[int, NDArray[np.intp]]:
    """Samples of a log that are filtered, the first so many, and the numbers of those that are kept of them.

    Raises
    ------
    ValueError
        If nothing is left between the cuts.
    """
    h, n = period(log), log.t.size
    if n > LONG:  # a cosine transform of a length with large prime factors takes five times as long
        n = prev_fast_len(n)
    margin = max(round(settings.cut / h), 1)
    step = max(int(1.0 / (settings.samples_per_cycle * settings.cutoff * h)), 1)
    keep = np.arange(margin, n - margin, step)
    if keep.size < 2:
        raise ValueError(f"log: {n} samples leave nothing between cuts of {margin} at both ends.")
    return n, keep


def _between(x: Array, at: Array) -> Array:
    """Cubic spline through evenly spaced samples, shape (2, n, k), at places counted in samples, away from the ends."""
    c, first = spline_filter1d(x, axis=1), np.floor(at).astype(np.intp)
    f = (at - first)[:, np.newaxis]
    weights = ((1 - f) ** 3, 4 - 6 * f**2 + 3 * f**3, 1 + 3 * f + 3 * f**2 - 3 * f**3, f**3)  # of the B-splines around
    around = (np.clip(first + k, 0, x.shape[1] - 1) for k in range(-1, 3))
    value: Array = sum((w * c[:, i] for w, i in zip(weights, around, strict=True)), np.zeros(())) / 6
    return value


def prepare(log: Log, settings: FilterSettings) -> Regression:
    """Filter, cut and thin out, each piece of the log on its own.

    Parameters
    ----------
    log : Log
        Uniformly sampled. Of a long one the last few samples, at most 1 in 50, may be left out.
    settings : FilterSettings
        Filters, delay, cut.

    Returns
    -------
    Regression
        Ready for any method.

    Raises
    ------
    ValueError
        If nothing is left between the cuts.
    """
    parts = [_piece(piece, settings) for piece in log.pieces]
    return parts[0] if len(parts) == 1 else replace(joined(parts), t=np.concatenate([part.t for part in parts]))


def _piece(log: Log, settings: FilterSettings) -> Regression:
    """Regression of a log in one piece."""
    h = period(log)
    n, keep = kept(log, settings)
    time, recorded, torque = log.t[:n], log.q[:, :n], log.tau[:, :n]
    moved = motion(recorded, h, settings)
    y = filtered_regressor(moved, h, settings)
    halves = []
    for first in (0, 1):
        there = slice(first, None, 2)
        half = filtered_regressor(motion(recorded[:, there], 2 * h, settings), 2 * h, settings)
        halves.append(_between(half, (keep - first) / 2))
    tau = filtered_torque(torque, h, settings)
    q, dq, ddq = (x[:, keep] for x in moved)
    counts = np.ones(q.shape, dtype=np.bool_)
    return Regression(
        time[keep], y[:, keep], tau[:, keep], q, dq, ddq, counts, (keep[1] - keep[0]) * h, np.stack(halves)
    )
