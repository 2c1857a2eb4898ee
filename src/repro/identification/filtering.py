"""From a log to a linear regression, tau = Y beta, with torque and regressor through the same filters.

Parallel filtering (Swevers and others): the position is smoothed and differentiated with a wide filter, so that Eq. 1's
sines and signs see the true motion; then each column of the regressor and the torque go through the narrow filter,
which keeps their relation exactly because it is linear. The torque also goes through the wide filter.

The cut-off is the lower of two limits: of the position over its noise, and of the squared coherence of recorded and
rebuilt torque. The second is not enough: a controller answers noise with torque, and the two agree on that.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.fft import dct, idct, idst, prev_fast_len, rfft, rfftfreq
from scipy.interpolate import CubicSpline
from scipy.ndimage import spline_filter1d

from repro.errors import InputError
from repro.identification.log import Log, cached_per_log, period, recorded_period
from repro.identification.regression import Regression, correlation_time, joined, masked, solve
from repro.model.dynamics import LAMBDA, regressor
from repro.model.parameters import Array

#: Position, velocity and acceleration, each of shape (..., 2, N): rad, rad/s, rad/s^2.
Moved = tuple[Array, Array, Array]

#: Samples of a log that is long enough to be shortened to a length that is quickly transformed.
MIN_SHORTENED_SAMPLES = 4096
#: Squared coherence of the torque, of both joints, and amplitude of the position over its noise, of the better joint.
MIN_COHERENCE, MIN_SIGNAL_TO_NOISE = 0.5, 10.0
MIN_CUTOFF_HZ, MAX_CUTOFF_HZ = 1.0, 10.0  # range of the cut-off
SEGMENT = 3.0  # length of a segment of the spectra, s
#: Coefficients of the cosines that add up to a window of the spectra.
HANN, BLACKMAN_HARRIS = (0.5, 0.5), (0.35875, 0.48829, 0.14128, 0.01168)
#: Values of lambda that are tried, s/rad: from friction that sets in over 0.2 rad/s to one that is a step.
STEEPNESS_GRID = (5.0, 10.0, 20.0, 50.0, 100.0, 200.0)
MAX_DELAY, N_DELAYS = 0.02, 11  # largest delay that is searched, s, and number of delays
MAX_EXPECTED_DELAY = 2.0  # latest delay that a drive is expected to have, sampling periods: any other needs evidence
MIN_ERROR_REDUCTION = 0.2  # fraction of the squared error by which an effect must reduce it
MAX_CONTAMINATION = 0.05  # part of torques that did not act in a low-passed torque, above which it is left out
BUTTERWORTH_ORDER = 4
#: Degree, and half-power frequency of a window of 2 m + 1 samples times m + 1/2, in half the sampling rate, to 1 %.
SAVITZKY_GOLAY_DEGREE, SAVITZKY_GOLAY_HALF_POWER = 3, 1.066


# Zero-phase low-pass filters that differentiate. All take the half-power frequency, so they can be exchanged.


def dct_pair(x: Array, h: float, cutoff: float, order: int = 0) -> Array:
    """Apply the paper's DCT low-pass (Eq. 6, 14) with derivatives that keep the phase.

    The paper's backward difference lags by half a sample at each order. Here the cosine series itself is
    differentiated: with s = t + h/2, sum_k X_k cos(omega_k s) becomes -sum_k omega_k X_k sin(omega_k s). A signal that
    moves at an end has a kink there; the Gaussian keeps its effect within a few sqrt(2 c_f).
    """
    n = x.shape[-1]
    omega = np.pi * np.arange(n) / (n * h)
    c_f = 0.5 * np.log(2.0) / (2.0 * np.pi * cutoff) ** 2  # s^2; the gain exp(-c_f omega^2) is 1/sqrt(2) at the cut-off
    bands = np.asarray(dct(x, type=2, norm="ortho", axis=-1))
    bands *= np.exp(-c_f * omega**2)  # in place, and below too: fresh memory costs as much time as the transform
    if order == 0:
        return np.asarray(idct(bands, type=2, norm="ortho", axis=-1, overwrite_x=True))
    if order == 2:
        bands *= -(omega**2)
        return np.asarray(idct(bands, type=2, norm="ortho", axis=-1, overwrite_x=True))
    # The k-th sine of the orthonormal DST-II is band k + 1; the last, at half the sampling rate, has no partner.
    sines = np.concatenate([-(omega * bands)[..., 1:], np.zeros_like(bands[..., :1])], axis=-1)
    return np.asarray(idst(sines, type=2, norm="ortho", axis=-1))


def savitzky_golay(x: Array, h: float, cutoff: float, order: int = 0) -> Array:
    """Fit a cubic to a moving window, or its derivative; see `Filter.apply`."""
    from scipy.signal import savgol_filter  # noqa: PLC0415  (a third of a second that the default filter does not need)

    half = max(round(SAVITZKY_GOLAY_HALF_POWER / (2.0 * cutoff * h) - 0.5), SAVITZKY_GOLAY_DEGREE)
    window = min(2 * half + 1, (x.shape[-1] - 1) // 2 * 2 + 1)
    return savgol_filter(x, window, SAVITZKY_GOLAY_DEGREE, deriv=order, delta=h, axis=-1)


def butterworth(x: Array, h: float, cutoff: float, order: int = 0) -> Array:
    """Apply a Butterworth low-pass forwards and backwards, with central differences."""
    from scipy.signal import butter, sosfiltfilt  # noqa: PLC0415  (as above)

    # The gain 1 / (1 + (f / f_0)^8) of both passes is 1/sqrt(2) at f_0 (sqrt(2) - 1)^(1/8).
    corner = cutoff / (np.sqrt(2.0) - 1.0) ** (0.5 / BUTTERWORTH_ORDER)
    sos = butter(BUTTERWORTH_ORDER, min(2.0 * corner * h, 0.99), output="sos")
    smooth: Array = sosfiltfilt(sos, x, axis=-1)
    for _ in range(order):
        smooth = np.gradient(smooth, h, axis=-1, edge_order=2)
    return smooth


class Filter(NamedTuple):
    """A zero-phase low-pass; ``apply(x, h, cutoff, order)`` derives x (..., N) `order` times, 0 to 2; s and Hz."""

    description: str
    apply: Callable[[Array, float, float, int], Array]


FILTERS: dict[str, Filter] = {
    "dct": Filter("Gaussian on the DCT-II bands (Eq. 6), derivatives by the matching sine series", dct_pair),
    "savitzky-golay": Filter("Savitzky-Golay, cubic", savitzky_golay),
    "butterworth": Filter("Butterworth of order 4 run forwards and backwards, central differences", butterworth),
}


# Parallel filtering of a log.


@dataclass(frozen=True)
class FilterSettings:
    """How a log is filtered."""

    name: str = "dct"  # key of `FILTERS`
    cutoff: float = 5.0  # half-power frequency of torque and regressor, Hz
    width: float = 4.0  # half-power frequency of the motion's own filter over `cutoff`
    delay: float = 0.0  # the torque acts this much later than it was recorded, s
    friction_steepness: float = LAMBDA  # lambda of Eq. 1, s/rad
    stribeck_speed: float = 0.5  # at which Stribeck friction has fallen to 1/e of its value at rest, rad/s
    cut: float = 0.3  # length left out at each end, s
    samples_per_cycle: float = 8.0  # samples kept in a period of the cut-off: more would be redundant
    even_odd: bool = True  # whether a method needs `Regression.even_odd`


def motion_cutoff(settings: FilterSettings, h: float) -> float:
    """Half-power frequency of the motion's own filter, Hz."""
    return min(settings.width * settings.cutoff, 0.45 / h)


