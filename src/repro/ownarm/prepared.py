"""Logs made ready: settings chosen from the fitted one, the same for all."""

from dataclasses import dataclass, replace
from pathlib import Path

from repro.errors import InputError
from repro.identification.alternatives import Alternative, alternatives, without
from repro.identification.cutoff import Cutoff, choose_cutoff
from repro.identification.delay import REACH, estimate_delay
from repro.identification.excitation import Excited, excitation
from repro.identification.parallel import FilterSettings, prepare
from repro.identification.regression import Regression
from repro.identification.setup import Fault, columns_of_faults, corrected, find_faults
from repro.identification.solve import solve
from repro.identification.standstill import without_rest, without_standstill
from repro.identification.steepness import choose_steepness
from repro.logs.armfile import Arm
from repro.logs.describe import describe
from repro.logs.description import Description
from repro.logs.log import Log
from repro.logs.reading import read_log
from repro.logs.speed import period
from repro.logs.uniform import uniform
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
    """

    log: Log
    description: Description


@dataclass(frozen=True)
class Problem:
    """What the methods solve and are judged by.

    Attributes
    ----------
    fitted : Told
        The log to fit.
    regression : Regression
        Made of it, all samples but of joints that never move: what methods are judged on.
    moving : Regression
        The same without standstill: what methods are fitted to.
    as_good : dict of Alternative
        As `moving`, by what could have been chosen otherwise.
    others : tuple of (Told, Regression)
        Logs to predict.
    settings : FilterSettings
        Of all of them.
    cutoff : Cutoff
        How the cut-off was chosen.
    excited : Excited
        What the motion tells about the parameters.
    delay_was_found : bool
        Whether the delay was looked for in the log.
    faults : tuple of Fault
        What the set-up gets wrong: the logs here are put right.
    """

    fitted: Told
    regression: Regression
    moving: Regression
    as_good: dict[str, Alternative]
    others: tuple[tuple[Told, Regression], ...]
    settings: FilterSettings
    cutoff: Cutoff
    excited: Excited
    delay_was_found: bool
    faults: tuple[Fault, ...] = ()


def read(path: Path, arm: Arm) -> Told:
    """Read and describe a log."""
    raw = read_log(path, arm)
    description = describe(raw, arm)
    log = uniform(raw)
    fresh = tuple(note for note in log.notes if note not in description.notes)
    return Told(log, replace(description, notes=description.notes + fresh))


def _choose(log: Log, arm: Arm, options: Options) -> tuple[FilterSettings, Cutoff, float]:
    """Cut-off, lambda and delay where they are not given, and the standard error of the delay."""
    settings = FilterSettings(name=options.filter, delay=arm.delay or 0.0)
    if arm.friction_steepness is not None:
        settings = replace(settings, friction_steepness=arm.friction_steepness)
    chosen = choose_cutoff(log, settings)
    if options.cutoff is not None:
        chosen = replace(chosen, hertz=options.cutoff, reason="given by the user")
    settings = replace(settings, cutoff=chosen.hertz)
    rate = 1.0 / period(log)
    if chosen.hertz > 0.25 * rate:
        expected = f"at least four times the cut-off of {chosen.hertz:.3g} Hz"
        raise InputError.at(f"{log.name}: rate", f"{rate:.4g} Hz", expected)
    if arm.friction_steepness is None:
        settings = replace(settings, friction_steepness=choose_steepness(log, settings))
    if arm.delay is not None:
        return settings, chosen, 0.0
    delay, late = estimate_delay(log, settings)
    return replace(settings, delay=delay), chosen, late


def make_problem(fitted: Told, others: tuple[Told, ...], arm: Arm, options: Options) -> Problem:
    """Put right what the set-up gets wrong, choose what is not given, and filter all logs alike."""
    settings, chosen, late = _choose(fitted.log, arm, options)
    faults: tuple[Fault, ...] = ()
    for _ in range(2):  # the delay is found better on a log that is put right, and faults with the right delay
        faults = find_faults(fitted.log, settings)
        values = {fault.name: fault.value for fault in faults}
        if not faults:
            break
        settings, chosen, late = _choose(corrected(fitted.log, values), arm, options)
    fitted, *rest = (replace(told, log=corrected(told.log, values)) for told in (fitted, *others))
    others = tuple(rest)
    for told in others:
        rate = 1.0 / period(told.log)
        if chosen.hertz > 0.25 * rate:
            expected = f"at least four times the cut-off of {chosen.hertz:.3g} Hz"
            raise InputError.at(f"{told.log.name}: rate", f"{rate:.4g} Hz", expected)
    predicted = tuple((told, prepare(told.log, settings)) for told in others)
    regression = without_rest(prepare(fitted.log, settings))
    moving = without_standstill(regression)
    as_good = alternatives(fitted.log, settings, late)
    if faults:
        columns = columns_of_faults(fitted.log, settings, solve(moving.y, moving.tau), faults)
        as_good["set-up"] = Alternative((without(moving, columns),))
    return Problem(
        fitted,
        regression,
        moving,
        as_good,
        predicted,
        settings,
        chosen,
        excitation(moving),
        arm.delay is None,
        faults,
    )


def delay_at_limit(problem: Problem) -> bool:
    """Whether the delay was found at the end of what is looked at."""
    return problem.delay_was_found and abs(problem.settings.delay) >= 0.99 * REACH
