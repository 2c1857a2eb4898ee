"""Regressions of the known arm without any filter, another motion of it, and noise that stays correlated."""

import numpy as np
from log_example import BETA, motion
from scipy.signal import lfilter

from repro.identification.regression import Regression
from repro.model.dynamics import regressor

#: Time between samples and cut-off: a period of the cut-off is ten samples.
H, CUTOFF = 0.02, 5.0


def regression_of(y, tau, h=H):
    """A regression of any regressor (2, n, 9) and torque (2, n); its motion is zero, and every row counts."""
    n = y.shape[1]
    nothing, counts = np.zeros((2, n)), np.ones((2, n), dtype=bool)
    return Regression(
        t=h * np.arange(n),
        y=y,
        tau=tau,
        even_odd=np.stack([y, y]),
        q=nothing,
        dq=nothing,
        ddq=nothing,
        mask=counts,
        h=h,
    )


def exact(moved, beta=BETA, noise=0.0):
    """The regression of a motion (q, dq, ddq) and of the torque it needs, with noise added to that."""
    y = regressor(*moved)
    return regression_of(y, y @ beta + noise)


def exciting(n, h=H):
    """The regression of the motion that excites all nine parameters."""
    return exact(motion(h * np.arange(n)))


def other_motion(t):
    """Two sinusoids a joint, faster and around another place than those of `log_example.motion`."""
    frequency = 2 * np.pi * np.array([[0.4, 0.9], [0.3, 1.0]])[..., np.newaxis]
    amplitude = np.array([[0.5, -0.25], [0.6, 0.3]])[..., np.newaxis]
    phase = frequency * t + np.array([[0.1, 2.0], [1.4, 0.6]])[..., np.newaxis]
    q = np.array([[0.3], [-0.4]]) + (amplitude * np.sin(phase)).sum(1)
    return q, (amplitude * frequency * np.cos(phase)).sum(1), (-amplitude * frequency**2 * np.sin(phase)).sum(1)


def autoregressive(rho, n, rng, size=1.0):
    """Both joints' noise e[k] = rho e[k-1] + white, of standard deviation `size` from the first sample on."""
    white = np.sqrt(1.0 - rho**2) * rng.normal(size=(2, n))
    white[:, 0] /= np.sqrt(1.0 - rho**2)
    return size * lfilter([1.0], [1.0, -rho], white, axis=-1)