def smooth_motion(q: Array, h: float, settings: FilterSettings) -> Moved:
    """Smooth a position (2, N) and differentiate it twice."""
    smooth = FILTERS[settings.name].apply
    top = motion_cutoff(settings, h)
    return smooth(q, h, top, 0), smooth(q, h, top, 1), smooth(q, h, top, 2)


def filter_columns(columns: Array, h: float, settings: FilterSettings) -> Array:
    """Apply the narrow filter to columns (2, N, k)."""
    return np.moveaxis(FILTERS[settings.name].apply(np.moveaxis(columns, -1, 0), h, settings.cutoff, 0), 0, -1)


def filtered_regressor(moved: Moved, h: float, settings: FilterSettings) -> Array:
    """Compute the regressor (2, N, 9) of a motion through the narrow filter."""
    return filter_columns(regressor(*moved, settings.friction_steepness), h, settings)


def filtered_torque(tau: Array, h: float, settings: FilterSettings) -> Array:
    """Apply both filters to a torque (2, N) and shift it by the delay."""
    smooth = FILTERS[settings.name].apply
    tau = smooth(smooth(tau, h, motion_cutoff(settings, h), 0), h, settings.cutoff, 0)
    if settings.delay == 0.0:
        return tau
    t = h * np.arange(tau.shape[-1])
    return CubicSpline(t, tau, axis=-1)(t - settings.delay)


