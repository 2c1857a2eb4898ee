"""Training samples by numeric substitution (Section IV-A): torque = Y beta, on one motion or on many.

A sample is four 100-vectors (the image's factors) for each channel and nine labels; images are never stored.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from repro.cnn.image import ImageSettings, image_factors
from repro.cnn.priors import GuessSettings, Prior, sample_beta, training_guess
from repro.cnn.unmodelled import UnmodelledColumns, UnmodelledSettings, draw_unmodelled, unmodelled_columns
from repro.model.dynamics import regressor
from repro.model.parameters import Array
from repro.signals.dct import dct2low, dct2sub
from repro.signals.sampling import SignalSettings, image_regressor
from repro.signals.trajectories import Motion

Floats32 = NDArray[np.float32]


@dataclass(frozen=True)
class SampledMotion:
    """What the image needs of a motion, or of K motions that samples draw from.

    Attributes
    ----------
    torque : array of shape (2, M, 9) or (K, 2, M, 9)
        Maps beta to the filtered and subsampled torque tau_s: the regressor sent through lines 3 and 7 of
        Algorithm 1, which are linear.
    model : array of shape (2, M, 9) or (K, 2, M, 9)
        Regressor of the subsampled motion: f of Eq. 9. One for all motions where f is taken on the desired motion.
    beyond : UnmodelledColumns, optional
        Torques that Eq. 1 does not hold, of the same motions.
    """

    torque: Array
    model: Array
    beyond: UnmodelledColumns | None = None


def sample_motion(
    motion: Motion, settings: SignalSettings, proper: slice = slice(None), beyond: bool = False
) -> SampledMotion:
    """Regressors that training draws its torques and images from.

    Parameters
    ----------
    motion : Motion
        Identification trajectory at full rate.
    settings : SignalSettings
        Filter and length.
    proper : slice
        Samples kept after filtering: **cut** of Algorithm 1.
    beyond : bool
        Whether to add the columns of torques beyond Eq. 1.

    Returns
    -------
    SampledMotion
        Of one motion.
    """
    h, c_f, reading, m = settings.h, settings.c_f, settings.reading, settings.samples
    y = np.moveaxis(regressor(motion.q, motion.dq, motion.ddq), -1, 0)  # (9, 2, N)
    tau_s = dct2sub(dct2low(y, h, c_f, reading)[..., proper], m)
    model = image_regressor(motion.q[:, proper], motion.dq[:, proper], motion.ddq[:, proper], settings)
    columns = unmodelled_columns(motion.q, motion.dq, y, proper, h, c_f, reading, m) if beyond else None
    return SampledMotion(np.moveaxis(tau_s, 0, -1), model, columns)


def stack_motions(motions: Sequence[SampledMotion], model: Array | None = None) -> SampledMotion:
    """Motions that samples draw from; `model`, if given, is f's regressor for all of them."""
    beyond = [motion.beyond for motion in motions if motion.beyond is not None]
    columns = (np.stack([getattr(each, field.name) for each in beyond]) for field in fields(UnmodelledColumns))
    return SampledMotion(
        np.stack([motion.torque for motion in motions]),
        np.stack([motion.model for motion in motions]) if model is None else model,
        UnmodelledColumns(*columns) if len(beyond) == len(motions) else None,
    )


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
    unmodelled : UnmodelledSettings
        What torques hold beyond Eq. 1: nothing by default, as in the paper.
    """

    prior: Prior = "mixture"
    guess: GuessSettings = field(default_factory=GuessSettings)
    image: ImageSettings = field(default_factory=ImageSettings)
    label: Label = "largest-torque"
    unmodelled: UnmodelledSettings = field(default_factory=UnmodelledSettings)

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
        Regressors of the identification trajectory, or of K motions of which each sample draws one.
    settings : DataSettings
        Distribution.

    Returns
    -------
    Samples
        Single precision.
    """
    m = motion.torque.shape[-2]
    alpha, beta_bar, which = draw_torques(rng, n, motion, settings)
    alpha = alpha.astype(np.float32)
    beta_n = training_guess(rng, beta_bar, settings.guess)
    psi = 2 * alpha - _rebuilt(motion.model, beta_n, which).reshape(n, 2, m).astype(np.float32)
    u, v = image_factors(alpha, psi, settings.image)
    return Samples(u, v, (beta_bar - beta_n).astype(np.float32))


def draw_torques(
    rng: np.random.Generator, n: int, motion: SampledMotion, settings: DataSettings
) -> tuple[Array, Array, NDArray[np.int64] | None]:
    """Torques (n, 2, M) over their largest magnitude, the parameters behind them (n, 9), and each one's motion."""
    m = motion.torque.shape[-2]
    beta = sample_beta(rng, n, settings.prior)
    many = motion.torque.ndim == 4
    which = rng.integers(len(motion.torque), size=n) if many else None
    tau = _rebuilt(motion.torque, beta, which)  # (n, 2M)
    if settings.unmodelled:
        if motion.beyond is None:
            raise ValueError("unmodelled: the motion has no torques beyond Eq. 1.")
        columns = motion.beyond if which is None else motion.beyond.take(which)
        largest = np.abs(tau).max(-1, keepdims=True)
        tau = tau + draw_unmodelled(rng, beta, largest, columns, settings.unmodelled).reshape(n, -1)
    largest = np.abs(tau).max(-1, keepdims=True)
    # psi equals alpha for the right guess only if parameters are read in units of the largest torque.
    beta_bar = beta / largest if settings.label == "largest-torque" else beta
    return (tau / largest).reshape(n, 2, m), beta_bar, which


def _rebuilt(columns: Array, beta: Array, which: NDArray[np.int64] | None) -> Array:
    """Y beta of each sample, shape (n, 2 M), on the one motion or on motion ``which`` of K."""
    if columns.ndim == 3 or which is None:
        torque: Array = beta @ columns.reshape(-1, columns.shape[-1]).T
    else:
        torque = np.einsum("nrp,np->nr", columns.reshape(len(columns), -1, columns.shape[-1])[which], beta)
    return torque
