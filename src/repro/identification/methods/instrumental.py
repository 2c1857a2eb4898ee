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
from repro.identification.solve import solve_normal
from repro.model.parameters import Array


def _products(regression: Regression) -> tuple[Array, Array, Array]:
    """Of each joint: Z' Y with both halves as instruments of each other, Z' tau, squared lengths of both halves."""
    if regression.interleaved is None:
        raise NoSolutionError("the regression was made without the regressors of every other sample")
    odd, even = regression.interleaved
    cross = odd.mT @ even
    length = np.stack([np.einsum("jnp,jnp->jp", half, half) for half in (odd, even)])
    return cross + cross.mT, ((odd + even).mT @ regression.tau[..., None])[..., 0], length


def _solve(products: tuple[Array, Array, Array], variance: Array) -> Array:
    """Z' (tau - Y beta) = 0, each joint over its variance."""
    gram, right, length = products
    weight = 1.0 / variance  # (2, 1)
    odd, even = np.sqrt((weight * length).sum(1))
    return solve_normal((weight[..., None] * gram).sum(0), (weight * right).sum(0), np.sqrt(odd * even))


def estimate(regression: Regression) -> Estimate:
    """Instrumental-variable estimate with the joints weighted as in weighted least squares."""
    products = _products(regression)
    beta = _solve(products, np.ones((2, 1)))
    beta = _solve(products, joint_variance(regression, beta))
    return Estimate(beta, ("the instruments are the regressors of every other sample",))


METHOD = Method("instrumental", "instrumental variables", "janot2014generic", estimate)