def retained_samples(log: Log, settings: FilterSettings) -> tuple[int, NDArray[np.intp]]:
    """Number of samples that are filtered, and the indices of those that are kept; InputError if none are."""
    h, n = period(log), log.t.size
    if n > MIN_SHORTENED_SAMPLES:  # a cosine transform of a length with large prime factors takes five times as long
        n = prev_fast_len(n)
    margin = max(round(settings.cut / h), 1)
    step = max(int(1.0 / (settings.samples_per_cycle * settings.cutoff * h)), 1)
    keep = np.arange(margin, n - margin, step)
    if keep.size < 2:
        found = f"{n} samples, which leave nothing between cuts of {margin} at both ends"
        raise InputError.at(log.name, found, "a longer log or a higher cut-off")
    return n, keep


def _interpolate(x: Array, at: Array) -> Array:
    """Evaluate a cubic spline through samples (2, n, k) at places counted in samples, away from the ends."""
    c, first = spline_filter1d(x, axis=1), np.floor(at).astype(np.intp)
    f = (at - first)[:, np.newaxis]
    weights = ((1 - f) ** 3, 4 - 6 * f**2 + 3 * f**3, 1 + 3 * f + 3 * f**2 - 3 * f**3, f**3)  # of the B-splines around
    around = (np.clip(first + k, 0, x.shape[1] - 1) for k in range(-1, 3))
    return sum((w * c[:, i] for w, i in zip(weights, around, strict=True)), np.zeros(())) / 6


def prepare(log: Log, settings: FilterSettings, even_odd: bool = True) -> Regression:
    """Filter, cut and decimate each piece of a uniformly sampled log; InputError if nothing remains."""
    parts = [_piece(piece, settings, even_odd and settings.even_odd) for piece in log.pieces]
    return parts[0] if len(parts) == 1 else replace(joined(parts), t=np.concatenate([part.t for part in parts]))


def _piece(log: Log, settings: FilterSettings, even_odd: bool) -> Regression:
    """Prepare a log in one piece."""
    h = period(log)
    n, keep = retained_samples(log, settings)
    of_motion = replace(settings, delay=0.0, stribeck_speed=0.0)  # neither changes what follows from the motion
    moved, y = _filtered_motion(log, of_motion)
    halves = _filtered_halves(log, of_motion) if even_odd else None
    tau = filtered_torque(log.tau[:, :n], h, settings)[:, keep]
    mask = np.ones(tau.shape, dtype=np.bool_)
    regression = Regression(log.t[:n][keep], y, tau, *moved, mask, (keep[1] - keep[0]) * h, halves)
    if log.left_out is None:
        return regression
    contamination = filtered_torque(log.left_out[:, :n].astype(np.float64), h, settings)[:, keep]
    return masked(regression, np.abs(contamination) <= MAX_CONTAMINATION)


@cached_per_log
def _filtered_motion(log: Log, settings: FilterSettings) -> tuple[Moved, Array]:
    """Motion and regressor of a log in one piece at the samples that are kept."""
    n, keep = retained_samples(log, settings)
    q, dq, ddq = smooth_motion(log.q[:, :n], period(log), settings)
    y = filtered_regressor((q, dq, ddq), period(log), settings)
    return (q[:, keep], dq[:, keep], ddq[:, keep]), y[:, keep]


@cached_per_log
def _filtered_halves(log: Log, settings: FilterSettings) -> Array:
    """`Regression.even_odd` of a log in one piece."""
    (n, keep), h = retained_samples(log, settings), 2 * period(log)
    motions = [smooth_motion(log.q[:, first:n:2], h, settings) for first in (0, 1)]
    halves = [filtered_regressor(motion, h, settings) for motion in motions]
    return np.stack([_interpolate(half, (keep - first) / 2) for first, half in enumerate(halves)])


# Choice of the cut-off.


@dataclass(frozen=True)
class Cutoff:
    """The choice of the cut-off and its reason."""

    hertz: float  # half-power frequency for `FilterSettings.cutoff`
    reason: str  # one line
    frequency: Array  # (m,), Hz
    coherence: Array  # squared coherence of recorded and rebuilt torque of each joint, (2, m)
    position: Array  # amplitude of the position over that of its noise, of each joint, (2, m)
    highest: float  # highest cut-off that could have been chosen, Hz
    by_noise: float = np.inf  # frequency above which the position is too near its noise, Hz


