"""When is a parameter set physically possible (Algorithm 1, line 22)?"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from repro.model.parameters import Array, check_beta


def is_positive(beta: Array) -> NDArray[np.bool_]:
    """All nine parameters are above zero: the reading that the paper's own test arms survive.

    Parameters
    ----------
    beta : array of shape (..., 9)
        Parameter sets.

    Returns
    -------
    array of bool of shape (...)
        True where the set is accepted.
    """
    return np.asarray((check_beta(beta) > 0.0).all(-1))


def is_positive_definite(beta: Array) -> NDArray[np.bool_]:
    """M(q) is positive definite for every q2, and friction is not negative.

    det M = I3 (I1 + I2 c) - (I3 + I2 c / 2)^2 = I3 (I1 - I3) - I2^2 c^2 / 4 is smallest at c^2 = 1.

    Parameters
    ----------
    beta : array of shape (..., 9)
        Parameter sets.

    Returns
    -------
    array of bool of shape (...)
        True where the set is accepted.
    """
    beta = check_beta(beta)
    i1, i2, i3 = beta[..., 0], beta[..., 1], beta[..., 2]
    definite = (i3 > 0.0) & (i3 * (i1 - i3) > 0.25 * i2**2)
    return np.asarray(definite & (beta[..., 5:] >= 0.0).all(-1))


CHECKS: dict[str, Callable[[Array], NDArray[np.bool_]]] = {
    "positive": is_positive,
    "positive-definite": is_positive_definite,
}
