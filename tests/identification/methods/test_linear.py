"""Robust, instrumental and weighted least squares: SciPy, conditions of optimality, Monte Carlo with known truth."""

from dataclasses import replace

import log_example
import numpy as np
import pytest
from hypothesis import given, settings
from log_example import BETA
from regression_example import log_from, problem, random_regressor
from scipy.optimize import least_squares
from strategies import seeds

from repro.identification.methods.every import METHODS
from repro.identification.methods.interface import joint_variance
from repro.identification.parallel import FilterSettings, prepare
from repro.identification.solve import solve


def beta_of(name, regression):
    return METHODS[name].estimate(regression).beta


def hostile(seed, n=40):
    """A regression whose best parameters are often not physical: signs of the truth are drawn."""
    rng = np.random.default_rng(seed)
    y = random_regressor(rng, n)
    noise = rng.choice([0.01, 0.1, 1.0]) * rng.normal(size=(2, n))
    return problem(y, y @ (BETA * rng.choice([-1.0, 1.0, 1.0], 9)) + noise)


# Robust.


def heavy_tailed(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(30, 200))
    y = random_regressor(rng, n)
    size = np.array([[0.1], [0.3]]) * rng.choice([0.1, 1.0, 10.0])
    return problem(y, y @ BETA + size * rng.standard_t(3, size=(2, n)))


def scales(error):
    """Standard deviation of each joint by the median of the error's size."""
    return np.median(np.abs(error), axis=1, keepdims=True) / 0.6744897501960817


@given(seeds)
@settings(max_examples=30)
def test_robust_minimises_huber_s_loss(seed):
    """SciPy's minimiser of the same loss, at the scales that the estimate leaves."""
    regression = heavy_tailed(seed)
    y, tau, beta = regression.y, regression.tau, beta_of("robust", regression)
    scale = scales(tau - y @ beta)
    rows = -(y / scale[..., np.newaxis]).reshape(-1, 9)
    found = least_squares(
        lambda b: ((tau - y @ b) / scale).reshape(-1), solve(y, tau), jac=lambda _: rows, loss="huber", f_scale=1.345,
        xtol=1e-14, ftol=1e-14, gtol=1e-12, x_scale="jac",
    )  # fmt: skip
    standard_error = np.sqrt(np.diag(np.linalg.inv(rows.T @ rows)))
    assert (np.abs(found.x - beta) / standard_error).max() < 0.01


@given(seeds)
@settings(max_examples=30)
def test_robust_is_stationary(seed):
    """The sum of psi(error / scale) y / scale is zero, psi being cut off at 1.345."""
    regression = heavy_tailed(seed)
    error = regression.tau - regression.y @ beta_of("robust", regression)
    scale = scales(error)
    psi = np.clip(error / scale, -1.345, 1.345) / scale
    total = np.einsum("jn,jnp->p", psi, regression.y)
    assert (np.abs(total) < 2e-3 * np.einsum("jn,jnp->p", np.abs(psi), np.abs(regression.y))).all()


@pytest.mark.parametrize("seed", range(5))
def test_gross_outliers_move_ordinary_far_and_robust_little(seed):
    rng = np.random.default_rng(seed)
    y = random_regressor(rng, 150)
    tau = y @ BETA + 0.02 * rng.normal(size=(2, 150))
    hit = rng.random(tau.shape) < 0.1
    spoiled = problem(y, tau + np.where(hit, rng.uniform(5.0, 7.0, tau.shape), 0.0))
    clean = solve(y, tau)
    ordinary, robust = (np.linalg.norm(beta_of(name, spoiled) - clean) for name in ("ordinary", "robust"))
    assert ordinary > 0.2
    assert robust < ordinary / 20.0
    lowered = float(METHODS["robust"].estimate(spoiled).notes[0].split(" %")[0])
    assert lowered >= 100.0 * hit.mean()


def test_robust_costs_little_where_errors_are_normal():
    """95 % efficiency: the variance is about 1/0.95 of least squares'."""
    ordinary, robust = [], []
    for seed in range(200):
        rng = np.random.default_rng(seed)
        y = random_regressor(rng, 100)
        regression = problem(y, y @ BETA + 0.1 * rng.normal(size=(2, 100)))
        ordinary.append(beta_of("ordinary", regression) - BETA)
        robust.append(beta_of("robust", regression) - BETA)
    ratio = np.mean(np.square(ordinary), 0) / np.mean(np.square(robust), 0)
    assert 0.9 < ratio.mean() < 1.0


