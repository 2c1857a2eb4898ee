"""Least squares of a regression that may not excite every parameter, by its normal equations.

Columns are scaled to unit length first, which leaves the equations a condition number of the square of some tens: ten
digits remain, and a method can be repeated hundreds of times for its standard errors.
"""

import numpy as np
from numpy.typing import NDArray

from repro.model.parameters import Array

#: Singular values below this share of the largest are taken for zero, columns having unit length.
RANK_TOLERANCE = 1e-6
#: Columns shorter than this share of the longest are rounding of a joint that does not move, and count as zero.
MOVED = 1e-9
#: Weights of the rows that pull to zero, with columns of unit length: directions that nothing determines, and all.
OPEN, PULL = 1e-3, 1e-7


def unit_columns(y: Array) -> tuple[Array, Array]:
    """Regressor as rows with columns of unit length.

    Parameters
    ----------
    y : array of shape (2, n, 9)
        Regressor.

    Returns
    -------
    a : array of shape (2 n, 9)
        Scaled; a column that is nothing but rounding is zero.
    scale : array of shape (9,)
        beta = z / scale solves the problem that z solves for `a`.
    """
    a = y.reshape(-1, y.shape[-1])
    length = np.sqrt(np.einsum("np,np->p", a, a))
    moved = length > MOVED * length.max(initial=0.0)
    scale = np.where(moved, length, 1.0)
    return a * np.where(moved, 1.0 / scale, 0.0), scale


def pseudo_solve(gram: Array, right: Array) -> Array:
    """Shortest solution of a symmetric system whose small eigenvalues count as zero."""
    values, vectors = np.linalg.eigh(gram)
    kept = np.abs(values) > RANK_TOLERANCE**2 * np.abs(values).max()
    inverse = np.divide(1.0, values, out=np.zeros_like(values), where=kept)
    solution: Array = vectors @ (inverse * (vectors.T @ right))
    return solution


def solve_normal(gram: Array, right: Array, length: Array) -> Array:
    """Solution of normal equations whose columns are of these lengths; one that is nothing but rounding counts as 0."""
    moved = length > MOVED * length.max(initial=0.0)
    inverse = np.divide(1.0, length, out=np.zeros_like(length), where=moved)
    return pseudo_solve(gram * inverse * inverse[:, None], right * inverse) * inverse


def solve(y: Array, tau: Array, weight: Array | None = None) -> Array:
    """Parameters with the smallest sum of squared torque errors.

    Where they are not unique, those of the smallest length in units of the columns' length.

    Parameters
    ----------
    y : array of shape (2, n, 9)
        Regressor.
    tau : array of shape (2, n)
        Torque, N m.
    weight : array that broadcasts to (2, n), optional
        Weight of each squared error.

    Returns
    -------
    array of shape (9,)
        A parameter that the motion does not move is 0.
    """
    if weight is not None:  # one pass less over the rows; the same to rounding
        flat = y.reshape(-1, y.shape[-1])
        weighted = flat * np.broadcast_to(weight, tau.shape).reshape(-1, 1)
        gram = weighted.T @ flat
        return solve_normal(gram, weighted.T @ tau.reshape(-1), np.sqrt(gram.diagonal()))
    a, scale = unit_columns(y)
    gram = a.T @ a
    return pseudo_solve(gram, a.T @ tau.reshape(-1)) * (gram.diagonal() > 0.0) / scale


def nine_rows(y: Array, tau: Array) -> tuple[Array, Array, Array]:
    """The least-squares problem in few rows: |R z - c|^2 is |Y beta - tau|^2 but for a constant.

    Further rows make the solution one: directions that nothing determines are pulled to zero, so that they cannot go
    anywhere, and so is all of z, too weakly to be seen where anything else determines it.

    Parameters
    ----------
    y : array of shape (2, n, 9)
        Regressor.
    tau : array of shape (2, n)
        Torque, N m.

    Returns
    -------
    R : array of shape (k, 9)
        One row for each direction in which the motion moves anything, and nine.
    c : array of shape (k,)
        Right side.
    scale : array of shape (9,)
        beta = z / scale.
    """
    a, scale = unit_columns(y)
    gram = a.T @ a
    moved = np.flatnonzero(gram.diagonal() > 0.0)
    values, vectors = np.linalg.eigh(gram[np.ix_(moved, moved)])
    kept = values > RANK_TOLERANCE**2 * values.max(initial=0.0)
    directions = np.zeros((moved.size, len(scale)))
    directions[:, moved] = vectors.T
    root = np.sqrt(values[kept])
    open_rows, weak = OPEN * directions[~kept], PULL * np.eye(len(scale))
    rows = np.vstack([root[:, None] * directions[kept], open_rows, weak])
    right = np.zeros(len(rows))
    right[: root.size] = directions[kept] @ (a.T @ tau.reshape(-1)) / root
    return rows, right, scale


def asked(r: Array, c: Array) -> NDArray[np.bool_]:
    """Parameters that rows R z = c ask for: the others share no row with them and are exactly 0 in the solution."""
    alone = np.count_nonzero(r.T @ r, axis=0) == 1
    return np.asarray(~(alone & (r.T @ c == 0.0)))


def snap(z: Array, share: float) -> Array:
    """Numbers smaller than a share of the largest set to zero: what a solver leaves of a bound that holds."""
    return np.where(np.abs(z) > share * np.abs(z).max(initial=0.0), z, 0.0)
