"""Terms that extend Eq. 1, chosen by cross-validation: further friction, and the columns of calibration errors.

Friction may be in proportion to the load, and larger near rest (Stribeck). Each such term is a candidate column next to
the nine of the regressor (`FRICTION`, and `CALIBRATION` of `repro.identification.calibration`). The chosen subset of
the candidates predicts blocks of the log from the other blocks best, and each of its columns reduces the squared error
by `MIN_ERROR_REDUCTION`. A chosen term is also `MIN_Z_SCORE` standard errors away from no effect. Other logs of the
arm, to which none of the terms applies, may take part in the fit.

Coulomb friction that differs between the two directions is no candidate: while a joint moves it is an offset.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations

import numpy as np
from scipy.interpolate import CubicSpline

from repro.identification.filtering import (
    FilterSettings,
    Moved,
    filter_columns,
    prepare,
    retained_samples,
    smooth_motion,
)
from repro.identification.regression import Regression, correlation_time, drop_standstill
from repro.identification.solve import solve
from repro.logs.log import Log, period
from repro.model.dynamics import regressor
from repro.model.parameters import NAMES, Array

#: Fraction of the cross-validated squared error by which a further column must reduce it.
MIN_ERROR_REDUCTION = 0.2
#: Standard errors that a term must be away from no effect.
MIN_Z_SCORE = 4.0
#: Reduction of the cross-validated squared error beyond which friction that is not subtracted is reported.
MIN_REPORTED_REDUCTION = 0.05
#: Blocks of the log in cross-validation.
BLOCKS = 6
#: Difference of the position with which the columns of a zero position are made, rad.
ZERO_DIFFERENCE = 1e-4
#: Speeds at which Stribeck friction may have fallen to 1/e of its value at rest, rad/s.
STRIBECK_SPEEDS = (0.1, 0.2, 0.5)
N_NINE = len(NAMES)

#: ``columns(motion, beta, friction_steepness)``: torque (2, N, k) that terms of unit size add.
Columns = Callable[[Moved, Array, float], Array]


def one_joint(values: Array) -> Array:
    """Make a column for each joint that is zero in the other, (2, N) -> (2, N, 2)."""
    return values[..., np.newaxis] * np.eye(2)[:, np.newaxis]


def offset(moved: Moved, beta: Array, steepness: float) -> Array:  # noqa: ARG001
    """Compute the columns of a constant torque of each joint, shape (2, N, 2)."""
    return one_joint(np.ones_like(moved[0]))


def zero_position(moved: Moved, beta: Array, steepness: float) -> Array:
    """Compute the change of the torque of each joint with the zero position of either, shape (2, N, 2)."""
    q, dq, ddq = moved
    torque = regressor(q, dq, ddq, steepness) @ beta
    shifted = [regressor(q + ZERO_DIFFERENCE * unit[:, np.newaxis], dq, ddq, steepness) @ beta for unit in np.eye(2)]
    return np.stack([(other - torque) / ZERO_DIFFERENCE for other in shifted], axis=-1)


def scale(moved: Moved, beta: Array, steepness: float) -> Array:
    """Compute the change of the torque of joint 2 with its torque constant, shape (2, N, 1)."""
    column = np.zeros((2, moved[0].shape[-1], 1))
    column[1, :, 0] = (regressor(*moved, steepness) @ beta)[1]
    return column


def load_friction(moved: Moved, beta: Array, steepness: float) -> Array:
    """Compute Coulomb friction in proportion to the torque that the gear carries, shape (2, N, 2)."""
    load = regressor(*moved, steepness)[..., :5] @ beta[:5]
    return one_joint(np.abs(load) * np.tanh(steepness * moved[1]))


def stribeck(
    moved: Moved,
    beta: Array,  # noqa: ARG001
    steepness: float,
    speed: float = STRIBECK_SPEEDS[-1],
    power: int = 2,
) -> Array:
    """Compute friction that is larger near rest, shape (2, N, 2): powers of 1 and 2 are both in use."""
    return one_joint(np.tanh(steepness * moved[1]) * np.exp(-((np.abs(moved[1]) / speed) ** power)))


@dataclass(frozen=True)
class Kind:
    """A kind of term, with a column for each of its joints."""

    columns: Columns
    unit: str  # of its value
    joints: tuple[int, ...] = (1, 2)
    neutral: float = 0.0  # value without effect
    max_step: float = np.inf  # longest step of Gauss-Newton, as columns are valid near the log that they are made on


#: Friction in proportion to the load, and friction at rest on top of k.
FRICTION: dict[str, Kind] = {"load": Kind(load_friction, "1"), "stribeck": Kind(stribeck, "N m")}


def term_names(kinds: Mapping[str, Kind]) -> tuple[str, ...]:
    """Names of the terms, ``KINDj`` with joint j, in the order of the columns."""
    return tuple(f"{name}{joint}" for name, kind in kinds.items() for joint in kind.joints)


FRICTION_TERMS = term_names(FRICTION)


@dataclass(frozen=True)
class Term:
    """A term that a log shows."""

    name: str  # of `FRICTION_TERMS` or `repro.identification.calibration.CALIBRATION_TERMS`
    value: float  # in the unit of its kind: a zero is added to the position, an offset subtracted from the torque
    error: float  # standard error of the value


@dataclass(frozen=True)
class FrictionTerm(Term):
    """Friction that Eq. 1 does not model."""

    gain: float  # fraction by which it reduces the cross-validated squared error, next to the other terms
    taken: bool  # whether it is subtracted from the torque


def values_of(terms: Sequence[Term]) -> dict[str, float]:
    """Values of terms by name."""
    return {term.name: term.value for term in terms}


# Columns of the regressor, and selection among them.


def raw_columns(kinds: Mapping[str, Kind], moved: Moved, beta: Array, steepness: float) -> Array:
    """Compute the columns of all terms of these kinds along a motion, shape (2, N, k)."""
    return np.concatenate([kind.columns(moved, beta, steepness) for kind in kinds.values()], axis=-1)


def filtered_columns(makes: Sequence[Columns], log: Log, settings: FilterSettings, beta: Array) -> list[Array]:
    """Compute columns at the retained samples through the filters of the regressor, each of shape (2, n, k)."""
    pieces = []
    for piece in log.pieces:
        h, (n, keep) = period(piece), retained_samples(piece, settings)
        moved = smooth_motion(piece.q[:, :n], h, settings)
        raw = (make(moved, beta, settings.friction_steepness) for make in makes)
        pieces.append([filter_columns(columns, h, settings)[:, keep] for columns in raw])
    return [np.concatenate(parts, axis=1) for parts in zip(*pieces, strict=True)]


def term_columns(
    kinds: Mapping[str, Kind], log: Log, settings: FilterSettings, beta: Array, terms: Sequence[Term] | None = None
) -> Array:
    """Compute the filtered columns (2, n, k) of terms, or of all terms of these kinds."""
    columns = filtered_columns([partial(raw_columns, kinds)], log, settings, beta)[0]
    return columns if terms is None else columns[..., [term_names(kinds).index(term.name) for term in terms]]


def weighted_rows(regression: Regression, columns: Array) -> tuple[Array, Array]:
    """Append columns to the regressor; return rows (2, n, 9 + k) and torque, joints weighted by their residual."""
    residual = regression.tau - regression.y @ solve(regression.y, regression.tau)
    count = np.maximum(regression.mask.sum(-1, keepdims=True), 1)
    size = np.sqrt(np.sum(residual**2, axis=-1, keepdims=True) / count)
    weight = np.where(size > 0.0, 1.0 / np.where(size > 0.0, size, 1.0), 0.0)
    masked = columns * regression.mask[..., np.newaxis]
    a = np.concatenate([regression.y, masked], axis=-1) * weight[..., np.newaxis]
    return a, regression.tau * weight


#: Rows of no other log.
NO_ROWS: Array = np.empty((0, N_NINE + 1))


def reduced_rows(a: Array, b: Array) -> Array:
    """Reduce rows with the torque as last column to as many as there are columns (QR): least squares stays the same."""
    both = np.concatenate([a, b[..., np.newaxis]], axis=-1).reshape(-1, a.shape[-1] + 1)
    return np.asarray(np.linalg.qr(both, mode="r"))


def other_rows(regressions: Sequence[Regression]) -> Array:
    """Reduce other logs, to which no term applies, to rows (m, 10) for the functions below."""
    each = [reduced_rows(*weighted_rows(r, np.empty((*r.tau.shape, 0)))) for r in regressions]
    return np.concatenate([NO_ROWS, *each])


def _padded(others: Array, k: int) -> Array:
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
    """Reduced rows of each block of the log."""
    block = np.arange(b.shape[1]) * BLOCKS // b.shape[1]
    return [reduced_rows(a[:, block == k], b[:, block == k]) for k in range(BLOCKS)]


def _leave_one_out(blocks: Sequence[Array], columns: Sequence[int], others: Array) -> list[Array]:
    """Solutions from all blocks but one, and from the other logs."""
    always = _padded(others, blocks[0].shape[1] - others.shape[1])
    rest = [np.concatenate([*blocks[:k], *blocks[k + 1 :], always]) for k in range(len(blocks))]
    return [_fit(r[:, columns], r[:, -1]) for r in rest]


def _block_error(blocks: Sequence[Array], columns: Sequence[int], others: Array) -> float:
    pairs = zip(blocks, _leave_one_out(blocks, columns, others), strict=True)
    return float(sum(np.sum((r[:, -1] - r[:, columns] @ x) ** 2) for r, x in pairs))


def cross_validation_error(a: Array, b: Array, others: Array = NO_ROWS) -> float:
    """Squared error of the blocks of a log, each predicted from the others."""
    return _block_error(_blocks(a, b), range(a.shape[-1]), others)


def fit_with_errors(a: Array, b: Array, h: float, others: Array = NO_ROWS) -> tuple[Array, Array]:
    """Fit rows `h` apart; the standard errors are the larger of those by independent samples and by the blocks."""
    blocks = _blocks(a, b)
    both = np.concatenate([*blocks, _padded(others, a.shape[-1] + 1 - others.shape[1])])
    flat, x = both[:, :-1], _fit(both[:, :-1], both[:, -1])
    residual = b - a @ x
    n_independent = residual.size * h / correlation_time(residual, h)
    spread = np.sqrt(np.abs(np.diag(np.linalg.pinv(flat.T @ flat))) * np.sum(residual**2) / max(n_independent, 1.0))
    jackknife = np.sqrt((BLOCKS - 1) * np.var(_leave_one_out(blocks, range(a.shape[-1]), others), axis=0))
    return x, np.maximum(spread, jackknife)


def _nine_and(subset: Sequence[int]) -> list[int]:
    """Numbers of the nine columns and of some of those behind them."""
    return [*range(N_NINE), *(N_NINE + k for k in subset)]


def best_subset(a: Array, b: Array, candidates: Sequence[int], others: Array = NO_ROWS) -> list[int]:
    """Choose the columns behind the nine that predict blocks best, each worth `MIN_ERROR_REDUCTION` of the error."""
    subsets = [subset for size in range(len(candidates) + 1) for subset in combinations(candidates, size)]
    blocks = _blocks(a, b)
    error = [
        _block_error(blocks, _nine_and(subset), others) * (1.0 - MIN_ERROR_REDUCTION) ** -len(subset)
        for subset in subsets
    ]
    return list(subsets[int(np.argmin(error))])


def detection_limits(
    a: Array, b: Array, chosen: Sequence[int], candidates: Sequence[int], h: float, others: Array = NO_ROWS
) -> list[float]:
    """Compute the smallest size of each candidate that both rules would accept, next to the chosen columns.

    A column of size x reduces the squared error by x^2 S, with S its part that no other column contains; that must be
    `MIN_ERROR_REDUCTION` of the error with it.
    """
    error, limits = cross_validation_error(a[..., _nine_and(chosen)], b, others), []
    for k in candidates:
        columns = a[..., _nine_and([*chosen, k])]
        _, standard_error = fit_with_errors(columns, b, h, others)
        flat = columns.reshape(-1, columns.shape[-1])
        flat = np.concatenate([flat, _padded(others[:, :-1], flat.shape[-1] - N_NINE)])
        alone = flat[:, -1] - flat[:, :-1] @ _fit(flat[:, :-1], flat[:, -1])
        ratio = MIN_ERROR_REDUCTION / (1.0 - MIN_ERROR_REDUCTION)
        square = ratio * error / max(float(alone @ alone), np.finfo(float).tiny)
        limits.append(max(MIN_Z_SCORE * float(standard_error[-1]), float(np.sqrt(square))))
    return limits


def find_friction(log: Log, settings: FilterSettings, subtract: bool) -> tuple[FrictionTerm, ...]:
    """Find the friction terms to subtract, if any may be, and those that would help, in a calibrated log."""
    r = drop_standstill(prepare(log, settings))
    a, b = weighted_rows(r, term_columns(FRICTION, log, settings, solve(r.y, r.tau)))
    candidates = [k for k in range(len(FRICTION_TERMS)) if np.any(a[..., N_NINE + k])]

    def evaluated(k: int, chosen: Sequence[int]) -> FrictionTerm:
        others = [other for other in chosen if other != k]
        columns = a[..., _nine_and([k, *others])]
        error = max(cross_validation_error(a[..., _nine_and(others)], b), np.finfo(np.float64).tiny)
        gain = 1.0 - cross_validation_error(columns, b) / error
        value, standard_error = (float(x[N_NINE]) for x in fit_with_errors(columns, b, r.h))
        return FrictionTerm(FRICTION_TERMS[k], value, standard_error, gain, k in chosen)

    chosen = best_subset(a, b, candidates) if subtract else []
    while True:
        terms = [evaluated(k, chosen) for k in candidates]
        credible = [term for term in terms if term.value > MIN_Z_SCORE * term.error]
        rejected = [FRICTION_TERMS.index(term.name) for term in terms if term.taken and term not in credible]
        if not rejected:
            return tuple(term for term in credible if term.taken or term.gain > MIN_REPORTED_REDUCTION)
        chosen = [k for k in chosen if k != rejected[0]]


def subtract_friction(log: Log, settings: FilterSettings, beta: Array, terms: Sequence[FrictionTerm]) -> Log:
    """Subtract the friction of these terms from the torque of a log; `beta` gives the load."""
    moved = smooth_motion(log.q, period(log), settings)
    columns = raw_columns(FRICTION, moved, beta, settings.friction_steepness)
    subset = [FRICTION_TERMS.index(term.name) for term in terms]
    friction = columns[..., subset] @ np.array([term.value for term in terms])
    acting = np.clip(log.t + settings.delay, log.t[0], log.t[-1])
    return replace(log, tau=log.tau - CubicSpline(log.t, friction, axis=1)(acting))
