"""Methods of least squares: each solves tau = Y beta of a regression for the nine parameters.

A new method is a function from a `Regression` to an `Estimate`, an entry of `METHODS`, and its name in
`repro.identification.method.LEAST_SQUARES`.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import wraps
from operator import itemgetter

import clarabel
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear
from scipy.sparse import csc_array

from repro.identification.method import Estimate, Method, NoSolutionError
from repro.identification.regression import (
    Regression,
    clip_to_bound,
    determined,
    joint_variance,
    reduced_problem,
    solve,
    solve_normal,
    without_known,
)
from repro.model.parameters import NAMES, SIGNED, Array, has_possible_signs, is_positive_definite

WEIGHTED_ITERATIONS = 5
#: Error, in standard deviations, beyond which Huber's loss is linear: 95 % efficient for normal errors.
HUBER_THRESHOLD = 1.345
#: Most iterations of the robust method, and change of torque over the residual's scale at which they end.
ROBUST_ITERATIONS, ROBUST_TOLERANCE = 25, 1e-3
#: Penalties that the parsimonious method tries, in units of the viscous torque's own energy.
PENALTIES = (0.0, 0.03, 0.1, 0.2, 0.3, 0.5, 1.0, 3.0)
BLOCKS = 10  # blocks of the parsimonious method's cross-validation
#: Smallest eigenvalue that the inertia may have, over I1 + I3 of the bounded solution: M(q) can be inverted.
MIN_EIGENVALUE_RATIO = 1e-3
MIN_FRICTION_RATIO = 1e-6  # friction torque over the largest torque of a parameter below which friction is set to zero
#: What beta loses when a unit is taken from both diagonal elements of [[I1 - I3, I2/2], [I2/2, I3]].
INERTIA_MARGIN = np.array([2.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
#: Rows of beta (9,): upper triangle of that matrix, as a vector of the same norm.
INERTIA_CONE = np.array([[1.0, 0.0, -1.0], [0.0, np.sqrt(0.5), 0.0], [0.0, 0.0, 1.0]]) @ np.eye(3, 9)
LOWER_BOUNDS = np.array([-np.inf] * 5 + [0.0] * 4)  # lower bounds: friction is zero or more, the rest is free
UPPER_BOUNDS = np.full(9, np.inf)
#: Signs of I2, g1 and g2 whose product is positive.
SIGNS = ((1.0, 1.0, 1.0), (1.0, -1.0, -1.0), (-1.0, 1.0, -1.0), (-1.0, -1.0, 1.0))


def with_known(method: Callable[[Regression], Estimate]) -> Callable[[Regression], Estimate]:
    """Let a method estimate only what the prior does not know, and add the rest to its estimate."""

    @wraps(method)
    def estimate(regression: Regression) -> Estimate:
        found = method(without_known(regression))
        prior = regression.prior
        return found if prior is None else replace(found, beta=np.where(prior.known, prior.mean, found.beta))

    return estimate


@with_known
def ordinary(regression: Regression) -> Estimate:
    """Minimise the sum of squared torque errors (Gautier and Khalil)."""
    return Estimate(solve(regression.y, regression.tau, prior=regression.prior))


@with_known
def weighted(regression: Regression) -> Estimate:
    """Minimise each joint's errors in units of their own standard deviation (Swevers and others)."""
    beta, size = weighted_fit(regression)
    return Estimate(beta, (_weights_note(size),))


def weighted_fit(regression: Regression) -> tuple[Array, Array]:
    """Compute weighted parameters (9,) and the size (2, 1) of each joint's torque errors, N m."""
    beta = solve(regression.y, regression.tau, prior=regression.prior)
    for _ in range(WEIGHTED_ITERATIONS):
        beta = solve(regression.y, regression.tau, 1.0 / joint_variance(regression, beta), regression.prior)
    return beta, np.sqrt(joint_variance(regression, beta))


def _weights_note(size: Array) -> str:
    first, second = size[:, 0]
    return f"torque errors of {first:.3g} and {second:.3g} N m made the weights of joints 1 and 2"