def choose_cutoff(log: Log, settings: FilterSettings) -> Cutoff:
    """Find the highest frequency that satisfies both limits: 1 to 10 Hz, but at most a tenth of the sampling rate."""
    rate = 1.0 / period(log)
    highest = min(MAX_CUTOFF_HZ, rate / 10.0)
    segment = min(round(SEGMENT * rate), log.longest.t.size // 4)
    q = [piece.q for piece in log.pieces]
    frequency, density = _density(q, q, rate, segment, BLACKMAN_HARRIS)
    # The noise is that of the upper half of the spectrum, where an arm does not move.
    noise = np.median(density.real[:, frequency > 0.25 * rate], axis=-1, keepdims=True)
    position = np.sqrt(density.real / np.where(noise > 0.0, noise, np.finfo(np.float64).tiny))
    band = (frequency >= MIN_CUTOFF_HZ) & (frequency <= highest)
    by_noise = _first_below(frequency[band], position.max(0)[band], MIN_SIGNAL_TO_NOISE)

    first = prepare(log, replace(settings, cutoff=min(3.0, highest)), even_odd=False)
    beta = solve(first.y, first.tau)
    every_sample = replace(settings, cutoff=2.0 * highest, samples_per_cycle=np.inf)
    wide = [prepare(replace(piece, left_out=None), every_sample, even_odd=False) for piece in log.pieces]
    tau, rebuilt = [piece.tau for piece in wide], [piece.y @ beta for piece in wide]
    if log.left_out is not None:  # a gap in the torque would show in its spectrum
        counts = [prepare(piece, every_sample, even_odd=False).mask for piece in log.pieces]
        tau = [np.where(mask, x, fitted) for mask, x, fitted in zip(counts, tau, rebuilt, strict=True)]
    segment = min(segment, max(piece.t.size for piece in wide) // 4)
    pairs = ((tau, rebuilt), (tau, tau), (rebuilt, rebuilt))
    (grid, cross), (_, measured), (_, modelled) = (_density(*pair, rate, segment, HANN) for pair in pairs)
    with np.errstate(divide="ignore", invalid="ignore"):  # no torque at all
        squared = np.nan_to_num(np.abs(cross) ** 2 / measured.real / modelled.real)
    coherence = np.stack([np.interp(frequency, grid, joint) for joint in squared])
    driven = log.tau.any(axis=-1)  # a joint without a drive has no torque to explain
    explained = (coherence[driven] if driven.any() else coherence).mean(0)
    by_coherence = _first_below(frequency[band], explained[band], MIN_COHERENCE)

    hertz = min(by_noise, by_coherence, highest)
    reason = f"above {hertz:.3g} Hz the position is less than {MIN_SIGNAL_TO_NOISE:g} times its noise"
    if hertz == highest:
        reason = f"position and torque are good up to {highest:.3g} Hz, the most that is used"
    elif by_coherence <= by_noise:
        reason = f"above {hertz:.3g} Hz Eq. 1 explains less than half of the torque's power"
    return Cutoff(hertz, reason, frequency, coherence, position, highest, by_noise)


def _density(
    x: Sequence[Array], y: Sequence[Array], rate: float, segment: int, window: tuple[float, ...]
) -> tuple[Array, NDArray[np.complex128]]:
    """Frequency and cross-spectral density (Welch), but for a factor; pieces of a log count by their length."""
    angle = np.linspace(-np.pi, np.pi, segment, endpoint=False)
    taper = sum(size * np.cos(k * angle) for k, size in enumerate(window))

    def spectra(signal: Array) -> NDArray[np.complex128]:
        parts = sliding_window_view(signal, segment, axis=-1)[..., :: segment - segment // 2, :]
        return rfft((parts - parts.mean(-1, keepdims=True)) * taper)

    long = [(a, b) for a, b in zip(x, y, strict=True) if a.shape[-1] >= segment]
    densities = [np.mean(spectra(a).conj() * spectra(b), axis=-2) for a, b in long]
    density = np.average(densities, axis=0, weights=[a.shape[-1] for a, _ in long])
    density[..., 1 : (segment + 1) // 2] *= 2.0  # one-sided
    return rfftfreq(segment, 1.0 / rate), density


def _first_below(frequency: Array, curve: Array, limit: float) -> float:
    """Lowest frequency at which a curve is below a limit; infinity if there is none."""
    below = np.flatnonzero(curve < limit)
    return float(frequency[below[0]]) if below.size else np.inf


# Choice of the friction's steepness and the delay.


def choose_steepness(logs: Sequence[tuple[Log, FilterSettings]]) -> float:
    """Choose lambda of Eq. 1 with the smallest sum of squared errors, each joint of a log over its torque's energy."""
    errors = np.zeros(len(STEEPNESS_GRID))
    for (log, settings), (k, steepness) in product(logs, enumerate(STEEPNESS_GRID)):
        r = prepare(log, replace(settings, friction_steepness=steepness), even_odd=False)
        weight = 1.0 / np.mean(r.tau**2, axis=-1, keepdims=True)
        errors[k] += np.sum(weight * (r.tau - r.y @ solve(r.y, r.tau, weight)) ** 2)
    return STEEPNESS_GRID[int(np.argmin(errors))]


def estimate_delay(log: Log, settings: FilterSettings, columns: Array | None = None) -> tuple[float, float]:
    """Estimate the delay of the torque, at most `MAX_DELAY` to either side, and its standard error, s.

    Columns (2, n, k) at the retained samples join the regressor: of effects that the delay would otherwise absorb.
    The sum of squared errors is close to a parabola about the true delay. Unmodelled effects move it by milliseconds.
    Unless it reduces the squared error by `MIN_ERROR_REDUCTION`, the result is therefore the nearest delay of at most
    `MAX_EXPECTED_DELAY`, and its standard error includes the distance.
    """
    delays = np.linspace(-MAX_DELAY, MAX_DELAY, N_DELAYS)
    ends = np.cumsum([retained_samples(piece, settings)[1].size for piece in log.pieces])
    more = np.empty((2, ends[-1], 0)) if columns is None else columns
    parts = zip(log.pieces, np.split(more, ends[:-1], axis=1), strict=True)
    pieces = [_delayed(piece, settings, delays, part) for piece, part in parts]
    y, tau, h = np.concatenate([y for y, _, _ in pieces], 1), np.concatenate([x for _, x, _ in pieces], 2), pieces[0][2]
    residual = np.stack([x - y @ solve(y, x) for x in tau])
    error = np.sum(residual**2, axis=(1, 2))
    best = int(np.clip(error.argmin(), 1, N_DELAYS - 2))
    near = slice(best - 1, best + 2)
    curve, slope, _ = np.polyfit(delays[near] - delays[best], error[near], 2)
    delay, spread = float(delays[error.argmin()]), MAX_DELAY
    if curve > 0.0:
        delay = float(np.clip(delays[best] - slope / (2.0 * curve), -MAX_DELAY, MAX_DELAY))
        # The sum of squares grows by its mean over independent samples within a standard error of the minimum.
        n_independent = residual[best].size * h / correlation_time(residual[best], h)
        spread = float(np.sqrt(error.min() / n_independent / curve))
    expected = float(np.clip(delay, 0.0, min(MAX_EXPECTED_DELAY * recorded_period(log), MAX_DELAY)))
    if error.min() > (1.0 - MIN_ERROR_REDUCTION) * np.interp(expected, delays, error):
        return expected, min(float(np.hypot(spread, delay - expected)), MAX_DELAY)
    return delay, MAX_DELAY if abs(delay) >= MAX_DELAY else min(spread, MAX_DELAY)


def _delayed(log: Log, settings: FilterSettings, delays: Array, columns: Array) -> tuple[Array, Array, float]:
    """Give regressor and columns of a piece of a log, its torque by delay (len(delays), 2, n), and the period."""
    settings = replace(settings, delay=0.0)
    plain = prepare(log, settings, even_odd=False)
    inside = slice(*np.searchsorted(plain.t, [plain.t[0] + MAX_DELAY, plain.t[-1] - MAX_DELAY]))
    n, every = retained_samples(log, replace(settings, samples_per_cycle=np.inf))
    torque_at = CubicSpline(log.t[every], filtered_torque(log.tau[:, :n], period(log), settings)[:, every], axis=-1)
    torque = np.stack([torque_at(plain.t[inside] - delay) for delay in delays])
    y = np.concatenate([plain.y, columns * plain.mask[..., np.newaxis]], axis=-1)
    return y[:, inside], torque * plain.mask[:, inside], plain.h
