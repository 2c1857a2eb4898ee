"""From a problem to a result: fit the methods, evaluate their estimates, recommend one, and test it on known arms."""

import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from scipy.interpolate import CubicSpline

from repro.fitting.prepare import LoadedLog, Options, PreparedLog, prepare_logs
from repro.fitting.prior import NOT_NEGATIVE
from repro.fitting.problem import SCALE_OF_JOINT_1, IdentificationProblem, join_logs, single_problem
from repro.fitting.recommend import compare_networks, recommend, warnings, wrong_length
from repro.fitting.result import (
    EXPORTS,
    HALVES,
    Curves,
    Excitation,
    MethodResult,
    Parameter,
    Preparation,
    RecoveredParameter,
    Result,
    Score,
    SelfTest,
    Signals,
    SingleFit,
)
from repro.fitting.text import FIXED, calibration_warnings, inconsistency, verdict
from repro.identification.armfile import Arm
from repro.identification.calibration import correct_calibration
from repro.identification.excitation import MIN_TORQUE_FRACTION, torque_fraction
from repro.identification.extra_terms import ROTOR, STRIBECK, TERMS, term_columns, values_of
from repro.identification.filtering import FILTERS, SEGMENT, motion_cutoff, smooth_motion
from repro.identification.least_squares import METHODS
from repro.identification.log import period, segments, uniform
from repro.identification.method import NETWORKS, Estimate, Method, NoSolutionError
from repro.identification.regression import Regression, joined, residual_autocorrelation
from repro.identification.scores import position_errors, relative_rms, similarity
from repro.identification.uncertainty import Uncertainty, bootstrap
from repro.logs.torque_limits import quantisation_step
from repro.model.dynamics import regressor
from repro.model.parameters import DESCRIPTIONS, NAMES, UNITS, Array
from repro.signals.dct import spectrum
from repro.streams import Stream, stream

_LOG = logging.getLogger(__name__)

#: Called with what is done, steps done, steps in all and perhaps a note.
ReportProgress = Callable[..., None]
Position = tuple[float, float] | None

DRAWS = 5  # synthetic logs of a self-test
#: Share of the squared torque error that noise must explain: below it Eq. 1 is wrong.
MIN_NOISE_SHARE = 0.5
MAX_UNREPORTED_WEIGHT = 0.5  # weight of the prior in an estimate above which the verdict reports it


@dataclass(frozen=True)
class Fit:
    """The estimate of one method, before it is evaluated."""

    method: Method
    estimate: Estimate
    spread: Uncertainty | None  # standard errors and intervals, if it claims any
    halves: tuple[Score, ...]  # each half predicted from the other; of several logs each from the others
    prior_weight: Array = field(default_factory=lambda: np.zeros(len(NAMES)))  # of each estimate (9,), 0 to 1


def resolve(options: Options, progress: ReportProgress) -> list[Method]:
    """Find the methods by their names."""
    known = dict(METHODS)
    if set(options.methods) & set(NETWORKS):
        from repro.cnn.architecture import TrainingSettings  # noqa: PLC0415
        from repro.identification.algorithm1.own_network import NetworkSearch, methods  # noqa: PLC0415

        training = TrainingSettings(steps=options.steps, seed=options.seed)
        search = NetworkSearch(options.cache, training, seed=options.seed)
        if "algorithm1+refinement" not in options.methods:
            search = replace(search, refinement=replace(search.refinement, passes=0))
        known |= {method.name: method for method in methods(search, partial(progress, "training the CNN"))}
    return [known[name] for name in options.methods]


def fit_all(
    problem: IdentificationProblem, methods: Sequence[Method], seed: int, progress: ReportProgress
) -> list[Fit]:
    """Fit the methods one after another; one without a solution is left out with a warning."""
    fits = []
    for method in methods:
        report = partial(progress, f"standard errors, {method.title}")
        try:
            fits.append(fit(method, problem, seed, method.name not in NETWORKS, report))
        except NoSolutionError as error:
            _LOG.warning("%s: no result, %s", method.title, error)
        else:
            _LOG.info("%s", "; ".join((f"{method.title}: done", *fits[-1].estimate.notes)))
    return fits


