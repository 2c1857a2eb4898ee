"""Which method's parameters to use, and what to beware of."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from repro.identification.scores import driven, relative_rms
from repro.identification.solve import solve
from repro.ownarm.prepared import Problem, at_limit
from repro.ownarm.result import HALVES, Excitation, MethodResult, Score

#: Above these a result deserves a warning: condition number, friction correlation, residual autocorrelation,
#: validation error over fit error, relative RMS error of the fit.
CONDITION, CORRELATION, AUTOCORRELATION, WORSE, POOR = 100.0, 0.9, 0.5, 2.0, 0.3
#: A network whose validation error is more than this times the best least squares' has its reason told; fits whose
#: similarities differ by less than the second are equally good.
WORSE_THAN_BEST, SAME_FIT = 1.05, 0.005
#: A delay below this is no drive's, s.
EARLY = -0.005
#: A log of fewer seconds deserves a warning.
SHORT = 15.0
#: Errors that differ by less than this factor are equally good.
AS_GOOD_AS = 1.01


def prediction_error(method: MethodResult) -> float:
    """Mean relative RMS torque error over both joints of the logs not used, or else of the halves."""
    scores: Sequence[Score] = method.validation or method.halves
    return float(np.mean([s.relative_rms for s in scores])) if scores else np.inf


def fit_error(method: MethodResult) -> float:
    """Mean relative RMS torque error over both joints of the log that was fitted."""
    return float(np.mean(method.fit.relative_rms))


def recommend(methods: Sequence[MethodResult]) -> tuple[str, str]:
    """The physically consistent method that predicts best what it has not seen."""
    consistent = [m for m in methods if m.consistent]
    # Parameters are for use with their intervals, if any method has them.
    able = [m for m in consistent if m.claims_intervals] or consistent or methods
    errors = [prediction_error(m) for m in able]
    if min(errors) == np.inf:
        errors = [fit_error(m) for m in able]
    best = next(m for m, error in zip(able, errors, strict=True) if error <= AS_GOOD_AS * min(errors))
    if not consistent:
        return best.method, "no method asked for gives physically consistent parameters; this one predicts best"
    if len(methods) == 1:
        return best.method, "the only method asked for"
    if prediction_error(best) == np.inf:
        return best.method, "smallest error on the log it was fitted to; give --validate a log to judge by"
    on = "the validation logs" if best.validation else "each half from the other"
    return best.method, f"smallest mean torque error on {on} among the physically consistent methods"


def against_least_squares(methods: Sequence[MethodResult], networks: Sequence[str]) -> tuple[MethodResult, ...]:
    """Add to each method that runs a network how it does beside the best of the others."""
    others = [m for m in methods if m.method not in networks and m.validation]
    if not others:
        return tuple(methods)
    best = min(others, key=prediction_error)
    return tuple(
        replace(m, notes=(*m.notes, _beside(m, best))) if m.method in networks and m.validation else m for m in methods
    )


def _beside(method: MethodResult, best: MethodResult) -> str:
    """How a method's prediction compares with the best least squares', and why it is worse if it is."""
    ratio = prediction_error(method) / max(prediction_error(best), np.finfo(np.float64).tiny)
    note = f"mean validation error {ratio:.3g} times that of the best least squares ({best.method})"
    if ratio <= WORSE_THAN_BEST:
        return note
    gap = float(np.mean(method.fit.similarity) - np.mean(best.fit.similarity))
    why = "the similarity it maximises does not see the difference" if gap > -SAME_FIT else "it fits worse"
    more = "higher" if gap > 0 else "lower"
    return f"{note}; on the log itself its similarity is {100 * abs(gap):.2g} points {more}: {why}"


def _known(method: MethodResult, *places: int) -> bool:
    """Whether a method's intervals of these parameters are small beside the parameters."""
    found = [method.parameters[place] for place in places]
    return all(p.low is not None and p.high is not None and p.high - p.low < abs(p.estimate) for p in found)


