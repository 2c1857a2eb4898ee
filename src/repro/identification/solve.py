"""Least squares of a regression that may not excite every parameter, by its normal equations.

Columns are scaled to unit length first, which leaves the equations a condition number of the square of some tens: ten
digits remain, and a method can be repeated hundreds of times for its standard errors.
"""

import numpy as np
from numpy.typing import NDArray

from repro.identification.regression import Prior
from repro.model.parameters import Array

#: Singular values below this fraction of the largest count as zero, for columns of unit length.
RANK_TOLERANCE = 1e-6
#: Columns shorter than this fraction of the longest are rounding of a joint that does not move, and count as zero.
MIN_COLUMN_RATIO = 1e-9
#: Weights of the rows that pull to zero, for columns of unit length: undetermined directions, and all parameters.
UNDETERMINED_WEIGHT, REGULARISATION_WEIGHT = 1e-3, 1e-7


def unit_columns(y: Array) -> tuple[Array, Array]:
    """Scale a regressor (2, n, 9) to rows (2 n, 9) with columns of unit length, or zero; beta = z / scale (9,)."""
    a = y.reshape(-1, y.shape[-1])
    length = np.sqrt(np.einsum("np,np->p", a, a))
    moved = length > MIN_COLUMN_RATIO * length.max(initial=0.0)
    scale = np.where(moved, length, 1.0)
    return a * np.where(moved, 1.0 / scale, 0.0), scale


def pseudo_solve(gram: Array, right: Array) -> Array:
    """Compute the shortest solution of a symmetric system whose small eigenvalues count as zero."""
    values, vectors = np.linalg.eigh(gram)
    nonzero = np.abs(values) > RANK_TOLERANCE**2 * np.abs(values).max()
    inverse = np.divide(1.0, values, out=np.zeros_like(values), where=nonzero)
    return np.asarray(vectors @ (inverse * (vectors.T @ right)))


def solve_normal(gram: Array, right: Array, length: Array) -> Array:
    """Solve normal equations whose columns have these lengths; a column that is nothing but rounding counts as 0."""
    moved = length > MIN_COLUMN_RATIO * length.max(initial=0.0)
    inverse = np.divide(1.0, length, out=np.zeros_like(length), where=moved)
    return pseudo_solve(gram * inverse * inverse[:, None], right * inverse) * inverse


def solve(y: Array, tau: Array, weight: Array | None = None, prior: Prior | None = None) -> Array:
    """Compute the parameters (9,) with the smallest sum of squared torque errors, from y (2, n, 9) and tau (2, n).

    `weight` of each squared error broadcasts to (2, n); next to a prior, weighted rows have a variance of 1. Parameters
    that are not unique are the shortest in units of the columns' length; one that the motion does not move is 0.
    """
    if weight is None and prior is None:
        a, scale = unit_columns(y)
        gram = a.T @ a
        return pseudo_solve(gram, a.T @ tau.reshape(-1)) * (gram.diagonal() > 0.0) / scale
    flat = y.reshape(-1, y.shape[-1])
    weighted = (y * np.asarray(1.0 if weight is None else weight)[..., np.newaxis]).reshape(flat.shape)
    gram, right = weighted.T @ flat, weighted.T @ tau.reshape(-1)
    if prior is not None:
        added = prior.precision * (prior.variance if weight is None else 1.0)
        gram, right = gram + np.diag(added), right + added * prior.mean
    return solve_normal(gram, right, np.sqrt(gram.diagonal()))


def reduced_problem(y: Array, tau: Array, prior: Prior | None = None) -> tuple[Array, Array, Array]:
    """Reduce |Y beta - tau|^2, but for a constant, to |R z - c|^2 with R (k, 9), c (k,) and beta = z / scale (9,).

    Further rows are those of the prior, and rows that pull undetermined directions, and more weakly all of z, to zero.
    """
    a, scale = unit_columns(y)
    gram, product = a.T @ a, a.T @ tau.reshape(-1)
    if prior is not None:
        added = prior.precision * prior.variance / scale
        gram, product = gram + np.diag(added / scale), product + added * prior.mean
        length = np.sqrt(np.where(gram.diagonal() > 0.0, gram.diagonal(), 1.0))
        gram, product, scale = gram / length / length[:, None], product / length, scale * length
    moved = np.flatnonzero(gram.diagonal() > 0.0)
    values, vectors = np.linalg.eigh(gram[np.ix_(moved, moved)])
    nonzero = values > RANK_TOLERANCE**2 * values.max(initial=0.0)
    directions = np.zeros((moved.size, len(scale)))
    directions[:, moved] = vectors.T
    root = np.sqrt(values[nonzero])
    undetermined, weak = UNDETERMINED_WEIGHT * directions[~nonzero], REGULARISATION_WEIGHT * np.eye(len(scale))
    rows = np.vstack([root[:, None] * directions[nonzero], undetermined, weak])
    right = np.zeros(len(rows))
    right[: root.size] = directions[nonzero] @ product / root
    return rows, right, scale


def determined(r: Array, c: Array) -> NDArray[np.bool_]:
    """Find the parameters that rows R z = c determine; the others share no row with them and are exactly 0."""
    alone = np.count_nonzero(r.T @ r, axis=0) == 1
    return np.asarray(~(alone & (r.T @ c == 0.0)))


def clip_to_bound(z: Array, ratio: float) -> Array:
    """Set numbers smaller than a fraction of the largest to zero: what a solver leaves of a bound that holds."""
    return np.where(np.abs(z) > ratio * np.abs(z).max(initial=0.0), z, 0.0)
