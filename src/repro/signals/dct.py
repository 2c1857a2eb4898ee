"""DCT-II low-pass, derivative and subsampling (Eq. 5-7, 14; Fig. 5), and the regressor that the image uses.

The transform is the orthonormal DCT of type 2 along the last axis, which is Eq. 5.
"""

from dataclasses import dataclass
from typing import Annotated, Literal, get_args

import numpy as np
from annotated_types import Ge, Le
from numpy.typing import ArrayLike
from scipy.fft import dct, idct

from repro.errors import InputError
from repro.keys import SECTION, Flag, Integer, Key, Level, Positive, renamed
from repro.model.dynamics import LAMBDA, regressor
from repro.model.parameters import Array

FrequencyUnit = Literal["rad_per_s", "hertz", "index"]
FREQUENCY_UNITS: tuple[FrequencyUnit, ...] = get_args(FrequencyUnit)


def spectrum(x: ArrayLike) -> Array:
    """Compute the DCT-II spectrum (..., N) of Eq. 5, which keeps norms and inner products, of a finite signal."""
    x = np.asarray(x, dtype=np.float64)
    if x.ndim == 0 or x.shape[-1] == 0:
        raise ValueError("x: a signal needs at least one sample.")
    if not np.isfinite(x).all():
        raise ValueError("x: every sample must be finite.")
    return np.asarray(dct(x, type=2, norm="ortho", axis=-1))


def band_frequency(n: int, h: float, unit: FrequencyUnit = "index") -> Array:
    """Compute omega (n,) of each DCT-II band k: pi k / (n h), k / (2 n h), or k itself; the paper does not say."""
    if not 0 < h < np.inf:
        raise ValueError(f"h: the sampling period must be positive and finite, got {h}.")
    k = np.arange(n, dtype=np.float64)
    omega = {"rad_per_s": np.pi * k / (n * h), "hertz": k / (2.0 * n * h), "index": k}
    if unit not in omega:
        raise ValueError(f"unit: must be one of {FREQUENCY_UNITS}, got {unit!r}.")
    return omega[unit]


def dct2low(x: ArrayLike, h: float, c_f: float, unit: FrequencyUnit = "index") -> Array:
    """Low-pass a signal with a Gaussian in the DCT-II domain (Eq. 14).

    Parameters
    ----------
    x : array_like of shape (..., N)
        Signal.
    h : float
        Sampling period, s.
    c_f : float
        Filter coefficient, not negative; 0 leaves the signal as it is.
    unit : {"rad_per_s", "hertz", "index"}
        Unit of omega in exp(-c_f omega^2).

    Returns
    -------
    array of shape (..., N)
        Filtered signal.

    Raises
    ------
    ValueError
        If `c_f` is negative or not finite, or `x`, `h` or `unit` is not valid.

    Examples
    --------
    >>> repro.low_pass(np.full(4, 2.0), h=0.01, c_f=1e-4)  # a constant passes
    array([2., 2., 2., 2.])
    """
    if not 0 <= c_f < np.inf:
        raise ValueError(f"c_f: the filter coefficient must be finite and not negative, got {c_f}.")
    bands = spectrum(x)
    gain = np.exp(-c_f * band_frequency(bands.shape[-1], h, unit) ** 2)
    return np.asarray(idct(bands * gain, type=2, norm="ortho", axis=-1))