@with_known
def robust(regression: Regression) -> Estimate:
    """Compute Huber's M-estimate, each joint with its own scale: collisions and stiction have little effect."""
    y, tau = regression.y, regression.tau
    error = tau - y @ solve(y, tau, prior=regression.prior)
    for _ in range(ROBUST_ITERATIONS):
        scale = _median_scale(error, regression.mask)
        size = np.abs(error) / scale
        weight = HUBER_THRESHOLD / np.maximum(size, HUBER_THRESHOLD)
        beta = solve(y, tau, weight / scale**2, regression.prior)
        before, error = error, tau - y @ beta
        if np.max(np.abs(error - before) / scale) < ROBUST_TOLERANCE:
            break
    lowered = 100.0 * float(np.mean(weight[regression.mask] < 1.0))
    return Estimate(beta, (f"{lowered:.3g} % of the samples count less than the rest",))


def _median_scale(error: Array, mask: NDArray[np.bool_]) -> Array:
    """Standard deviation of each joint's error (2, 1), by the median where it moves."""
    scale = np.array([[1.4826 * np.median(np.abs(e[m])) if m.any() else 0.0] for e, m in zip(error, mask, strict=True)])
    return np.where(scale > 0.0, scale, 1.0)


@with_known
def instrumental(regression: Regression) -> Estimate:
    """Compute the instrumental-variable estimate, with the joints weighted as in weighted least squares.

    Noise of the position attenuates least squares. The regressor of every other sample is therefore the instrument for
    that of the samples between, whose noise is independent. (The tanh of Coulomb friction, not linear, stays biased.)
    """
    if regression.even_odd is None:
        raise NoSolutionError("the regression was made without the regressors of every other sample")
    odd, even = regression.even_odd
    cross, prior = odd.mT @ even, regression.prior
    # For each joint: Z' Y with both halves as each other's instruments, Z' tau, squared lengths of both halves.
    gram, right = cross + cross.mT, ((odd + even).mT @ regression.tau[..., None])[..., 0]
    length = np.stack([np.einsum("jnp,jnp->jp", half, half) for half in (odd, even)])

    def solution(variance: Array, of_rows: float = 1.0) -> Array:
        """Solve Z' (tau - Y beta) = 0, each joint over its variance; the prior counts twice, as each sample does."""
        weight = 1.0 / variance  # (2, 1)
        size = np.sqrt(np.prod(np.sqrt((weight * length).sum(1)), axis=0))
        matrix, product = (weight[..., None] * gram).sum(0), (weight * right).sum(0)
        if prior is not None:
            rows, values = prior.rows()
            added = 2.0 * of_rows * rows.T @ rows
            matrix, product = matrix + added, product + 2.0 * of_rows * rows.T @ values
            size = np.sqrt(size**2 + added.diagonal())
        return solve_normal(matrix, product, size)

    beta = solution(np.ones((2, 1)), 1.0 if prior is None else prior.variance)
    beta = solution(joint_variance(regression, beta))
    return Estimate(beta, ("the instruments are the regressors of every other sample",))


@with_known
def bounded(regression: Regression) -> Estimate:
    """Solve least squares under the bounds beta >= 0, which line 22 of Algorithm 1 requires of a candidate."""
    r, c, scale = reduced_problem(regression)
    z = lsq_linear(r, c, bounds=(0.0, np.inf), method="bvls").x * determined(r, c)
    beta = clip_to_bound(np.maximum(z, 0.0), 1e-12) / scale
    known = set() if regression.prior is None else {*np.flatnonzero(regression.prior.known)}
    zero = [NAMES[k] for k in np.flatnonzero(beta == 0.0) if k not in known]
    return Estimate(beta, (f"held at zero: {', '.join(zero)}",) if zero else ())


