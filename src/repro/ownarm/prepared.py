"""Logs made ready: settings chosen from the fitted one, the same for all."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from repro.errors import InputError
from repro.identification.excitation import Identifiability, excitation
from repro.identification.extra_terms import (
    CALIBRATION,
    FRICTION,
    CalibrationError,
    FrictionTerm,
    calibration_limits,
    correct_calibration,
    find_calibration_errors,
    find_friction,
    subtract_friction,
    term_columns,
    values_of,
)
from repro.identification.filtering import (
    MAX_DELAY,
    Cutoff,
    FilterSettings,
    choose_cutoff,
    choose_steepness,
    estimate_delay,
    prepare,
)
from repro.identification.regression import Regression, drop_idle_joints, drop_standstill, joined, joint_variance
from repro.identification.sensitivity import Perturbation, perturbations, project_out
from repro.identification.solve import solve
from repro.logs.armfile import Arm
from repro.logs.conventions import quiet_joints
from repro.logs.diagnostics import Description, describe
from repro.logs.load import read_log
from repro.logs.log import Log, period
from repro.logs.uniform import uniform
from repro.model.parameters import Array
from repro.ownarm.settings import Options


@dataclass(frozen=True)
class Told:
    """A log and what is said about it.

    Attributes
    ----------
    log : Log
        Evenly sampled.
    description : Description
        Of the log as it was recorded.
    recorded : Log or None
        Before it was evenly sampled, where that is known.
    """

    log: Log
    description: Description
    recorded: Log | None = None


@dataclass(frozen=True)
class Ready:
    """One log that is fitted, put right and filtered.

    Attributes
    ----------
    told : Told
        The log, with what the set-up gets wrong put right.
    regression : Regression
        Made of it, all samples but of joints that never move: what methods are judged on.
    moving : Regression
        The same without standstill: what methods are fitted to.
    as_good : dict of Perturbation
        As `moving`, by what could have been chosen otherwise.
    settings : FilterSettings
        Its filters and delay.
    cutoff : Cutoff
        How the cut-off was chosen.
    faults : tuple of CalibrationError
        What the set-up got wrong.
    hidden : dict of str to float or None
        What else it could get wrong unseen, and up to which size, see `calibration_limits`.
    terms : tuple of FrictionTerm
        Friction beyond Eq. 1; that taken is out of the torque of `told`, and projected out of `moving`.
    load : array of shape (9,) or None
        Parameters that give the load of that friction.
    doubt : str
        Why no interval of what this log gives alone is claimed; empty where it is.
    """

    told: Told
    regression: Regression
    moving: Regression
    as_good: dict[str, Perturbation]
    settings: FilterSettings
    cutoff: Cutoff
    faults: tuple[CalibrationError, ...] = ()
    hidden: dict[str, float | None] = field(default_factory=dict)
    terms: tuple[FrictionTerm, ...] = ()
    load: Array | None = None
    doubt: str = ""


@dataclass(frozen=True)
class Problem:
    """What the methods solve and are judged by.

    Attributes
    ----------
    logs : tuple of Ready
        The logs to fit, each with filters of its own.
    regression, moving : Regression
        Of all of them together; in `moving` each log counts as its errors are small.
    as_good : dict of Perturbation
        As `moving`.
    others : tuple of (Told, Regression)
        Logs to predict, with the filters of the first log and put right as it was.
    excited : Identifiability
        What the motion tells about the parameters.
    delay_was_found : bool
        Whether the delay was looked for in the log.
    """

    logs: tuple[Ready, ...]
    regression: Regression
    moving: Regression
    as_good: dict[str, Perturbation]
    others: tuple[tuple[Told, Regression], ...]
    excited: Identifiability
    delay_was_found: bool

    @property
    def doubt(self) -> str:
        """Why no interval is claimed; empty where one of the logs is beyond doubt."""
        return self.logs[0].doubt if all(log.doubt for log in self.logs) else ""

    @property
    def fitted(self) -> Told:
        """The log to fit, the first of them."""
        return self.logs[0].told

    @property
    def settings(self) -> FilterSettings:
        """Filters of the first log."""
        return self.logs[0].settings

    @property
    def cutoff(self) -> Cutoff:
        """How the cut-off of the first log was chosen."""
        return self.logs[0].cutoff


def read(path: Path, arm: Arm) -> Told:
    """Read and describe a log."""
    raw = read_log(path, arm)
    description = describe(raw, arm)
    log = uniform(raw)
    fresh = tuple(note for note in log.notes if note not in description.notes)
    return Told(log, replace(description, notes=description.notes + fresh), raw)


def _check_rate(log: Log, cutoff: Cutoff) -> None:
    """Refuse a log that is sampled too slowly for the cut-off."""
    rate = 1.0 / period(log)
    if cutoff.hertz > 0.25 * rate:
        expected = f"at least four times the cut-off of {cutoff.hertz:.3g} Hz"
        raise InputError.at(f"{log.name}: rate", f"{rate:.4g} Hz", expected)


def _choose(log: Log, arm: Arm, options: Options) -> tuple[FilterSettings, Cutoff, float]:
    """Cut-off, lambda and delay where they are not given, and the standard error of the delay."""
    settings = FilterSettings(name=options.filter, delay=arm.delay or 0.0)
    if arm.friction_steepness is not None:
        settings = replace(settings, friction_steepness=arm.friction_steepness)
    chosen = choose_cutoff(log, settings)
    if options.cutoff is not None:
        chosen = replace(chosen, hertz=options.cutoff, reason="given by the user")
    settings = replace(settings, cutoff=chosen.hertz)
    _check_rate(log, chosen)
    if arm.friction_steepness is None:
        settings = replace(settings, friction_steepness=choose_steepness(log, settings))
    if arm.delay is not None:
        return settings, chosen, 0.0
    delay, late = estimate_delay(log, settings)
    return replace(settings, delay=delay), chosen, late


def make_ready(told: Told, arm: Arm, options: Options, others: Sequence[Regression] = ()) -> Ready:
    """Put right what the set-up gets wrong in a log, choose what is not given, and filter it.

    Other logs of the arm tell what is wrong with one that tells it not of itself.
    """
    settings, chosen, late = _choose(told.log, arm, options)
    faults = find_calibration_errors(told.log, settings, others)
    if faults:  # the delay is found better on a log that is put right, and faults with the right delay
        settings, _, _ = _choose(correct_calibration(told.log, values_of(faults)), arm, options)
        faults = find_calibration_errors(told.log, settings, others)
        told = replace(told, log=correct_calibration(told.log, values_of(faults)))
        settings, chosen, late = _choose(told.log, arm, options)
    hidden = calibration_limits(told.log, settings, faults, others)
    regression = drop_idle_joints(prepare(told.log, settings))
    moving = drop_standstill(regression)
    terms, load = find_friction(told.log, settings, options.friction), solve(moving.y, moving.tau)
    taken = [term for term in terms if term.taken]
    if taken:
        told = replace(told, log=subtract_friction(told.log, settings, load, taken))
        regression = drop_idle_joints(prepare(told.log, settings))
        moving = project_out(drop_standstill(regression), term_columns(FRICTION, told.log, settings, load, taken))
    as_good = perturbations(told.log, settings, late)
    if faults:
        columns = term_columns(CALIBRATION, told.log, settings, solve(moving.y, moving.tau), faults)
        as_good["set-up"] = Perturbation((project_out(moving, columns),))
    doubt = _doubt(told.log, settings.delay, arm)
    return Ready(told, regression, moving, as_good, settings, chosen, faults, hidden, terms, load, doubt)


def _doubt(log: Log, delay: float, arm: Arm) -> str:
    """Where Eq. 1 of a joint says nothing but that terms add up to none, least squares shrinks them all."""
    if quiet := quiet_joints(log):
        return f"the torque of joint {quiet[0]} is little more than noise"
    return "the delay of the torque lies beyond what is looked at" if arm.delay is None and at_limit(delay) else ""


def _all_ready(logs: Sequence[Told], arm: Arm, options: Options) -> tuple[Ready, ...]:
    """Each log by itself; those that show no fault then beside the others, the one that gains most first.

    Beside a log that is wrong a right one looks wrong too: it is looked at again once that is put right.
    """
    ready = [make_ready(told, arm, options) for told in logs]
    left = [k for k, log in enumerate(ready) if not log.faults and len(logs) > 1]
    while left:
        beside = {k: [log.moving for log in ready if log is not ready[k]] for k in left}
        found = {k: find_calibration_errors(logs[k].log, ready[k].settings, beside[k]) for k in left}
        gains = {k: min(fault.after / fault.before for fault in faults) for k, faults in found.items() if faults}
        if not gains:
            break
        most = min(gains, key=gains.__getitem__)
        ready[most] = make_ready(logs[most], arm, options, beside[most])
        left.remove(most)
    return tuple(ready)


def together(logs: Sequence[Ready]) -> tuple[Regression, dict[str, Perturbation]]:
    """Several logs as one regression without standstill, and what could have been chosen otherwise."""
    size = [float(np.sqrt(np.mean(joint_variance(log.moving, solve(log.moving.y, log.moving.tau))))) for log in logs]
    weights = [float(np.mean(size)) / one for one in size]
    as_good = {}
    for name in dict.fromkeys(name for log in logs for name in log.as_good):
        found = [log.as_good.get(name, Perturbation((log.moving,), 0.0)) for log in logs]
        members = max(len(one.regressions) for one in found)
        mixed = [joined([one.regressions[k % len(one.regressions)] for one in found], weights) for k in range(members)]
        as_good[name] = Perturbation(tuple(mixed), max(one.weight for one in found))
    return joined([log.moving for log in logs], weights), as_good


def _as_first(log: Log, first: Ready) -> Log:
    """A log put right, and without the friction, as the first is."""
    right, taken = correct_calibration(log, values_of(first.faults)), [term for term in first.terms if term.taken]
    return subtract_friction(right, first.settings, first.load, taken) if taken and first.load is not None else right


def make_problem(
    fitted: Told, others: tuple[Told, ...], arm: Arm, options: Options, more: tuple[Told, ...] = ()
) -> Problem:
    """Make the logs to fit ready, each for itself, and filter the others as the first."""
    logs = _all_ready((fitted, *more), arm, options)
    first = logs[0]
    others = tuple(replace(told, log=_as_first(told.log, first)) for told in others)
    for told in others:
        _check_rate(told.log, first.cutoff)
    predicted = tuple((told, prepare(told.log, first.settings)) for told in others)
    moving, as_good = together(logs)
    regression = joined([log.regression for log in logs])
    return Problem(logs, regression, moving, as_good, predicted, excitation(moving), arm.delay is None)


def at_limit(delay: float) -> bool:
    """Whether a delay is the end of what is looked at."""
    return abs(delay) >= 0.99 * MAX_DELAY
