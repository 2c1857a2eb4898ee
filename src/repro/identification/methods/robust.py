"""Robust regression by iteratively reweighted least squares with Huber's weights.

Errors beyond 1.345 standard deviations count in proportion to their size, not to its square: 95 % as efficient as
least squares where errors are normal, and little moved by collisions, stiction and other short events.
"""

import numpy as np
from numpy.typing import NDArray

from repro.identification.methods.interface import Estimate, Method
from repro.identification.regression import Regression
from repro.identification.solve import solve
from repro.model.parameters import Array

HUBER = 1.345
ROUNDS = 25
#: Rounds end when the torque of no sample changes by more than this share of the residual's scale.
SETTLED = 1e-3


def _scale(error: Array, moving: NDArray[np.bool_]) -> Array:
    """Standard deviation of each joint's error by its median where it moves, shape (2, 1)."""
    scale = np.array(
        [[1.4826 * np.median(np.abs(e[m])) if m.any() else 0.0] for e, m in zip(error, moving, strict=True)]
    )
    return np.where(scale > 0.0, scale, 1.0)


def estimate(regression: Regression) -> Estimate:
    """Huber's M-estimate with each joint's own scale."""
    y, tau = regression.y, regression.tau
    error = tau - y @ solve(y, tau)
    for _ in range(ROUNDS):
        scale = _scale(error, regression.moving)
        size = np.abs(error) / scale
        weight = HUBER / np.maximum(size, HUBER)
        beta = solve(y, tau, weight / scale**2)
        before, error = error, tau - y @ beta
        if np.max(np.abs(error - before) / scale) < SETTLED:
            break
    lowered = 100.0 * float(np.mean(weight[regression.moving] < 1.0))
    return Estimate(beta, (f"{lowered:.3g} % of the samples count less than the rest",))


METHOD = Method("robust", "robust least squares (Huber)", "huber1964robust", estimate)
