"""The problem that the methods solve: one regression of all logs to fit, and what else is as plausible."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from repro.errors import InputError
from repro.fitting.prepare import LoadedLog, Options, PreparedLog, check_rate, mean_scale, prepare_logs, wrong_torque
from repro.fitting.prior import with_plane
from repro.identification import uncertainty
from repro.identification.armfile import Arm
from repro.identification.calibration import CALIBRATION, correct_calibration
from repro.identification.excitation import Identifiability, excitation
from repro.identification.extra_terms import TERMS, subtract_terms, term_columns, values_of
from repro.identification.filtering import prepare
from repro.identification.log import Log
from repro.identification.regression import Prior, Regression, joined, mean_variance, solve
from repro.identification.uncertainty import Perturbation, WeightedLog
from repro.model.parameters import Array

#: Name of the perturbation that corrects the torque of joint 1 instead of that of joint 2, if either may be wrong.
SCALE_OF_JOINT_1 = "scale of joint 1"


@dataclass(frozen=True)
class IdentificationProblem:
    """The regressions that the methods solve and are evaluated on."""

    logs: tuple[PreparedLog, ...]  # the logs to fit, each with its own filters
    regression: Regression  # all of them together
    moving: Regression  # the same without standstill, with subtracted terms projected out: methods are fitted to it
    as_good: dict[str, Perturbation]  # `moving` with other choices that are as plausible
    validation: tuple[tuple[LoadedLog, Regression], ...]  # logs to predict, corrected and filtered as the first log
    excited: Identifiability  # which parameters the motion identifies
    estimates_delay: bool  # whether the delay is estimated from the log
    prior: Prior | None = None  # of the parameters

    @cached_property
    def left_out(self) -> tuple[tuple[PreparedLog, Regression], ...]:
        """Each of several logs with a fit of the others, if they determine what all do."""
        pairs = []
        for log in self.logs if len(self.logs) > 1 else ():
            others = [other for other in self.logs if other is not log]
            moving = [other.moving for other in others]
            rest = join_logs(others, self.prior)[0] if self.prior else joined(moving, _weights(others))
            if excitation(rest).rank == self.excited.rank:
                pairs.append((log, rest))
        return tuple(pairs)

    @property
    def doubt(self) -> str:
        """Why no interval is claimed; empty if it is from one of the logs."""
        return self.first.doubt if all(log.doubt for log in self.logs) else ""

    @property
    def first(self) -> PreparedLog:
        """The first log to fit, whose filters are those of the validation logs."""
        return self.logs[0]


#: RMS error of a log over that of the best one above which its rows count less: the model causes smaller differences.
MAX_ERROR_RATIO = 3.0


def _weights(logs: Sequence[PreparedLog]) -> list[float]:
    """Weigh the rows of each of several logs: one with large errors counts less."""
    size = [float(np.sqrt(mean_variance(log.moving, solve(log.moving.y, log.moving.tau)))) for log in logs]
    return [min(1.0, MAX_ERROR_RATIO * min(size) / one) if one > 0.0 else 1.0 for one in size]


def _subtracted_columns(whole: Regression, logs: Sequence[tuple[WeightedLog, PreparedLog]]) -> Array:
    """Compute the columns (2, n, k) of all terms that were subtracted from at least one of the joined logs."""
    taken = list({term.name: term for _, one in logs for term in one.taken}.values())
    if not taken:
        return np.empty((*whole.tau.shape, 0))
    each = [log.weight * term_columns(TERMS, log.log, log.settings, one.load, taken) for log, one in logs]
    return np.concatenate(each, axis=1)


def join_logs(logs: Sequence[PreparedLog], prior: Prior | None = None) -> tuple[Regression, dict[str, Perturbation]]:
    """Join several logs and a prior to one regression without standstill, and its perturbations."""
    weights = _weights(logs)
    weighted = [WeightedLog(log.loaded.log, log.settings, weight) for log, weight in zip(logs, weights, strict=True)]
    pairs = list(zip(weighted, logs, strict=True))
    # The values of what was subtracted have errors, so that its columns are projected out.
    whole = joined([log.moving for log in logs], weights)
    subtracted = _subtracted_columns(whole, pairs)
    moving = uncertainty.project_out(whole, subtracted)
    as_good = uncertainty.perturbations(weighted, whole, max(log.delay_error for log in logs))
    if any(log.faults for log in logs):
        beta = solve(moving.y, moving.tau)
        columns = [
            log.weight * term_columns(CALIBRATION, log.log, log.settings, beta, one.faults) for log, one in pairs
        ]
        both = np.concatenate([subtracted, uncertainty.of_each_log(columns)], axis=-1)
        as_good["set-up"] = Perturbation((uncertainty.project_out(whole, both),))
        recorded = [replace(log, log=one.recorded) for log, one in pairs]
        instead = uncertainty.unmodelled_effects(recorded, uncertainty.join_filtered(recorded), whole)
        as_good |= {f"{name}, no correction": effect for name, effect in instead.items()}
        factor = mean_scale(logs)
        if factor is not None and wrong_torque(prior, beta, factor) is None:
            scaled = moving.change(lambda y: y / factor)
            as_good[SCALE_OF_JOINT_1] = Perturbation((scaled,), rival=True)
    return (moving, as_good) if prior is None else uncertainty.attach_prior(prior, moving, as_good)


def _correct_as(log: Log, logs: Sequence[PreparedLog]) -> Log:
    """Correct a log by the errors that all logs have, with the values of the first, and subtract its terms."""
    first, names = logs[0], [values_of(log.faults) for log in logs]
    common = {name: value for name, value in names[0].items() if all(name in each for each in names)}
    right = correct_calibration(log, common)
    return subtract_terms(right, first.settings, first.load, first.taken) if first.taken else right


def _check_distinct(fitted: Sequence[LoadedLog], validation: Sequence[LoadedLog]) -> None:
    """Refuse a log with the samples of one that is fitted."""
    places = [log.name for log in fitted] + [f"validate: {log.name}" for log in validation]
    for k, one in enumerate((*fitted, *validation)):
        for other in fitted[:k]:
            if np.array_equal(one.log.q, other.log.q) and np.array_equal(one.log.tau, other.log.tau):
                expected = "each log once" if k < len(fitted) else "a log of another motion"
                raise InputError.at(places[k], f"the samples of {other.name}", expected)


def make_problem(
    fitted: Sequence[LoadedLog], validation: Sequence[LoadedLog], arm: Arm, options: Options
) -> IdentificationProblem:
    """Prepare the logs to fit, each by itself, and filter the validation logs as the first."""
    _check_distinct(fitted, validation)
    logs = prepare_logs(fitted, arm, options)
    first = logs[0]
    validation = tuple(replace(loaded, log=_correct_as(loaded.log, logs)) for loaded in validation)
    for loaded in validation:
        check_rate(loaded.log, first.cutoff)
    predicted = tuple((loaded, prepare(loaded.log, first.settings)) for loaded in validation)
    prior = with_plane(options.prior, arm)
    moving, as_good = join_logs(logs, prior)
    regression = joined([log.regression for log in logs])
    excited = excitation(moving)
    return IdentificationProblem(logs, regression, moving, as_good, predicted, excited, arm.delay is None, prior)


def single_problem(problem: IdentificationProblem, log: PreparedLog) -> IdentificationProblem:
    """Give the problem of one of its logs by itself, prepared as it is among the others."""
    moving, as_good = join_logs((log,), problem.prior)
    alone = replace(problem, logs=(log,), regression=log.regression, validation=(), excited=excitation(moving))
    return replace(alone, moving=moving, as_good=as_good)
