"""Choice of columns next to the nine of the regressor: by cross-validation, and by how far each is from no effect.

The chosen subset of the candidates predicts blocks of the log from the other blocks best, and each of its columns
reduces the squared error by `TermKind.min_reduction`. A chosen term is also `MIN_Z_SCORE` standard errors away from no
effect. Other logs of the arm, to which no term applies, may join the fit.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import combinations, product

import numpy as np

from repro.identification.extra_terms import (
    LOAD,
    MIN_REPORTED_REDUCTION,
    MIN_Z_SCORE,
    N_NINE,
    ROTOR,
    STRIBECK_GRID,
    TERM_NAMES,
    TERMS,
    Columns,
    ExtraTerm,
    elasticity,
    filtered_columns,
    load_friction,
    rotor_inertia,
    stribeck,
    term_columns,
)
from repro.identification.filtering import MIN_ERROR_REDUCTION, FilterSettings, prepare
from repro.identification.log import Log
from repro.identification.regression import Regression, correlation_time, drop_standstill, joined, solve
from repro.model.parameters import Array

BLOCKS = 6  # blocks of the log in cross-validation
_ROTOR = TERM_NAMES.index(f"{ROTOR}2")  # number of the rotor among the terms
LOAD_ITERATIONS = 2  # after which parameters and the load that they give agree to a percent


def weighted_rows(regression: Regression, columns: Array) -> tuple[Array, Array]:
    """Append columns to the regressor; return rows (2, n, 9 + k) and torque, joints weighted by their residual."""
    residual = regression.tau - regression.y @ solve(regression.y, regression.tau)
    count = np.maximum(regression.mask.sum(-1, keepdims=True), 1)
    size = np.sqrt(np.sum(residual**2, axis=-1, keepdims=True) / count)
    weight = np.where(size > 0.0, 1.0 / np.where(size > 0.0, size, 1.0), 0.0)
    masked = columns * regression.mask[..., np.newaxis]
    a = np.concatenate([regression.y, masked], axis=-1) * weight[..., np.newaxis]
    return a, regression.tau * weight


NO_ROWS: Array = np.empty((0, N_NINE + 1))  # rows of no other log


def reduced_rows(a: Array, b: Array) -> Array:
    """Reduce rows with the torque as last column to as many as there are columns (QR): least squares stays the same."""
    rows = np.concatenate([a, b[..., np.newaxis]], axis=-1).reshape(-1, a.shape[-1] + 1)
    return np.asarray(np.linalg.qr(rows, mode="r"))


def other_rows(regressions: Sequence[Regression]) -> Array:
    """Reduce other logs, to which no term applies, to rows (m, 10) for the functions below."""
    rows = [reduced_rows(*weighted_rows(r, np.empty((*r.tau.shape, 0)))) for r in regressions]
    return np.concatenate([NO_ROWS, *rows])


def padded(others: Array, k: int) -> Array:
    """Insert k columns of zeros behind the nine of other logs."""
    nine, rest = np.split(others, [N_NINE], axis=1)
    return np.concatenate([nine, np.zeros((len(others), k)), rest], axis=1)


def _fit(a: Array, b: Array) -> Array:
    """Solve least squares with columns of unit length."""
    flat = a.reshape(-1, a.shape[-1])
    size = np.linalg.norm(flat, axis=0)
    size = np.where(size > 0.0, size, 1.0)
    return np.linalg.lstsq(flat / size, b.reshape(-1), rcond=1e-6)[0] / size


def _blocks(a: Array, b: Array) -> list[Array]:
    """Reduced rows of each block of the log, by joint (2, m, k + 1)."""
    block = np.arange(b.shape[1]) * BLOCKS // b.shape[1]
    return [
        np.stack([reduced_rows(*rows) for rows in zip(a[:, block == k], b[:, block == k], strict=True)])
        for k in range(BLOCKS)
    ]


def _leave_one_out(blocks: Sequence[Array], columns: Sequence[int], others: Array) -> list[Array]:
    """Solutions from all blocks but one, and from the other logs."""
    flat = [block.reshape(-1, block.shape[-1]) for block in blocks]
    always = padded(others, flat[0].shape[1] - others.shape[1])
    rest = [np.concatenate([*flat[:k], *flat[k + 1 :], always]) for k in range(len(blocks))]
    return [_fit(r[:, columns], r[:, -1]) for r in rest]


def _block_error(blocks: Sequence[Array], columns: Sequence[int], others: Array) -> Array:
    pairs = zip(blocks, _leave_one_out(blocks, columns, others), strict=True)
    error: Array = sum(np.sum((r[..., -1] - r[..., columns] @ x) ** 2, axis=-1) for r, x in pairs)
    return np.maximum(error, np.finfo(np.float64).tiny)


def cross_validation_error(a: Array, b: Array, others: Array = NO_ROWS) -> Array:
    """Squared error of each joint (2,) in the blocks of a log, each predicted from the others; never zero."""
    return _block_error(_blocks(a, b), range(a.shape[-1]), others)


def fit_with_errors(a: Array, b: Array, h: float, others: Array = NO_ROWS) -> tuple[Array, Array]:
    """Fit rows `h` apart; the standard errors are the larger of those by independent samples and by the blocks."""
    blocks = _blocks(a, b)
    flat = [block.reshape(-1, block.shape[-1]) for block in blocks]
    rows = np.concatenate([*flat, padded(others, a.shape[-1] + 1 - others.shape[1])])
    x = _fit(rows[:, :-1], rows[:, -1])
    residual = b - a @ x
    n_independent = max(residual.size * h / correlation_time(residual, h), 1.0)
    gram = rows[:, :-1].T @ rows[:, :-1]
    spread = np.sqrt(np.abs(np.diag(np.linalg.pinv(gram))) * np.sum(residual**2) / n_independent)
    jackknife = np.sqrt((BLOCKS - 1) * np.var(_leave_one_out(blocks, range(a.shape[-1]), others), axis=0))
    return x, np.maximum(spread, jackknife)


def nine_and(subset: Sequence[int]) -> list[int]:
    """Numbers of the nine columns and of some of those behind them."""
    return [*range(N_NINE), *(N_NINE + k for k in subset)]


def best_subset(
    a: Array, b: Array, candidates: Mapping[int, float], others: Array = NO_ROWS, by_joint: bool = False
) -> list[int]:
    """Choose columns behind the nine that predict blocks best; each must be worth its fraction of the squared error."""
    subsets = [subset for size in range(len(candidates) + 1) for subset in combinations(candidates, size)]
    blocks = _blocks(a, b)
    penalty = [-sum(np.log(1.0 - candidates[k]) for k in subset) for subset in subsets]
    errors = (_block_error(blocks, nine_and(subset), others) for subset in subsets)
    log_error = [np.sum(np.log(error)) if by_joint else np.log(error.sum()) for error in errors]
    return list(subsets[int(np.argmin(np.add(log_error, penalty)))])


def detection_limits(
    a: Array, b: Array, chosen: Sequence[int], candidates: Sequence[int], h: float, others: Array = NO_ROWS
) -> list[float]:
    """Compute the smallest size of each candidate that both rules would accept, next to the chosen columns.

    A column of size x reduces the squared error by x^2 S, with S its part that no other column contains.
    """
    error, limits = float(cross_validation_error(a[..., nine_and(chosen)], b, others).sum()), []
    ratio = MIN_ERROR_REDUCTION / (1.0 - MIN_ERROR_REDUCTION)
    for k in candidates:
        columns = a[..., nine_and([*chosen, k])]
        _, standard_error = fit_with_errors(columns, b, h, others)
        flat = columns.reshape(-1, columns.shape[-1])
        rows = np.concatenate([flat, padded(others[:, :-1], flat.shape[-1] - N_NINE)])
        alone = flat[:, -1] - flat[:, :-1] @ _fit(rows[:, :-1], rows[:, -1])
        smallest = np.sqrt(ratio * error / max(float(alone @ alone), np.finfo(float).tiny))
        limits.append(max(MIN_Z_SCORE * float(standard_error[-1]), float(smallest)))
    return limits


def _weight(regression: Regression, columns: Array) -> float:
    """Weigh a log by its RMS error of least squares with further columns, 1/(N m)."""
    a = np.concatenate([regression.y, columns * regression.mask[..., np.newaxis]], axis=-1)
    error = regression.tau - a @ _fit(a, regression.tau)
    return 1.0 / (float(np.linalg.norm(error) / np.sqrt(max(regression.mask.sum(), 1))) or 1.0)


def _is_rotor_needed(a: Array, b: Array, chosen: Sequence[int], elastic: Array) -> bool:
    """Whether the rotor among chosen columns is worth its place next to elastic gears, which look like one."""
    without = np.concatenate([a[..., nine_and([k for k in chosen if k != _ROTOR])], elastic], axis=-1)
    with_it = np.concatenate([without, a[..., [N_NINE + _ROTOR]]], axis=-1)
    smaller, larger = (float(np.log(cross_validation_error(part, b)).sum()) for part in (with_it, without))
    return bool(smaller < larger + np.log(1.0 - TERMS[ROTOR].min_reduction))


def find_terms(logs: Sequence[tuple[Log, FilterSettings]], friction: bool) -> tuple[tuple[ExtraTerm, ...], Array]:
    """Find what to subtract from logs of one arm and what would help, in the order of `TERM_NAMES`; also the load (9,).

    Friction is subtracted if it may be, and a rotor if elastic gears do not explain it. The logs have correct
    calibration. Each of several is weighted by its errors with all terms in the model: a noisy log must not hide what a
    good one shows.
    """
    regressions = [drop_standstill(prepare(log, settings, even_odd=False)) for log, settings in logs]
    unweighted = joined(regressions)
    # Without a drive inertia and gravity equal the friction: in proportion to them, 1 would replace b and k.
    driven = np.any([log.tau.any(axis=1) for log, _ in logs], axis=0)
    possible = np.array([not name.startswith(LOAD) or driven[int(name[-1]) - 1] for name in TERM_NAMES])
    load = solve(unweighted.y, unweighted.tau)
    columns = [term_columns(TERMS, log, settings, load) * possible for log, settings in logs]
    of_load = [name.startswith(LOAD) for name in TERM_NAMES]
    for _ in range(LOAD_ITERATIONS):  # friction in proportion to the load biases the parameters that give the load
        more = np.concatenate(columns, axis=1) * unweighted.mask[..., np.newaxis]
        load = solve(np.concatenate([unweighted.y, more], axis=-1), unweighted.tau)[:N_NINE]
        for (log, settings), of_log in zip(logs, columns, strict=True):
            of_log[..., of_load] = filtered_columns([load_friction], log, settings, load)[0] * possible[of_load]
    weights = [_weight(r, c) for r, c in zip(regressions, columns, strict=True)] if len(logs) > 1 else [1.0]
    r = joined(regressions, weights)

    def rows(of_logs: Sequence[Array]) -> tuple[Array, Array]:
        return weighted_rows(r, np.concatenate([w * c for w, c in zip(weights, of_logs, strict=True)], axis=1))

    a, b = rows(columns)
    candidates = [k for k in range(len(TERM_NAMES)) if np.any(a[..., N_NINE + k])]

    def evaluated(k: int, chosen: Sequence[int]) -> ExtraTerm:
        rest = [number for number in chosen if number != k]
        columns = a[..., nine_and([k, *rest])]
        with_it, without = (cross_validation_error(part, b) for part in (columns, a[..., nine_and(rest)]))
        # The product of both joints' ratios: a term that acts on one joint is judged by that joint.
        gain = 1.0 - float(np.exp(np.sum(np.log(with_it) - np.log(without))))
        value, standard_error = (float(x[N_NINE]) for x in fit_with_errors(columns, b, r.h))
        return ExtraTerm(TERM_NAMES[k], value, standard_error, gain, k in chosen)

    reductions = {k: TERMS[TERM_NAMES[k][:-1]].min_reduction for k in candidates}
    allowed = {k: least for k, least in reductions.items() if friction or k == _ROTOR}
    chosen = best_subset(a, b, allowed, by_joint=True)
    if _ROTOR in chosen:
        elastic = rows([filtered_columns([elasticity], log, settings, load)[0] for log, settings in logs])[0]
        if not _is_rotor_needed(a, b, chosen, elastic[..., N_NINE:]):
            del allowed[_ROTOR]
            chosen = best_subset(a, b, allowed, by_joint=True)
    while True:
        terms = [evaluated(k, chosen) for k in candidates]
        credible = [term for term in terms if term.value > MIN_Z_SCORE * term.error]
        rejected = [TERM_NAMES.index(term.name) for term in terms if term.taken and term not in credible]
        if not rejected:
            return tuple(term for term in credible if term.taken or term.gain > MIN_REPORTED_REDUCTION), load
        chosen = [k for k in chosen if k != rejected[0]]


def choose_friction_curve(
    logs: Sequence[tuple[Log, FilterSettings]], steepness: Sequence[float]
) -> tuple[float, float]:
    """Choose lambda (s/rad, of those given) and the speed of Stribeck friction (rad/s) that explain an arm's logs best.

    Both shape the same curve near standstill, so that a lambda chosen without Stribeck friction is wrong next to it.
    """
    makes: list[Columns] = [load_friction, rotor_inertia, *(partial(stribeck, speed=speed) for speed in STRIBECK_GRID)]
    log_error = np.zeros((len(steepness), len(STRIBECK_GRID)))  # of both joints' squared errors, summed over logs
    for (log, settings), (k, lam) in product(logs, enumerate(steepness)):
        changed = replace(settings, friction_steepness=lam)
        r = drop_standstill(prepare(log, changed, even_odd=False))
        energy = np.mean(r.tau**2, axis=-1, keepdims=True)
        weight = np.divide(
            1.0, energy, out=np.zeros_like(energy), where=energy > 0.0
        )  # a joint without a drive has none
        always, rotor, *of_speeds = filtered_columns(makes, log, changed, solve(r.y, r.tau))
        for n, columns in enumerate(of_speeds):
            more = np.concatenate([always, rotor, columns], axis=-1) * r.mask[..., np.newaxis]
            rows = np.concatenate([r.y, more], axis=-1)
            squares = np.sum((r.tau - rows @ solve(rows, r.tau, weight)) ** 2, axis=-1)
            log_error[k, n] += np.sum(np.log(np.maximum(squares, np.finfo(np.float64).tiny)))
    best, speed = divmod(int(np.argmin(log_error)), len(STRIBECK_GRID))
    return steepness[best], STRIBECK_GRID[speed]
