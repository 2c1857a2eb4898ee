"""Ordinary least squares: every squared torque error counts the same (Gautier and Khalil)."""

from repro.identification.methods.interface import Estimate, Method
from repro.identification.regression import Regression
from repro.identification.solve import solve


def estimate(regression: Regression) -> Estimate:
    """Parameters with the smallest sum of squared torque errors; nothing keeps them physically consistent."""
    return Estimate(solve(regression.y, regression.tau))


METHOD = Method("ordinary", "ordinary least squares", "gautier1992exciting", estimate)