def fit(
    method: Method, problem: IdentificationProblem, seed: int, halves: bool, report: Callable[[int, int], None]
) -> Fit:
    """Compute the estimate, its standard errors and the scores of the halves."""
    r = problem.regression if method.needs_all_samples else problem.without_standstill
    estimate = method.estimate(r)
    spread, parts = None, []
    if method.claims_intervals:
        rng = stream(seed, Stream.OWN_BOOTSTRAP)
        spread = bootstrap(method, r, estimate, problem.perturbations, rng, report=report)
        parts = [(log.loaded.name, others, log.regression) for log, others in problem.left_out]
    if halves and not parts:
        first, second = problem.halves
        pairs = zip(HALVES, ((first, second), (second, first)), strict=True)
        parts = [(name, r.take(used), problem.regression.take(predicted)) for name, (used, predicted) in pairs]
    scores = tuple(score(name, unseen, method.estimate(used).beta, None) for name, used, unseen in parts)
    return Fit(method, estimate, spread, scores, _prior_weight(method, r, estimate))


def _prior_weight(method: Method, regression: Regression, estimate: Estimate) -> Array:
    """Compute by how much each estimate (9,) follows its own prior mean: 0 without a prior, 1 for a known parameter."""
    weight, prior = np.zeros(len(NAMES)), regression.prior
    if prior is not None:
        weight[prior.known] = 1.0
        for k, shifted in zip(prior.informative, prior.shifted(), strict=False):
            moved = method.repeat(replace(regression, prior=shifted), estimate)
            weight[k] = np.clip((moved[k] - estimate.beta[k]) / prior.sd[k], 0.0, 1.0)
    return weight


def score(name: str, regression: Regression, beta: Array, position: Position) -> Score:
    """Compute the errors of predicting one log."""
    return Score(name, relative_rms(regression, beta), similarity(regression, beta), position)


def evaluate(fitted: Fit, problem: IdentificationProblem, positions: tuple[Position, ...]) -> MethodResult:
    """Evaluate a fit on every log, given the position errors of each."""
    beta, r, n = fitted.estimate.beta, problem.regression, len(problem.logs)
    name = " + ".join(log.loaded.name for log in problem.logs)
    pairs = zip(problem.validation, positions[n:], strict=True)
    validation = tuple(score(loaded.name, unseen, beta, position) for (loaded, unseen), position in pairs)
    reason = inconsistency(beta)
    return MethodResult(
        method=fitted.method.name,
        title=fitted.method.title,
        parameters=_parameters(fitted, problem),
        claims_intervals=fitted.spread is not None,
        consistent=not reason,
        why_not_consistent=reason,
        fit=score(name, r, beta, positions[0] if n == 1 else None),
        validation=validation,
        halves=fitted.halves,
        whiteness=residual_autocorrelation(r, beta, problem.first.settings.cutoff),
        notes=fitted.estimate.notes,
        citation=fitted.method.citation,
    )


def _parameters(fitted: Fit, problem: IdentificationProblem) -> tuple[Parameter, ...]:
    """Give the nine with their verdicts; a parameter at its bound, or not determined by itself, has no interval."""
    beta, spread, determined = fitted.estimate.beta, fitted.spread, problem.excited.determined
    excited = torque_fraction(problem.without_standstill, beta) > MIN_TORQUE_FRACTION
    rough_joints = {term.name[-1] for term in problem.first.terms if not (term.taken or term.kind == ROTOR)}
    known = problem.prior.known if problem.prior is not None else np.zeros(len(NAMES), bool)
    rows = []
    for k, name in enumerate(NAMES):
        at_bound = bool(beta[k] == 0.0 or known[k])
        error = low = high = None
        if spread is not None and determined[k] and not (at_bound or problem.doubt):
            error, low, high = (float(values[k]) for values in (spread.standard_error, spread.low, spread.high))
        possible, doubt = beta[k] > 0.0 or name not in NOT_NEGATIVE, problem.doubt if spread is not None else ""
        weight = float(fitted.prior_weight[k])
        text = verdict(float(beta[k]), low, high, bool(excited[k]), at_bound, determined[k], possible, doubt)
        if known[k]:
            text = FIXED
        elif weight > MAX_UNREPORTED_WEIGHT:
            text += f"; mostly from the prior (weight {100 * weight:.0f} %)"
        if name[0] in "bk" and name[1] in rough_joints:
            text += "; includes other friction"
        rows.append(Parameter(name, UNITS[k], DESCRIPTIONS[k], float(beta[k]), error, low, high, text, weight))
    return tuple(rows)


