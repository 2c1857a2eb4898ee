"""How long residuals stay correlated."""

import numpy as np

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
