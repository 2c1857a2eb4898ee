"""Sampling and filtering shared by training and identification, and the regressor as the image sees it."""

from dataclasses import dataclass

import numpy as np

from repro.model.dynamics import LAMBDA, regressor
from repro.model.parameters import Array
from repro.signals.dct import FrequencyReading, dct2sub


@dataclass(frozen=True)
class SignalSettings:
    """Sampling and filter of Algorithm 1."""

    h: float = 2.5e-3  # sampling period, s
    c_f: float = 1e-4  # filter coefficient of Eq. 6 and 14
    reading: FrequencyReading = "rad_per_s"  # unit of omega in the filter
    samples: int = 100  # length M of the subsampled signals, and so the side of the image
    duration: float = 3.0 * np.pi  # of the identification trajectory, s
    #: Divide each motion signal inside f by its own maximum, as Eq. 8 prints; unscaled motion keeps Eq. 1 exact.
    normalise_motion: bool = False


def image_regressor(
    q: Array, dq: Array, ddq: Array, settings: SignalSettings, friction_steepness: float = LAMBDA
) -> Array:
    """Compute the regressor of the subsampled motion, as f of Eq. 9 uses it.

    Parameters
    ----------
    q, dq, ddq : arrays of shape (2, N)
        Position (rad), velocity (rad/s) and acceleration (rad/s^2) at full rate.
    settings : SignalSettings
        Length M of the subsampled signals, and the interpretation of Eq. 8.
    friction_steepness : float
        lambda of Eq. 1, s/rad.

    Returns
    -------
    array of shape (2, M, 9)
        Regressor.
    """
    motion = np.stack([dct2sub(x, settings.samples) for x in (q, dq, ddq)])
    if settings.normalise_motion:
        motion = motion / np.abs(motion).max(-1, keepdims=True)
    return regressor(motion[0], motion[1], motion[2], friction_steepness)
