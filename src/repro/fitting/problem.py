"""The problem that the methods solve: one regression of all logs to fit, and what else is as plausible."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from repro.errors import InputError
from repro.fitting.link_length import LinkLength, link_length
from repro.fitting.prepare import LoadedLog, Options, PreparedLog, check_rate, mean_scale, prepare_logs, wrong_torque
from repro.fitting.prior import with_plane
from repro.identification import uncertainty
from repro.identification.armfile import Arm
from repro.identification.calibration import (
    CALIBRATION,
    calibration_limits,
    correct_calibration,
    find_calibration_errors,
)
from repro.identification.excitation import Identifiability, excitation
from repro.identification.extra_terms import subtract_terms, term_columns, values_of
from repro.identification.filtering import prepare
from repro.identification.log import Log
from repro.identification.regression import Prior, Regression, joined, mean_variance, moving_fraction, solve
from repro.identification.uncertainty import Perturbation, WeightedLog
from repro.logs.conventions import smoothed

#: Range of a joint in other logs over that in a log, below which they cannot predict it: there it only holds its place.
MIN_RANGE_RATIO = 0.1
#: Name of the perturbation that corrects the torque of joint 1 instead of that of joint 2, if either may be wrong.
SCALE_OF_JOINT_1 = "scale of joint 1"


@dataclass(frozen=True)
class IdentificationProblem:
    """The regressions that the methods solve and are evaluated on."""

    logs: tuple[PreparedLog, ...]  # the logs to fit, each with its own filters
    regression: Regression  # all of them together
    without_standstill: Regression  # the same for fits: standstill masked, and subtracted terms projected out
    perturbations: dict[str, Perturbation]  # `without_standstill` under other plausible choices of the analysis
    validation: tuple[tuple[LoadedLog, Regression], ...]  # logs to predict, corrected and filtered as the first log
    excited: Identifiability  # which parameters the motion identifies
    estimates_delay: bool  # whether the delay is estimated from the log
    prior: Prior | None = None  # of the parameters
    length: LinkLength | None = None  # of link 1, where the arm file states it

    @cached_property
    def left_out(self) -> tuple[tuple[PreparedLog, Regression], ...]:
        """Each of several logs with a fit of the others, if they move its joints and determine what all do."""
        pairs = []
        for log in self.logs if len(self.logs) > 1 else ():
            others = [other for other in self.logs if other is not log]
            regressions = [other.without_standstill for other in others]
            rest = join_logs(others, self.prior)[0] if self.prior else joined(regressions, _weights(others))
            moved = np.ptp(rest.q, axis=1) >= MIN_RANGE_RATIO * np.ptp(log.regression.q, axis=1)
            if moved.all() and excitation(rest).rank == self.excited.rank:
                pairs.append((log, rest))
        return tuple(pairs)

    @property
    def halves(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Rows of the first half of each log, and of the second."""
        ends = np.cumsum([log.regression.t.size for log in self.logs])
        parts = [np.array_split(rows, 2) for rows in np.split(np.arange(ends[-1]), ends[:-1])]
        first, second = (np.concatenate(half) for half in zip(*parts, strict=True))
        return first, second

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
    regressions = [log.without_standstill for log in logs]
    errors = [float(np.sqrt(mean_variance(r, solve(r.y, r.tau)))) for r in regressions]
    return [min(1.0, MAX_ERROR_RATIO * min(errors) / error) if error > 0.0 else 1.0 for error in errors]


def join_logs(logs: Sequence[PreparedLog], prior: Prior | None = None) -> tuple[Regression, dict[str, Perturbation]]:
    """Join several logs and a prior to one regression without standstill, and its perturbations."""
    regression, perturbations = _join_logs(logs, prior)
    if prior is None:
        return regression, perturbations
    return uncertainty.attach_prior(prior, regression, perturbations)


def _join_logs(logs: Sequence[PreparedLog], prior: Prior | None) -> tuple[Regression, dict[str, Perturbation]]:
    """Join several logs; the prior decides only which torque constant is wrong."""
    weights = _weights(logs)
    weighted = [
        WeightedLog(log.corrected, log.settings, weight, moving_fraction(log.regression), log.taken, log.load)
        for log, weight in zip(logs, weights, strict=True)
    ]
    pairs = list(zip(weighted, logs, strict=True))
    # The values of what was subtracted have errors, so that its columns are projected out.
    unprojected = joined([log.without_standstill for log in logs], weights)
    subtracted = uncertainty.columns_of_terms(weighted)
    regression = uncertainty.project_out(unprojected, subtracted)
    perturbations = uncertainty.perturbations(weighted, regression, max(log.delay_error for log in logs))
    if any(log.calibration_errors for log in logs):
        beta = solve(regression.y, regression.tau)
        columns = [
            log.weight * term_columns(CALIBRATION, log.log, log.settings, beta, prepared.calibration_errors)
            for log, prepared in pairs
        ]
        columns_of_all = np.concatenate([subtracted, uncertainty.of_each_log(columns)], axis=-1)
        perturbations["calibration"] = Perturbation((uncertainty.project_out(unprojected, columns_of_all),))
        recorded = [replace(log, log=prepared.recorded) for log, prepared in pairs]
        instead = uncertainty.unmodelled_effects(recorded, uncertainty.join_filtered(recorded), regression)
        perturbations |= {f"{name}, no correction": effect for name, effect in instead.items() if effect.rival}
        factor = mean_scale(logs)
        if factor is not None and wrong_torque(prior, beta, factor) is None:
            scaled = regression.change(lambda y: y / factor)
            perturbations[SCALE_OF_JOINT_1] = Perturbation((scaled,), rival=True)
    return regression, perturbations


