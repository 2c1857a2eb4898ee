"""Weighted least squares: each joint's errors in units of their own standard deviation (Swevers and others)."""

import numpy as np

from repro.identification.methods.interface import Estimate, Method, joint_variance
from repro.identification.regression import Regression
from repro.identification.solve import solve

ROUNDS = 5


def estimate(regression: Regression) -> Estimate:
    """Least squares and the joints' error variances in turn, until they agree."""
    beta = solve(regression.y, regression.tau)
    for _ in range(ROUNDS):
        beta = solve(regression.y, regression.tau, 1.0 / joint_variance(regression, beta))
    first, second = np.sqrt(joint_variance(regression, beta))[:, 0]
    return Estimate(beta, (f"torque errors of {first:.3g} and {second:.3g} N m made the weights of joints 1 and 2",))


METHOD = Method("weighted", "weighted least squares", "swevers2007dynamic", estimate)
