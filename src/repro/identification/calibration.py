"""Calibration errors of a log: found, evaluated against rival explanations, and corrected.

A wrong zero position turns gravity, an offset of the torque is always there, and a wrong torque constant of one joint
shows because both joints share I2, I3 and g2. Columns are selected first; Gauss-Newton on the corrected log follows.

Friction c |u| sign(w) that grows with the torque u of the drive makes u larger by 1 / (1 - c) where it drives, smaller
by 1 / (1 + c) where it brakes, and larger on average: a wrong torque constant must be needed next to such friction.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from repro.identification.extra_terms import (
    MIN_Z_SCORE,
    N_NINE,
    Term,
    TermKind,
    filtered_columns,
    offset,
    one_joint,
    term_columns,
    term_names,
    torque_friction,
    values_of,
    waves,
    zero_position,
)
from repro.identification.filtering import MIN_ERROR_REDUCTION, FilterSettings, prepare
from repro.identification.log import Log, cached_per_log
from repro.identification.regression import Regression, drop_standstill, solve
from repro.identification.term_selection import (
    best_subset,
    cross_validation_error,
    detection_limits,
    fit_with_errors,
    nine_and,
    other_rows,
    padded,
    reduced_rows,
    weighted_rows,
)
from repro.model.parameters import Array

MAX_ITERATIONS, MAX_LAST_STEP = 8, 0.1  # most iterations of Gauss-Newton, and step in standard errors at which they end
#: Zero (rad) beyond which it is no calibration error but another convention of the log, see `repro.logs.conventions`.
MAX_ZERO = 0.25
#: Relative RMS torque error of a corrected log above which Eq. 1 explains too little of it to show an error.
MAX_CALIBRATED_ERROR = 0.5
#: Factor beyond which the scale of a torque is no calibration error but a joint of which the log shows nothing.
MAX_SCALE = 3.0
#: Torques of the position that may be taken for a calibration error: of 1 to 8 periods a turn.
WAVES = tuple(partial(waves, periods=n) for n in range(1, 9))
#: What may be wrong with a log: zero of a joint, offset of its torque, and the recorded torque of a joint over the one
#: that Eq. 1 shares with the other. A log cannot determine which of the two is wrong: joint 2, unless a prior decides.
CALIBRATION: dict[str, TermKind] = {
    "zero": TermKind(zero_position, max_step=0.1),
    "offset": TermKind(offset),
    "scale": TermKind(lambda log: one_joint(log.y @ log.beta), neutral=1.0, max_step=0.3),
}
OTHER_SCALE, SCALE = "scale1", "scale2"  # torque constants belong to the arm rather than to a log
CALIBRATION_TERMS = term_names(CALIBRATION)
CANDIDATES = tuple(name for name in CALIBRATION_TERMS if name != OTHER_SCALE)  # those that a log is searched for
#: Columns that are computed together: behind those of calibration errors, the friction that looks like a scale.
_COLUMNS = CALIBRATION | {"friction": TermKind(torque_friction)}
_FRICTION = range(len(CALIBRATION_TERMS), len(term_names(_COLUMNS)))


@dataclass(frozen=True)
class CalibrationError(Term):
    """A calibration error of a log."""

    before: float  # relative RMS error of the rebuilt torque, mean of both joints, with all errors but this corrected
    after: float  # the same with all errors corrected
    instead: dict[str, float] = field(default_factory=dict)  # other errors that would explain the log nearly as well

    @property
    def is_credible(self) -> bool:
        """Whether it is well away from none, not too large to be one, and reduces the torque error."""
        away = abs(self.value - CALIBRATION[self.kind].neutral)
        small = {"zero": away <= MAX_ZERO, "scale": 1.0 / MAX_SCALE <= self.value <= MAX_SCALE}.get(self.kind, True)
        return away > MIN_Z_SCORE * self.error and small and self.after < min(self.before, MAX_CALIBRATED_ERROR)


def correct_calibration(log: Log, values: Mapping[str, float]) -> Log:
    """Correct positions and torques of a log by the values of calibration errors; a missing one has no effect."""
    if not values:
        return log
    zero, constant, factor = (
        np.array([[values.get(f"{name}{j}", kind.neutral)] for j in (1, 2)]) for name, kind in CALIBRATION.items()
    )
    return replace(log, q=log.q + zero, tau=(log.tau - constant) / factor)


def blame_joint_1(errors: Sequence[CalibrationError]) -> tuple[CalibrationError, ...]:
    """Attribute a scale to joint 1 instead of joint 2: its torque is as much too small as that of joint 2 too large."""
    return tuple(
        replace(e, name=OTHER_SCALE, value=1.0 / e.value, error=e.error / e.value**2) if e.name == SCALE else e
        for e in errors
    )


def _candidates(columns: Array, mask: NDArray[np.bool_], names: Sequence[str]) -> list[int]:
    """Number the terms with these names whose columns are not zero throughout."""
    return [k for k, name in enumerate(CALIBRATION_TERMS) if name in names and np.any(columns[..., k] * mask)]


@cached_per_log
def _regression_and_columns(log: Log, settings: FilterSettings) -> tuple[Regression, Array]:
    """Regression of a log without standstill, and the columns of all calibration errors and of friction."""
    r = drop_standstill(prepare(log, settings, even_odd=False))
    return r, term_columns(_COLUMNS, log, settings, solve(r.y, r.tau))


@dataclass(frozen=True)
class CalibrationProblem:
    """Estimation of the calibration errors of a log, next to correct logs of the same arm."""

    log: Log
    settings: FilterSettings
    others: Array  # rows (m, 10) of the correct logs

    def relative_error(self, values: Mapping[str, float], with_waves: bool = False) -> float:
        """Relative RMS error of least squares of the corrected log and others, mean of its joints that have torque.

        With waves: next to a torque of the position of each joint, of the number of periods a turn that fits best.
        """
        log = correct_calibration(self.log, values)
        r = drop_standstill(prepare(log, self.settings, even_odd=False))
        columns: Array = np.empty((*r.tau.shape, 0))
        if with_waves:
            all_waves = filtered_columns(WAVES, log, self.settings, solve(r.y, r.tau))
            for joint in (0, 1):  # every second column is of this joint
                candidates = (np.concatenate([columns, wave[..., joint::2]], axis=-1) for wave in all_waves)
                columns = min(candidates, key=lambda candidate: self._relative_error(r, candidate))
        return self._relative_error(r, columns)

    def _relative_error(self, r: Regression, columns: Array) -> float:
        a = np.concatenate([r.y, columns * r.mask[..., np.newaxis]], axis=-1)
        beta = solve(a, r.tau)
        if len(self.others):
            own = reduced_rows(*weighted_rows(r, columns))
            rows = np.concatenate([own, padded(self.others, columns.shape[-1])])
            beta = solve(rows[:, :-1], rows[:, -1])
        error, torque = np.linalg.norm(r.tau - a @ beta, axis=-1), np.linalg.norm(r.tau, axis=-1)
        return float(np.mean((error / np.where(torque > 0.0, torque, 1.0))[torque > 0.0])) if torque.any() else 0.0

    def values(self, names: Sequence[str]) -> dict[str, tuple[float, float]]:
        """Values of these calibration errors with their standard errors, by Gauss-Newton."""
        values = {name: CALIBRATION[name[:-1]].neutral for name in names}
        errors = dict.fromkeys(names, np.inf)
        subset = [CALIBRATION_TERMS.index(name) for name in names]
        for _ in range(MAX_ITERATIONS):
            r, columns = _regression_and_columns(correct_calibration(self.log, values), self.settings)
            fit = fit_with_errors(*weighted_rows(r, columns[..., subset]), r.h, self.others)
            steps, spread = (x[N_NINE:] for x in fit)
            for name, step, error in zip(names, steps, spread, strict=True):
                kind = CALIBRATION[name[:-1]]
                size = values[name] if kind.neutral else 1.0
                values[name] += size * float(np.clip(step, -kind.max_step, kind.max_step))
                errors[name] = abs(size) * float(error)
            if np.all(np.abs(steps) < MAX_LAST_STEP * spread):
                break
        return {name: (values[name], errors[name]) for name in names}

    def errors(self, names: Sequence[str], of: Sequence[str]) -> list[CalibrationError]:
        """Evaluate some of these calibration errors, which are all corrected."""
        estimates = self.values(names)
        values = {name: value for name, (value, _) in estimates.items()}
        after = self.relative_error(values)
        remaining = [{rest: value for rest, value in values.items() if rest != name} for name in of]
        return [
            CalibrationError(name, *estimates[name], self.relative_error(rest), after)
            for name, rest in zip(of, remaining, strict=True)
        ]

    def are_waves(self, doubted: Sequence[CalibrationError], errors: Sequence[CalibrationError]) -> bool:
        """Whether torques of the position explain the log better than these of the errors, and also without them."""
        rest = values_of([error for error in errors if error not in doubted])
        least, instead = 1.0 - MIN_ERROR_REDUCTION, self.relative_error(rest, with_waves=True) ** 2
        if instead >= least * errors[0].after ** 2:
            return False
        return self.relative_error(values_of(errors), with_waves=True) ** 2 >= least * instead

    def with_rivals(self, error: CalibrationError, names: Sequence[str]) -> CalibrationError:
        """Add the calibration errors that explain the log nearly as well in place of this one."""
        instead = {}
        for candidate in (name for name in CANDIDATES if name not in names):
            (rival,) = self.errors([candidate if name == error.name else name for name in names], [candidate])
            if (1.0 - MIN_ERROR_REDUCTION) * rival.after**2 < error.after**2 and rival.is_credible:
                instead[candidate] = rival.value
        return replace(error, instead=instead)


def _is_scale_needed(a: Array, b: Array, chosen: Sequence[int], others: Array) -> bool:
    """Whether the scale among chosen columns is worth its place next to friction in proportion to the torque."""
    without = [*_FRICTION, *(k for k in chosen if CALIBRATION_TERMS[k] != SCALE)]
    with_it = [*without, CALIBRATION_TERMS.index(SCALE)]
    smaller, larger = (
        cross_validation_error(a[..., nine_and(subset)], b, others).sum() for subset in (with_it, without)
    )
    return bool(smaller < (1.0 - MIN_ERROR_REDUCTION) * larger)


def find_calibration_errors(
    log: Log, settings: FilterSettings, others: Sequence[Regression] = (), names: Sequence[str] = CANDIDATES
) -> tuple[CalibrationError, ...]:
    """Find the calibration errors with these names in a log; `others` are correct regressions of the same arm."""
    r, columns = _regression_and_columns(log, settings)
    problem = CalibrationProblem(log, settings, other_rows(others))
    candidates = dict.fromkeys(_candidates(columns, r.mask, names), MIN_ERROR_REDUCTION)
    a, b = weighted_rows(r, columns)
    scale, chosen = CALIBRATION_TERMS.index(SCALE), best_subset(a, b, candidates, problem.others)
    if scale in chosen and not _is_scale_needed(a, b, chosen, problem.others):
        chosen = best_subset(a, b, {k: least for k, least in candidates.items() if k != scale}, problem.others)
    names = [CALIBRATION_TERMS[k] for k in chosen]
    while names:
        errors = problem.errors(names, names)
        rejected = [error for error in errors if not error.is_credible]
        if not rejected and problem.are_waves(errors, errors):
            return ()
        rejected = rejected or [error for error in errors if problem.are_waves([error], errors)]
        if not rejected:
            return tuple(problem.with_rivals(error, names) for error in errors)
        # Gauss-Newton may end far away because of an error that is not there: without it the others converge.
        least = min(rejected, key=lambda error: error.before - error.after)
        names = [name for name in names if name != least.name]
    return ()


def calibration_limits(
    log: Log, settings: FilterSettings, corrected: Sequence[CalibrationError], others: Sequence[Regression] = ()
) -> dict[str, float | None]:
    """Compute the detection limits (rad, N m, fraction of the scale) of the calibration errors that were not corrected.

    A limit beyond `MAX_ZERO`, the largest torque or `MAX_SCALE` is None: an error of any size could be hidden.
    """
    r, columns = _regression_and_columns(log, settings)
    names = [SCALE if error.name == OTHER_SCALE else error.name for error in corrected]
    subset = [CALIBRATION_TERMS.index(name) for name in names]
    candidates = _candidates(columns, r.mask, [name for name in CANDIDATES if name not in names])
    a, b = weighted_rows(r, columns)
    first, second = np.abs(log.tau).max(axis=-1)
    max_sizes = dict(zip(CANDIDATES, (MAX_ZERO, MAX_ZERO, first, second, MAX_SCALE - 1.0), strict=True))
    limits = detection_limits(a, b, subset, candidates, r.h, other_rows(others))
    if CALIBRATION_TERMS.index(SCALE) in candidates:  # the last
        next_to_friction = detection_limits(a, b, [*subset, *_FRICTION], candidates[-1:], r.h, other_rows(others))
        limits[-1:] = [max(limits[-1], *next_to_friction)]
    sizes = zip((CALIBRATION_TERMS[k] for k in candidates), limits, strict=True)
    return {name: size if size < max_sizes[name] else None for name, size in sizes}
