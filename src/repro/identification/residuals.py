"""Residuals: how long they stay correlated, and whether they are white."""

import numpy as np

from repro.identification.regression import Regression
from repro.model.parameters import Array


def correlation_time(error: Array, h: float) -> float:
    """Time over which residuals stay correlated: the sum of the autocorrelation up to its first zero.

    Parameters
    ----------
    error : array of shape (2, n)
        Residuals.
    h : float
        Time between samples, s.

    Returns
    -------
    float
        s, the longer of both joints.
    """
    n = error.shape[-1]
    centred = error - error.mean(-1, keepdims=True)
    power = np.abs(np.fft.rfft(centred, 2 * n, axis=-1)) ** 2
    correlation = np.fft.irfft(power, axis=-1)[:, :n]
    times = []
    for joint in correlation:
        if joint[0] <= 0.0:
            continue
        end = int(np.argmax(joint <= 0.0)) or n
        times.append(float(joint[:end].sum() / joint[0]) * h)
    return max(times, default=h)


def lag_one(regression: Regression, beta: Array, cutoff: float) -> tuple[float, float]:
    """Autocorrelation of each joint's residual at a lag of one period of the cut-off.

    Filtering alone correlates neighbouring samples; a whole period of the cut-off apart what is left is not the
    filter's doing.

    Parameters
    ----------
    regression : Regression
        Filtered regressor and torque.
    beta : array of shape (9,)
        Parameters.
    cutoff : float
        Half-power frequency of torque and regressor, Hz.

    Returns
    -------
    tuple of 2 floats
        0 for white residuals, near 1 for residuals that Eq. 1 or the delay does not explain.
    """
    error = regression.tau - regression.y @ beta
    error = error - error.mean(-1, keepdims=True)
    lag = max(round(1.0 / (cutoff * regression.h)), 1)
    if lag >= error.shape[-1]:
        return 0.0, 0.0
    energy = np.sum(error**2, axis=-1)
    product = np.sum(error[:, lag:] * error[:, :-lag], axis=-1)
    first, second = np.divide(product, energy, out=np.zeros(2), where=energy > 0.0)
    return float(first), float(second)
