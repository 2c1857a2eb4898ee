"""Training samples by numeric substitution (Section IV-A): torque = Y beta, on one motion or on many.

A sample is four 100-vectors (the image's factors) for each channel and nine labels; images are never stored. By an
extension of ours, off by default, torques may also have unmodelled effects: Stribeck friction, ripple, noise and delay.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray

from repro.cnn.image import PUBLISHED_IMAGE, ImageSettings, image_factors
from repro.cnn.priors import GuessSettings, ListedPrior, Prior, sample_beta, training_guess
from repro.keys import SECTION, Key, Level
from repro.model.dynamics import LAMBDA, regressor
from repro.model.parameters import Array
from repro.signals.dct import SignalSettings, dct2dev, dct2low, dct2sub, image_regressor
from repro.signals.trajectories import Motion

Floats32 = NDArray[np.float32]
Label = Literal["largest-torque", "physical"]

#: Cycles a turn of the ripples that training torques may have.
RIPPLE_CYCLES = (3, 7, 11, 17, 23, 31)
#: Velocity over which Stribeck friction fades, rad/s.
STRIBECK_VELOCITY = 0.2


@dataclass(frozen=True)
class UnmodelledSettings:
    """Torque beyond Eq. 1 in training samples, which draw from zero to these levels."""

    __pydantic_config__ = SECTION

    stribeck: Annotated[Level, Key("share by which Coulomb friction is higher near standstill")] = 0.0
    ripple: Annotated[Level, Key("amplitude of a ripple of 3 to 31 cycles a turn", "largest torque")] = 0.0
    noise: Annotated[Level, Key("standard deviation of noise on the subsampled torque", "largest torque")] = 0.0
    delay_s: Annotated[Level, Key("delay of the torque", "s")] = 0.0  # to first order

    def __str__(self) -> str:
        """List the levels for a model card."""
        return ", ".join(f"{name} {level:g}" for name, level in vars(self).items()) if self else "none"

    def __bool__(self) -> bool:
        """Whether there is anything to draw."""
        return any(level > 0 for level in vars(self).values())


@dataclass(frozen=True)
class UnmodelledColumns:
    """Filtered and subsampled torques of the unmodelled effects of a motion, for unit amounts."""

    stribeck: Array  # (2, M), for a Coulomb friction and a fraction of 1
    ripple: Array  # (2, M, 2 C): sine and cosine of each of the C `RIPPLE_CYCLES`
    rate: Array  # (2, M, 9): time derivative of the torque, a column for each parameter, 1/s


@dataclass(frozen=True)
class SampledMotion:
    """Regressors of a motion, or of K motions that samples draw from, with K in front of each shape."""

    #: (2, M, 9), from beta to the filtered and subsampled torque tau_s: the regressor sent through lines 3 and 7 of
    #: Algorithm 1, which are linear.
    torque: Array
    model: Array  # (2, M, 9), f of Eq. 9; one for all motions if f is evaluated on the desired motion
    unmodelled: UnmodelledColumns | None = None


def sample_motion(
    motion: Motion, settings: SignalSettings, proper: slice = slice(None), unmodelled: bool = False
) -> SampledMotion:
    """Compute the regressors of a motion; `proper` is what **cut** of Algorithm 1 keeps after filtering."""
    filtering = settings.sampling_period_s, settings.filter_coefficient, settings.frequency_reading

    def sampled(x: Array, lines: Callable[..., Array] = dct2low) -> Array:
        return dct2sub(lines(x, *filtering)[..., proper], settings.image_samples)

    y = np.moveaxis(regressor(motion.q, motion.dq, motion.ddq), -1, 0)  # (9, 2, N)
    torque = np.moveaxis(sampled(y), 0, -1)
    model = image_regressor(motion.q[:, proper], motion.dq[:, proper], motion.ddq[:, proper], settings)
    if not unmodelled:
        return SampledMotion(torque, model)
    n = np.array(RIPPLE_CYCLES)[:, np.newaxis, np.newaxis]
    waves = np.stack([np.sin(n * motion.q), np.cos(n * motion.q)], axis=1).reshape(-1, *motion.q.shape)  # (2 C, 2, N)
    friction = np.tanh(LAMBDA * motion.dq) - np.tanh(motion.dq / STRIBECK_VELOCITY)
    ripple, rate = (np.moveaxis(x, 0, -1) for x in (sampled(waves), sampled(y, dct2dev)))
    return SampledMotion(torque, model, UnmodelledColumns(sampled(friction), ripple, rate))


def stack_motions(motions: Sequence[SampledMotion], model: Array | None = None) -> SampledMotion:
    """Stack motions that samples draw from; `model`, if given, is f's regressor for all of them."""
    known = [vars(motion.unmodelled).values() for motion in motions if motion.unmodelled is not None]
    columns = UnmodelledColumns(*map(np.stack, zip(*known, strict=True))) if len(known) == len(motions) else None
    shared = np.stack([motion.model for motion in motions]) if model is None else model
    return SampledMotion(np.stack([motion.torque for motion in motions]), shared, columns)