# Instrumental variables.


def test_noise_in_the_regressor_attenuates_ordinary_and_not_instrumental():
    """Two regressors with noise of their own, 0.7 of each column's size; truth counts alike in every column."""
    ordinary, instrumental = [], []
    for seed in range(200):
        rng = np.random.default_rng(seed)
        y = random_regressor(rng, 200)
        size = np.sqrt(np.mean(y**2, axis=(0, 1)))
        halves = y + 0.7 * size * rng.normal(size=(2, *y.shape)) * (y != 0.0)
        regression = problem(halves.mean(0), y @ (1.0 / size) + 0.02 * rng.normal(size=(2, 200)), halves)
        ordinary.append(beta_of("ordinary", regression) * size - 1.0)
        instrumental.append(beta_of("instrumental", regression) * size - 1.0)
    biased, fair = np.mean(ordinary, 0), np.mean(instrumental, 0)
    assert (biased < -0.03).all()
    assert biased.mean() < -0.08
    assert np.abs(fair).max() < 0.03
    standard_error = np.std(instrumental, 0) / np.sqrt(200)
    assert (np.abs(fair) < 4.0 * standard_error).all()


def test_noise_in_the_position_biases_inertia_less_with_instruments():
    """The whole way from a log: inertia and gravity, which noise does not enter through a tanh."""
    ordinary, instrumental = [], []
    log = log_from(log_example.motion)
    for seed in range(10):
        noise = 0.004 * np.random.default_rng(seed).normal(size=log.q.shape)
        regression = prepare(replace(log, q=log.q + noise), FilterSettings(cutoff=5.0))
        ordinary.append(beta_of("ordinary", regression) / BETA - 1.0)
        instrumental.append(beta_of("instrumental", regression) / BETA - 1.0)
    biased, fair = np.mean(ordinary, 0)[:5], np.mean(instrumental, 0)[:5]
    assert (biased < 0.0).all()
    assert biased[0] < -0.05
    assert (np.abs(fair) < 0.7 * np.abs(biased)).all()
    assert abs(fair[0]) < 0.2 * abs(biased[0])


@given(seeds)
@settings(max_examples=30)
def test_instruments_without_noise_make_it_weighted_least_squares(seed):
    regression = hostile(seed)
    first = solve(regression.y, regression.tau)
    expected = solve(regression.y, regression.tau, 1.0 / joint_variance(regression, first))
    np.testing.assert_allclose(beta_of("instrumental", regression), expected, rtol=1e-7, atol=1e-9)


# Weighted.


def uneven(seed, n=150, size=((1.0,), (0.02,))):
    rng = np.random.default_rng(seed)
    y = random_regressor(rng, n)
    return problem(y, y @ BETA + np.array(size) * rng.normal(size=(2, n)))


@given(seeds)
@settings(max_examples=30)
def test_weighted_solves_its_own_normal_equations(seed):
    """With weights from the very residuals that it leaves."""
    regression = uneven(seed)
    error = regression.tau - regression.y @ beta_of("weighted", regression)
    weighted = error / np.mean(error**2, axis=1, keepdims=True)
    total = np.einsum("jn,jnp->p", weighted, regression.y)
    assert (np.abs(total) < 1e-9 * np.einsum("jn,jnp->p", np.abs(weighted), np.abs(regression.y))).all()


def test_weighted_is_generalised_least_squares_of_known_variances():
    weighted, known, ordinary = [], [], []
    for seed in range(100):
        regression = uneven(seed)
        rows = (regression.y / np.array([1.0, 0.02])[:, np.newaxis, np.newaxis]).reshape(-1, 9)
        whitened = (regression.tau / np.array([[1.0], [0.02]])).reshape(-1)
        known.append(np.linalg.lstsq(rows, whitened)[0] - BETA)
        weighted.append(beta_of("weighted", regression) - BETA)
        ordinary.append(beta_of("ordinary", regression) - BETA)
    spread = np.std(known, 0)
    assert (np.std(np.array(weighted) - known, 0) < 0.02 * spread).all()
    assert (np.abs(np.mean(weighted, 0)) < 4.0 * spread / np.sqrt(100)).all()
    # Parameters that the accurate joint shows gain; those of joint 1 alone cannot.
    gain = np.std(ordinary, 0) / np.std(weighted, 0)
    assert (gain[[1, 2, 4, 6, 8]] > 2.0).all()
    assert (gain > 0.9).all()
