"""Least squares among physically consistent parameters: a convex programme, solved by Clarabel through CVXPY.

M(q) is positive definite in every pose when I3 > 0 and I3 (I1 - I3) > I2^2 / 4 (see `repro.model.parameters`), that
is when [[I1 - I3, I2/2], [I2/2, I3]] is: a linear matrix inequality in the parameters. Friction must not be negative.
Gravity may have either sign: it depends on where zero is.
"""

import warnings

import numpy as np
from scipy.optimize import lsq_linear

from repro.identification.methods.interface import Estimate, Method, NoSolutionError
from repro.identification.solve import asked, nine_rows, snap
from repro.model.parameters import Array, is_positive_definite

#: Smallest eigenvalue that the inertia may have, over I1 + I3 of the bounded solution: M(q) can be inverted.
MARGIN = 1e-3
#: Friction torque over the largest torque of a parameter below which friction is held at zero.
HAIR = 1e-6
#: What beta loses when a unit is taken from both diagonal elements of [[I1 - I3, I2/2], [I2/2, I3]].
INERTIA_MARGIN = np.array([2.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
#: Friction is zero or more, the rest is free.
FRICTION_BOUNDS = np.array([-np.inf] * 5 + [0.0] * 4)


def solve_consistent(r: Array, c: Array, scale: Array, margin: float) -> Array:
    """Minimise |R z - c| over consistent beta = z / scale.

    Parameters
    ----------
    r, c, scale : arrays of shape (k, 9), (k,), (9,)
        As `repro.identification.solve.nine_rows` gives them; more rows may have been added.
    margin : float
        Smallest eigenvalue of [[I1 - I3, I2/2], [I2/2, I3]], kg m^2.

    Returns
    -------
    array of shape (9,)
        beta.

    Raises
    ------
    NoSolutionError
        If the solver ends without a solution.
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
    # The pull to zero is below the solver's tolerance. The inertia keeps what its condition asks for instead.
    solution[5:] *= asked(r, c)[5:]
    # The solver stays inside its bounds by a hair: what it leaves of a friction that is held is no friction.
    solution[5:] = np.maximum(snap(solution, HAIR)[5:], 0.0)
    return solution / scale


def consistent(r: Array, c: Array, scale: Array) -> tuple[Array, bool]:
    """Consistent parameters with the smallest error, and whether a condition holds them.

    Least squares under the bounds on friction alone is cheap; where its inertia is positive definite with the margin,
    the matrix inequality does not bind and it is the solution.

    Parameters
    ----------
    r, c, scale : arrays of shape (k, 9), (k,), (9,)
        As for `solve_consistent`.

    Returns
    -------
    array of shape (9,), bool
        beta; False if it is the unconditional least-squares solution.
    """
    z = lsq_linear(r, c, bounds=(FRICTION_BOUNDS, np.inf), method="bvls").x
    z *= asked(r, c)  # which leaves no rounding in the rows that pull
    z[5:] = np.maximum(snap(z, 1e-12)[5:], 0.0)
    bounded = z / scale
    margin = MARGIN * max(abs(float(bounded[0] + bounded[2])), np.finfo(np.float64).tiny)
    if is_positive_definite(bounded - margin * INERTIA_MARGIN):
        return bounded, bool((bounded[5:] == 0.0).any())
    return solve_consistent(r, c, scale, margin), True


def solve(y: Array, tau: Array) -> Estimate:
    """Least squares with M(q) positive definite in every pose and no friction negative."""
    beta, held = consistent(*nine_rows(y, tau))
    note = "the conditions of physical consistency hold it" if held else "consistent without being held"
    return Estimate(beta, (note,))


METHOD = Method("consistent", "consistent least squares", "sousa2014physical", lambda r: solve(r.y, r.tau))
