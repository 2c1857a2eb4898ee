"""Which method's parameters to use, and warnings about the result as a whole."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from operator import itemgetter

import numpy as np

from repro.errors import option
from repro.fitting.link_length import LinkLength
from repro.fitting.prepare import delay_at_limit
from repro.fitting.problem import IdentificationProblem
from repro.fitting.result import HALVES, Excitation, MethodResult, Parameter, Score
from repro.identification.filtering import MAX_EXPECTED_DELAY, MIN_SIGNAL_TO_NOISE
from repro.identification.least_squares import METHODS
from repro.identification.log import recorded_period
from repro.identification.regression import Regression, solve
from repro.identification.scores import driven, relative_rms


@dataclass(frozen=True)
class Limits:
    """Limits beyond which a result deserves a warning or a note, and those within which errors are equally good."""

    max_condition: float = 100.0  # condition number of the regressor
    max_friction_correlation: float = 0.9  # correlation of viscous and Coulomb friction of a joint
    min_inertia_over_rest: float = 5.0  # RMS torque of inertia over that left unexplained, at both joints
    max_autocorrelation: float = 0.5  # of the residual, one period of the cut-off apart
    max_fit_error: float = 0.25  # relative RMS torque error of the fit
    max_usable_error: float = 0.5  # relative RMS torque error, fit or prediction, of parameters that may be used
    max_prediction_over_fit: float = 2.0  # prediction error over fit error
    max_good_prediction_error: float = 0.1  # relative RMS: up to it `max_prediction_over_fit` does not apply
    max_network_over_best: float = 1.05  # validation error of a network over that of the best least squares
    max_similarity_loss: float = 0.005  # loss of similarity, fraction of 1, up to which fits are equally good
    max_prior_deviation: float = 3.0  # standard deviations of the prior between its mean and the estimate
    min_free_over_known: float = 0.8  # torque error without a known parameter over that with it
    min_delay_s: float = -0.005  # delay of the torque: no drive has one below this
    min_length_s: float = 15.0  # length of the logs together
    max_equal_ratio: float = 1.01  # ratio of errors that are equally good
    max_similar_ratio: float = 1.05  # ratio of errors above which the other method is named


LIMITS = Limits()
EQUAL = 1e-9  # relative difference of two delays that are the same but for rounding
#: What to type for a motion that shows more.
EXCITE = "record the motion that repro excite --arm arm.yaml -o OUT (Python: repro.excite) designs"


def prediction_error(method: MethodResult) -> float:
    """Mean relative RMS torque error over both joints of the validation logs, or else of the halves."""
    scores: Sequence[Score] = method.validation or method.halves
    return float(np.mean([s.relative_rms for s in scores])) if scores else np.inf


def recommend(methods: Sequence[MethodResult]) -> tuple[str, str]:
    """Choose the physically consistent method that predicts unseen data best, and give the reason."""
    consistent = [m for m in methods if m.consistent]
    # Parameters are for use with their intervals, if any method has them.
    able = [m for m in consistent if m.claims_intervals] or consistent or methods
    errors = [prediction_error(m) for m in able]
    if min(errors) == np.inf:
        errors = [float(np.mean(m.fit.relative_rms)) for m in able]
    position = [_position_error(m) for m in able]
    judged = errors if min(position) == np.inf else np.multiply(errors, position).tolist()
    best = next(m for m, error in zip(able, judged, strict=True) if error <= LIMITS.max_equal_ratio * min(judged))
    if not consistent:
        return best.method, "none of the methods gives physically consistent parameters; this one predicts best"
    if len(methods) == 1:
        return best.method, "the only method requested"
    if prediction_error(best) == np.inf:
        remedy = "give a log to judge by: --validate LOG (Python: validate=log)"
        return best.method, f"smallest error on the log it was fitted to; {remedy}"
    halves = best.halves and best.halves[0].log in HALVES
    rest = "each half predicted from the other" if halves else "each log predicted from the others"
    on = "the validation logs" if best.validation else rest
    if judged is errors:
        return best.method, f"smallest mean torque error on {on} among the physically consistent methods"
    what = "smallest product of mean torque error and mean position error over 0.5 s"
    return best.method, f"{what} on {on} among the physically consistent methods{_disagreement(able, best)}"


def _position_error(method: MethodResult) -> float:
    """Mean error of the re-simulated position on the validation logs, rad; infinite without one of each."""
    errors = [score.position_rms or (np.inf, np.inf) for score in method.validation]
    return float(np.mean(errors)) if errors else np.inf


def _disagreement(methods: Sequence[MethodResult], best: MethodResult) -> str:
    """Name the methods with a clearly smaller torque error or position error than the recommended one."""
    found, kinds = [], (("torque", prediction_error, 100.0, "%"), ("position", _position_error, 1.0, "rad"))
    for what, error, factor, unit in kinds:
        other = min(methods, key=error)
        here, there = factor * error(best), factor * error(other)
        if here > LIMITS.max_similar_ratio * there:
            found.append(f"{other.method} has the smaller {what} error, {there:.2g} instead of {here:.2g} {unit}")
    return "".join(f"; {line}" for line in found)


def compare_networks(methods: Sequence[MethodResult], networks: Sequence[str]) -> tuple[MethodResult, ...]:
    """Add a note to each method that runs a network: its validation error against the best of the others."""
    best = min((m for m in methods if m.method not in networks and m.validation), key=prediction_error, default=None)
    return tuple(
        replace(m, notes=(*m.notes, _comparison(m, best))) if best and m.method in networks and m.validation else m
        for m in methods
    )


def _comparison(method: MethodResult, best: MethodResult) -> str:
    ratio = prediction_error(method) / max(prediction_error(best), np.finfo(np.float64).tiny)
    note = f"mean validation error {ratio:.3g} times that of the best least squares ({best.method})"
    if ratio <= LIMITS.max_network_over_best:
        return note
    gap = float(np.mean(method.fit.similarity) - np.mean(best.fit.similarity))
    equal = gap > -LIMITS.max_similarity_loss
    reason = "the similarity that it maximises does not show the difference" if equal else "it fits worse"
    more = "higher" if gap > 0 else "lower"
    return f"{note}; on the fitted log its similarity is {100 * abs(gap):.2g} points {more}: {reason}"


def warnings(
    problem: IdentificationProblem, methods: Sequence[MethodResult], recommended: str, excitation: Excitation
) -> tuple[str, ...]:
    """List what may spoil the result as a whole, one line each: first what an option or the arm file can change."""
    best = next(m for m in methods if m.method == recommended)
    can_be_changed = (
        *_unusable(methods, best),
        *contradicted(problem, best),
        *noisy_cutoff(problem),
        *odd_delay(problem),
    )
    of_logs = (*undriven(problem, best), *disagreeing(problem, best), *_poor_scores(best))
    return (*can_be_changed, *of_logs, *_poor_excitation(excitation, problem, best), *_short(problem))


def unusable(method: MethodResult) -> str:
    """Give the reason not to use the parameters; empty if they can be used. Validation logs count before halves."""
    if not method.consistent:
        return f"the parameters are not physically consistent: {method.why_not_consistent}"
    judged = [score for kind, score in method.scores if kind != "half" or not method.validation]
    worst, where = max((max(score.relative_rms), score.log) for score in judged)
    found = f"Eq. 1 leaves up to {100 * worst:.0f} % of a torque unexplained ({where})"
    return found if worst > LIMITS.max_usable_error else ""


def _unusable(methods: Sequence[MethodResult], best: MethodResult) -> Iterator[str]:
    if reason := unusable(best):
        given = any("consistent" in m.method for m in methods)
        remedy = "" if given else f"; give {option('method', 'weighted-consistent')}"
        yield reason + (": do not use the parameters, nor their URDF and MJCF" if best.consistent else remedy)


def contradicted(problem: IdentificationProblem, method: MethodResult) -> Iterator[str]:
    """Warn of a prior that the log contradicts: of a known parameter, because the torque is rebuilt better without."""
    prior, r, numbers = problem.prior, problem.without_standstill, np.arange(len(method.parameters))
    if prior is None:
        return
    given = float(np.mean(relative_rms(r, np.array([p.estimate for p in method.parameters]))))
    for k in np.flatnonzero(prior.known).tolist():
        free = replace(r, prior=replace(prior, sd=np.where(numbers == k, np.inf, prior.sd)))
        beta = METHODS["ordinary"].estimate(free).beta
        error = float(np.mean(relative_rms(r, beta)))
        if error < LIMITS.min_free_over_known * given:
            p, change = method.parameters[k], f"torque error {100 * error:.3g} instead of {100 * given:.3g} %"
            known = f"{p.name} = {prior.mean[k]:.4g} {p.unit}"
            yield f"the log contradicts {known}, which is given as known: left out it is {beta[k]:.4g} ({change})"
    for k in prior.informative:
        p, mean, sd = method.parameters[k], prior.mean[k], prior.sd[k]
        inside = p.low is not None and p.high is not None and p.low <= mean <= p.high
        if abs(p.estimate - mean) > LIMITS.max_prior_deviation * sd and not inside:
            found = f"{mean:.4g} +- {2.0 * sd:.2g} {p.unit} becomes {p.estimate:.4g}"
            yield f"the log contradicts the prior of {p.name}: {found}; check the prior, or leave {p.name} out of it"


def wrong_length(length: LinkLength | None) -> Iterator[str]:
    """Warn if I2 and g2 contradict the length of link 1: wrong times change inertia, not gravity."""
    if length is None or length.relation is not None:
        return
    found = (
        f"I2 and g2 imply l1 = {length.implied:.3g} m, and the arm file states {length.given:.3g} m, which is left out"
    )
    remedy = "check link_lengths and the unit of time"
    if length.implied > 0.0:
        remedy += f" (times that are {np.sqrt(length.implied / length.given):.2g} times the true ones explain it)"
    yield f"{found}: {remedy}"


def undriven(problem: IdentificationProblem, method: MethodResult) -> Iterator[str]:
    """Warn of joints with next to no torque in a log; one without a drive, whose torque is zero, has a note instead."""
    beta = np.array([parameter.estimate for parameter in method.parameters])
    for log in problem.logs:
        for joint in np.flatnonzero(~driven(log.regression, beta) & log.loaded.log.tau.any(axis=-1)) + 1:
            found = f"joint {joint} has next to no torque in {log.loaded.log.name}"
            reason = f"either the other joint moves it or its torque was not recorded (arm file: columns.tau{joint})"
            yield f"{found}: {reason}; its error is relative to the torques that should cancel"


def _poor_excitation(excitation: Excitation, problem: IdentificationProblem, best: MethodResult) -> Iterator[str]:
    if excitation.rank < 9:
        yield f"the motion determines only {excitation.rank} combinations of the nine parameters: {EXCITE}"
    elif excitation.condition > LIMITS.max_condition:
        found = f"condition number {excitation.condition:.3g}"
        yield f"the motion hardly distinguishes the parameters ({found}): {EXCITE}"
    elif len([p for p in best.parameters[:3] if p.low is not None and not _known(p)]) > 1:
        yield from _weak_inertia(problem.without_standstill, best)
    for joint, correlation in enumerate(excitation.friction_correlation, start=1):
        friction = (best.parameters[4 + joint], best.parameters[6 + joint])
        if abs(correlation) > LIMITS.max_friction_correlation and not all(map(_known, friction)):
            found = f"viscous and Coulomb friction of joint {joint} are hard to distinguish"
            remedy = f"record slow and fast motion in one log, or give {option('method', 'parsimonious')}"
            yield f"{found} (correlation {correlation:.2f}): {remedy}"


def _known(p: Parameter) -> bool:
    """Whether half the interval is below half the estimate."""
    return p.low is not None and p.high is not None and p.high - p.low < abs(p.estimate)


def _weak_inertia(r: Regression, method: MethodResult) -> Iterator[str]:
    """Compare the torque that inertia needs with the one that Eq. 1 leaves unexplained."""
    beta = np.array([p.estimate for p in method.parameters])
    inertia, rest = (np.sqrt(np.mean(x**2, axis=1)) for x in (r.y[..., :3] @ beta[:3], r.tau - r.y @ beta))
    if (inertia < LIMITS.min_inertia_over_rest * rest).any():
        needed, left = (" and ".join(f"{x:.2g}" for x in torques) for torques in (inertia, rest))
        found = f"it makes {needed} N m RMS of the torques, and Eq. 1 leaves {left} N m unexplained"
        yield f"the motion is too slow to determine inertia ({found}): {EXCITE}"


def _poor_scores(method: MethodResult) -> Iterator[str]:
    """Warn of a poor fit, of residuals that are not white, and of predictions much worse than the fit."""
    fit = max(method.fit.relative_rms)
    if fit > LIMITS.max_fit_error:
        found = f"{100 * fit:.3g} % of the torque of joint {method.fit.relative_rms.index(fit) + 1} unexplained"
        remedy = "check units, sign and zero in the arm file; if they are right, unmodelled effects are as large"
        yield f"Eq. 1 leaves {found}: {remedy}"
    if abs(worst := max(method.whiteness, key=abs)) > LIMITS.max_autocorrelation:
        reason = "Eq. 1 does not model this friction or flexibility"
        remedy = f"compare with {option('self-test')}"
        yield f"residuals are far from white (autocorrelation {worst:.2f}): {reason}; {remedy}"
    worst = max((max(s.relative_rms) for s in method.validation), default=0.0)
    if worst > max(LIMITS.max_prediction_over_fit * fit, LIMITS.max_good_prediction_error):
        found = f"reaches {100 * worst:.3g} %, on the fitted log {100 * fit:.3g} %: the logs excite different effects"
        yield f"on the validation logs the torque error {found}; fit both, and validate on a third"
    half = max((max(s.relative_rms) for s in method.halves if s.log in HALVES), default=0.0)
    if half > max(LIMITS.max_prediction_over_fit * fit, LIMITS.max_good_prediction_error):
        found = f"one half of the log predicts the other with a torque error of {100 * half:.0f} %"
        reason = "the log is too short, or something changed during it"
        yield f"{found}: {reason}; record a longer one, or fit several logs"


def disagreeing(problem: IdentificationProblem, method: MethodResult) -> Iterator[str]:
    """Warn of the log that the others predict worst, if it can be fitted much better."""
    pairs = zip(method.halves, problem.left_out, strict=False)  # by place, because two logs may have one name
    left_out = [(max(score.relative_rms), log) for score, (log, _) in pairs if score.log not in HALVES]
    if not left_out:
        return
    predicted, log = max(left_out, key=itemgetter(0))
    regression = log.without_standstill
    alone = max(relative_rms(log.regression, solve(regression.y, regression.tau)))
    if predicted > max(LIMITS.max_prediction_over_fit * alone, LIMITS.max_good_prediction_error):
        found = f"its torque error is {100 * predicted:.3g} % predicted from them, and {100 * alone:.3g} % fitted alone"
        yield f"the log {log.loaded.name} disagrees with the others: {found}; leave it out if the arm changed"


def _short(problem: IdentificationProblem) -> Iterator[str]:
    pieces = [piece for log in problem.logs for piece in log.loaded.log.pieces]
    length = sum(float(piece.t[-1] - piece.t[0]) for piece in pieces)
    if length < LIMITS.min_length_s:
        reason = f"the intervals are reliable from {LIMITS.min_length_s:g} s on"
        yield f"the log is short, {length:.3g} s: {reason}; record more"


def noisy_cutoff(problem: IdentificationProblem) -> Iterator[str]:
    """Warn of a given cut-off at which the position is too near its noise."""
    cutoff = max((log.cutoff for log in problem.logs), key=lambda cutoff: cutoff.hertz / cutoff.by_noise)
    if cutoff.hertz > cutoff.by_noise:
        found = f"above {cutoff.by_noise:.3g} Hz the position is less than {MIN_SIGNAL_TO_NOISE:g} times its noise"
        reason = f"a cut-off of {cutoff.hertz:.3g} Hz biases inertia towards zero"
        yield f"{found}: {reason}; leave --cutoff (Python: cutoff) out, or record larger or faster motion"


def odd_delay(problem: IdentificationProblem) -> Iterator[str]:
    """Warn of a delay that few drives have, that none has, or at the end of the search range."""
    for log in problem.logs if problem.estimates_delay else ():
        where = f" in {log.loaded.log.name}" if len(problem.logs) > 1 else ""
        delay = f"{1e3 * log.settings.delay:.3g} ms"
        if delay_at_limit(log.settings.delay):
            found = f"at the end of the search range ({delay}): check the time stamps"
            yield f"the delay of the torque{where} is {found}, then give delay (s) in the arm file"
        elif log.settings.delay < LIMITS.min_delay_s:
            found = f"the delay of the torque{where} is {delay}, as if it acted before it was recorded"
            reason = "either the stamps of position and torque differ, or the log does not determine it"
            yield f"{found}: {reason} (arm file: delay)"
        elif log.settings.delay >= (most := MAX_EXPECTED_DELAY * recorded_period(log.recorded)) * (1.0 - EQUAL):
            applied = log.settings.delay > most * (1.0 + EQUAL)
            found = f"the torque{where} fits the motion best more than {MAX_EXPECTED_DELAY:g} sampling periods later"
            what = f"{delay} are applied" if applied else f"only {delay} are applied, as the evidence is weak"
            yield f"{found} than recorded: {what}; play, elasticity or ripple look like a delay (arm file: delay)"
