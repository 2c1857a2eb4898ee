"""Speed of each joint as a recording shows it, coarse but safe against jitter and encoder steps."""

import numpy as np

from repro.logs.log import Log
from repro.model.parameters import Array

#: Half the time that a difference spans, s.
HALF_SPAN = 0.02


def period(log: Log) -> float:
    """Typical time from one sample to the next, s."""
    return float(np.median(np.diff(log.t)))


def spanned(log: Log) -> int:
    """Samples to each side that a difference spans."""
    return max(1, round(HALF_SPAN / period(log)))


def speed(log: Log) -> Array:
    """Velocity by central differences over about 40 ms.

    Parameters
    ----------
    log : Log
        Recording of N samples.

    Returns
    -------
    array of shape (2, N - 2 w)
        rad/s, at the samples but the first and last w of `spanned`.
    """
    w = spanned(log)
    return np.asarray((log.q[:, 2 * w :] - log.q[:, : -2 * w]) / (log.t[2 * w :] - log.t[: -2 * w]))