def disagreeing(problem: Problem, method: MethodResult) -> list[str]:
    """The log that the others foretell worst, if it is much worse than it can be fitted."""
    left_out = [score for score in method.halves if score.log not in HALVES]
    if not left_out:
        return []
    worst = int(np.argmax([max(score.relative_rms) for score in left_out]))
    log, foretold = problem.logs[worst], max(left_out[worst].relative_rms)
    own = max(relative_rms(log.regression, solve(log.moving.y, log.moving.tau)))
    if foretold <= max(WORSE * own, 0.1):
        return []
    return [
        f"the log {left_out[worst].log} disagrees with the others: foretold by them its torque error is "
        f"{100 * foretold:.3g} %, fitted alone {100 * own:.3g} %"
    ]


def undriven(problem: Problem, method: MethodResult) -> list[str]:
    """Joints that a log holds no torque of."""
    beta = np.array([parameter.estimate for parameter in method.parameters])
    return [
        f"joint {joint} has next to no torque in {log.told.log.name}: the other joint moves it, or its torque was not "
        "recorded; its error is told as a share of the torques that should add up to none"
        for log in problem.logs
        for joint, has in enumerate(driven(log.regression, beta), start=1)
        if not has
    ]


def odd_delay(problem: Problem) -> list[str]:
    """A delay that no drive has, or the end of the range."""
    found = []
    for log in problem.logs if problem.delay_was_found else ():
        where = f" in {log.told.log.name}" if len(problem.logs) > 1 else ""
        late = f"{1e3 * log.settings.delay:.3g} ms"
        if at_limit(log.settings.delay):
            found.append(f"the delay of the torque{where} is at the end of the range looked at ({late})")
        elif log.settings.delay < EARLY:
            found.append(
                f"the delay of the torque{where} is {late}, as if it acted before it was recorded: the stamps of "
                "position and torque differ, or the log tells little of it (arm file: delay)"
            )
    return found


def warnings(problem: Problem, methods: Sequence[MethodResult], recommended: str, told: Excitation) -> tuple[str, ...]:
    """What may spoil the result as a whole, one line each."""
    best = next(m for m in methods if m.method == recommended)
    found = []
    if told.rank < 9:
        found.append(f"the motion determines {told.rank} combinations of the nine parameters only: excite more")
    elif told.condition > CONDITION:
        found.append(
            f"the motion hardly tells the parameters apart (condition number {told.condition:.3g}): excite more"
        )
    found += undriven(problem, best)
    for joint, correlation in enumerate(told.friction_correlation, start=1):
        if abs(correlation) > CORRELATION and not _known(best, 4 + joint, 6 + joint):
            found.append(
                f"viscous and Coulomb friction of joint {joint} are hard to tell apart "
                f"(correlation {correlation:.2f}): log slow and fast motion"
            )
    if max(best.fit.relative_rms) > POOR:
        joint = int(np.argmax(best.fit.relative_rms)) + 1
        found.append(
            f"Eq. 1 leaves {100 * max(best.fit.relative_rms):.3g} % of the torque of joint {joint} unexplained: "
            "units, signs or a zero may be wrong, or what Eq. 1 lacks is as large"
        )
    if max(np.abs(best.whiteness)) > AUTOCORRELATION:
        found.append(
            f"residuals are far from white (autocorrelation {max(best.whiteness, key=abs):.2f}): friction or "
            "flexibility that Eq. 1 does not hold"
        )
    worst = max((max(s.relative_rms) for s in best.validation), default=0.0)
    if worst > max(WORSE * max(best.fit.relative_rms), 0.1):
        found.append(
            f"on logs not used the torque error reaches {100 * worst:.3g} %, on the log itself "
            f"{100 * max(best.fit.relative_rms):.3g} %: the logs excite different things"
        )
    halves = max((max(s.relative_rms) for s in best.halves if s.log in HALVES), default=0.0)
    if halves > max(WORSE * max(best.fit.relative_rms), 0.1):
        found.append(
            f"one half of the log predicts the other with a torque error of {100 * halves:.3g} %: too short a log, or "
            "something changed in it"
        )
    found += disagreeing(problem, best)
    length = sum(float(log.told.log.t[-1] - log.told.log.t[0]) for log in problem.logs)
    if length < SHORT:
        found.append(f"the log is short, {length:.3g} s: with {SHORT:g} s or more the intervals can be trusted")
    found += odd_delay(problem)
    if not best.consistent:
        found.append(f"the parameters are not physically consistent: {best.why_not_consistent}")
    return tuple(found)
