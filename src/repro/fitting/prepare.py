"""Prepare logs: filters chosen, calibration errors corrected, and terms beyond Eq. 1 subtracted."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from repro.errors import InputError
from repro.identification import filtering
from repro.identification.armfile import Arm
from repro.identification.calibration import (
    CANDIDATES,
    SCALE,
    CalibrationError,
    blame_joint_1,
    calibration_limits,
    correct_calibration,
    find_calibration_errors,
)
from repro.identification.decimation import decimated
from repro.identification.extra_terms import STRIBECK, TERMS, ExtraTerm, subtract_terms, term_columns, values_of
from repro.identification.least_squares import METHODS
from repro.identification.log import Log, period, recorded_period, uniform
from repro.identification.regression import Prior, Regression, drop_idle_joints, drop_standstill, joined, solve
from repro.identification.scores import unexplained
from repro.identification.term_selection import choose_friction_curve, find_terms
from repro.logs.conventions import smoothed
from repro.logs.diagnostics import Description, describe, left_out_torque
from repro.logs.load import Source, read_log
from repro.logs.torque_limits import saturated, unreliable_torque
from repro.model.parameters import NAMES, Array


@dataclass(frozen=True)
class Options:
    """Options of `repro identify`."""

    methods: tuple[str, ...]  # names, in the order of the report
    cache: Path  # folder of trained networks
    filter: str = "dct"  # key of `FILTERS`
    cutoff: float | None = None  # Hz; None: chosen from the log
    seed: int = 1  # of the bootstrap, of training and of the search
    steps: int = 1500  # training steps of the CNN
    prior: Prior | None = None  # of the parameters
    friction: bool = True  # whether friction that Eq. 1 does not model is subtracted where the log shows it

    def __post_init__(self) -> None:
        """Refuse what the command line refuses, too."""
        if not isinstance(self.filter, str) or self.filter not in filtering.FILTERS:
            raise InputError.at("filter", repr(self.filter), f"one of {', '.join(filtering.FILTERS)}")
        limits: tuple[tuple[str, Any, float, float], ...] = (
            ("cutoff", (int, float, np.number), 0.1, 1000.0),
            ("seed", (int, np.integer), 0, 2**32 - 1),
            ("steps", (int, np.integer), 1, 10**7),
        )
        for name, kind, low, high in limits:
            value = getattr(self, name)
            number = isinstance(value, kind) and not isinstance(value, bool) and low <= value <= high
            if not number and not (name == "cutoff" and value is None):
                whole = "whole " * (name != "cutoff")
                raise InputError.at(name, repr(value)[:60], f"a {whole}number from {low:g} to {high:.10g}")


@dataclass(frozen=True)
class LoadedLog:
    """A log with its description."""

    log: Log  # evenly sampled, a long one at a lower rate
    description: Description  # of the log as it was recorded
    recorded: Log | None = None  # before it was evenly sampled, where that is known

    @property
    def name(self) -> str:
        """File name."""
        return self.description.name


@dataclass(frozen=True)
class PreparedLog:
    """A fitted log, corrected and filtered; `_finish` subtracts friction and sets the fields after the errors."""

    loaded: LoadedLog  # with calibration errors corrected and friction subtracted
    recorded: Log  # as it was loaded
    regression: Regression  # methods are evaluated on it; `_finish` leaves out joints that never move
    settings: filtering.FilterSettings  # filters and delay
    cutoff: filtering.Cutoff  # how the cut-off was chosen
    delay_error: float  # standard error of the delay, s
    calibration_errors: tuple[CalibrationError, ...] = ()  # those that were corrected
    calibration_limits: dict[str, float | None] = field(default_factory=dict)  # detection limits of the other errors
    terms: tuple[ExtraTerm, ...] = ()  # terms beyond Eq. 1, of all logs of the arm
    load: Array = field(default_factory=lambda: np.zeros(len(NAMES)))  # parameters that give the load of friction
    doubt: str = ""  # why no interval is claimed from this log alone; empty if it is

    @cached_property
    def without_standstill(self) -> Regression:
        """The regression without standstill."""
        return drop_standstill(self.regression)

    @property
    def corrected(self) -> Log:
        """The log with calibration errors corrected and the torque of the terms beyond Eq. 1."""
        return correct_calibration(self.recorded, values_of(self.calibration_errors))

    @property
    def taken(self) -> list[ExtraTerm]:
        """Terms that were subtracted from the torque."""
        return [term for term in self.terms if term.taken]

    def change(self, log: Log, **changes: Any) -> "PreparedLog":  # noqa: ANN401
        """Replace the log and other fields, and filter it with them."""
        changed = replace(self, loaded=replace(self.loaded, log=log), **changes)
        return replace(changed, regression=filtering.prepare(log, changed.settings))

    def delayed(self, delay: float, error: float) -> "PreparedLog":
        """Replace the delay and its standard error."""
        return self.change(self.loaded.log, settings=replace(self.settings, delay=delay), delay_error=error)


def load_log(source: Source, arm: Arm) -> LoadedLog:
    """Read and describe a log."""
    raw = read_log(source, arm)
    description = describe(raw, arm)
    log = uniform(raw)
    if (wrong := unreliable_torque(log)).any():
        log = replace(log, left_out=wrong)
    log = decimated(log)
    fresh = tuple(note for note in log.notes if note not in description.notes)
    warnings = (*description.warnings, *left_out_torque(log))
    return LoadedLog(log, replace(description, notes=description.notes + fresh, warnings=warnings), raw)


GIVEN = "given by the user"  # why a cut-off is the user's


def check_rate(log: Log, cutoff: filtering.Cutoff) -> None:
    """Refuse a log that is sampled too slowly for the cut-off."""
    rate, hertz = f"{1.0 / period(log):.4g} Hz", f"{cutoff.hertz:.3g} Hz"
    if cutoff.hertz > 0.25 * (1.0 / period(log)):
        if cutoff.reason == GIVEN:
            raise InputError.at("cutoff", hertz, f"at most a quarter of the {rate} of {log.name}")
        raise InputError.at(f"{log.name}: rate", rate, f"at least four times the cut-off of {hertz}")


@dataclass(frozen=True)
class _Common:
    """What logs of one arm have in common."""

    hertz: float  # cut-off: the lowest of the logs, as a row must mean the same in each
    friction_steepness: float  # lambda of Eq. 1, s/rad
    delay: float  # of the torque, s
    delay_error: float
    names: tuple[str, ...]  # of the calibration errors that a log is searched for


def _lowered(chosen: filtering.Cutoff, hertz: float) -> filtering.Cutoff:
    """Lower a cut-off to that of another log."""
    return replace(chosen, hertz=hertz, reason="the lowest cut-off of the logs") if hertz < chosen.hertz else chosen


def _choose_settings(
    log: Log, arm: Arm, options: Options, common: _Common | None = None
) -> tuple[filtering.FilterSettings, filtering.Cutoff, float]:
    """Choose cut-off, lambda and delay where they are not given; also the standard error of the delay."""
    even_odd = any(METHODS[name].needs_even_odd for name in options.methods if name in METHODS)
    settings = filtering.FilterSettings(name=options.filter, delay=arm.delay or 0.0, even_odd=even_odd)
    if arm.friction_steepness is not None:
        settings = replace(settings, friction_steepness=arm.friction_steepness)
    chosen = filtering.choose_cutoff(log, settings)
    if options.cutoff is not None:
        chosen = replace(chosen, hertz=options.cutoff, reason=GIVEN)
    elif common is not None:
        chosen = _lowered(chosen, common.hertz)
    # Noise above the cut-off biases estimates where it enters sines and signs: a given cut-off needs no wider filter.
    width = float(np.clip(settings.width * chosen.by_noise / chosen.hertz, 1.0, settings.width))
    settings = replace(settings, cutoff=chosen.hertz, width=width)
    check_rate(log, chosen)
    if arm.friction_steepness is None:
        steepness = common.friction_steepness if common else filtering.choose_steepness([(log, settings)])
        settings = replace(settings, friction_steepness=steepness)
    if arm.delay is not None:
        return settings, chosen, 0.0
    delay, error = (common.delay, common.delay_error) if common else filtering.estimate_delay(log, settings)
    return replace(settings, delay=delay), chosen, error


def _correct(
    loaded: LoadedLog, arm: Arm, options: Options, others: Sequence[Regression] = (), common: _Common | None = None
) -> PreparedLog:
    """Correct the calibration errors of a log; regressions of other logs of the arm reveal some and contradict some."""
    recorded = loaded.log
    settings, chosen, delay_error = _choose_settings(recorded, arm, options, common)
    names = common.names if common else CANDIDATES
    errors = find_calibration_errors(recorded, settings, others, names)
    if errors:  # the delay is estimated better from a corrected log, and the errors better with the right delay
        settings, _, _ = _choose_settings(correct_calibration(recorded, values_of(errors)), arm, options, common)
        errors = find_calibration_errors(recorded, settings, others, names)
        loaded = replace(loaded, log=correct_calibration(recorded, values_of(errors)))
        settings, chosen, delay_error = _choose_settings(loaded.log, arm, options, common)
    return PreparedLog(loaded, recorded, filtering.prepare(loaded.log, settings), settings, chosen, delay_error, errors)


def _finish(
    log: PreparedLog, arm: Arm, terms: tuple[ExtraTerm, ...], load: Array, others: Sequence[Regression]
) -> PreparedLog:
    """Subtract the terms beyond Eq. 1 from a corrected log."""
    limits = calibration_limits(log.loaded.log, log.settings, log.calibration_errors, others)
    log = replace(log, calibration_limits=limits, terms=terms, load=load)
    if log.taken:
        log = log.change(subtract_terms(log.loaded.log, log.settings, load, log.taken))
    log = replace(log, regression=drop_idle_joints(log.regression))
    return replace(log, doubt=_interval_doubt(log, arm))


#: Fraction of a joint's squared torque that Eq. 1 must predict for intervals to be claimed, and largest product of both
#: joints' squared errors over those with friction alone.
MIN_EXPLAINED, MAX_OVER_FRICTION = 0.5, 0.5
#: Fraction of the samples of a torque at its limit above which no interval is claimed, if Eq. 1 leaves more than the
#: second fraction of the squared torque: the rest shows too little of what acted.
MAX_SATURATED, MAX_LEFT_SATURATED = 0.5, 0.04
FRICTION = slice(NAMES.index("b1"), None)


def delay_at_limit(delay: float) -> bool:
    """Whether a delay is at the end of the search range."""
    return abs(delay) >= 0.99 * filtering.MAX_DELAY


def _interval_doubt(log: PreparedLog, arm: Arm) -> str:
    """Find a reason to claim no intervals."""
    left, by_friction = unexplained(log.without_standstill), unexplained(log.without_standstill, FRICTION)
    worst = int(np.argmax(left))
    # Where Eq. 1 predicts little, the motion is not the one that this torque caused, or unmodelled effects caused it.
    if left[worst] > 1.0 - MIN_EXPLAINED:
        if quiet := smoothed(log.loaded.log).noisy_joints():  # rows of noise bias every estimate towards zero
            return f"the torque of joint {quiet[0]} is little more than noise"
        explained = f"{max(100.0 * (1.0 - left[worst]), 0.0):.0f} % of the squared torque of joint {worst + 1}"
        return f"Eq. 1 predicts only {explained} from the rest of the log"
    # A corrected torque has no limit, nor has the mean of several samples.
    at_limit = saturated(log.loaded.recorded or log.recorded).mean(axis=-1)
    worst = int(np.argmax(at_limit))
    if at_limit[worst] > MAX_SATURATED and left[worst] > MAX_LEFT_SATURATED:
        return f"the torque of joint {worst + 1} is at its limit in {100.0 * at_limit[worst]:.0f} % of the samples"
    # A torque that only compensates friction is explained without inertia and gravity, whatever they are.
    if np.prod(left[left > 0.0] / by_friction[left > 0.0]) > MAX_OVER_FRICTION:
        return "friction alone explains the torque nearly as well as Eq. 1"
    late = arm.delay is None and delay_at_limit(log.settings.delay)
    return "the delay of the torque is beyond the search range" if late else ""


def _in_common(logs: Sequence[PreparedLog], arm: Arm) -> _Common:
    """Find what several logs of an arm have in common."""
    # A torque constant is the arm's: its error counts if no log contradicts it that would show it by itself.
    factor = mean_scale(logs)
    without_scale = [log for log in logs if SCALE not in values_of(log.calibration_errors)]
    limits = (calibration_limits(log.loaded.log, log.settings, log.calibration_errors)[SCALE] for log in without_scale)
    scaled = factor is not None and not any(limit is not None and limit < abs(factor - 1.0) for limit in limits)
    names = tuple(name for name in CANDIDATES if scaled or name != SCALE)
    hertz = min(log.settings.cutoff for log in logs)
    pairs = [(log.loaded.log, replace(log.settings, cutoff=hertz)) for log in logs]
    return _Common(hertz, arm.friction_steepness or filtering.choose_steepness(pairs), *_common_delay(logs), names)


def _common_delay(logs: Sequence[PreparedLog]) -> tuple[float, float]:
    """Weigh the delays of several logs by their precision; their scatter widens the error (Birge)."""
    delay = np.array([log.settings.delay for log in logs])
    weight = 1.0 / np.array([max(log.delay_error, recorded_period(log.recorded) / 10.0) for log in logs]) ** 2
    mean = float(np.average(delay, weights=weight))
    birge = float(np.sum(weight * (delay - mean) ** 2)) / (len(logs) - 1)
    return mean, float(np.sqrt(max(birge, 1.0) / weight.sum()))


def _estimate_delay_again(logs: Sequence[PreparedLog], terms: Sequence[ExtraTerm], load: Array) -> list[PreparedLog]:
    """Estimate the delay next to terms beyond Eq. 1: without them it compensates for a part of them."""
    again = []
    for log in logs:
        columns = term_columns(TERMS, log.loaded.log, log.settings, load, terms)
        again.append(log.delayed(*filtering.estimate_delay(log.loaded.log, log.settings, columns)))
    return again if len(logs) == 1 else [log.delayed(*_common_delay(again)) for log in again]


def _with_friction_curve(logs: Sequence[PreparedLog], steepness: Sequence[float]) -> list[PreparedLog]:
    """Choose the speed of Stribeck friction and one of these values of lambda."""
    best, speed = choose_friction_curve([(log.loaded.log, log.settings) for log in logs], steepness)
    settings = [replace(log.settings, friction_steepness=best, stribeck_speed=speed) for log in logs]
    return [log.change(log.loaded.log, settings=changed) for log, changed in zip(logs, settings, strict=True)]


#: Relative error of an estimate that is compared with a prior, and smallest difference of squared errors that decides.
COMPARED_ERROR, MIN_DECISIVE_DIFFERENCE = 0.05, 4.0


def mean_scale(logs: Sequence[PreparedLog]) -> float | None:
    """Mean scale of the torque of joint 2 of the logs that have one; None without any."""
    values = [error.value for log in logs for error in log.calibration_errors if error.name == SCALE]
    return float(np.mean(values)) if values else None


def wrong_torque(prior: Prior | None, beta: Array, factor: float) -> int | None:
    """Decide by a prior which joint's torque constant is wrong, None if it cannot; `factor` is that of joint 2."""
    # If it is that of joint 1 after all, all parameters are `factor` times those of the log with joint 2 corrected.
    if prior is None:
        return None
    compared = np.flatnonzero((np.isfinite(prior.sd) & (prior.mean != 0.0))[:5])
    sd = np.hypot(prior.sd, COMPARED_ERROR * prior.mean)[compared]
    second, first = (float(np.sum(((size * beta - prior.mean)[compared] / sd) ** 2)) for size in (1.0, factor))
    return None if abs(second - first) < MIN_DECISIVE_DIFFERENCE else 1 if first < second else 2


