"""Zero-phase low-pass filters that differentiate. All take the half-power frequency, so they can be exchanged."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.fft import dct, idct, idst
from scipy.signal import butter, savgol_filter, sosfiltfilt

from repro.model.parameters import Array

BUTTERWORTH_ORDER = 4
SAVITZKY_GOLAY_DEGREE = 3
#: Half-power frequency of a cubic Savitzky-Golay window of 2 m + 1 samples times m + 1/2, in half the sampling rate;
#: to 1 % for m of 8 and more.
SAVITZKY_GOLAY_HALF_POWER = 1.066


def filter_coefficient(cutoff: float) -> float:
    """Compute c_f of Eq. 6, s^2, whose gain exp(-c_f omega^2) is 1/sqrt(2) at `cutoff`, Hz."""
    return float(0.5 * np.log(2.0) / (2.0 * np.pi * cutoff) ** 2)


def dct_pair(x: Array, h: float, cutoff: float, order: int = 0) -> Array:
    """Apply the paper's DCT low-pass (Eq. 6, 14) with derivatives that keep the phase; see `Filter.apply`.

    The paper differentiates by a backward difference, which lags by half a sample at each order. Here the cosine series
    itself is differentiated: with s = t + h/2, sum_k X_k cos(omega_k s) becomes -sum_k omega_k X_k sin(omega_k s).
    The series is even about both ends, so a signal that moves there has a kink; the Gaussian keeps its effect within
    a few sqrt(2 c_f) of the ends, which are cut.
    """
    n = x.shape[-1]
    omega = np.pi * np.arange(n) / (n * h)
    bands = dct(x, type=2, norm="ortho", axis=-1) * np.exp(-filter_coefficient(cutoff) * omega**2)
    if order == 0:
        return np.asarray(idct(bands, type=2, norm="ortho", axis=-1))
    if order == 2:
        return np.asarray(idct(-(omega**2) * bands, type=2, norm="ortho", axis=-1))
    # The k-th sine of the orthonormal DST-II is band k + 1; the last, at half the sampling rate, has no partner.
    sines = np.concatenate([-(omega * bands)[..., 1:], np.zeros_like(bands[..., :1])], axis=-1)
    return np.asarray(idst(sines, type=2, norm="ortho", axis=-1))


def savitzky_golay(x: Array, h: float, cutoff: float, order: int = 0) -> Array:
    """Fit a cubic to a moving window, or its derivative; see `Filter.apply`."""
    half = max(round(SAVITZKY_GOLAY_HALF_POWER / (2.0 * cutoff * h) - 0.5), SAVITZKY_GOLAY_DEGREE)
    window = min(2 * half + 1, (x.shape[-1] - 1) // 2 * 2 + 1)
    smooth: Array = savgol_filter(x, window, SAVITZKY_GOLAY_DEGREE, deriv=order, delta=h, axis=-1)
    return smooth


def butterworth(x: Array, h: float, cutoff: float, order: int = 0) -> Array:
    """Apply a Butterworth low-pass forwards and backwards, with central differences; see `Filter.apply`.

    `cutoff` is that of both passes together: their gain 1 / (1 + (f / f_0)^8) is 1/sqrt(2) at f_0 (sqrt(2) - 1)^(1/8).
    """
    corner = cutoff / (np.sqrt(2.0) - 1.0) ** (0.5 / BUTTERWORTH_ORDER)
    sos = butter(BUTTERWORTH_ORDER, min(2.0 * corner * h, 0.99), output="sos")
    smooth: Array = sosfiltfilt(sos, x, axis=-1)
    for _ in range(order):
        smooth = np.gradient(smooth, h, axis=-1, edge_order=2)
    return smooth


@dataclass(frozen=True)
class Filter:
    """A zero-phase low-pass filter.

    ``apply(x, h, cutoff, order)`` computes the `order`-th time derivative (0, 1 or 2) of the low-passed `x` (..., N),
    with the sampling period `h` in s and the half-power frequency `cutoff` in Hz.
    """

    description: str
    apply: Callable[[Array, float, float, int], Array]


FILTERS: dict[str, Filter] = {
    "dct": Filter("Gaussian on the DCT-II bands (Eq. 6), derivatives by the matching sine series", dct_pair),
    "savitzky-golay": Filter("Savitzky-Golay, cubic", savitzky_golay),
    "butterworth": Filter("Butterworth of order 4 run forwards and backwards, central differences", butterworth),
}
