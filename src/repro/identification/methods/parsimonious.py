"""Physically consistent least squares with no more viscous friction than the log can show.

A slow motion hardly tells viscous from Coulomb friction: a little more of one and less of the other fit as well, and
the difference shows on faster motions. The viscous torque is therefore shrunk, by a penalty rho |Y_b b|^2, as far as
prediction allows: the strongest penalty whose error in block cross-validation is within one standard error of the
smallest ([1]_; of the differences, because the blocks are the same).

.. [1] L. Breiman, J. Friedman, R. Olshen and C. Stone, "Classification and Regression Trees", 1984, section 3.4.3.
"""

import numpy as np

from repro.identification.methods import consistent as unshrunk
from repro.identification.methods.consistent import consistent
from repro.identification.methods.interface import Estimate, Method
from repro.identification.regression import Regression
from repro.identification.solve import nine_rows
from repro.model.parameters import Array

#: Penalties tried, in units of the viscous torque's own energy.
PENALTIES = (0.0, 0.03, 0.1, 0.2, 0.3, 0.5, 1.0, 3.0)
BLOCKS = 10
VISCOUS = (5, 6)


def _shrunk(problem: tuple[Array, Array, Array], penalty: float) -> Array:
    """Consistent parameters with two rows added that pull the viscous torque to zero."""
    r, c, scale = problem
    rows = np.zeros((len(VISCOUS), 9))
    rows[range(len(VISCOUS)), VISCOUS] = np.sqrt(penalty)
    return consistent(np.vstack([r, rows]), np.concatenate([c, np.zeros(len(VISCOUS))]), scale)[0]


def _prediction_errors(regression: Regression) -> Array:
    """Squared error of each block, from parameters fitted without it, shape (penalties, blocks)."""
    n = regression.t.size
    edges = np.linspace(0, n, BLOCKS + 1).astype(int)
    energy = np.mean(regression.tau**2, axis=-1)
    energy = np.where(energy > 0.0, energy, 1.0)
    errors = np.empty((len(PENALTIES), BLOCKS))
    for k in range(BLOCKS):
        inside = np.zeros(n, dtype=bool)
        inside[edges[k] : edges[k + 1]] = True
        rest, block = regression.take(np.flatnonzero(~inside)), regression.take(np.flatnonzero(inside))
        problem = nine_rows(rest.y, rest.tau)
        for i, penalty in enumerate(PENALTIES):
            error = block.tau - block.y @ _shrunk(problem, penalty)
            errors[i, k] = np.sum(np.mean(error**2, axis=-1) / energy)
    return errors


def choose_penalty(errors: Array) -> int:
    """Index of the strongest penalty within one standard error of the best; errors of shape (penalties, blocks)."""
    best = int(errors.mean(1).argmin())
    more = errors - errors[best]
    allowed = more.mean(1) <= more.std(1, ddof=1) / np.sqrt(errors.shape[1])
    allowed[best] = True
    return int(np.flatnonzero(allowed).max())


def estimate(regression: Regression) -> Estimate:
    """Consistent parameters with the viscous torque shrunk as far as prediction allows.

    Biased on purpose: the difference to the unshrunk estimate enters its standard errors.
    """
    chosen = PENALTIES[choose_penalty(_prediction_errors(regression))]
    note = f"viscous torque shrunk with a penalty of {chosen:g}, the most that prediction of left-out blocks allows"
    return Estimate(refit(regression, chosen), (note,), chosen)


def refit(regression: Regression, penalty: float) -> Array:
    """Consistent parameters under a given penalty rho."""
    return _shrunk(nine_rows(regression.y, regression.tau), penalty)


METHOD = Method(
    "parsimonious",
    "parsimonious least squares",
    "breiman1984cart",
    estimate,
    refit=refit,
    unbiased=unshrunk.METHOD,
)
