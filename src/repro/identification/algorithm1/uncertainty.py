"""How far the network's estimate may be off: the spread over guesses, stretched until it covers; and unlike motions.

Algorithm 1 gives no interval. The network reads the same torque from many guesses, and its estimates scatter. Their
spread is too narrow, for they share their error; split conformal calibration [1]_ stretches it by what arms of known
parameters ask for, which covers arms drawn like those whatever the network is worth.

.. [1] V. Vovk, A. Gammerman, G. Shafer, "Algorithmic Learning in a Random World", Springer, 2005.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from repro.model.parameters import Array

#: Central share of the estimates whose half range is the width.
CENTRAL = 0.68
#: Width below which nothing is known to be narrower, over the largest torque: an estimate's rounding to a digit.
FLOOR = 1e-4
#: Share of training motions that are further from their nearest one than a motion may be that is not warned of.
UNLIKE = 0.01


@dataclass(frozen=True)
class Spread:
    """Estimates of one arm or of many from many guesses.

    Attributes
    ----------
    centre : array of shape (..., 9)
        Median over the guesses, in units of the largest torque.
    width : array of shape (..., 9)
        Half the range of the central `CENTRAL` of the estimates.
    """

    centre: Array
    width: Array


def spread_of(estimates: Array) -> Spread:
    """Centre and width of estimates, an array of shape (guesses, 9) or (arms, guesses, 9).

    Raises
    ------
    ValueError
        If there are fewer than 10 guesses.
    """
    if estimates.ndim < 2 or estimates.shape[-2] < 10:
        raise ValueError(f"estimates: at least 10 guesses are needed, got shape {estimates.shape}.")
    low, middle, high = np.quantile(estimates, [0.5 - CENTRAL / 2, 0.5, 0.5 + CENTRAL / 2], axis=-2)
    return Spread(middle, np.maximum((high - low) / 2, FLOOR))


def misses(spread: Spread, truth: Array) -> Array:
    """By how many widths each centre misses the truth, both of shape (..., 9)."""
    missed: Array = np.abs(truth - spread.centre) / spread.width
    return missed


def stretch_factors(spread: Spread, truth: Array, levels: Sequence[float]) -> Array:
    """Factors on the width that cover arms of known parameters.

    Parameters
    ----------
    spread : Spread
        Of n arms.
    truth : array of shape (n, 9)
        Their parameters, in units of the largest torque.
    levels : sequence of float
        Shares of arms to cover, each below n / (n + 1).

    Returns
    -------
    array of shape (levels, 9)
        The ceil((n + 1) level)-th smallest of |truth - centre| / width: an arm drawn like these is covered with at
        least that probability.

    Raises
    ------
    ValueError
        If there are too few arms for a level.
    """
    scores = np.sort(misses(spread, truth), axis=0)
    n = len(scores)
    ranks = np.ceil((n + 1) * np.asarray(levels)).astype(int)
    if (ranks > n).any() or (ranks < 1).any():
        raise ValueError(f"levels: {n} arms can calibrate shares of 0 to {n / (n + 1):.4g}, got {tuple(levels)}.")
    factors: Array = scores[ranks - 1]
    return factors


def covered(spread: Spread, truth: Array, factors: Array) -> Array:
    """Share of arms whose parameter lies within centre +- factor x width, shape (levels, 9)."""
    return np.asarray((misses(spread, truth) <= factors[:, np.newaxis]).mean(axis=1))


def distances(motions: Array, others: Array | None = None) -> Array:
    """Distance of each motion from the nearest other one, as a share of its own size.

    Parameters
    ----------
    motions : array of shape (n, 2, M, 9)
        Filtered and subsampled regressors of motions.
    others : array of shape (k, 2, M, 9), optional
        Motions to be near to; by default the rest of `motions`.

    Returns
    -------
    array of shape (n,)
        Root of the mean over parameters of |Y - Y_k|^2 / |Y|^2 at the nearest k: what a share means does not hang on
        units.
    """
    own = np.moveaxis(motions, -1, 1).reshape(len(motions), 9, -1)
    size = np.sum(own**2, axis=-1)  # (n, 9)
    found = np.empty(len(own))
    pool = own if others is None else np.moveaxis(others, -1, 1).reshape(len(others), 9, -1)
    for k, one in enumerate(own):
        gap = np.sqrt(np.mean(np.sum((pool - one) ** 2, axis=-1) / size[k], axis=-1))
        if others is None:
            gap[k] = np.inf
        found[k] = gap.min()
    return found


def unlike_beyond(training: Array) -> float:
    """Distance beyond which a motion is unlike the training motions, of shape (K, 2, M, 9)."""
    return float(np.quantile(distances(training), 1.0 - UNLIKE))