def solve_inequality(
    r: Array, c: Array, scale: Array, margin: float, known: Array, low: Array = LOWER_BOUNDS, high: Array = UPPER_BOUNDS
) -> Array:
    """Minimise |R z - c| over beta = z / scale + known (9,) whose inertia has eigenvalues of `margin` (kg m^2) or more.

    M(q) is positive definite in every pose when [[I1 - I3, I2/2], [I2/2, I3]] is (see `repro.model.parameters`): a
    linear matrix inequality, solved by Clarabel. The bounds (9,) of beta are zero or infinite.
    """
    size = float(np.linalg.norm(c)) or 1.0  # the solver's tolerances are made for numbers about 1
    rows = np.vstack([np.eye(9)[low == 0.0], -np.eye(9)[high == 0.0], INERTIA_CONE])
    limits = (rows @ known - np.r_[np.zeros(len(rows) - 3), margin, 0.0, margin]) / size
    # Residuals y = R z - c are variables, too: R' R would lose half of the digits.
    n, n_bounds = len(r), len(rows) - 3
    a = np.block([[-np.eye(n), r], [np.zeros((len(rows), n)), -rows / scale]])
    objective = csc_array(np.diag(np.repeat([2.0, 0.0], [n, 9]))), np.zeros(n + 9)
    cones = [clarabel.ZeroConeT(n), clarabel.NonnegativeConeT(n_bounds), clarabel.PSDTriangleConeT(2)]
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    found = clarabel.DefaultSolver(*objective, csc_array(a), np.r_[c / size, limits], cones, settings).solve()
    if found.status not in (clarabel.SolverStatus.Solved, clarabel.SolverStatus.AlmostSolved):
        raise NoSolutionError(f"the convex solver ended with {found.status}")
    solution = size * np.array(found.x[n:])
    # The pull to zero is below the solver's tolerance; the inertia keeps what its condition requires. The solver stays
    # inside its bounds by a hair: friction that small is a bound that holds.
    solution[5:] *= determined(r, c)[5:]
    return _at_bounds(solution, MIN_FRICTION_RATIO, low, high) / scale + known


def _at_bounds(z: Array, ratio: float, low: Array, high: Array) -> Array:
    """Set what a solver leaves of a bound that holds, a fraction of the largest number, to zero."""
    return np.where((low == 0.0) | (high == 0.0), np.clip(clip_to_bound(z, ratio), low, high), z)


def solve_consistent(r: Array, c: Array, scale: Array, known: Array) -> tuple[Array, bool]:
    """Compute the consistent parameters (9,) with the smallest error, and whether a condition is binding."""
    beta, binding = _solve_definite(r, c, scale, known, LOWER_BOUNDS, UPPER_BOUNDS)
    if has_possible_signs(beta):
        return beta, binding
    # The error within the bounds alone is the least that a set of signs can have, so the rest need not be solved.
    bounds = [(lsq_linear(r, c, bounds=pair, method="bvls").cost, *pair) for pair in _bounds_of_signs(known)]
    min_cost = np.inf
    for cost_of_bounds, low, high in sorted(bounds, key=itemgetter(0)):
        if cost_of_bounds < min_cost:
            candidate = _solve_definite(r, c, scale, known, low, high)[0]
            cost = 0.5 * float(np.sum((r @ ((candidate - known) * scale) - c) ** 2))
            min_cost, beta = min((min_cost, beta), (cost, candidate), key=itemgetter(0))
    return beta, True


def _bounds_of_signs(known: Array) -> Iterator[tuple[Array, Array]]:
    """Bounds (9,) of each set of signs that agrees with what is known; that itself has no bound."""
    values, is_known = known[[*SIGNED]], known[[*SIGNED]] != 0.0
    for signs in np.array(SIGNS):
        if (signs * values >= 0.0).all():
            low, high = LOWER_BOUNDS.copy(), UPPER_BOUNDS.copy()
            low[[*SIGNED]] = np.where((signs > 0.0) & ~is_known, 0.0, -np.inf)
            high[[*SIGNED]] = np.where((signs < 0.0) & ~is_known, 0.0, np.inf)
            yield low, high


def _solve_definite(r: Array, c: Array, scale: Array, known: Array, low: Array, high: Array) -> tuple[Array, bool]:
    """Compute the parameters with a definite inertia and within bounds, and whether a condition is binding."""
    # Bounds alone are cheap, and give the solution where its inertia is definite.
    z = lsq_linear(r, c, bounds=(low, high), method="bvls").x
    z *= determined(r, c)  # which leaves no rounding in the rows that pull
    bounded = _at_bounds(z, 1e-12, low, high) / scale + known
    margin = MIN_EIGENVALUE_RATIO * max(abs(float(bounded[0] + bounded[2])), np.finfo(np.float64).tiny)
    if is_positive_definite(bounded - margin * INERTIA_MARGIN):
        return bounded, bool((bounded[5:] == 0.0).any())
    return solve_inequality(r, c, scale, margin, known, low, high), True


@with_known
def consistent(regression: Regression) -> Estimate:
    """Solve least squares with M(q) positive definite in every pose, friction >= 0 and I2 g1 g2 >= 0."""
    beta, binding = solve_consistent(*reduced_problem(regression), regression.known)
    return Estimate(beta, (_binding_note(binding),))