def _correct_as(log: Log, logs: Sequence[PreparedLog]) -> Log:
    """Correct a log by the errors that all logs have, with the values of the first, and subtract its terms.

    An error that this log would show by itself, and does not, is one of the other logs alone.
    """
    first, values = logs[0], [values_of(log.calibration_errors) for log in logs]
    common = {name: value for name, value in values[0].items() if all(name in of_log for of_log in values)}
    if common and log.tau.any():
        found = values_of(find_calibration_errors(log, first.settings))
        limits = calibration_limits(log, first.settings, ())
        for name, value in [*common.items()]:
            limit = limits.get(name)
            if name not in found and limit is not None and limit < abs(value - CALIBRATION[name[:-1]].neutral):
                del common[name]
    corrected = correct_calibration(log, common)
    return subtract_terms(corrected, first.settings, first.load, first.taken) if first.taken else corrected


def _check_distinct(fitted: Sequence[LoadedLog], validation: Sequence[LoadedLog]) -> None:
    """Refuse a log with the samples of one that is fitted."""
    places = [log.name for log in fitted] + [f"validate: {log.name}" for log in validation]
    for k, loaded in enumerate((*fitted, *validation)):
        for earlier in fitted[:k]:
            if np.array_equal(loaded.log.q, earlier.log.q) and np.array_equal(loaded.log.tau, earlier.log.tau):
                expected = "each log once" if k < len(fitted) else "a log of another motion"
                raise InputError.at(places[k], f"the samples of {earlier.name}", expected)


def _set_apart(
    fitted: Sequence[LoadedLog], validation: Sequence[LoadedLog]
) -> tuple[Sequence[LoadedLog], Sequence[LoadedLog]]:
    """Leave logs whose torques are noise to validation, if others can be fitted: they would shrink every estimate."""
    noise = [len(smoothed(loaded.log).noisy_joints()) == len(loaded.log.tau) for loaded in fitted]
    if all(noise):
        return fitted, validation
    pairs = list(zip(fitted, noise, strict=True))
    without_torque = [log for log, is_noise in pairs if is_noise]
    return [log for log, is_noise in pairs if not is_noise], [*validation, *without_torque]


def make_problem(
    fitted: Sequence[LoadedLog], validation: Sequence[LoadedLog], arm: Arm, options: Options
) -> IdentificationProblem:
    """Prepare the logs to fit, each by itself, and filter the validation logs as the first."""
    _check_distinct(fitted, validation)
    fitted, validation = _set_apart(fitted, validation)
    logs = prepare_logs(fitted, arm, options)
    first = logs[0]
    validation = tuple(replace(loaded, log=_correct_as(loaded.log, logs)) for loaded in validation)
    for loaded in validation:
        check_rate(loaded.log, first.cutoff)
    predicted = tuple((loaded, prepare(loaded.log, first.settings)) for loaded in validation)
    prior = with_plane(options.prior, arm)
    without_standstill, perturbations = _join_logs(logs, prior)
    length = link_length(arm, without_standstill, perturbations)
    if length is not None and length.relation is not None:
        prior = replace(prior or Prior(), relations=(length.relation,))
    if prior is not None:
        without_standstill, perturbations = uncertainty.attach_prior(prior, without_standstill, perturbations)
    return IdentificationProblem(
        logs=logs,
        regression=joined([log.regression for log in logs]),
        without_standstill=without_standstill,
        perturbations=perturbations,
        validation=predicted,
        excited=excitation(without_standstill),
        estimates_delay=arm.delay is None,
        prior=prior,
        length=length,
    )


def single_problem(problem: IdentificationProblem, log: PreparedLog) -> IdentificationProblem:
    """Give the problem of one of its logs by itself, prepared as it is among the others."""
    regression, perturbations = join_logs((log,), problem.prior)
    alone = replace(problem, logs=(log,), regression=log.regression, validation=(), excited=excitation(regression))
    return replace(alone, without_standstill=regression, perturbations=perturbations)
