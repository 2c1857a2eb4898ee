"""What a real torque holds beyond Eq. 1, for training torques: Stribeck friction, ripple, noise and delay.

An extension of ours, off by default. Every part is linear in numbers drawn for a sample, so the columns of a motion are
computed once.
"""

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from repro.model.dynamics import LAMBDA
from repro.model.parameters import Array
from repro.signals.dct import FrequencyReading, dct2dev, dct2low, dct2sub

#: Cycles a turn of the ripples that training torques may have, and velocity over which Stribeck friction fades, rad/s.
RIPPLE_CYCLES = (3, 7, 11, 17, 23, 31)
STRIBECK_VELOCITY = 0.2


@dataclass(frozen=True)
class UnmodelledSettings:
    """Upper ends of what each sample draws uniformly from zero.

    Attributes
    ----------
    stribeck : float
        Share by which Coulomb friction is higher near standstill.
    ripple : float
        Amplitude of a ripple that turns with the joint, over the largest torque.
    noise : float
        Standard deviation of independent noise on the subsampled torque, over the largest torque.
    delay_s : float
        Time by which the torque comes late, s; to first order.
    """

    stribeck: float = 0.0
    ripple: float = 0.0
    noise: float = 0.0
    delay_s: float = 0.0

    def __post_init__(self) -> None:
        """Refuse levels that are negative or not finite."""
        for field in fields(self):
            if not 0 <= getattr(self, field.name) < np.inf:
                found = getattr(self, field.name)
                raise ValueError(f"{field.name}: must be finite and not negative, got {found}.")

    def __str__(self) -> str:
        """In words, for a model card."""
        return ", ".join(f"{field.name} {getattr(self, field.name):g}" for field in fields(self)) if self else "none"

    def __bool__(self) -> bool:
        """Whether there is anything to draw."""
        return any(getattr(self, field.name) > 0 for field in fields(self))


@dataclass(frozen=True)
class UnmodelledColumns:
    """Filtered and subsampled torques of a motion for unit amounts.

    Attributes
    ----------
    stribeck : array of shape (2, M)
        For a Coulomb friction and a share of 1.
    ripple : array of shape (2, M, 2 C)
        Sine and cosine of each of the C `RIPPLE_CYCLES`.
    rate : array of shape (2, M, 9)
        Time derivative of the torque, a column for each parameter, 1/s.
    """

    stribeck: Array
    ripple: Array
    rate: Array

    def take(self, which: NDArray[np.int64]) -> "UnmodelledColumns":
        """Columns of these motions, where there is an axis of motions in front."""
        return UnmodelledColumns(self.stribeck[which], self.ripple[which], self.rate[which])


def unmodelled_columns(
    q: Array, dq: Array, y: Array, proper: slice, h: float, c_f: float, reading: FrequencyReading, samples: int
) -> UnmodelledColumns:
    """Columns of one motion.

    Parameters
    ----------
    q, dq : arrays of shape (2, N)
        Position, rad, and velocity, rad/s.
    y : array of shape (9, 2, N)
        Regressor, parameters first.
    proper : slice
        Samples kept after filtering.
    h, c_f, reading
        Sampling period and filter, see `repro.signals.dct.dct2low`.
    samples : int
        Length M of the subsampled signals.

    Returns
    -------
    UnmodelledColumns
        Filtered as the torque is.
    """
    n = np.array(RIPPLE_CYCLES)[:, np.newaxis, np.newaxis]
    waves = np.stack([np.sin(n * q), np.cos(n * q)], axis=1).reshape(-1, *q.shape)  # (2 C, 2, N)
    friction = np.tanh(LAMBDA * dq) - np.tanh(dq / STRIBECK_VELOCITY)

    def sampled(x: Array) -> Array:
        return dct2sub(dct2low(x, h, c_f, reading)[..., proper], samples)

    rate = dct2sub(dct2dev(y, h, c_f, reading)[..., proper], samples)
    return UnmodelledColumns(sampled(friction), np.moveaxis(sampled(waves), 0, -1), np.moveaxis(rate, 0, -1))


def draw_unmodelled(
    rng: np.random.Generator, beta: Array, largest: Array, columns: UnmodelledColumns, settings: UnmodelledSettings
) -> Array:
    """Torque beyond Eq. 1 of each sample.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of randomness.
    beta : array of shape (n, 9)
        Arms.
    largest : array of shape (n, 1)
        Largest torque of each sample, N m.
    columns : UnmodelledColumns
        Of one motion, or of the motion of each sample: with an axis of length n in front.
    settings : UnmodelledSettings
        Levels.

    Returns
    -------
    array of shape (n, 2, M)
        N m.
    """
    n, m = len(beta), columns.stribeck.shape[-1]
    share = rng.uniform(0.0, settings.stribeck, (n, 2))
    torque = (share * beta[:, 7:])[..., np.newaxis] * columns.stribeck
    waves = len(RIPPLE_CYCLES)
    which, phase = rng.integers(waves, size=(n, 2)), rng.uniform(0.0, 2.0 * np.pi, (n, 2))
    amplitude = rng.uniform(0.0, settings.ripple, (n, 2)) * largest
    weight = np.zeros((n, 2, 2 * waves))
    np.put_along_axis(weight, 2 * which[..., np.newaxis], (amplitude * np.cos(phase))[..., np.newaxis], -1)
    np.put_along_axis(weight, 2 * which[..., np.newaxis] + 1, (amplitude * np.sin(phase))[..., np.newaxis], -1)
    torque += (columns.ripple @ weight[..., np.newaxis])[..., 0]
    late = rng.uniform(0.0, settings.delay_s, (n, 1, 1))
    torque -= late * (columns.rate @ beta[:, np.newaxis, :, np.newaxis])[..., 0]
    noise = rng.uniform(0.0, settings.noise, (n, 1)) * largest
    total: Array = torque + noise[..., np.newaxis] * rng.standard_normal((n, 2, m))
    return total
