"""One method on one problem: its parameters, how sure they are, and how well they predict."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from repro.identification.bootstrap import Uncertainty, bootstrap
from repro.identification.excitation import MIN_TORQUE_FRACTION, torque_fraction
from repro.identification.method import Estimate, Method
from repro.identification.regression import Regression, residual_autocorrelation
from repro.identification.scores import relative_rms, similarity
from repro.model.parameters import DESCRIPTIONS, NAMES, UNITS, Array, is_positive_definite
from repro.ownarm.prepared import Problem, together
from repro.ownarm.result import HALVES, MethodResult, Parameter, Score
from repro.ownarm.words import verdict
from repro.streams import Stream, stream

#: Parameters that may be negative: they depend on where masses and the zero position are.
EITHER_SIGN = ("I2", "g1", "g2")
Position = tuple[float, float] | None


@dataclass(frozen=True)
class Found:
    """What a method found, before it is judged.

    Attributes
    ----------
    method : Method
        Which.
    estimate : Estimate
        Its parameters.
    spread : Uncertainty or None
        Standard errors and intervals, if it claims any.
    halves : tuple of Score
        Each half predicted from the other; of several logs each from the rest.
    """

    method: Method
    estimate: Estimate
    spread: Uncertainty | None
    halves: tuple[Score, ...]


def score(name: str, regression: Regression, beta: Array, position: Position) -> Score:
    """Errors of predicting one log."""
    return Score(name, relative_rms(regression, beta), similarity(regression, beta), position)


def find(method: Method, problem: Problem, seed: int, halves: bool, report: Callable[[int, int], None]) -> Found:
    """Estimate, standard errors and halves."""
    r = problem.regression if method.needs_all_samples else problem.moving
    estimate = method.estimate(r)
    spread = None
    if method.claims_intervals:
        rng = stream(seed, Stream.OWN_BOOTSTRAP)
        spread = bootstrap(method, r, estimate, problem.as_good, rng, report=report)
    scores = []
    if len(problem.logs) > 1 and method.claims_intervals:
        for k, log in enumerate(problem.logs):
            beta = method.estimate(together([*problem.logs[:k], *problem.logs[k + 1 :]])[0]).beta
            scores.append(score(log.told.description.name, log.regression, beta, None))
    elif halves:
        middle = r.t.size // 2
        first, second = np.arange(middle), np.arange(middle, r.t.size)
        for name, used, predicted in zip(HALVES, (first, second), (second, first), strict=True):
            beta = method.estimate(r.take(used)).beta
            scores.append(score(name, problem.regression.take(predicted), beta, None))
    return Found(method, estimate, spread, tuple(scores))


def judge(found: Found, problem: Problem, positions: tuple[Position, ...]) -> MethodResult:
    """Everything about a method."""
    beta, r = found.estimate.beta, problem.regression
    consistent = bool(is_positive_definite(beta))
    fitted = len(problem.logs)
    name = " + ".join(log.told.description.name for log in problem.logs)
    fit = score(name, r, beta, positions[0] if fitted == 1 else None)
    validation = tuple(
        score(told.description.name, regression, beta, position)
        for (told, regression), position in zip(problem.others, positions[fitted:], strict=True)
    )
    return MethodResult(
        method=found.method.name,
        title=found.method.title,
        parameters=_parameters(found, torque_fraction(problem.moving, beta), problem),
        claims_intervals=found.spread is not None,
        consistent=consistent,
        why_not_consistent="" if consistent else why_not_consistent(beta),
        fit=fit,
        validation=validation,
        halves=found.halves,
        whiteness=residual_autocorrelation(r, beta, problem.settings.cutoff),
        notes=found.estimate.notes,
        citation=found.method.citation,
    )


def why_not_consistent(beta: Array) -> str:
    """Conditions of `repro.model.parameters.is_positive_definite` that fail, with numbers."""
    i1, i2, i3 = beta[:3]
    broken = []
    if i3 <= 0.0 or i3 * (i1 - i3) <= 0.25 * i2**2:
        broken.append(
            f"the inertia matrix is not positive definite: I3 (I1 - I3) = {i3 * (i1 - i3):.3g} is not above "
            f"I2^2 / 4 = {0.25 * i2**2:.3g}"
        )
    broken += [
        f"{name} = {value:.3g} is negative" for name, value in zip(NAMES[5:], beta[5:], strict=True) if value < 0
    ]
    return "; ".join(broken)


def _parameters(found: Found, share: Array, problem: Problem) -> tuple[Parameter, ...]:
    """The nine with their verdicts; what is held, or not determined by itself, gets no interval."""
    beta, spread, determined = found.estimate.beta, found.spread, problem.excited.determined
    more = {term.name[-1] for log in problem.logs for term in log.terms if not term.taken}
    rows = []
    for k, name in enumerate(NAMES):
        held = bool(beta[k] == 0.0)
        error, low, high = (
            (None, None, None)
            if spread is None or held or not determined[k] or problem.doubt
            else (float(spread.standard_error[k]), float(spread.low[k]), float(spread.high[k]))
        )
        words = verdict(
            float(beta[k]),
            low,
            high,
            bool(share[k] > MIN_TORQUE_FRACTION),
            held,
            determined[k],
            name in EITHER_SIGN or beta[k] > 0.0,
            problem.doubt if spread is not None else "",
        )
        if name[0] in "bk" and name[1] in more:
            words += "; other friction is in it too"
        rows.append(Parameter(name, UNITS[k], DESCRIPTIONS[k], float(beta[k]), error, low, high, words))
    return tuple(rows)