def dct2dev(x: ArrayLike, h: float, c_f: float, unit: FrequencyUnit = "index") -> Array:
    """Compute the filtered derivative of a signal (Eq. 6).

    The backward difference of the first sample would need a sample before it. The second sample's difference stands
    in for it.

    Parameters
    ----------
    x : array_like of shape (..., N)
        Signal with at least two samples.
    h : float
        Sampling period, s.
    c_f, unit
        As for `low_pass`.

    Returns
    -------
    array of shape (..., N)
        Derivative, in units of `x` per second.

    Raises
    ------
    ValueError
        If there are fewer than two samples, or an argument is not valid.

    Examples
    --------
    >>> t = 0.01 * np.arange(500)
    >>> velocity = repro.differentiate(np.sin(t), h=0.01, c_f=1e-4)
    >>> bool(np.abs(velocity - np.cos(t))[50:-50].max() < 0.01)
    True
    """
    x = np.asarray(x, dtype=np.float64)
    if x.ndim == 0 or x.shape[-1] < 2:
        raise ValueError("x: a derivative needs at least two samples.")
    difference = np.diff(x, axis=-1)
    difference = np.concatenate([difference[..., :1], difference], axis=-1)
    return dct2low(difference / h, h, c_f, unit)


def dct2sub(x: Array, m: int) -> Array:
    """Subsample a signal (..., N) to m samples by its first m bands (Fig. 5); sqrt(m/N) keeps the level."""
    bands = spectrum(x)
    n = bands.shape[-1]
    if not 1 <= m <= n:
        raise ValueError(f"m: must be between 1 and the {n} samples of x, got {m}.")
    return np.asarray(idct(bands[..., :m] * np.sqrt(m / n), type=2, norm="ortho", axis=-1))


@renamed(
    h="sampling_period_s",
    c_f="filter_coefficient",
    omega_unit="frequency_reading",
    samples="image_samples",
    duration="duration_s",
)
@dataclass(frozen=True)
class SignalSettings:
    """Sampling and filters."""

    __pydantic_config__ = SECTION

    sampling_period_s: Annotated[
        Positive, Key("h; 0.0025, the board's clock", "s", "published: Eq. 6, Section III")
    ] = 2.5e-3
    filter_coefficient: Annotated[
        Level, Key("c_f of the low-pass exp(-c_f omega^2)", "1/omega^2", "published: Eq. 6, 14")
    ] = 1e-4
    frequency_reading: Annotated[FrequencyUnit, Key("unit of omega; `index`: DCT-II bands", source="Eq. 6, 14")] = (
        "index"
    )
    image_samples: Annotated[Integer, Ge(100), Le(100), Key("M, side of the image", "samples", "published: Eq. 8")] = (
        100
    )
    duration_s: Annotated[
        Positive,
        Key("length of the identification trajectory, 3 pi", "s", "published: Eq. 10", "what the board's memory holds"),
    ] = 3.0 * np.pi
    normalise_motion: Annotated[
        Flag, Key("divide motion signals by their maximum, as printed; bends Eq. 1", source="Eq. 8")
    ] = False

    def __post_init__(self) -> None:
        """Refuse a period, filter or length that no signal can have."""
        for name, kind, least, expected in (
            ("sampling_period_s", int | float, np.nextafter(0.0, 1.0), "a finite number above 0, s"),
            ("filter_coefficient", int | float, 0.0, "a finite number of 0 or more"),
            ("image_samples", int, 1, "an integer of at least 1"),
            ("duration_s", int | float, np.nextafter(0.0, 1.0), "a finite number above 0, s"),
        ):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, kind) or not least <= value < np.inf:
                raise InputError.at(name, repr(value), expected)
        if self.frequency_reading not in FREQUENCY_UNITS:
            raise InputError.at(
                "frequency_reading", repr(self.frequency_reading), f"one of {', '.join(FREQUENCY_UNITS)}"
            )


def image_regressor(
    q: Array, dq: Array, ddq: Array, settings: SignalSettings, friction_steepness: float = LAMBDA
) -> Array:
    """Compute the regressor (2, M, 9) that f of Eq. 9 uses: of the subsampled motion, from full-rate signals (2, N)."""
    motion = np.stack([dct2sub(x, settings.image_samples) for x in (q, dq, ddq)])
    if settings.normalise_motion:
        motion = motion / np.abs(motion).max(-1, keepdims=True)
    return regressor(motion[0], motion[1], motion[2], friction_steepness)
