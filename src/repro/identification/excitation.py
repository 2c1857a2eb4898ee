"""Which parameters a motion identifies, whatever the method.

The regressor with columns of unit length has a rank, the number of base parameters, and a condition number. Below full
rank only combinations of parameters are determined; pivoted QR finds independent columns and the combinations.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr, solve_triangular

from repro.identification.regression import Regression, unit_columns, without_known
from repro.model.parameters import NAMES, Array

#: Singular values below this fraction of the largest count as zero: a noisy log cannot separate such columns either.
MIN_SINGULAR_RATIO = 1e-4
#: A parameter that moves less than this fraction of the RMS torque of its joint is not excited.
MIN_TORQUE_FRACTION = 2e-3
MIN_COEFFICIENT = 1e-3  # coefficients, for columns of unit length, that are smaller are left out of a combination


@dataclass(frozen=True)
class Identifiability:
    """Parameters that a regressor determines."""

    rank: int  # number of base parameters
    condition: float  # largest over smallest singular value of the columns that are not zero
    friction_correlation: tuple[float, float]  # of the estimates of b and k of each joint; 0 if one is not excited
    determined: tuple[bool, ...]  # whether each parameter is determined by itself, not in a combination alone (9)
    base_parameters: tuple[str, ...]  # combinations that are determined


def excitation(regression: Regression) -> Identifiability:
    """Analyse a motion; no torque is used. Rows of a prior count as rows, a known parameter as determined."""
    prior = regression.prior
    y = without_known(regression).y
    if prior is not None:
        rows = np.sqrt(prior.variance) * prior.rows()[0]
        y = np.concatenate([y.reshape(-1, y.shape[-1]), rows])[np.newaxis]
    known = np.zeros(len(NAMES), bool) if prior is None else prior.known
    a, scale = unit_columns(y)
    moved = np.flatnonzero(np.linalg.norm(a, axis=0) > 0.0)
    if not moved.size:
        condition = 1.0 if known.all() else np.inf
        return Identifiability(int(known.sum()), condition, (0.0, 0.0), tuple(map(bool, known)), ())
    _, singular, right = np.linalg.svd(a[:, moved], full_matrices=False)
    rank = int((singular > MIN_SINGULAR_RATIO * singular[0]).sum())
    condition = float(singular[0] / singular[-1]) if singular[-1] > 0.0 else np.inf
    # Squared projection of each parameter on the determined directions: 1, or only a combination is determined.
    projection = np.zeros(len(NAMES))
    projection[moved] = np.sum(right[:rank] ** 2, axis=0)
    covariance = np.asarray(np.linalg.inv(a.T @ a + MIN_SINGULAR_RATIO**2 * np.eye(len(NAMES))), dtype=np.float64)
    first, second = (
        float(covariance[i, j] / np.sqrt(covariance[i, i] * covariance[j, j])) if {i, j} <= {*moved} else 0.0
        for i, j in ((5, 7), (6, 8))
    )
    determined = tuple(((projection > 1.0 - MIN_COEFFICIENT) | known).tolist())
    base = (*_combinations(a, scale, moved, rank), *(NAMES[k] for k in np.flatnonzero(known)))
    return Identifiability(rank + int(known.sum()), condition, (first, second), determined, base)


def _combinations(a: Array, scale: Array, moved: NDArray[np.intp], rank: int) -> tuple[str, ...]:
    """Base parameters as text: each independent parameter with those whose columns contain its own."""
    r, order = qr(a[:, moved], mode="r", pivoting=True)
    names, size = [NAMES[k] for k in moved[order]], scale[moved[order]]
    # Columns D = P K of unit length; beta_P s_P + K beta_D s_D is determined, per unit of beta_P.
    mix = solve_triangular(r[:rank, :rank], r[:rank, rank:])
    ratio = mix * size[rank:] / size[:rank, None]
    lines = []
    for name, row, visible in zip(names[:rank], ratio, np.abs(mix) > MIN_COEFFICIENT, strict=True):
        others = zip(row, names[rank:], visible, strict=True)
        terms = [f"{'-' if c < 0.0 else '+'} {abs(c):.3g} {other}" for c, other, shown in others if shown]
        lines.append(" ".join([name, *terms]))
    return tuple(sorted(lines, key=lambda text: NAMES.index(text.split()[0])))


def torque_fraction(regression: Regression, beta: Array) -> Array:
    """Compute the RMS torque (9,) that each parameter moves over the RMS torque, in the joint where that is larger."""
    part = np.sqrt(np.mean((regression.y * beta) ** 2, axis=1))  # (2, 9)
    torque = np.sqrt(np.mean(regression.tau**2, axis=-1))
    return np.asarray(np.max(part / np.where(torque > 0.0, torque, np.inf)[:, None], axis=0))
