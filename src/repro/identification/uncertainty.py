"""Expanded uncertainty of an estimate: sampling, choices of the analysis, and effects beyond Eq. 1.

Filtering and unmodelled friction leave residuals correlated over seconds, so single samples cannot be resampled. Three
uncertainties are combined; docs/explanation/methods-and-intervals.md describes them, `fitting/methods.bib` has sources.

- Sampling: moving-block pairs bootstrap, or the delete-a-group jackknife where its variance is larger by an F-test.
- Type B: root mean square shift of the estimate under `perturbations`. With the columns of an effect projected out of
  torque and regressor, any method gives the parameters that it would give with them in its model (Frisch, Waugh and
  Lovell). The squared shift is multiplied by the positive-part shrinkage factor 1 - c / F (Baranchik 1970) with the
  critical value c of the F-test. The largest shift a counts, by the variance a^2 / 3 of a rectangular distribution. An
  effect that is certainly there needs no test and is no rival: a^2 F / (1 + F) shrinks a shift that is only noise.
  Terms that were subtracted from the torque are fitted again next to every perturbation.
- Bias by errors of the motion, estimated by SIMEX. It widens the interval and does not move the estimate.

Sampling and type B add up to the standard error. For the interval each is multiplied by Student's t of its own degrees
of freedom. (The single factor of Welch and Satterthwaite can narrow an interval when an uncertainty is added.)
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag, hadamard
from scipy.special import fdtri, stdtrit

from repro.identification.extra_terms import (
    CERTAIN_EFFECTS,
    EFFECTS_PER_LOG,
    MAX_TORQUE_SHARE,
    N_NINE,
    STRIBECK,
    STRIBECK_FACTORS,
    TERMS,
    UNMODELLED_EFFECTS,
    ExtraTerm,
    filtered_columns,
    term_columns,
)
from repro.identification.filtering import FilterSettings, prepare
from repro.identification.least_squares import weighted_fit
from repro.identification.log import Log
from repro.identification.method import Estimate, Method, NoSolutionError
from repro.identification.regression import (
    RANK_TOLERANCE,
    Prior,
    Regression,
    condense,
    correlation_time,
    drop_standstill,
    joined,
    mean_variance,
    solve,
)
from repro.model.parameters import Array

REPLICATES = 200
CORRELATION_TIMES_PER_BLOCK, MIN_BLOCKS = 5.0, 20  # correlation times in a block, and fewest blocks in a log
GROUPS = 6  # groups of the jackknife: parts of the log that are left out in turn
FILTER_FACTORS = ((0.8, 0.7), (0.8, 1.4), (1.25, 0.7), (1.25, 1.4))  # factors on cut-off and width of the filters
#: Factors on lambda of Eq. 1, up to which it may be wrong: half the widest step of the values that `auto` chooses from.
STEEPNESS_FACTORS = (2.5**-0.5, 2.5**0.5)
N_SIMEX_TERMS = 5  # inertia and gravity: the first parameters, whose terms SIMEX perturbs
SIMEX = "errors of the motion"  # name of `simex` among the perturbations
F_TEST_LEVEL = 0.05


@dataclass(frozen=True)
class Perturbation:
    """A choice of the analysis made differently."""

    regressions: tuple[Regression, ...]  # one for each way to make it
    weight: float = 1.0  # factor on the squared shift of an estimate
    rival: bool = False  # whether it explains the same residual as other rivals, of which the largest shift counts


def simex(regression: Regression) -> Regression:
    """Add an error to each inertial and gravity term, as large as would explain the residual.

    The shift that a second error of the same size causes estimates the bias (SIMEX with a linear extrapolant). The
    signs of the errors are columns of a Hadamard matrix, which are orthogonal from term to term.
    """
    beta = solve(regression.y, regression.tau)
    residual = (regression.tau - regression.y @ beta) * regression.mask
    terms = regression.y[..., :N_SIMEX_TERMS] * beta[:N_SIMEX_TERMS] * regression.mask[..., np.newaxis]
    size = np.linalg.norm(terms, axis=(1, 2))
    fraction = np.linalg.norm(residual, axis=-1) / np.where(size > 0.0, size, np.inf)  # of each joint
    n = regression.t.size
    signs = np.resize(hadamard(16)[:, 1 : 2 * N_SIMEX_TERMS : 2], (n, N_SIMEX_TERMS))
    factors = np.ones((2, n, regression.y.shape[-1]))
    factors[..., :N_SIMEX_TERMS] += fraction[:, np.newaxis, np.newaxis] * signs
    return regression.change(lambda y: y * factors)


def project_out(regression: Regression, columns: Array) -> Regression:
    """Project columns (2, n, k) out of torque and regressor, as if they were in the model of least squares."""
    if not columns.shape[-1]:
        return regression
    x = (columns * regression.mask[..., np.newaxis]).reshape(-1, columns.shape[-1])
    size = np.linalg.norm(x, axis=0)
    basis, triangle = np.linalg.qr(x[:, size > 0.0] / size[size > 0.0])
    basis = basis[:, np.abs(np.diag(triangle)) > RANK_TOLERANCE]  # a column that others contain adds noise

    def remainder(part: Array) -> Array:
        flat = part.reshape(basis.shape[0], -1)
        return (flat - basis @ (basis.T @ flat)).reshape(part.shape)

    return regression.change(remainder, tau=remainder(regression.tau))


def f_statistic(plain: Regression, projected: Regression, k: int, weight: Array) -> tuple[float, float]:
    """Compute F of k projected columns over independent samples, 0 without any sign of them, and its critical value.

    The weight (2, 1) of each joint's squared errors keeps those of one from hiding an effect on the other.
    """
    errors = [r.tau - r.y @ solve(r.y, r.tau, weight) for r in (plain, projected)]
    before, after = (float(np.sum(weight * error**2)) for error in errors)
    freedom: float = errors[0].size * plain.h / correlation_time(errors[0], plain.h) - plain.y.shape[-1] - k
    if not 0.0 < after < before or freedom <= 0.0:
        return 0.0, np.inf
    return (before - after) / after * freedom / k, float(fdtri(k, freedom, 1.0 - F_TEST_LEVEL))


@dataclass(frozen=True)
class WeightedLog:
    """A log of an arm among others, how it is filtered, and what is fitted next to the nine parameters."""

    log: Log  # with the torque of the terms
    settings: FilterSettings
    weight: float = 1.0  # factor on its rows
    moving: Array | None = None  # fraction of time that each joint moves (2, 1), whatever another filter makes of noise
    terms: Sequence[ExtraTerm] = ()  # of all logs
    load: Array | None = None  # parameters (9,) that give the load of friction


def columns_of_terms(logs: Sequence[WeightedLog]) -> Array:
    """Compute the columns (2, n, k) of the terms of joined logs."""
    parts = []
    for log in logs:
        beta = np.zeros(N_NINE) if log.load is None else log.load
        parts.append(log.weight * term_columns(TERMS, log.log, log.settings, beta, log.terms))
    return np.concatenate(parts, axis=1)


def join_filtered(
    logs: Sequence[WeightedLog],
    cutoff: float = 1.0,
    width: float = 1.0,
    later: float = 0.0,
    steeper: float = 1.0,
    stribeck: float = 1.0,
) -> Regression:
    """Join logs without standstill or terms, with factors on settings, and torque that acts `later`, s."""
    parts, filtered = [], []
    for log in logs:
        changed = replace(
            log.settings,
            cutoff=log.settings.cutoff * cutoff,
            width=log.settings.width * width / cutoff,
            delay=log.settings.delay + later,
            friction_steepness=log.settings.friction_steepness * steeper,
            stribeck_speed=log.settings.stribeck_speed * stribeck,
        )
        parts.append(drop_standstill(prepare(log.log, changed), log.moving))
        filtered.append(replace(log, settings=changed))
    regression = joined(parts, [log.weight for log in logs])
    return project_out(regression, columns_of_terms(filtered)) if logs[0].terms else regression


def of_each_log(parts: Sequence[Array]) -> Array:
    """Give each log its own coefficients of its columns (2, n, k), zero in the rows of the other logs."""
    return np.stack([block_diag(*joint) for joint in zip(*parts, strict=True)])


def unmodelled_effects(
    logs: Sequence[WeightedLog], regression: Regression, plain: Regression
) -> dict[str, Perturbation]:
    """Add the columns of each of `UNMODELLED_EFFECTS` to logs, weighted against the regression of the estimate."""
    beta, always = solve(regression.y, regression.tau), columns_of_terms(logs)
    weight = weighted_fit(plain)[1] ** -2.0
    makes = list(dict.fromkeys(make for forms in UNMODELLED_EFFECTS.values() for form in forms for make in form))
    made = [
        {make: log.weight * columns for make, columns in zip(makes, of_log, strict=True)}
        for log in logs
        for of_log in [filtered_columns(makes, log.log, log.settings, beta)]
    ]
    results = {}
    for name, forms in UNMODELLED_EFFECTS.items():
        join = of_each_log if name in EFFECTS_PER_LOG else partial(np.concatenate, axis=1)
        columns = [join([np.concatenate([of[make] for make in form], axis=-1) for of in made]) for form in forms]
        projected = [project_out(regression, np.concatenate([always, form], axis=-1)) for form in columns]
        tests = [f_statistic(plain, r, form.shape[-1], weight) for r, form in zip(projected, columns, strict=True)]
        weights = [max(0.0, 1.0 - critical / f) if f > 0.0 else 0.0 for f, critical in tests]
        best = int(np.argmax(weights))
        extended = np.concatenate([regression.y, always, columns[best]], axis=-1)
        sizes = solve(extended, regression.tau, weight)[-columns[best].shape[-1] :]
        if name in CERTAIN_EFFECTS and tests[best][0] > 0.0 and (sizes > 0.0).all():
            results[name] = Perturbation((projected[best],), tests[best][0] / (1.0 + tests[best][0]))
            continue
        if name in MAX_TORQUE_SHARE:
            torque = columns[best] @ sizes
            largest, most = np.abs(torque).max(axis=-1), MAX_TORQUE_SHARE[name] * np.abs(regression.tau).max(axis=-1)
            weights[best] *= float(np.min(np.divide(most, largest, out=np.ones(2), where=largest > most))) ** 2
        results[name] = Perturbation((projected[best],), weights[best], rival=True)
    return results


def perturbations(logs: Sequence[WeightedLog], plain: Regression, delay_error: float = 0.0) -> dict[str, Perturbation]:
    """Change the regression of logs: filters, delay (if its error is not 0), lambda, `UNMODELLED_EFFECTS`, SIMEX."""
    results = {"filters": Perturbation(tuple(join_filtered(logs, *factors) for factors in FILTER_FACTORS))}
    if delay_error > 0.0:
        results["delay"] = Perturbation(tuple(join_filtered(logs, later=by) for by in (-delay_error, delay_error)))
    steeper = tuple(join_filtered(logs, steeper=factor) for factor in STEEPNESS_FACTORS)
    results["lambda"] = Perturbation(steeper, 1.0 / 3.0)  # a rectangular distribution, as of an unmodelled effect
    if any(term.kind == STRIBECK for term in logs[0].terms):
        speeds = tuple(join_filtered(logs, stribeck=factor) for factor in STRIBECK_FACTORS)
        results["speed of Stribeck friction"] = Perturbation(speeds, 1.0 / 3.0)
    return results | unmodelled_effects(logs, plain, plain) | {SIMEX: Perturbation((simex(plain),))}


def type_b_variance(
    solution: Callable[[Regression], Array], beta: Array, perturbations: Mapping[str, Perturbation]
) -> tuple[Array, Array]:
    """Compute the variance of type B of an estimate (9,), and the squared shift by errors of the motion (`SIMEX`)."""
    type_b, unmodelled, attenuation = np.zeros((3, len(beta)))
    for name, perturbation in perturbations.items():
        shifts = [np.square(solution(r) - beta) for r in perturbation.regressions]
        square = perturbation.weight * np.mean(shifts, axis=0)
        if name == SIMEX:
            attenuation = square
        elif perturbation.rival:
            unmodelled = np.maximum(unmodelled, square / 3.0)  # variance of a rectangular distribution up to that shift
        else:
            type_b += square
    return type_b + unmodelled, attenuation


def _noise(regression: Regression) -> tuple[float, float]:
    """Variance of the torque errors, N^2 m^2, and rows that are worth one independent row."""
    beta = solve(regression.y, regression.tau)
    time = correlation_time(regression.tau - regression.y @ beta, regression.h)
    return mean_variance(regression, beta), max(2.0 * time / regression.h - 1.0, 1.0)


def combination_variances(
    coefficients: Array, regression: Regression, perturbations: Mapping[str, Perturbation]
) -> tuple[Array, Array]:
    """Compute variances (m,) of combinations (m, 9) of ordinary least squares: of sampling, and of all else."""
    y, (variance, rows) = regression.y.reshape(-1, coefficients.shape[-1]), _noise(regression)
    sampling = variance * rows * np.diag(coefficients @ np.linalg.pinv(y.T @ y) @ coefficients.T)

    def combine(r: Regression) -> Array:
        return coefficients @ solve(r.y, r.tau)

    return sampling, sum(type_b_variance(combine, combine(regression), perturbations), np.zeros(()))


def attach_prior(
    prior: Prior, regression: Regression, perturbations: Mapping[str, Perturbation]
) -> tuple[Regression, dict[str, Perturbation]]:
    """Add a prior to a regression and its perturbations, and the uncertainty of its means as one more of them.

    The squared shifts by means that are off by their standard deviations add up (GUM 5.1.2). In linear least squares
    they complete the covariance of the posterior. The log counts by its whole variance, of sampling and type B.
    """
    variance, rows = _noise(regression)
    sampling, shifted = combination_variances(prior.coefficients, regression, perturbations)
    inflation = 1.0 + np.where(sampling > 0.0, shifted / np.where(sampling > 0.0, sampling, 1.0), 0.0)
    prior = replace(prior, variance=variance, correlated=rows, inflation=inflation)
    results = {
        name: replace(perturbation, regressions=tuple(replace(r, prior=prior) for r in perturbation.regressions))
        for name, perturbation in perturbations.items()
    }
    shifts = tuple(replace(regression, prior=shifted) for shifted in prior.shifted())
    if shifts:
        results["prior"] = Perturbation(shifts, float(len(shifts)))
    return replace(regression, prior=prior), results


# Sampling, and the interval.


@dataclass(frozen=True)
class Uncertainty:
    """Uncertainty of an estimate, each array of shape (9,)."""

    standard_error: Array  # combined standard uncertainty of sampling and type B
    low: Array  # ends of the 95 % interval
    high: Array


def block_length(error: Array, h: float) -> int:
    """Samples in a block, from the residuals (2, n) of a fit."""
    length = round(CORRELATION_TIMES_PER_BLOCK * correlation_time(error, h) / h)
    return int(np.clip(length, 1, max(error.shape[-1] // MIN_BLOCKS, 1)))


def resample(n: int, length: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """Draw the sample indices of one replicate: blocks of `length` that begin anywhere, `n` samples in all."""
    starts = rng.integers(0, n - length + 1, size=-(-n // length))
    return (starts[:, None] + np.arange(length)).reshape(-1)[:n]


def fit_replicate(
    method: Method, regression: Regression, first: Estimate, times: NDArray[np.intp] | None = None
) -> Array:
    """Apply a method again to a regression, each of whose samples counts `times` (n,); returns (9,)."""
    if method.sums_suffice:
        regression = condense(regression, times)
    elif times is not None:
        regression = regression.take(np.repeat(np.arange(times.size), times))
    return method.repeat(regression, first)


def jackknife(method: Method, regression: Regression, first: Estimate) -> tuple[Array, int]:
    """Compute the variance (9,) by the delete-a-group jackknife and its degrees of freedom."""
    n = regression.t.size
    group = np.arange(n) * GROUPS // n
    estimates = []
    for k in range(GROUPS):
        with suppress(NoSolutionError):
            estimates.append(fit_replicate(method, regression, first, (group != k).astype(np.intp)))
    freedom = len(estimates) - 1
    if freedom < 1:
        return np.zeros(len(first.beta)), 1
    return freedom * np.var(estimates, axis=0), freedom


def bootstrap(
    method: Method,
    regression: Regression,
    first: Estimate,
    perturbations: Mapping[str, Perturbation],
    rng: np.random.Generator,
    replicates: int = REPLICATES,
    report: Callable[[int, int], None] = lambda *_: None,
) -> Uncertainty:
    """Compute standard errors and 95 % intervals of a method on the regression that gave the estimate `first`."""
    n, beta = regression.t.size, first.beta
    length = block_length(regression.tau - regression.y @ beta, regression.h)
    if not method.needs_even_odd:  # two thirds of what a replicate copies
        regression = replace(regression, even_odd=None)
    drawn = []
    for k in range(replicates):
        times = np.bincount(resample(n, length, rng), minlength=n)
        with suppress(NoSolutionError):  # a block drawn so often that it determines too little
            drawn.append(fit_replicate(method, regression, first, times))
        report(k + 1, replicates)
    if len(drawn) < max(replicates // 2, 2):
        raise NoSolutionError("most replicates of the bootstrap have no solution")
    sampling = np.var(drawn, axis=0, ddof=1)
    blocks = max(n // length - 1, 1)
    slow, groups = jackknife(method, regression, first)
    slower = slow > float(fdtri(groups, blocks, 1.0 - F_TEST_LEVEL)) * sampling
    sampling = np.where(slower, slow, sampling)
    type_b, attenuation = type_b_variance(lambda r: fit_replicate(method, r, first), beta, perturbations)
    if method.unbiased is not None:
        type_b += (method.unbiased(regression).beta - beta) ** 2
    factors = stdtrit(np.where(slower, groups, blocks), 0.975), float(stdtrit(blocks, 0.975))
    half_width = np.sqrt(factors[0] ** 2 * sampling + factors[1] ** 2 * type_b + attenuation)
    return Uncertainty(np.sqrt(sampling + type_b), beta - half_width, beta + half_width)
