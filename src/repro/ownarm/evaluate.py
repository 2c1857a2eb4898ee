"""From a problem to a result: fit the methods, evaluate their estimates, recommend one."""

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from repro.identification.excitation import MIN_TORQUE_FRACTION, torque_fraction
from repro.identification.filtering import FILTERS
from repro.identification.least_squares import METHODS
from repro.identification.method import NETWORKS, Estimate, Method, NoSolutionError
from repro.identification.regression import Prior, Regression, residual_autocorrelation
from repro.identification.scores import position_errors, relative_rms, similarity
from repro.identification.uncertainty import Uncertainty, bootstrap
from repro.logs.armfile import Arm
from repro.model.parameters import DESCRIPTIONS, NAMES, UNITS, Array, is_positive_definite
from repro.ownarm.prepare import IdentificationProblem, Options, join_logs, single_problem
from repro.ownarm.recommend import compare_networks, recommend, warnings
from repro.ownarm.result import (
    HALVES,
    Curves,
    Excitation,
    MethodResult,
    Parameter,
    Preparation,
    Result,
    Score,
    Signals,
    SingleFit,
)
from repro.ownarm.selftest import self_test
from repro.ownarm.text import FIXED, calibration_warnings, inconsistency, verdict
from repro.signals.dct import spectrum
from repro.streams import Stream, stream

_LOG = logging.getLogger(__name__)

#: Called with what is done, steps done, steps in all and a note.
Progress = Callable[[str, int, int, str], None]
Position = tuple[float, float] | None

#: Parameters that may be negative: they depend on where masses and the zero position are.
EITHER_SIGN = ("I2", "g1", "g2")
#: Weight of the prior in an estimate above which the verdict reports it.
MOSTLY = 0.5


@dataclass(frozen=True)
class Fit:
    """The estimate of one method, before it is evaluated."""

    method: Method
    estimate: Estimate
    spread: Uncertainty | None  # standard errors and intervals, if it claims any
    halves: tuple[Score, ...]  # each half predicted from the other; of several logs each from the others
    prior_weight: Array = field(default_factory=lambda: np.zeros(len(NAMES)))  # of each estimate (9,), 0 to 1


def resolve(options: Options, progress: Progress) -> list[Method]:
    """Find the methods by their names."""
    known = dict(METHODS)
    if set(options.methods) & set(NETWORKS):
        from repro.cnn.architecture import TrainingSettings  # noqa: PLC0415
        from repro.identification.algorithm1.own_network import NetworkSearch, methods  # noqa: PLC0415

        training = TrainingSettings(steps=options.steps, seed=options.seed)
        search = NetworkSearch(options.cache, training, seed=options.seed)
        if "algorithm1+refinement" not in options.methods:
            search = replace(search, refinement=replace(search.refinement, passes=0))
        for method in methods(search, lambda done, total, note: progress("training the CNN", done, total, note)):
            known[method.name] = method
    return [known[name] for name in options.methods]


def fit_all(
    problem: IdentificationProblem,
    methods: Sequence[Method],
    seed: int,
    progress: Progress,
    fitted: Callable[[Fit], None],
) -> list[Fit]:
    """Fit the methods one after another; one without a solution is left out with a warning."""
    fits = []
    for method in methods:

        def report(k: int, n: int, title: str = method.title) -> None:
            progress(f"standard errors, {title}", k, n, "")

        try:
            fits.append(fit(method, problem, seed, method.name not in NETWORKS, report))
        except NoSolutionError as error:
            _LOG.warning("%s: no result, %s", method.title, error)
        else:
            fitted(fits[-1])
    return fits


def fit(
    method: Method, problem: IdentificationProblem, seed: int, halves: bool, report: Callable[[int, int], None]
) -> Fit:
    """Compute the estimate, its standard errors and the scores of the halves."""
    r = problem.regression if method.needs_all_samples else problem.moving
    estimate = method.estimate(r)
    spread = None
    if method.claims_intervals:
        rng = stream(seed, Stream.OWN_BOOTSTRAP)
        spread = bootstrap(method, r, estimate, problem.as_good, rng, report=report)
    scores = []
    if len(problem.logs) > 1 and method.claims_intervals:
        for k, log in enumerate(problem.logs):
            others = join_logs([*problem.logs[:k], *problem.logs[k + 1 :]], problem.prior)[0]
            beta = method.estimate(others).beta
            scores.append(score(log.loaded.name, log.regression, beta, None))
    elif halves:
        middle = r.t.size // 2
        first, second = np.arange(middle), np.arange(middle, r.t.size)
        for name, used, predicted in zip(HALVES, (first, second), (second, first), strict=True):
            beta = method.estimate(r.take(used)).beta
            scores.append(score(name, problem.regression.take(predicted), beta, None))
    return Fit(method, estimate, spread, tuple(scores), _prior_weight(method, r, estimate))


