"""Savitzky-Golay smoothing and differentiation: a cubic through a moving window, from SciPy."""

from scipy.signal import savgol_filter

from repro.model.parameters import Array

DEGREE = 3

#: Half-power frequency times m + 1/2, in units of half the sampling rate.
HALF_POWER = 1.066


def savitzky_golay(x: Array, h: float, cutoff: float, order: int = 0) -> Array:
    """`Filter.apply`.

    The response of a cubic window of 2 m + 1 samples falls to 1/sqrt(2) at 1.066 / (m + 1/2) of half the sampling rate,
    to 1 % for m of 8 and more.
    """
    if order not in (0, 1, 2):
        raise ValueError(f"order: must be 0, 1 or 2, got {order}.")
    half = max(round(HALF_POWER / (2.0 * cutoff * h) - 0.5), DEGREE)
    window = min(2 * half + 1, (x.shape[-1] - 1) // 2 * 2 + 1)
    smooth: Array = savgol_filter(x, window, DEGREE, deriv=order, delta=h, axis=-1)
    return smooth
