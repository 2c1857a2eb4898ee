"""Least squares of a regression that may not excite every parameter, by its normal equations.

Columns are scaled to unit length first, which leaves the equations a condition number of the square of some tens: ten
digits remain, and a method can be repeated hundreds of times for its standard errors.
"""

import numpy as np

from repro.model.parameters import Array

#: Singular values below this share of the largest are taken for zero, columns having unit length.
RANK_TOLERANCE = 1e-6


def unit_columns(y: Array) -> tuple[Array, Array]:
    """Regressor as rows with columns of unit length.

    Parameters
    ----------
    y : array of shape (2, n, 9)
        Regressor.

    Returns
    -------
    a : array of shape (2 n, 9)
        Scaled; a column that is zero stays so.
    scale : array of shape (9,)
        beta = z / scale solves the problem that z solves for `a`.
    """
    a = y.reshape(-1, y.shape[-1])
    length = np.sqrt(np.einsum("np,np->p", a, a))
    scale = np.where(length > 0.0, length, 1.0)
    return a / scale, scale


def pseudo_solve(gram: Array, right: Array) -> Array:
    """Shortest solution of a symmetric system whose small eigenvalues count as zero."""
    values, vectors = np.linalg.eigh(gram)
    kept = np.abs(values) > RANK_TOLERANCE**2 * np.abs(values).max()
    inverse = np.divide(1.0, values, out=np.zeros_like(values), where=kept)
    solution: Array = vectors @ (inverse * (vectors.T @ right))
    return solution


def solve(y: Array, tau: Array, weight: Array | None = None) -> Array:
    """Parameters with the smallest sum of squared torque errors, of the smallest length if they are not unique.

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
    if weight is not None:
        root = np.sqrt(np.broadcast_to(weight, tau.shape))
        y, tau = y * root[..., None], tau * root
    a, scale = unit_columns(y)
    return pseudo_solve(a.T @ a, a.T @ tau.reshape(-1)) / scale


def nine_rows(y: Array, tau: Array) -> tuple[Array, Array, Array]:
    """The least-squares problem in nine rows or fewer: |R z - c|^2 is |Y beta - tau|^2 but for a constant.

    Parameters
    ----------
    y : array of shape (2, n, 9)
        Regressor.
    tau : array of shape (2, n)
        Torque, N m.

    Returns
    -------
    R : array of shape (k, 9)
        One row for each direction that the motion determines.
    c : array of shape (k,)
        Right side.
    scale : array of shape (9,)
        beta = z / scale.
    """
    a, scale = unit_columns(y)
    values, vectors = np.linalg.eigh(a.T @ a)
    kept = values > RANK_TOLERANCE**2 * values.max()
    root = np.sqrt(values[kept])
    directions = vectors[:, kept].T
    return root[:, None] * directions, directions @ (a.T @ tau.reshape(-1)) / root, scale
