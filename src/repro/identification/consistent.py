"""Least squares among physically consistent parameters: a convex programme, solved by Clarabel through CVXPY.

M(q) is positive definite in every pose when I3 > 0 and I3 (I1 - I3) > I2^2 / 4 (see `repro.model.parameters`), that
is when [[I1 - I3, I2/2], [I2/2, I3]] is: a linear matrix inequality in the parameters. Friction must not be negative.
Gravity may have either sign: it depends on where zero is.
"""

import warnings

import numpy as np
from scipy.optimize import lsq_linear

from repro.identification.method import NoSolutionError
from repro.identification.solve import clip_to_bound, determined
from repro.model.parameters import Array, is_positive_definite

#: Smallest eigenvalue that the inertia may have, over I1 + I3 of the bounded solution: M(q) can be inverted.
MIN_EIGENVALUE_RATIO = 1e-3
#: Friction torque over the largest torque of a parameter below which friction is set to zero.
MIN_FRICTION_RATIO = 1e-6
#: What beta loses when a unit is taken from both diagonal elements of [[I1 - I3, I2/2], [I2/2, I3]].
INERTIA_MARGIN = np.array([2.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
#: Lower bounds: friction is zero or more, the rest is free.
LOWER_BOUNDS = np.array([-np.inf] * 5 + [0.0] * 4)


def solve_inequality(r: Array, c: Array, scale: Array, margin: float) -> Array:
    """Minimise |R z - c| over beta = z / scale (9,) whose inertia matrix has eigenvalues of `margin` (kg m^2) or more.

    The rows (k, 9), (k,) and the scale (9,) are those of `repro.identification.solve.reduced_problem`, with or without
    further rows. NoSolutionError is raised if the solver ends without a solution.
    """
    import cvxpy as cp  # noqa: PLC0415  (takes a second to load, and most logs need none of it)

    size = float(np.linalg.norm(c)) or 1.0  # the solver's tolerances are made for numbers about 1
    z = cp.Variable(9)
    beta = cp.multiply(z, 1.0 / scale)
    off = beta[1] / 2.0
    inertia = cp.bmat([[beta[0] - beta[2], off], [off, beta[2]]])
    conditions = [inertia >> margin / size * np.eye(2), beta[5:] >= 0.0]
    problem = cp.Problem(cp.Minimize(cp.sum_squares(r @ z - c / size)), conditions)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of inaccuracy, which `is_positive_definite` is there to catch
        problem.solve(solver=cp.CLARABEL)
    if z.value is None:
        raise NoSolutionError(f"the convex solver ended with {problem.status!r}")
    solution: Array = size * np.asarray(z.value)
    # The pull to zero is below the solver's tolerance. The inertia keeps what its condition requires instead.
    solution[5:] *= determined(r, c)[5:]
    # The solver stays inside its bounds by a hair: friction that small is a bound that holds.
    solution[5:] = np.maximum(clip_to_bound(solution, MIN_FRICTION_RATIO)[5:], 0.0)
    return solution / scale


def solve_consistent(r: Array, c: Array, scale: Array) -> tuple[Array, bool]:
    """Compute the consistent parameters (9,) with the smallest error, and whether a condition is binding.

    Least squares under the bounds on friction alone is cheap; where its inertia is positive definite with the margin,
    the matrix inequality does not bind and it is the solution. The arguments are those of `solve_inequality`.
    """
    z = lsq_linear(r, c, bounds=(LOWER_BOUNDS, np.inf), method="bvls").x
    z *= determined(r, c)  # which leaves no rounding in the rows that pull
    z[5:] = np.maximum(clip_to_bound(z, 1e-12)[5:], 0.0)
    bounded = z / scale
    margin = MIN_EIGENVALUE_RATIO * max(abs(float(bounded[0] + bounded[2])), np.finfo(np.float64).tiny)
    if is_positive_definite(bounded - margin * INERTIA_MARGIN):
        return bounded, bool((bounded[5:] == 0.0).any())
    return solve_inequality(r, c, scale, margin), True