def _find_terms(logs: Sequence[PreparedLog], options: Options) -> tuple[tuple[ExtraTerm, ...], Array]:
    """Find the terms beyond Eq. 1 of all logs; also the parameters that give the load of friction."""
    return find_terms([(log.loaded.log, log.settings) for log in logs], options.friction)


def prepare_logs(logs: Sequence[LoadedLog], arm: Arm, options: Options) -> tuple[PreparedLog, ...]:
    """Prepare the logs of one arm, which has one delay, lambda, cut-off and set of terms beyond Eq. 1.

    Each log is corrected by itself, then compared with the others: first those with calibration errors, which the
    others may contradict, then those without. Of these the log whose correction reduces the error most comes first: an
    uncorrected log can make a good one look faulty.
    """
    corrected = [_correct(loaded, arm, options) for loaded in logs]
    common, remaining = _in_common(corrected, arm) if len(logs) > 1 else None, list[int]()

    def others(log: PreparedLog) -> list[Regression]:
        return [other.without_standstill for other in corrected if other is not log]

    def compare(k: int) -> PreparedLog:
        return _correct(logs[k], arm, options, others(corrected[k]), common)

    if common is not None:
        corrected = [_correct(loaded, arm, options, (), common) for loaded in logs]
        for k in [k for k, log in enumerate(corrected) if log.calibration_errors]:
            corrected[k] = compare(k)
        remaining = [k for k, log in enumerate(corrected) if not log.calibration_errors]
    while remaining:
        compared = {k: compare(k) for k in remaining}
        gains = {
            k: min(error.after / error.before for error in log.calibration_errors)
            for k, log in compared.items()
            if log.calibration_errors
        }
        if not gains:
            break
        most = min(gains, key=gains.__getitem__)
        corrected[most] = compared[most]
        remaining.remove(most)
    hertz = min(log.settings.cutoff for log in corrected)  # a corrected log may need a lower one
    for k, log in enumerate(corrected):
        if (lowered := _lowered(log.cutoff, hertz)) is not log.cutoff:
            corrected[k] = log.change(log.loaded.log, settings=replace(log.settings, cutoff=hertz), cutoff=lowered)
    regression, factor = joined([log.without_standstill for log in corrected]), mean_scale(corrected)
    if factor is not None and wrong_torque(options.prior, solve(regression.y, regression.tau), factor) == 1:
        for k, log in enumerate(corrected):
            errors = blame_joint_1(log.calibration_errors)
            corrected[k] = log.change(correct_calibration(log.recorded, values_of(errors)), calibration_errors=errors)
    if options.friction:
        corrected = _with_friction_curve(corrected, [corrected[0].settings.friction_steepness])
    terms, load = _find_terms(corrected, options)
    if arm.friction_steepness is None and any(term.taken and term.kind == STRIBECK for term in terms):
        corrected = _with_friction_curve(corrected, filtering.STEEPNESS_GRID)
        terms, load = _find_terms(corrected, options)
    if arm.delay is None and (taken := [term for term in terms if term.taken]):
        corrected = _estimate_delay_again(corrected, taken, load)
        terms, load = _find_terms(corrected, options)
    return tuple(_finish(log, arm, terms, load, others(log)) for log in corrected)
