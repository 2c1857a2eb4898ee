"""Butterworth low-pass forwards and backwards, with central differences."""

import numpy as np
from scipy.signal import butter, sosfiltfilt

from repro.model.parameters import Array

ORDER = 4


def butterworth(x: Array, h: float, cutoff: float, order: int = 0) -> Array:
    """`Filter.apply`; `cutoff` is that of both passes together.

    Two passes have the gain 1 / (1 + (f / f_0)^8), which is 1/sqrt(2) at f_0 (sqrt(2) - 1)^(1/8).
    """
    if order not in (0, 1, 2):
        raise ValueError(f"order: must be 0, 1 or 2, got {order}.")
    corner = cutoff / (np.sqrt(2.0) - 1.0) ** (0.5 / ORDER)
    sos = butter(ORDER, min(2.0 * corner * h, 0.99), output="sos")
    smooth: Array = sosfiltfilt(sos, x, axis=-1)
    for _ in range(order):
        smooth = np.gradient(smooth, h, axis=-1, edge_order=2)
    return smooth