@dataclass(frozen=True)
class LabelSettings(GuessSettings):
    """What training samples show."""

    __pydantic_config__ = SECTION

    #: With the largest torque a right guess makes psi equal alpha, as Section IV-A says; with SI it does not.
    label: Annotated[
        Label, Key("unit of labels and guesses: the largest torque, or SI", source="Section IV-A, Eq. 9")
    ] = "largest-torque"
    unmodelled: UnmodelledSettings = UnmodelledSettings()


@dataclass(frozen=True)
class DataSettings(LabelSettings):
    """Distribution of the training samples."""

    prior: Prior | ListedPrior = "mixture"  # of the arms, see `repro.cnn.priors`
    image: ImageSettings = PUBLISHED_IMAGE


@dataclass(frozen=True)
class Samples:
    """A batch of samples."""

    u: Floats32  # factors of the images (n, 2, 2, M)
    v: Floats32
    residual: Floats32  # labels (n, 9): beta_bar - beta_n


def draw_samples(rng: np.random.Generator, n: int, motion: SampledMotion, settings: DataSettings) -> Samples:
    """Draw n training samples in single precision; of K motions, each sample draws one."""
    torque, beta_bar, which = draw_torques(rng, n, motion, settings)
    alpha = torque.astype(np.float32)
    beta_n = training_guess(rng, beta_bar, settings)
    psi = 2 * alpha - _rebuilt(motion.model, beta_n, which).reshape(alpha.shape).astype(np.float32)
    u, v = image_factors(alpha, psi, settings.image)
    return Samples(u, v, (beta_bar - beta_n).astype(np.float32))


def draw_torques(
    rng: np.random.Generator, n: int, motion: SampledMotion, settings: DataSettings
) -> tuple[Array, Array, NDArray[np.int64] | None]:
    """Draw torques (n, 2, M) over their largest magnitude, the parameters behind them (n, 9), and each one's motion."""
    beta = sample_beta(rng, n, settings.prior)
    which = rng.integers(len(motion.torque), size=n) if motion.torque.ndim == 4 else None
    tau = _rebuilt(motion.torque, beta, which)  # (n, 2M)
    if settings.unmodelled:
        if motion.unmodelled is None:
            raise ValueError("unmodelled: the motion has no torques beyond Eq. 1.")
        columns = motion.unmodelled
        if which is not None:
            columns = UnmodelledColumns(*(each[which] for each in vars(columns).values()))
        largest = np.abs(tau).max(-1, keepdims=True)
        tau = tau + draw_unmodelled(rng, beta, largest, columns, settings.unmodelled).reshape(n, -1)
    largest = np.abs(tau).max(-1, keepdims=True)
    # psi equals alpha for the right guess only if parameters are in units of the largest torque.
    beta_bar = beta / largest if settings.label == "largest-torque" else beta
    return (tau / largest).reshape(n, 2, -1), beta_bar, which


def _rebuilt(columns: Array, beta: Array, which: NDArray[np.int64] | None) -> Array:
    """Compute Y beta (n, 2 M) of each sample, on the one motion or on motion ``which`` of K."""
    if columns.ndim == 3 or which is None:
        return beta @ columns.reshape(-1, 9).T
    return np.asarray(np.einsum("nrp,np->nr", columns.reshape(len(columns), -1, 9)[which], beta))


def draw_unmodelled(
    rng: np.random.Generator, beta: Array, largest: Array, columns: UnmodelledColumns, settings: UnmodelledSettings
) -> Array:
    """Draw the unmodelled torque (n, 2, M) of arms (n, 9) with their largest torque (n, 1), on one motion or on n."""
    n, m = len(beta), columns.stribeck.shape[-1]
    excess = rng.uniform(0.0, settings.stribeck, (n, 2))
    torque = (excess * beta[:, 7:])[..., np.newaxis] * columns.stribeck
    waves = len(RIPPLE_CYCLES)
    which, phase = rng.integers(waves, size=(n, 2, 1)), rng.uniform(0.0, 2.0 * np.pi, (n, 2))
    amplitude = rng.uniform(0.0, settings.ripple, (n, 2)) * largest
    weight = np.zeros((n, 2, 2 * waves))
    sine_cosine = amplitude[..., np.newaxis] * np.stack([np.cos(phase), np.sin(phase)], axis=-1)
    np.put_along_axis(weight, 2 * which + np.arange(2), sine_cosine, -1)
    torque += (columns.ripple @ weight[..., np.newaxis])[..., 0]
    delay = rng.uniform(0.0, settings.delay_s, (n, 1, 1))
    torque -= delay * (columns.rate @ beta[:, np.newaxis, :, np.newaxis])[..., 0]
    noise = rng.uniform(0.0, settings.noise, (n, 1)) * largest
    return torque + noise[..., np.newaxis] * rng.standard_normal((n, 2, m))
