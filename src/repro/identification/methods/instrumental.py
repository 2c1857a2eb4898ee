"""Instrumental variables: least squares whose inertia and gravity noise in the position does not bias.

Noise in the regressor, e.g. of an encoder, pulls least squares towards zero. (What it does to the tanh of Coulomb
friction is not undone: that is not linear in the noise.) Instruments are signals that follow the
motion but not that noise. Here they come from the log itself, without a model of the controller: the regressor of
every other sample is the instrument of the regressor of the samples between, whose noise is independent of it.
Each half serves as the other's instrument, and the two sets of equations are added.
"""

import numpy as np

from repro.identification.methods.interface import Estimate, Method, NoSolutionError, joint_variance
from repro.identification.regression import Regression
from repro.identification.solve import MOVED, pseudo_solve
from repro.model.parameters import Array


def _solve(regression: Regression, variance: Array) -> Array:
    """Z' (tau - Y beta) = 0 with both halves as instruments of each other, each joint over its variance."""
    if regression.interleaved is None:
        raise NoSolutionError("the regression was made without the regressors of every other sample")
    weight = 1.0 / np.sqrt(variance)
    odd, even = (half.reshape(-1, half.shape[-1]) for half in regression.interleaved * weight[..., None])
    length = np.sqrt(np.linalg.norm(odd, axis=0) * np.linalg.norm(even, axis=0))
    moved = length > MOVED * length.max(initial=0.0)
    scale = np.where(moved, length, 1.0)
    odd, even = (np.where(moved, half / scale, 0.0) for half in (odd, even))
    tau = (regression.tau * weight).reshape(-1)
    beta: Array = pseudo_solve(odd.T @ even + even.T @ odd, (odd + even).T @ tau) * moved / scale
    return beta


def estimate(regression: Regression) -> Estimate:
    """Instrumental-variable estimate with the joints weighted as in weighted least squares."""
    beta = _solve(regression, np.ones((2, 1)))
    beta = _solve(regression, joint_variance(regression, beta))
    return Estimate(beta, ("the instruments are the regressors of every other sample",))


METHOD = Method("instrumental", "instrumental variables", "janot2014generic", estimate)
