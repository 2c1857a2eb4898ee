"""What a motion can tell about the parameters, whatever the method.

The regressor with columns of unit length has a rank, the number of base parameters, and a condition number, by how
much noise of the torque may be magnified. Below full rank only combinations of parameters are determined; pivoted QR
finds independent columns, and the others are their combinations.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr, solve_triangular

from repro.identification.regression import Regression
from repro.identification.solve import unit_columns
from repro.model.parameters import NAMES, Array

#: Singular values below this share of the largest count as zero: what a noisy log cannot tell apart either.
SAME = 1e-4
#: A parameter that moves less than this share of the RMS torque of its joint is not excited.
EXCITED = 2e-3
#: Shares of torque smaller than this are left out of a combination.
VISIBLE = 1e-3


@dataclass(frozen=True)
class Excited:
    """What a regressor tells.

    Attributes
    ----------
    rank : int
        Number of base parameters.
    condition : float
        Largest over smallest singular value of the columns that are not zero.
    friction_correlation : tuple of 2 floats
        Correlation of the least-squares estimates of viscous and Coulomb friction of each joint; 0 where one of them
        is not excited.
    determined : tuple of 9 bool
        Whether each parameter is determined on its own, not in a combination alone.
    base_parameters : tuple of str
        Combinations that are determined.
    """

    rank: int
    condition: float
    friction_correlation: tuple[float, float]
    determined: tuple[bool, ...]
    base_parameters: tuple[str, ...]


def excitation(regression: Regression) -> Excited:
    """Rank, condition number, friction correlation and base parameters.

    Parameters
    ----------
    regression : Regression
        Filtered regressor.

    Returns
    -------
    Excited
        Of the motion alone; no torque is used.
    """
    a, scale = unit_columns(regression.y)
    moved = np.flatnonzero(np.linalg.norm(a, axis=0) > 0.0)
    if not moved.size:
        return Excited(0, np.inf, (0.0, 0.0), (False,) * len(NAMES), ())
    _, singular, right = np.linalg.svd(a[:, moved], full_matrices=False)
    rank = int((singular > SAME * singular[0]).sum())
    condition = float(singular[0] / singular[-1]) if singular[-1] > 0.0 else np.inf
    # What the determined directions hold of each parameter: all of it, or it is determined in a combination alone.
    held = np.zeros(len(NAMES))
    held[moved] = np.sum(right[:rank] ** 2, axis=0)
    covariance = np.asarray(np.linalg.inv(a.T @ a + SAME**2 * np.eye(len(NAMES))), dtype=np.float64)
    correlation = tuple(_correlation(covariance, 5 + j, 7 + j, moved) for j in range(2))
    return Excited(
        rank,
        condition,
        (correlation[0], correlation[1]),
        tuple((held > 1.0 - VISIBLE).tolist()),
        _combinations(a[:, moved], scale, moved, rank),
    )


def _correlation(covariance: Array, i: int, j: int, moved: NDArray[np.intp]) -> float:
    if i not in moved or j not in moved:
        return 0.0
    return float(covariance[i, j] / np.sqrt(covariance[i, i] * covariance[j, j]))


def _combinations(
    a: Array, scale: Array, moved: np.ndarray[tuple[int], np.dtype[np.intp]], rank: int
) -> tuple[str, ...]:
    """Base parameters in words: each independent parameter with those whose columns contain its own."""
    r, order = qr(a, mode="r", pivoting=True)
    r = r[: a.shape[1]]
    names = [NAMES[k] for k in moved[order]]
    if rank == a.shape[1]:
        return tuple(NAMES[k] for k in moved)
    # Columns D = P K of unit length; beta_P s_P + K beta_D s_D is determined, per unit of beta_P.
    size = scale[moved[order]]
    mix = solve_triangular(r[:rank, :rank], r[:rank, rank:])
    share = mix * size[rank:] / size[:rank, None]
    words = []
    for name, row, visible in zip(names[:rank], share, np.abs(mix) > VISIBLE, strict=True):
        others = (f"{c:+.3g} {other}" for c, other, told in zip(row, names[rank:], visible, strict=True) if told)
        words.append(" ".join([name, *(f"{text[0]} {text[1:]}" for text in others)]))
    return tuple(sorted(words, key=lambda text: NAMES.index(text.split()[0])))


def torque_share(regression: Regression, beta: Array) -> Array:
    """RMS torque that each parameter moves over the RMS torque, in the joint where that is larger.

    Parameters
    ----------
    regression : Regression
        Filtered regressor and torque.
    beta : array of shape (9,)
        Parameters.

    Returns
    -------
    array of shape (9,)
        0 for a parameter that the motion does not move.
    """
    part = np.sqrt(np.mean((regression.y * beta) ** 2, axis=1))  # (2, 9)
    whole = np.sqrt(np.mean(regression.tau**2, axis=-1))
    share: Array = np.max(part / np.where(whole > 0.0, whole, np.inf)[:, None], axis=0)
    return share
