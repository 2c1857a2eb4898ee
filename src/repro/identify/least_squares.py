"""Ordinary least squares of Eq. 1 on filtered signals: what the paper compares Algorithm 1 with (Section V-C)."""

from dataclasses import dataclass

import numpy as np

from repro.model.parameters import NAMES, Array


@dataclass(frozen=True)
class LeastSquares:
    """Estimate and how well the motion determines it.

    Attributes
    ----------
    beta : array of shape (9,)
        Parameters, SI units. Nothing keeps them positive.
    standard_error : array of shape (9,)
        Of each parameter if residuals were white and of one size; friction that Eq. 1 does not hold makes
        the true error larger.
    condition : float
        Condition number of the regressor with columns of unit length.
    """

    beta: Array
    standard_error: Array
    condition: float


def least_squares(y: Array, tau: Array) -> LeastSquares:
    """Solve tau = Y beta for both joints at once.

    Parameters
    ----------
    y : array of shape (2, N, 9)
        Regressor of the filtered motion.
    tau : array of shape (2, N)
        Torque through the same filter, N m.

    Returns
    -------
    LeastSquares
        Parameters that leave the smallest sum of squared torque errors.

    Raises
    ------
    ValueError
        If shapes differ, a value is not finite, or the motion does not excite every parameter.

    Notes
    -----
    Columns are scaled to unit length and the system is solved by singular values, not by the normal equations.
    """
    if tau.ndim != 2 or tau.shape[0] != 2 or y.shape != (*tau.shape, len(NAMES)):
        raise ValueError(f"y, tau: shapes {y.shape} and {tau.shape} must be (2, N, 9) and (2, N).")
    if not (np.isfinite(y).all() and np.isfinite(tau).all()):
        raise ValueError("y, tau: every value must be finite.")
    a, b = y.reshape(-1, len(NAMES)), tau.reshape(-1)
    length = np.linalg.norm(a, axis=0)
    if not (length > 0).all():
        still = ", ".join(name for name, size in zip(NAMES, length, strict=True) if not size > 0)
        raise ValueError(f"y: the motion does not excite {still}.")
    left, singular, right = np.linalg.svd(a / length, full_matrices=False)
    if singular[-1] <= singular[0] * len(b) * np.finfo(np.float64).eps:
        raise ValueError("y: the motion does not tell the nine parameters apart.")
    beta = right.T @ (left.T @ b / singular) / length
    freedom = max(len(b) - len(beta), 1)
    variance = float(np.sum((b - a @ beta) ** 2)) / freedom
    error = np.sqrt(variance * np.sum((right.T / singular) ** 2, 1)) / length
    return LeastSquares(beta, error, float(singular[0] / singular[-1]))
