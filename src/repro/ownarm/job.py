"""From logs to a result: the whole of `repro identify` but for files and words on the screen."""

import logging
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from repro.identification.excitation import MIN_TORQUE_FRACTION, torque_fraction
from repro.identification.filters import FILTERS
from repro.identification.least_squares import METHODS
from repro.identification.method import NETWORKS, Method, NoSolutionError
from repro.identification.regression import Regression
from repro.identification.scores import position_errors
from repro.logs.armfile import Arm
from repro.model.parameters import NAMES, Array
from repro.ownarm import setup
from repro.ownarm.judge import Found, find, judge
from repro.ownarm.prepared import Problem
from repro.ownarm.recommend import against_least_squares, recommend, warnings
from repro.ownarm.result import Curves, Excitation, MethodResult, Preparation, Result, Signals
from repro.ownarm.selftest import self_test
from repro.ownarm.settings import Options
from repro.signals.dct import spectrum

_LOG = logging.getLogger(__name__)

Report = Callable[[str, int, int, str], None]


def resolve(options: Options, report: Report) -> list[Method]:
    """Methods by their names."""
    known = dict(METHODS)
    if set(options.methods) & set(NETWORKS):
        from repro.cnn.schedule import TrainingSettings  # noqa: PLC0415
        from repro.identification.algorithm1.own_network import NetworkSearch, methods  # noqa: PLC0415

        training = TrainingSettings(steps=options.steps, seed=options.seed)
        search = NetworkSearch(options.cache, training, seed=options.seed)
        if "algorithm1+refinement" not in options.methods:
            search = replace(search, refinement=replace(search.refinement, passes=0))
        for method in methods(search, lambda done, total, note: report("training the CNN", done, total, note)):
            known[method.name] = method
    return [known[name] for name in options.methods]


def solve_all(
    problem: Problem, methods: Sequence[Method], seed: int, report: Report, done: Callable[[Found], None]
) -> list[Found]:
    """Run the methods one after another."""
    found = []
    for method in methods:

        def tell(k: int, n: int, title: str = method.title) -> None:
            report(f"standard errors, {title}", k, n, "")

        try:
            found.append(find(method, problem, seed, method.name not in NETWORKS, tell))
        except NoSolutionError as error:
            _LOG.warning("%s: no result, %s", method.title, error)
        else:
            done(found[-1])
    return found


def assemble(problem: Problem, found: Sequence[Found], arm: Arm) -> tuple[Result, Curves]:
    """Judge the methods and recommend one."""
    betas = np.stack([f.estimate.beta for f in found])
    logs = (*(log.told for log in problem.logs), *(told for told, _ in problem.others))
    filters = (*(log.settings for log in problem.logs), *(problem.settings for _ in problem.others))
    positions = [position_errors(told.log, one, betas) for told, one in zip(logs, filters, strict=True)]
    methods = tuple(judge(f, problem, tuple(position[k] for position in positions)) for k, f in enumerate(found))
    methods = against_least_squares(methods, NETWORKS)
    recommended, reason = recommend(methods)
    best = betas[[m.method for m in methods].index(recommended)]
    told, set_up = _excitation(problem, best), setup.told(problem.logs, arm)
    s, r = problem.settings, problem.regression
    result = Result(
        arm=arm.name,
        simulated=any(t.log.simulated for t in logs),
        log=problem.fitted.description,
        more_logs=tuple(log.told.description for log in problem.logs[1:]),
        validation_logs=tuple(t.description for t, _ in problem.others),
        preparation=Preparation(
            FILTERS[s.name].description,
            s.cutoff,
            problem.cutoff.reason,
            s.delay,
            s.friction_steepness,
            1.0 / r.h,
            r.t.size,
            s.cut,
        ),
        excitation=told,
        methods=methods,
        recommended=recommended,
        reason=reason,
        warnings=(*set_up, *warnings(problem, methods, recommended, told)),
        setup=tuple(log.faults for log in problem.logs),
        hidden=tuple(log.hidden for log in problem.logs),
        friction=tuple(log.terms for log in problem.logs),
    )
    return result, _curves(problem, methods, betas)


def with_self_test(result: Result, problem: Problem, arm: Arm, options: Options, report: Report) -> Result:
    """Add what the recommended method, of those with intervals, makes of logs with the parameters that it found."""
    able = [m for m in result.methods if m.claims_intervals]
    if not able:
        _LOG.warning("self-test: no result, for want of a method with intervals")
        return result
    name, _ = recommend(able)
    beta = np.array([p.estimate for m in able if m.method == name for p in m.parameters])
    try:
        return replace(result, selftest=self_test(problem, METHODS[name], beta, arm, options, report))
    except NoSolutionError as error:
        _LOG.warning("self-test: no result, %s", error)
        return result


def _excitation(problem: Problem, beta: Array) -> Excitation:
    found, share = problem.excited, torque_fraction(problem.moving, beta)
    still = torque_fraction(problem.moving, np.ones(9)) == 0.0
    weak = (share <= MIN_TORQUE_FRACTION) & (beta != 0.0)
    return Excitation(
        found.rank,
        found.condition,
        tuple(share.tolist()),
        found.friction_correlation,
        tuple(name for name, none in zip(NAMES, still | weak, strict=True) if none),
        found.base_parameters,
    )


def _curves(problem: Problem, methods: Sequence[MethodResult], betas: Array) -> Curves:
    pairs = (*((log.told, log.regression) for log in problem.logs), *problem.others)
    signals = tuple(_signals(told.description.name, r, methods, betas) for told, r in pairs)
    return Curves(signals, problem.cutoff)


def _signals(name: str, r: Regression, methods: Sequence[MethodResult], betas: Array) -> Signals:
    """Torques over time and frequency; the amplitude of a DCT-II band is sqrt(2/n) times its coefficient."""
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
