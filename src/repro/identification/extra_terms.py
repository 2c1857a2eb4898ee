"""Terms that extend Eq. 1, chosen by cross-validation: a rotor, further friction, and calibration errors.

Each such term is a candidate column next to the nine of the regressor (`TERMS`, and `CALIBRATION` of
`repro.identification.calibration`). The chosen subset of the candidates predicts blocks of the log from the other
blocks best, and each of its columns reduces the squared error by `TermKind.min_reduction`. A chosen term is also
`MIN_Z_SCORE` standard errors away from no effect. Other logs of the arm, to which no term applies, may join the fit.
Coulomb friction that differs between the two directions is no candidate: while a joint moves it is an offset.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import combinations, product

import numpy as np
from scipy.interpolate import CubicSpline

from repro.identification.filtering import (
    FILTERS,
    MIN_ERROR_REDUCTION,
    FilterSettings,
    Moved,
    filter_columns,
    filtered_torque,
    prepare,
    retained_samples,
    smooth_motion,
)
from repro.identification.log import Log, period
from repro.identification.regression import Regression, correlation_time, drop_standstill, joined, solve
from repro.model.dynamics import regressor
from repro.model.parameters import NAMES, Array

MIN_Z_SCORE = 4.0  # standard errors that a term must be away from no effect
#: Reduction of the cross-validated squared error beyond which friction that is not subtracted is reported.
MIN_REPORTED_REDUCTION = 0.05
BLOCKS = 6  # blocks of the log in cross-validation
LOAD_ITERATIONS = 2  # after which parameters and the load that they give agree to a percent
POSITION_DIFFERENCE = 1e-4  # difference with which columns of errors of the position are made, rad
#: Speeds at which Stribeck friction may have fallen to 1/e of its value at rest, rad/s.
STRIBECK_SPEEDS = (0.1, 0.2, 0.5)
N_NINE = len(NAMES)
N_LOAD = 5  # inertia and gravity: the first parameters, whose torque loads the gear


@dataclass(frozen=True, eq=False)
class SmoothLog:
    """One piece of a log as the columns of further terms need it."""

    moved: Moved  # smoothed motion
    tau: Array  # filtered torque (2, N)
    beta: Array  # parameters that give the torque of Eq. 1
    h: float  # sampling period, s
    settings: FilterSettings

    @classmethod
    def of(cls, log: Log, settings: FilterSettings, beta: Array) -> "SmoothLog":
        """Smooth a log in one piece."""
        h = period(log)
        return cls(smooth_motion(log.q, h, settings), filtered_torque(log.tau, h, settings), beta, h, settings)

    @cached_property
    def y(self) -> Array:
        """The regressor along the motion (2, N, 9)."""
        return regressor(*self.moved, self.settings.friction_steepness)

    @property
    def coulomb(self) -> Array:
        """Direction of the Coulomb friction of each joint (2, N)."""
        return np.tanh(self.settings.friction_steepness * self.moved[1])

    @property
    def gear_load(self) -> Array:
        """Recorded torque (2, N) behind the friction of each joint: a position error would falsify that of Eq. 1."""
        friction = FILTERS[self.settings.name].apply(self.y[..., 5:] @ self.beta[5:], self.h, self.settings.cutoff, 0)
        return self.tau - friction


Columns = Callable[[SmoothLog], Array]  # torque (2, N, k) that terms of unit size add


def one_joint(values: Array) -> Array:
    """Make a column for each joint that is zero in the other, (2, N) -> (2, N, 2)."""
    return values[..., np.newaxis] * np.eye(2)[:, np.newaxis]


def offset(log: SmoothLog) -> Array:
    """Compute the columns of a constant torque of each joint, shape (2, N, 2)."""
    return one_joint(np.ones_like(log.tau))


def position_error(log: SmoothLog, error: Array) -> Array:
    """Compute the change of both torques with an error (2, N) of the position of either joint, shape (2, N, 2)."""
    torque, moved = log.y @ log.beta, smooth_motion(error, log.h, log.settings)
    columns = []
    for joint, largest in zip(np.eye(2), np.abs(error).max(axis=-1), strict=True):
        difference = POSITION_DIFFERENCE / (largest or 1.0)
        q, dq, ddq = (x + difference * joint[:, np.newaxis] * dx for x, dx in zip(log.moved, moved, strict=True))
        columns.append((replace(log, moved=(q, dq, ddq)).y @ log.beta - torque) / difference)
    return np.stack(columns, axis=-1)


def zero_position(log: SmoothLog) -> Array:
    """Compute the change of the torque of each joint with the zero position of either, shape (2, N, 2)."""
    return position_error(log, np.ones_like(log.tau))


def rotor_inertia(log: SmoothLog) -> Array:
    """Compute the torque of a rotor of unit inertia that turns with joint 2 alone, shape (2, N, 1)."""
    return one_joint(log.moved[2])[..., 1:]


def load_friction(log: SmoothLog) -> Array:
    """Compute Coulomb friction in proportion to the torque that the gear carries, shape (2, N, 2)."""
    return one_joint(np.abs(log.y[..., :N_LOAD] @ log.beta[:N_LOAD]) * log.coulomb)


def torque_friction(log: SmoothLog) -> Array:
    """Compute Coulomb friction in proportion to the recorded torque, which contains it, shape (2, N, 2)."""
    return one_joint(np.abs(log.tau) * log.coulomb)


def stribeck(log: SmoothLog, speed: float = STRIBECK_SPEEDS[-1], power: int = 2) -> Array:
    """Compute friction that is larger near rest, shape (2, N, 2): powers of 1 and 2 are both in use."""
    return one_joint(log.coulomb * np.exp(-((np.abs(log.moved[1]) / speed) ** power)))


def friction(log: SmoothLog, speed: float, power: int) -> Array:
    """Compute friction in proportion to the load, and friction that is larger near rest, shape (2, N, 4)."""
    return np.concatenate([load_friction(log), stribeck(log, speed, power)], axis=-1)


def once_a_turn(log: SmoothLog) -> Array:
    """Compute torque of period one turn (eccentric gear), (2, N, 3), without sin q1 at joint 1: it is g1."""
    q = log.moved[0]
    return np.concatenate([one_joint(np.cos(q)), one_joint(np.sin(q))[..., 1:]], axis=-1)


def twice_a_turn(log: SmoothLog) -> Array:
    """Compute torque of period half a turn of a joint (cable, gear out of round), shape (2, N, 4)."""
    return np.concatenate([one_joint(wave(2.0 * log.moved[0])) for wave in (np.cos, np.sin)], axis=-1)


def backlash(log: SmoothLog, width: float) -> Array:
    """Compute the effect of play behind the encoder (2, N, 2): teeth change sides below `width` of the largest load."""
    largest = np.abs(log.gear_load).max(axis=-1, keepdims=True)
    return position_error(log, np.tanh(log.gear_load / (width * np.where(largest > 0.0, largest, 1.0))))


ZEROS, OFFSETS, CONSTANTS = "zero positions", "torque offsets", "torque constants that change with the current"
_STRIBECK = tuple(product(STRIBECK_SPEEDS, (1, 2)))  # speeds (rad/s) and powers of the forms of Stribeck friction
#: Effects beyond Eq. 1 by name. Of several forms, the one that explains the residual best counts. The teeth of a gear
#: may change sides at several loads over the largest one.
UNMODELLED_EFFECTS: dict[str, tuple[Columns, ...]] = {
    ZEROS: (zero_position,),
    OFFSETS: (offset,),
    "load-dependent friction": (load_friction,),
    "Stribeck friction": tuple(partial(stribeck, speed=speed, power=power) for speed, power in _STRIBECK),
    "both kinds of friction": tuple(partial(friction, speed=speed, power=power) for speed, power in _STRIBECK),
    "torque of period one turn": (once_a_turn,),
    "torque of period half a turn": (twice_a_turn,),
    "inertia of the rotor of joint 2": (rotor_inertia,),
    CONSTANTS: (lambda log: one_joint(log.tau * np.abs(log.tau)),),
    "elasticity": (lambda log: position_error(log, log.gear_load),),
    "backlash": tuple(partial(backlash, width=width) for width in (0.02, 0.05, 0.15)),
}
EFFECTS_PER_LOG = (ZEROS, OFFSETS)  # effects that differ from log to log of one arm
#: Largest credible torque of an effect, over the largest torque of its joint: beyond it something else looks like it.
MAX_TORQUE_SHARE = {CONSTANTS: 0.3}


@dataclass(frozen=True)
class TermKind:
    """A kind of term, with a column for each of its joints."""

    columns: Columns
    joints: tuple[int, ...] = (1, 2)
    min_reduction: float = MIN_ERROR_REDUCTION  # fraction of the cross-validated squared error that it must reduce
    neutral: float = 0.0  # value without effect
    max_step: float = np.inf  # longest step of Gauss-Newton, as columns are valid near the log that they are made on


#: Friction in proportion to the load, friction at rest on top of k (N m), and the rotor of joint 2 (kg m^2). Every gear
#: has a rotor, and a column that is not needed only widens the intervals: little evidence is enough.
TERMS: dict[str, TermKind] = {
    "load": TermKind(load_friction),
    "stribeck": TermKind(stribeck),
    "rotor": TermKind(rotor_inertia, (2,), min_reduction=MIN_REPORTED_REDUCTION),
}
LOAD = "load"  # the kind of friction that is not linear in the acceleration
ROTOR = "rotor"  # the kind that is no friction: it is subtracted without being asked


def term_names(kinds: Mapping[str, TermKind]) -> tuple[str, ...]:
    """Names of the terms, ``KINDj`` with joint j, in the order of the columns."""
    return tuple(f"{name}{joint}" for name, kind in kinds.items() for joint in kind.joints)


TERM_NAMES = term_names(TERMS)


@dataclass(frozen=True)
class Term:
    """A term that a log shows."""

    name: str  # of `TERM_NAMES` or `repro.identification.calibration.CALIBRATION_TERMS`
    value: float  # in the unit of its kind: a zero is added to the position, an offset subtracted from the torque
    error: float  # standard error of the value

    @property
    def kind(self) -> str:
        """Its name without the joint."""
        return self.name[:-1]


@dataclass(frozen=True)
class ExtraTerm(Term):
    """Friction or a rotor that Eq. 1 does not model."""

    gain: float  # fraction by which it reduces the cross-validated squared error, next to the other terms
    taken: bool  # whether it is subtracted from the torque


def values_of(terms: Sequence[Term]) -> dict[str, float]:
    """Values of terms by name."""
    return {term.name: term.value for term in terms}


# Columns of the regressor, and selection among them.


def raw_columns(kinds: Mapping[str, TermKind], log: SmoothLog) -> Array:
    """Compute the columns of all terms of these kinds, shape (2, N, k)."""
    return np.concatenate([kind.columns(log) for kind in kinds.values()], axis=-1)


def filtered_columns(makes: Sequence[Columns], log: Log, settings: FilterSettings, beta: Array) -> list[Array]:
    """Compute columns at the retained samples through the filters of the regressor, each of shape (2, n, k)."""
    pieces = []
    for piece in log.pieces:
        n, keep = retained_samples(piece, settings)
        smooth = SmoothLog.of(piece.piece(0, n), settings, beta)
        pieces.append([filter_columns(make(smooth), smooth.h, settings)[:, keep] for make in makes])
    return [np.concatenate(parts, axis=1) for parts in zip(*pieces, strict=True)]


def term_columns(
    kinds: Mapping[str, TermKind], log: Log, settings: FilterSettings, beta: Array, terms: Sequence[Term] | None = None
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


NO_ROWS: Array = np.empty((0, N_NINE + 1))  # rows of no other log


def reduced_rows(a: Array, b: Array) -> Array:
    """Reduce rows with the torque as last column to as many as there are columns (QR): least squares stays the same."""
    rows = np.concatenate([a, b[..., np.newaxis]], axis=-1).reshape(-1, a.shape[-1] + 1)
    return np.asarray(np.linalg.qr(rows, mode="r"))


def other_rows(regressions: Sequence[Regression]) -> Array:
    """Reduce other logs, to which no term applies, to rows (m, 10) for the functions below."""
    rows = [reduced_rows(*weighted_rows(r, np.empty((*r.tau.shape, 0)))) for r in regressions]
    return np.concatenate([NO_ROWS, *rows])


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
    """Reduced rows of each block of the log, by joint (2, m, k + 1)."""
    block = np.arange(b.shape[1]) * BLOCKS // b.shape[1]
    return [
        np.stack([reduced_rows(*rows) for rows in zip(a[:, block == k], b[:, block == k], strict=True)])
        for k in range(BLOCKS)
    ]


def _leave_one_out(blocks: Sequence[Array], columns: Sequence[int], others: Array) -> list[Array]:
    """Solutions from all blocks but one, and from the other logs."""
    flat = [block.reshape(-1, block.shape[-1]) for block in blocks]
    always = _padded(others, flat[0].shape[1] - others.shape[1])
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
    rows = np.concatenate([*flat, _padded(others, a.shape[-1] + 1 - others.shape[1])])
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
        rows = np.concatenate([flat, _padded(others[:, :-1], flat.shape[-1] - N_NINE)])
        alone = flat[:, -1] - flat[:, :-1] @ _fit(rows[:, :-1], rows[:, -1])
        smallest = np.sqrt(ratio * error / max(float(alone @ alone), np.finfo(float).tiny))
        limits.append(max(MIN_Z_SCORE * float(standard_error[-1]), float(smallest)))
    return limits


def _weight(regression: Regression, columns: Array) -> float:
    """Weigh a log by its RMS error of least squares with further columns, 1/(N m)."""
    a = np.concatenate([regression.y, columns * regression.mask[..., np.newaxis]], axis=-1)
    error = regression.tau - a @ _fit(a, regression.tau)
    return 1.0 / (float(np.linalg.norm(error) / np.sqrt(max(regression.mask.sum(), 1))) or 1.0)


def find_terms(logs: Sequence[tuple[Log, FilterSettings]], friction: bool) -> tuple[tuple[ExtraTerm, ...], Array]:
    """Find what to subtract from logs of one arm and what would help, in the order of `TERM_NAMES`; also the load (9,).

    Friction is subtracted if it may be, the rotor always. The logs have correct calibration. Each of several is
    weighted by its errors with all terms in the model: a noisy log must not hide what a good one shows.
    """
    regressions = [drop_standstill(prepare(log, settings, even_odd=False)) for log, settings in logs]
    unweighted = joined(regressions)
    # Without a drive inertia and gravity equal the friction: in proportion to them, 1 would replace b and k.
    driven = np.any([log.tau.any(axis=1) for log, _ in logs], axis=0)
    possible = np.array([not name.startswith(LOAD) or driven[int(name[-1]) - 1] for name in TERM_NAMES])
    load = solve(unweighted.y, unweighted.tau)
    for _ in range(LOAD_ITERATIONS):  # friction in proportion to the load biases the parameters that give the load
        columns = [term_columns(TERMS, log, settings, load) * possible for log, settings in logs]
        more = np.concatenate(columns, axis=1) * unweighted.mask[..., np.newaxis]
        load = solve(np.concatenate([unweighted.y, more], axis=-1), unweighted.tau)[:N_NINE]
    columns = [term_columns(TERMS, log, settings, load) * possible for log, settings in logs]
    weights = [_weight(r, c) for r, c in zip(regressions, columns, strict=True)] if len(logs) > 1 else [1.0]
    r = joined(regressions, weights)
    a, b = weighted_rows(r, np.concatenate([w * c for w, c in zip(weights, columns, strict=True)], axis=1))
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
    allowed = {k: least for k, least in reductions.items() if friction or TERM_NAMES[k].startswith(ROTOR)}
    chosen = best_subset(a, b, allowed, by_joint=True)
    while True:
        terms = [evaluated(k, chosen) for k in candidates]
        credible = [term for term in terms if term.value > MIN_Z_SCORE * term.error]
        rejected = [TERM_NAMES.index(term.name) for term in terms if term.taken and term not in credible]
        if not rejected:
            return tuple(term for term in credible if term.taken or term.gain > MIN_REPORTED_REDUCTION), load
        chosen = [k for k in chosen if k != rejected[0]]


def subtract_terms(log: Log, settings: FilterSettings, beta: Array, terms: Sequence[ExtraTerm]) -> Log:
    """Subtract these terms from the torque of a log; `beta` gives the load."""
    subset, values = [TERM_NAMES.index(term.name) for term in terms], np.array([term.value for term in terms])
    torques = []
    for piece in log.pieces:
        torque = raw_columns(TERMS, SmoothLog.of(piece, settings, beta))[..., subset] @ values
        acting = np.clip(piece.t + settings.delay, piece.t[0], piece.t[-1])
        torques.append(piece.tau - CubicSpline(piece.t, torque, axis=1)(acting))
    return replace(log, tau=np.concatenate(torques, axis=1))