def _binding_note(binding: bool) -> str:
    return "the conditions of physical consistency hold it" if binding else "consistent without being held"


@with_known
def weighted_consistent(regression: Regression) -> Estimate:
    """Solve weighted least squares under the conditions of `consistent`."""
    size = weighted_fit(regression)[1]
    beta, binding = solve_consistent(*reduced_problem(regression, size), regression.known)
    return Estimate(beta, (_weights_note(size), _binding_note(binding)))


@with_known
def parsimonious(regression: Regression) -> Estimate:
    """Solve weighted consistent least squares with no more viscous friction than the log can show.

    Slow motion hardly distinguishes viscous from Coulomb friction. A penalty rho |Y_b b|^2 therefore shrinks the
    viscous torque: the strongest whose error in block cross-validation is within one standard error of the smallest
    (Breiman et al., "Classification and Regression Trees", 1984, section 3.4.3).
    """
    penalty = PENALTIES[choose_penalty(_cross_validation_errors(regression))]
    note = f"viscous torque shrunk with a penalty of {penalty:g}, the most that prediction of left-out blocks allows"
    return Estimate(refit_parsimonious(regression, penalty), (note,), penalty)


def refit_parsimonious(regression: Regression, penalty: float) -> Array:
    """Compute consistent parameters (9,) under a given penalty rho."""
    rest = without_known(regression)
    return _shrunk(reduced_problem(rest, weighted_fit(rest)[1]), penalty, rest.known)


def _shrunk(problem: tuple[Array, Array, Array], penalty: float, known: Array) -> Array:
    """Compute consistent parameters with two rows added that pull the viscous torque to zero."""
    r, c, scale = problem
    rows = np.sqrt(penalty) * np.eye(9)[5:7]
    return solve_consistent(np.vstack([r, rows]), np.concatenate([c, [0.0, 0.0]]), scale, known)[0]


def _cross_validation_errors(regression: Regression) -> Array:
    """Squared error of each block (penalties, blocks), from parameters fitted without it."""
    samples = np.arange(regression.t.size)
    energy = np.mean(regression.tau**2, axis=-1)
    energy = np.where(energy > 0.0, energy, 1.0)
    errors = []
    for inside in np.split(samples, np.linspace(0, samples.size, BLOCKS + 1).astype(int)[1:-1]):
        rest, block = regression.take(np.delete(samples, inside)), regression.take(inside)
        problem = reduced_problem(rest, weighted_fit(rest)[1])
        residuals = (block.tau - block.y @ _shrunk(problem, penalty, rest.known) for penalty in PENALTIES)
        errors.append([np.sum(np.mean(error**2, axis=-1) / energy) for error in residuals])
    return np.stack(errors, axis=1)


def choose_penalty(errors: Array) -> int:
    """Index of the strongest penalty within one standard error of the best; errors are (penalties, blocks)."""
    best = int(errors.mean(1).argmin())
    more = errors - errors[best]
    allowed = more.mean(1) <= more.std(1, ddof=1) / np.sqrt(errors.shape[1])
    allowed[best] = True
    return int(np.flatnonzero(allowed).max())


METHODS: dict[str, Method] = {
    method.name: method
    for method in (
        Method("ordinary", "ordinary least squares", "gautier1992exciting", ordinary, sums_suffice=True),
        Method("weighted", "weighted least squares", "swevers2007dynamic", weighted, sums_suffice=True),
        Method("robust", "robust least squares (Huber)", "huber1964robust", robust),
        Method("instrumental", "instrumental variables", "janot2014generic", instrumental, needs_even_odd=True),
        Method("bounded", "bounded least squares", "branch1999subspace", bounded, sums_suffice=True),
        Method("consistent", "consistent least squares", "sousa2014physical", consistent, sums_suffice=True),
        Method(
            "weighted-consistent",
            "weighted consistent least squares",
            "sousa2014physical",
            weighted_consistent,
            sums_suffice=True,
        ),
        Method(
            "parsimonious",
            "parsimonious least squares",
            "breiman1984cart",
            parsimonious,
            sums_suffice=True,
            refit=refit_parsimonious,
            unbiased=weighted_consistent,
        ),
    )
}