def assemble(problem: IdentificationProblem, fits: Sequence[Fit], arm: Arm) -> tuple[Result, Curves]:
    """Evaluate the fits and recommend one."""
    betas = np.stack([f.estimate.beta for f in fits])
    s, r, why = problem.first.settings, problem.regression, problem.first.cutoff.reason
    logs = [(log.loaded, log.regression, log.settings) for log in problem.logs]
    logs += [(loaded, regression, s) for loaded, regression in problem.validation]
    positions = [position_errors(loaded.log, filters, betas) for loaded, _, filters in logs]
    methods = tuple(evaluate(f, problem, tuple(position[k] for position in positions)) for k, f in enumerate(fits))
    methods = compare_networks(methods, NETWORKS)
    recommended, reason = recommend(methods)
    best = [m.method for m in methods].index(recommended)
    excitation = _excitation(problem, betas[best])
    stribeck = s.stribeck_speed if any(term.kind == STRIBECK for term in problem.first.taken) else None
    filtering = (FILTERS[s.name].description, s.cutoff, why, s.delay, s.friction_steepness, stribeck)
    prior = problem.prior
    known = [] if prior is None else zip(NAMES, prior.mean.tolist(), prior.sd.tolist(), strict=True)
    result = Result(
        arm=arm.name,
        simulated=any(loaded.log.simulated for loaded, _, _ in logs),
        log=problem.first.loaded.description,
        more_logs=tuple(log.loaded.description for log in problem.logs[1:]),
        validation_logs=tuple(loaded.description for loaded, _ in problem.validation),
        preparation=Preparation(*filtering, 1.0 / r.h, r.t.size, s.cut),
        excitation=excitation,
        methods=methods,
        recommended=recommended,
        reason=reason,
        warnings=(
            *calibration_warnings(problem.logs, arm, SCALE_OF_JOINT_1 in problem.perturbations),
            *wrong_length(problem.length),
            *warnings(problem, methods, recommended, excitation),
        ),
        calibration_errors=tuple(log.calibration_errors for log in problem.logs),
        calibration_limits=tuple(log.calibration_limits for log in problem.logs),
        friction=tuple(log.terms for log in problem.logs),
        prior={name: {"value": mean, "sd": sd} for name, mean, sd in known if np.isfinite(sd)},
    )
    result = replace(result, exports=_export_scores(problem, result, betas[best]))
    signals = tuple(_signals(loaded.name, regression, methods, betas) for loaded, regression, _ in logs)
    return result, Curves(signals, problem.first.cutoff)


def _export_scores(problem: IdentificationProblem, result: Result, beta: Array) -> dict[str, tuple[Score, ...]]:
    """Score the exports that leave out a term of the arm, on every log."""
    first, scores = problem.first, dict[str, list[Score]]()
    logs = [(log.loaded, log.regression, log.settings) for log in problem.logs]
    logs += [(loaded, regression, first.settings) for loaded, regression in problem.validation]
    for name in EXPORTS:
        left = [term for term in first.taken if term.name in result.left_out_of(name)]
        values = np.array([term.value for term in left])
        for loaded, r, settings in logs if left else ():
            torque = term_columns(TERMS, loaded.log, settings, first.load, left) @ values
            alone = replace(r, tau=r.tau + torque * r.mask)
            scores.setdefault(name, []).append(score(loaded.name, alone, beta, None))
    return {name: tuple(of_logs) for name, of_logs in scores.items()}


