"""Sampling and filtering shared by training and identification, and the regressor as the image sees it."""

from dataclasses import dataclass

import numpy as np

from repro.model.dynamics import LAMBDA, regressor
from repro.model.parameters import Array
from repro.signals.dct import FrequencyUnit, dct2sub


@dataclass(frozen=True)
class SignalSettings:
    """Sampling and filter of Algorithm 1."""

    h: float = 2.5e-3  # sampling period, s
    c_f: float = 1e-4  # filter coefficient of Eq. 6 and 14
    omega_unit: FrequencyUnit = "rad_per_s"  # unit of omega in the filter
    samples: int = 100  # length M of the subsampled signals, and so the side of the image
    duration: float = 3.0 * np.pi  # of the identification trajectory, s
    #: Divide each motion signal inside f by its own maximum, as Eq. 8 prints; unscaled motion keeps Eq. 1 exact.
    normalise_motion: bool = False


def image_regressor(
    q: Array, dq: Array, ddq: Array, settings: SignalSettings, friction_steepness: float = LAMBDA
) -> Array:
    """Compute the regressor (2, M, 9) that f of Eq. 9 uses: of the subsampled motion, from full-rate signals (2, N)."""
    motion = np.stack([dct2sub(x, settings.samples) for x in (q, dq, ddq)])
    if settings.normalise_motion:
        motion = motion / np.abs(motion).max(-1, keepdims=True)
    return regressor(motion[0], motion[1], motion[2], friction_steepness)
