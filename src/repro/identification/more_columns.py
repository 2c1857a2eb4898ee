"""Columns beside the nine: which of them a log asks for, how large they are, and what it would not show.

Of all sets of them that one is taken that predicts parts of the log from the rest best, where each must take `ENOUGH`
of the squared error. Other logs of the arm, which have none of these columns, may stand beside the rest.
"""

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from repro.identification.regression import Regression, correlation_time
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
    size = np.sqrt(np.sum(left**2, axis=-1, keepdims=True) / np.maximum(regression.mask.sum(-1, keepdims=True), 1))
    weight = np.where(size > 0.0, 1.0 / np.where(size > 0.0, size, 1.0), 0.0)
    shown = columns * regression.mask[..., np.newaxis]
    a = np.concatenate([regression.y, shown], axis=-1) * weight[..., np.newaxis]
    return a, regression.tau * weight


#: No other log.
NONE: Array = np.empty((0, len(NAMES) + 1))


def reduced(a: Array, b: Array) -> Array:
    """Rows with the torque as last column, by QR as few as there are columns: all least squares stay."""
    both = np.concatenate([a, b[..., np.newaxis]], axis=-1).reshape(-1, a.shape[-1] + 1)
    return np.asarray(np.linalg.qr(both, mode="r"))


def nine_of(regressions: Sequence[Regression]) -> Array:
    """Rows of other logs for what takes `others`, shape (m, 10)."""
    each = [reduced(*rows(r, np.empty((*r.tau.shape, 0)))) for r in regressions]
    return np.concatenate([NONE, *each])


def _fitted(a: Array, b: Array) -> Array:
    flat = a.reshape(-1, a.shape[-1])
    size = np.linalg.norm(flat, axis=0)
    size = np.where(size > 0.0, size, 1.0)
    solution: Array = np.linalg.lstsq(flat / size, b.reshape(-1), rcond=1e-6)[0] / size
    return solution


def _parts(a: Array, b: Array) -> list[Array]:
    """Rows of each part of the log."""
    part = np.arange(b.shape[1]) * PARTS // b.shape[1]
    return [reduced(a[:, part == k], b[:, part == k]) for k in range(PARTS)]


def _beside_nine(others: Array, more: int) -> Array:
    """Rows of other logs with `more` columns of nothing behind their nine."""
    nine, rest = np.split(others, [len(NAMES)], axis=1)
    return np.concatenate([nine, np.zeros((len(others), more)), rest], axis=1)


def _left_out(parts: Sequence[Array], columns: Sequence[int], others: Array) -> list[Array]:
    """Least squares of all parts but one, and of the other logs."""
    always = _beside_nine(others, parts[0].shape[1] - others.shape[1])
    rest = [np.concatenate([*parts[:k], *parts[k + 1 :], always]) for k in range(len(parts))]
    return [_fitted(r[:, columns], r[:, -1]) for r in rest]


def _unseen(parts: Sequence[Array], columns: Sequence[int], others: Array) -> float:
    pairs = zip(parts, _left_out(parts, columns, others), strict=True)
    return float(sum(np.sum((r[:, -1] - r[:, columns] @ x) ** 2) for r, x in pairs))


def unseen(a: Array, b: Array, others: Array = NONE) -> float:
    """Squared error of parts of the log, each predicted from the rest."""
    return _unseen(_parts(a, b), range(a.shape[-1]), others)


def fitted_with_errors(a: Array, b: Array, h: float, others: Array = NONE) -> tuple[Array, Array]:
    """Least squares of rows `h` apart, and its standard errors: by samples that are independent or by parts."""
    parts = _parts(a, b)
    both = np.concatenate([*parts, _beside_nine(others, a.shape[-1] + 1 - others.shape[1])])
    flat, x = both[:, :-1], _fitted(both[:, :-1], both[:, -1])
    left = b - a @ x
    independent = left.size * h / correlation_time(left, h)
    spread = np.sqrt(np.abs(np.diag(np.linalg.pinv(flat.T @ flat))) * np.sum(left**2) / max(independent, 1.0))
    by_parts = np.sqrt((PARTS - 1) * np.var(_left_out(parts, range(a.shape[-1]), others), axis=0))
    return x, np.maximum(spread, by_parts)


def beside(a: Array, chosen: Sequence[int]) -> Array:
    """The nine columns and some of those behind them."""
    return a[..., [*range(len(NAMES)), *(len(NAMES) + k for k in chosen)]]


def best_set(a: Array, b: Array, able: Sequence[int], others: Array = NONE) -> list[int]:
    """Those of the columns behind the nine with which parts are best predicted, each for `ENOUGH` of the error."""
    sets = [chosen for size in range(len(able) + 1) for chosen in combinations(able, size)]
    parts, nine = _parts(a, b), range(len(NAMES))
    behind = [[*nine, *(len(NAMES) + k for k in chosen)] for chosen in sets]
    error = [_unseen(parts, columns, others) * (1.0 - ENOUGH) ** -(len(columns) - len(NAMES)) for columns in behind]
    return list(sets[int(np.argmin(error))])


def least_seen(
    a: Array, b: Array, chosen: Sequence[int], able: Sequence[int], h: float, others: Array = NONE
) -> list[float]:
    """Size from which each able column would be taken beside those chosen, by both rules; rows are `h` apart.

    Of a size x a column takes x^2 S of the squared error, S the part of it that no other column holds; that must be
    `ENOUGH` of what is left with what it takes.
    """
    before, sizes = unseen(beside(a, chosen), b, others), []
    for k in able:
        columns = beside(a, [*chosen, k])
        _, error = fitted_with_errors(columns, b, h, others)
        flat = columns.reshape(-1, columns.shape[-1])
        flat = np.concatenate([flat, _beside_nine(others[:, :-1], flat.shape[-1] - len(NAMES))])
        alone = flat[:, -1] - flat[:, :-1] @ _fitted(flat[:, :-1], flat[:, -1])
        takes = ENOUGH / (1.0 - ENOUGH) * before / max(float(alone @ alone), np.finfo(float).tiny)
        sizes.append(max(SURE * float(error[-1]), float(np.sqrt(takes))))
    return sizes