def _prior_weight(method: Method, regression: Regression, estimate: Estimate) -> Array:
    """Compute by how much each estimate (9,) follows its own prior mean: 0 without a prior, 1 for a known parameter."""
    weight, prior = np.zeros(len(NAMES)), regression.prior
    if prior is not None:
        weight[prior.known] = 1.0
        for k in prior.informative:
            moved = method.repeat(replace(regression, prior=prior.shifted(k)), estimate)
            weight[k] = np.clip((moved[k] - estimate.beta[k]) / prior.sd[k], 0.0, 1.0)
    return weight


def score(name: str, regression: Regression, beta: Array, position: Position) -> Score:
    """Compute the errors of predicting one log."""
    return Score(name, relative_rms(regression, beta), similarity(regression, beta), position)


def evaluate(fitted: Fit, problem: IdentificationProblem, positions: tuple[Position, ...]) -> MethodResult:
    """Evaluate a fit on every log, given the position errors of each."""
    beta, r = fitted.estimate.beta, problem.regression
    n = len(problem.logs)
    name = " + ".join(log.loaded.name for log in problem.logs)
    validation = tuple(
        score(loaded.name, regression, beta, position)
        for (loaded, regression), position in zip(problem.validation, positions[n:], strict=True)
    )
    consistent = bool(is_positive_definite(beta))
    return MethodResult(
        method=fitted.method.name,
        title=fitted.method.title,
        parameters=_parameters(fitted, torque_fraction(problem.moving, beta), problem),
        claims_intervals=fitted.spread is not None,
        consistent=consistent,
        why_not_consistent="" if consistent else inconsistency(beta),
        fit=score(name, r, beta, positions[0] if n == 1 else None),
        validation=validation,
        halves=fitted.halves,
        whiteness=residual_autocorrelation(r, beta, problem.settings.cutoff),
        notes=fitted.estimate.notes,
        citation=fitted.method.citation,
    )


def _parameters(fitted: Fit, share: Array, problem: IdentificationProblem) -> tuple[Parameter, ...]:
    """Give the nine with their verdicts; a parameter at its bound, or not determined by itself, has no interval."""
    beta, spread, determined = fitted.estimate.beta, fitted.spread, problem.excited.determined
    rough_joints = {term.name[-1] for log in problem.logs for term in log.terms if not term.taken}
    known = problem.prior.known if problem.prior is not None else np.zeros(len(NAMES), bool)
    rows = []
    for k, name in enumerate(NAMES):
        at_bound = bool(beta[k] == 0.0 or known[k])
        error, low, high = (
            (None, None, None)
            if spread is None or at_bound or not determined[k] or problem.doubt
            else (float(spread.standard_error[k]), float(spread.low[k]), float(spread.high[k]))
        )
        text = verdict(
            float(beta[k]),
            low,
            high,
            bool(share[k] > MIN_TORQUE_FRACTION),
            at_bound,
            determined[k],
            name in EITHER_SIGN or beta[k] > 0.0,
            problem.doubt if spread is not None else "",
        )
        weight = float(fitted.prior_weight[k])
        if known[k]:
            text = FIXED
        elif weight > MOSTLY:
            text += f"; mostly from the prior (weight {100 * weight:.0f} %)"
        if name[0] in "bk" and name[1] in rough_joints:
            text += "; includes other friction"
        rows.append(Parameter(name, UNITS[k], DESCRIPTIONS[k], float(beta[k]), error, low, high, text, weight))
    return tuple(rows)


