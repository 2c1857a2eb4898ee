"""Columns beside the nine: which of them a log asks for, how large they are, and what it would not show.

Of all sets of them that one is taken that predicts parts of the log from the rest best, where each must take `ENOUGH`
of the squared error.
"""

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from repro.identification.regression import Regression
from repro.identification.residuals import correlation_time
from repro.identification.solve import solve
from repro.model.parameters import NAMES, Array

#: Share of the squared error of parts not fitted that a further column must take.
ENOUGH = 0.2
#: Standard errors that it must be away from none.
SURE = 4.0
#: Parts of the log that are predicted in turn.
PARTS = 6


def rows(regression: Regression, columns: Array) -> tuple[Array, Array]:
    """Regressor with further columns as rows, joints weighted by their residual, and the torque."""
    left = regression.tau - regression.y @ solve(regression.y, regression.tau)
    size = np.sqrt(np.sum(left**2, axis=-1, keepdims=True) / np.maximum(regression.moving.sum(-1, keepdims=True), 1))
    weight = np.where(size > 0.0, 1.0 / np.where(size > 0.0, size, 1.0), 0.0)
    shown = columns * regression.moving[..., np.newaxis]
    a = np.concatenate([regression.y, shown], axis=-1) * weight[..., np.newaxis]
    return a, regression.tau * weight


def _fitted(a: Array, b: Array) -> Array:
    flat = a.reshape(-1, a.shape[-1])
    size = np.linalg.norm(flat, axis=0)
    size = np.where(size > 0.0, size, 1.0)
    solution: Array = np.linalg.lstsq(flat / size, b.reshape(-1), rcond=1e-6)[0] / size
    return solution


def _parts(a: Array, b: Array) -> list[Array]:
    """Rows of each part with the torque as last column, by QR as few as there are columns: all least squares stay."""
    part = np.arange(b.shape[1]) * PARTS // b.shape[1]
    both = np.concatenate([a, b[..., np.newaxis]], axis=-1)
    rows_of = [both[:, part == k].reshape(-1, both.shape[-1]) for k in range(PARTS)]
    return [np.asarray(np.linalg.qr(own, mode="r")) for own in rows_of]


def _left_out(parts: Sequence[Array], columns: Sequence[int]) -> list[Array]:
    """Least squares of all parts but one."""
    rest = [np.concatenate([*parts[:k], *parts[k + 1 :]]) for k in range(len(parts))]
    return [_fitted(r[:, columns], r[:, -1]) for r in rest]


def _unseen(parts: Sequence[Array], columns: Sequence[int]) -> float:
    pairs = zip(parts, _left_out(parts, columns), strict=True)
    return float(sum(np.sum((r[:, -1] - r[:, columns] @ x) ** 2) for r, x in pairs))


def unseen(a: Array, b: Array) -> float:
    """Squared error of parts of the log, each predicted from the rest."""
    return _unseen(_parts(a, b), range(a.shape[-1]))


def _by_parts(a: Array, b: Array) -> Array:
    """Standard errors by leaving out a part of the log at a time."""
    error: Array = np.sqrt((PARTS - 1) * np.var(_left_out(_parts(a, b), range(a.shape[-1])), axis=0))
    return error


def fitted_with_errors(a: Array, b: Array, h: float) -> tuple[Array, Array]:
    """Least squares of rows `h` apart, and its standard errors: by samples that are independent or by parts."""
    x, flat = _fitted(a, b), a.reshape(-1, a.shape[-1])
    left = b - a @ x
    independent = left.size * h / correlation_time(left, h)
    spread = np.sqrt(np.abs(np.diag(np.linalg.pinv(flat.T @ flat))) * np.sum(left**2) / max(independent, 1.0))
    return x, np.maximum(spread, _by_parts(a, b))


def beside(a: Array, chosen: Sequence[int]) -> Array:
    """The nine columns and some of those behind them."""
    return a[..., [*range(len(NAMES)), *(len(NAMES) + k for k in chosen)]]


def best_set(a: Array, b: Array, able: Sequence[int]) -> list[int]:
    """Those of the columns behind the nine with which parts are best predicted, each for `ENOUGH` of the error."""
    sets = [chosen for size in range(len(able) + 1) for chosen in combinations(able, size)]
    parts, nine = _parts(a, b), range(len(NAMES))
    behind = [[*nine, *(len(NAMES) + k for k in chosen)] for chosen in sets]
    error = [_unseen(parts, columns) * (1.0 - ENOUGH) ** -(len(columns) - len(NAMES)) for columns in behind]
    return list(sets[int(np.argmin(error))])


def least_seen(a: Array, b: Array, chosen: Sequence[int], able: Sequence[int], h: float) -> list[float]:
    """Size from which each able column would be taken beside those chosen, by both rules; rows are `h` apart.

    Of a size x a column takes x^2 S of the squared error, S the part of it that no other column holds; that must be
    `ENOUGH` of what is left with what it takes.
    """
    before, sizes = unseen(beside(a, chosen), b), []
    for k in able:
        columns = beside(a, [*chosen, k])
        _, error = fitted_with_errors(columns, b, h)
        flat = columns.reshape(-1, columns.shape[-1])
        alone = flat[:, -1] - flat[:, :-1] @ _fitted(columns[..., :-1], columns[..., -1])
        takes = ENOUGH / (1.0 - ENOUGH) * before / max(float(alone @ alone), np.finfo(float).tiny)
        sizes.append(max(SURE * float(error[-1]), float(np.sqrt(takes))))
    return sizes
