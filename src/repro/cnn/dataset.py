"""Training samples by numeric substitution (Section IV-A): torque = Y beta, no simulation.

A sample is four 100-vectors (the image's factors) for each channel and nine labels; images are never stored.
"""

from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from repro.cnn.image import ImageSettings, image_factors
from repro.cnn.priors import GuessSettings, Prior, sample_beta, training_guess
from repro.model.dynamics import LAMBDA, regressor
from repro.model.parameters import Array
from repro.signals.dct import FrequencyReading, dct2low, dct2sub
from repro.signals.trajectories import Motion

Floats32 = NDArray[np.float32]


@dataclass(frozen=True)
class SignalSettings:
    """Sampling and filtering shared by training and identification.

    Attributes
    ----------
    h : float
        Sampling period, s (2.5 ms).
    c_f : float
        Filter coefficient of Eq. 6 and 14.
    reading : {"rad_per_s", "hertz", "index"}
        Unit of omega in the filter.
    samples : int
        Length M of the subsampled signals, and so the side of the image.
    duration : float
        Length of the identification trajectory, s.
    normalise_motion : bool
        True: divide each motion signal inside f by its own maximum, as Eq. 8 prints. False (default):
        leave the motion as it is, which keeps Eq. 1 exact.
    """

    h: float = 2.5e-3
    c_f: float = 1e-4
    reading: FrequencyReading = "rad_per_s"
    samples: int = 100
    duration: float = 3.0 * np.pi
    normalise_motion: bool = False


@dataclass(frozen=True)
class SampledMotion:
    """What the image needs of a motion.

    Attributes
    ----------
    torque : array of shape (2, M, 9)
        Maps beta to the filtered and subsampled torque tau_s: the regressor sent through lines 3 and 7 of
        Algorithm 1, which are linear.
    model : array of shape (2, M, 9)
        Regressor of the subsampled motion: f of Eq. 9.
    """

    torque: Array
    model: Array


def image_regressor(
    q: Array, dq: Array, ddq: Array, settings: SignalSettings, friction_steepness: float = LAMBDA
) -> Array:
    """Regressor of the subsampled motion, as f of Eq. 9 uses it.

    Parameters
    ----------
    q, dq, ddq : arrays of shape (2, N)
        Motion at full rate.
    settings : SignalSettings
        Length of the subsampled signals and reading of Eq. 8.
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


def sample_motion(motion: Motion, settings: SignalSettings) -> SampledMotion:
    """Regressors that training draws its torques and images from.

    Parameters
    ----------
    motion : Motion
        Identification trajectory at full rate.
    settings : SignalSettings
        Filter and length.

    Returns
    -------
    SampledMotion
        Both regressors.
    """
    y = np.moveaxis(regressor(motion.q, motion.dq, motion.ddq), -1, 0)  # (9, 2, N)
    tau_s = dct2sub(dct2low(y, settings.h, settings.c_f, settings.reading), settings.samples)
    model = image_regressor(motion.q, motion.dq, motion.ddq, settings)
    return SampledMotion(np.moveaxis(tau_s, 0, -1), model)


Label = Literal["largest-torque", "physical"]
LABELS: tuple[Label, ...] = get_args(Label)


@dataclass(frozen=True)
class DataSettings:
    """Distribution of the training samples.

    Attributes
    ----------
    prior : str
        Where arms come from, see `repro.cnn.priors`.
    guess : GuessSettings
        Where guesses come from.
    image : ImageSettings
        Divisors of Eq. 9.
    label : {"largest-torque", "physical"}
        Unit of parameters in labels and guesses: of the largest torque (default), in which a right guess makes
        psi equal alpha as Section IV-A says, or SI as the text reads, in which it does not.
    """

    prior: Prior = "mixture"
    guess: GuessSettings = field(default_factory=GuessSettings)
    image: ImageSettings = field(default_factory=ImageSettings)
    label: Label = "largest-torque"

    def __post_init__(self) -> None:
        """Refuse an unknown unit."""
        if self.label not in LABELS:
            raise ValueError(f"label: must be one of {LABELS}, got {self.label!r}.")


@dataclass(frozen=True)
class Samples:
    """A batch of samples.

    Attributes
    ----------
    u, v : arrays of shape (n, 2, 2, M)
        Factors of the images.
    residual : array of shape (n, 9)
        Labels beta_bar - beta_n.
    """

    u: Floats32
    v: Floats32
    residual: Floats32


def draw_samples(rng: np.random.Generator, n: int, motion: SampledMotion, settings: DataSettings) -> Samples:
    """Draw training samples.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of randomness.
    n : int
        How many.
    motion : SampledMotion
        Regressors of the identification trajectory.
    settings : DataSettings
        Distribution.

    Returns
    -------
    Samples
        Single precision.
    """
    m = motion.torque.shape[1]
    beta = sample_beta(rng, n, settings.prior)
    tau = beta @ motion.torque.reshape(-1, 9).T  # (n, 2M)
    largest = np.abs(tau).max(-1, keepdims=True)
    # psi equals alpha for the right guess only if parameters are read in units of the largest torque.
    beta_bar = beta / largest if settings.label == "largest-torque" else beta
    alpha = (tau / largest).reshape(n, 2, m).astype(np.float32)
    beta_n = training_guess(rng, beta_bar, settings.guess)
    psi = 2 * alpha - (beta_n @ motion.model.reshape(-1, 9).T).reshape(n, 2, m).astype(np.float32)
    u, v = image_factors(alpha, psi, settings.image)
    return Samples(u, v, (beta_bar - beta_n).astype(np.float32))