def assemble(problem: IdentificationProblem, fits: Sequence[Fit], arm: Arm) -> tuple[Result, Curves]:
    """Evaluate the fits and recommend one."""
    betas = np.stack([f.estimate.beta for f in fits])
    logs = (*(log.loaded for log in problem.logs), *(loaded for loaded, _ in problem.validation))
    filters = (*(log.settings for log in problem.logs), *(problem.settings for _ in problem.validation))
    positions = [position_errors(loaded.log, one, betas) for loaded, one in zip(logs, filters, strict=True)]
    methods = tuple(evaluate(f, problem, tuple(position[k] for position in positions)) for k, f in enumerate(fits))
    methods = compare_networks(methods, NETWORKS)
    recommended, reason = recommend(methods)
    excitation = _excitation(problem, betas[[m.method for m in methods].index(recommended)])
    s, r = problem.settings, problem.regression
    preparation = Preparation(
        filter=FILTERS[s.name].description,
        cutoff=s.cutoff,
        cutoff_reason=problem.cutoff.reason,
        delay=s.delay,
        friction_steepness=s.friction_steepness,
        rate=1.0 / r.h,
        samples=r.t.size,
        cut=s.cut,
    )
    result = Result(
        arm=arm.name,
        simulated=any(loaded.log.simulated for loaded in logs),
        log=problem.fitted.description,
        more_logs=tuple(log.loaded.description for log in problem.logs[1:]),
        validation_logs=tuple(loaded.description for loaded, _ in problem.validation),
        preparation=preparation,
        excitation=excitation,
        methods=methods,
        recommended=recommended,
        reason=reason,
        warnings=(
            *calibration_warnings(problem.logs, arm),
            *warnings(problem, methods, recommended, excitation),
        ),
        setup=tuple(log.faults for log in problem.logs),
        hidden=tuple(log.hidden for log in problem.logs),
        friction=tuple(log.terms for log in problem.logs),
        prior=_prior_rows(problem.prior),
    )
    return result, _curves(problem, methods, betas)


def _prior_rows(prior: Prior | None) -> dict[str, dict[str, float]]:
    if prior is None:
        return {}
    rows = zip(NAMES, prior.mean.tolist(), prior.sd.tolist(), strict=True)
    return {name: {"value": mean, "sd": sd} for name, mean, sd in rows if np.isfinite(sd)}


def add_self_test(
    result: Result, problem: IdentificationProblem, arm: Arm, options: Options, progress: Progress
) -> Result:
    """Test the recommended one of the methods with intervals on synthetic logs with the parameters it estimated."""
    able = [m for m in result.methods if m.claims_intervals]
    if not able:
        _LOG.warning("self-test: no result, because no method claims intervals")
        return result
    name, _ = recommend(able)
    beta = np.array([p.estimate for m in able if m.method == name for p in m.parameters])
    try:
        return replace(result, selftest=self_test(problem, METHODS[name], beta, arm, options, progress))
    except NoSolutionError as error:
        _LOG.warning("self-test: no result, %s", error)
        return result


def add_runs(
    result: Result, problem: IdentificationProblem, methods: Sequence[Method], seed: int, progress: Progress
) -> Result:
    """Fit each of several logs by itself with the recommended method; one without a solution is left out."""
    method = next(m for m in methods if m.name == result.recommended)
    runs = []
    for log in problem.logs:
        name = log.loaded.name
        alone = single_problem(problem, log)

        def report(k: int, n: int, name: str = name) -> None:
            progress(f"{name} alone", k, n, "")

        try:
            fitted = fit(method, alone, seed, False, report)
        except NoSolutionError as error:
            _LOG.warning("%s alone: no result, %s", name, error)
            continue
        share = torque_fraction(alone.moving, fitted.estimate.beta)
        runs.append(SingleFit(name, _parameters(fitted, share, alone)))
    return replace(result, runs=tuple(runs))


def _excitation(problem: IdentificationProblem, beta: Array) -> Excitation:
    excited, share = problem.excited, torque_fraction(problem.moving, beta)
    still = torque_fraction(problem.moving, np.ones(9)) == 0.0
    weak = (share <= MIN_TORQUE_FRACTION) & (beta != 0.0)
    return Excitation(
        excited.rank,
        excited.condition,
        tuple(share.tolist()),
        excited.friction_correlation,
        tuple(name for name, none in zip(NAMES, still | weak, strict=True) if none),
        excited.base_parameters,
    )


def _curves(problem: IdentificationProblem, methods: Sequence[MethodResult], betas: Array) -> Curves:
    pairs = (*((log.loaded, log.regression) for log in problem.logs), *problem.validation)
    return Curves(tuple(_signals(loaded.name, r, methods, betas) for loaded, r in pairs), problem.cutoff)


def _signals(name: str, r: Regression, methods: Sequence[MethodResult], betas: Array) -> Signals:
    """Give torques over time and frequency; the amplitude of a DCT-II band is sqrt(2/n) times its coefficient."""
    rebuilt = {m.method: r.y @ beta for m, beta in zip(methods, betas, strict=True)}
    n = r.t.size
    size = np.sqrt(2.0 / n)
    return Signals(
        name,
        r.t,
        r.tau,
        rebuilt,
        np.arange(n) / (2.0 * n * r.h),
        size * np.abs(spectrum(r.tau)),
        {key: size * np.abs(spectrum(tau)) for key, tau in rebuilt.items()},
    )