def _level(x: Array, h: float, low: float, high: float) -> Array:
    """Estimate the standard deviation (2, 1) of white noise as strong as a signal between two frequencies."""
    from scipy.signal import welch  # noqa: PLC0415  (a third of a second, for a self-test alone)

    segment = min(round(SEGMENT / h), x.shape[-1] // 4)
    frequency, density = welch(x, 1.0 / h, window="blackmanharris", nperseg=segment, axis=-1)
    band = (frequency >= low) & (frequency <= high)
    return np.asarray(np.sqrt(0.5 / h * np.median(density[:, band], axis=-1, keepdims=True)))


def _measured(signal: Array, recorded: Array, noise: Array, rng: np.random.Generator) -> Array:
    """Add noise to a signal and quantise it as the recorded one; quantisation noise is not added twice."""
    rounded = []
    for x, there, size in zip(signal, recorded, noise[:, 0], strict=True):
        step = quantisation_step(there)
        drawn = x + np.sqrt(max(size**2 - (step or 0.0) ** 2 / 12.0, 0.0)) * rng.normal(size=x.shape)
        rounded.append(step * np.rint(drawn / step) if step else drawn)
    return np.stack(rounded)


def inverse_errors(errors: Mapping[str, float]) -> dict[str, float]:
    """Give the corrections that add estimated calibration errors again."""
    scales = {name: 1.0 / value for name, value in errors.items() if name.startswith("scale")}
    factors = {f"offset{name[-1]}": factor for name, factor in scales.items()}
    return {name: -value * factors.get(name, 1.0) for name, value in errors.items()} | scales


def synthetic_log(prepared: PreparedLog, beta: Array, rng: np.random.Generator) -> LoadedLog:
    """Simulate the recording of a log, or of its longest piece, with an arm of known parameters."""
    s, loaded = prepared.settings, prepared.loaded
    recorded = segments(loaded.recorded or loaded.log) if loaded.log.block == 1 else loaded.log.pieces
    pairs = zip(loaded.log.pieces, recorded, strict=True)
    longest = max(pairs, key=lambda pair: pair[0].t.size)
    log, piece = (replace(part, t=part.t - part.t[0]) for part in longest)
    even, h, top = uniform(piece), period(log), motion_cutoff(s, period(log))
    moved = smooth_motion(log.q, h, s)
    acting = CubicSpline(log.t, regressor(*moved, s.friction_steepness) @ beta, axis=1)
    late = acting(np.clip(log.t + s.delay, 0.0, log.t[-1]))
    right = correct_calibration(
        replace(log, q=moved[0], tau=late), inverse_errors(values_of(prepared.calibration_errors))
    )
    # Above the frequencies of the motion the torque contains friction, and its residual the noise of the position.
    noise = [_level(x, h, top, 2.0 * top) for x in (even.tau, even.tau - right.tau)]
    # Rounded time stamps say when a sample was written; it was measured at the even instant.
    at = even.t if even.t.size == piece.t.size and np.array_equal(even.q, piece.q) else piece.t
    q, tau = (CubicSpline(even.t, x, axis=1)(np.clip(at, 0.0, even.t[-1])) for x in (right.q, right.tau))
    q = _measured(q, piece.q, _level(even.q, h, 0.25 / h, np.inf), rng)
    raw = replace(piece, q=q, tau=_measured(tau, piece.tau, np.minimum(*noise), rng), dq=None)
    return LoadedLog(uniform(raw), loaded.description, raw)


def self_test(
    problem: IdentificationProblem, method: Method, beta: Array, arm: Arm, options: Options, report: ReportProgress
) -> SelfTest:
    """Simulate logs with the parameters that a method estimated, and solve them by that method as the real ones.

    Noise, quantisation, time stamps, delay and calibration errors are added as estimated from the log. Noise is white:
    of the position as strong as in the upper half of its spectrum, of the torque as just above the frequencies of the
    motion. The synthetic logs are prepared together, with the cut-off and lambda of the real ones.
    """
    betas, inside, claimed, errors = [], [], [], []
    as_real = replace(options, cutoff=problem.first.settings.cutoff, friction=False)
    arm = replace(arm, friction_steepness=problem.first.settings.friction_steepness)
    for draw in range(DRAWS):
        rng = stream(options.seed, Stream.SELF_TEST, draw)
        logs = prepare_logs([synthetic_log(log, beta, rng) for log in problem.logs], arm, as_real)
        regression, perturbations = join_logs(logs, problem.prior)
        estimate = method.estimate(regression)
        spread = bootstrap(method, regression, estimate, perturbations, rng)
        betas.append(estimate.beta)
        claimed.append(estimate.beta != 0.0)
        inside.append((spread.low <= beta) & (beta <= spread.high) & claimed[-1])
        errors.append(relative_rms(joined([log.regression for log in logs]), estimate.beta))
        report("self-test", draw + 1, DRAWS)
    real, error = relative_rms(problem.regression, beta), np.median(errors, axis=0)
    noise = np.minimum(np.divide(error, real, out=np.ones(2), where=np.array(real) > 0.0) ** 2, 1.0)
    columns = (beta, np.median(betas, 0), np.min(betas, 0), np.max(betas, 0), np.sum(inside, 0), np.sum(claimed, 0))
    parameters = tuple(map(RecoveredParameter, NAMES, *(column.tolist() for column in columns)))
    wrong = bool(noise.min() < MIN_NOISE_SHARE)
    return SelfTest(method.name, DRAWS, parameters, tuple(error.tolist()), real, tuple(noise.tolist()), wrong)


def add_self_test(
    result: Result, problem: IdentificationProblem, arm: Arm, options: Options, progress: ReportProgress
) -> Result:
    """Test the recommended one of the methods with intervals on synthetic logs with the parameters it estimated."""
    able = {m.method: m for m in result.methods if m.claims_intervals}
    try:
        if not able:
            raise NoSolutionError("because no method claims intervals")
        name, _ = recommend(tuple(able.values()))
        beta = np.array([p.estimate for p in able[name].parameters])
        return replace(result, selftest=self_test(problem, METHODS[name], beta, arm, options, progress))
    except NoSolutionError as error:
        _LOG.warning("self-test: no result, %s", error)
        return result


def add_runs(
    result: Result, problem: IdentificationProblem, methods: Sequence[Method], seed: int, progress: ReportProgress
) -> Result:
    """Fit each of several logs by itself with the recommended method; one without a solution is left out."""
    method = next(m for m in methods if m.name == result.recommended)
    runs = []
    for log in problem.logs:
        name, alone = log.loaded.name, single_problem(problem, log)
        try:
            fitted = fit(method, alone, seed, False, partial(progress, f"{name} alone"))
        except NoSolutionError as error:
            _LOG.warning("%s alone: no result, %s", name, error)
        else:
            runs.append(SingleFit(name, _parameters(fitted, alone)))
    return replace(result, runs=tuple(runs))


def _excitation(problem: IdentificationProblem, beta: Array) -> Excitation:
    of, share = problem.excited, torque_fraction(problem.without_standstill, beta)
    still = torque_fraction(problem.without_standstill, np.ones(9)) == 0.0
    unexcited = np.array(NAMES)[still | ((share <= MIN_TORQUE_FRACTION) & (beta != 0.0))]
    lists = tuple(share.tolist()), of.friction_correlation, tuple(unexcited.tolist()), of.base_parameters
    return Excitation(of.rank, of.condition, *lists)


def _signals(name: str, r: Regression, methods: Sequence[MethodResult], betas: Array) -> Signals:
    """Give torques over time and frequency; the amplitude of a DCT-II band is sqrt(2/n) times its coefficient."""
    rebuilt = {m.method: r.y @ beta for m, beta in zip(methods, betas, strict=True)}
    n = r.t.size
    size, frequency = np.sqrt(2.0 / n), np.arange(n) / (2.0 * n * r.h)
    spectra = {key: size * np.abs(spectrum(tau)) for key, tau in rebuilt.items()}
    return Signals(name, r.t, r.tau, rebuilt, frequency, size * np.abs(spectrum(r.tau)), spectra)
