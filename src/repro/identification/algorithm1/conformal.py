"""Conformal error bars for the network's estimate, and a novelty check of the motion.

The network estimates the same arm from many guesses. Their spread is too narrow, because they share their error. Split
conformal calibration (Vovk, Gammerman, Shafer, "Algorithmic Learning in a Random World", 2005) stretches it by a factor
found on arms of known parameters, which covers arms drawn like those for any network.
"""

from collections.abc import Sequence

import numpy as np

from repro.model.parameters import Array

CENTRAL_FRACTION = 0.68  # central fraction of the estimates whose half range is the width
MIN_WIDTH = 1e-4  # least width, over the largest torque: an estimate's rounding to a digit
#: Fraction of training motions that are as far from their nearest one as a motion that is called novel.
NOVEL_FRACTION = 0.01


def spread_of(estimates: Array) -> tuple[Array, Array]:
    """Compute median and half the central range, each (..., 9), of estimates from many guesses (..., guesses, 9)."""
    low, middle, high = np.quantile(estimates, [0.5 - CENTRAL_FRACTION / 2, 0.5, 0.5 + CENTRAL_FRACTION / 2], axis=-2)
    return middle, np.maximum((high - low) / 2, MIN_WIDTH)


def normalised_errors(estimates: Array, truth: Array) -> Array:
    """Compute |truth - centre| / width (..., 9) of estimates (..., guesses, 9)."""
    centre, width = spread_of(estimates)
    return np.abs(truth - centre) / width


def stretch_factors(errors: Array, levels: Sequence[float]) -> Array:
    """Compute the factors (levels, 9) on the width that cover: the ceil((n + 1) level)-th smallest of errors (n, 9)."""
    n = len(errors)
    ranks = np.ceil((n + 1) * np.asarray(levels)).astype(int)
    if (ranks > n).any() or (ranks < 1).any():
        raise ValueError(f"levels: {n} arms can calibrate shares of 0 to {n / (n + 1):.4g}, got {tuple(levels)}.")
    return np.asarray(np.sort(errors, axis=0)[ranks - 1])


def distances(motions: Array, others: Array | None = None) -> Array:
    """Compute the distance (n,) of motions, as regressors (n, 2, M, 9), from the nearest of `others`, or of each other.

    It is the root of the mean over parameters of |Y - Y_k|^2 / |Y|^2 at the nearest k, which does not depend on units.
    """
    own = np.moveaxis(motions, -1, 1).reshape(len(motions), 9, -1)
    size = np.sum(own**2, axis=-1)  # (n, 9)
    nearest = np.empty(len(own))
    pool = own if others is None else np.moveaxis(others, -1, 1).reshape(len(others), 9, -1)
    for k, motion in enumerate(own):
        gap = np.sqrt(np.mean(np.sum((pool - motion) ** 2, axis=-1) / size[k], axis=-1))
        if others is None:
            gap[k] = np.inf
        nearest[k] = gap.min()
    return nearest


def novelty_limit(training: Array) -> float:
    """Compute the distance beyond which a motion is unlike the training motions (K, 2, M, 9)."""
    return float(np.quantile(distances(training), 1.0 - NOVEL_FRACTION))
