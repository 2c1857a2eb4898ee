"""The paper's DCT low-pass (Eq. 6, 14) with derivatives that keep the phase.

The paper differentiates by a backward difference, which lags by half a sample at each order. Here the cosine series
itself is differentiated: with s = t + h/2, sum_k X_k cos(omega_k s) becomes -sum_k omega_k X_k sin(omega_k s).
The series is even about both ends, so a signal that moves there has a kink; the Gaussian keeps what it does within
a few sqrt(2 c_f) of the ends, which are cut.
"""

import numpy as np
from scipy.fft import dct, idct, idst

from repro.model.parameters import Array


def filter_coefficient(cutoff: float) -> float:
    """c_f of Eq. 6, s^2, whose gain exp(-c_f omega^2) is 1/sqrt(2) at `cutoff`, Hz."""
    return float(0.5 * np.log(2.0) / (2.0 * np.pi * cutoff) ** 2)


def dct_pair(x: Array, h: float, cutoff: float, order: int = 0) -> Array:
    """`Filter.apply` with the low-pass of Eq. 6."""
    if order not in (0, 1, 2):
        raise ValueError(f"order: must be 0, 1 or 2, got {order}.")
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
