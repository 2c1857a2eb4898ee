"""Regressions: several logs as one, standstill, the correlation of residuals, and a Gaussian prior."""

from dataclasses import replace

import numpy as np
import pytest
from fitting_problem import noisy
from hypothesis import given
from log_example import BETA, motion
from regression_example import H, beta_of, noisy_problem, regression_of, rows_of
from scipy.optimize import lsq_linear
from strategies import seeds

from repro.identification.excitation import excitation
from repro.identification.filtering import FilterSettings, prepare
from repro.identification.least_squares import METHODS
from repro.identification.log import Log
from repro.identification.regression import (
    Prior,
    Relation,
    drop_standstill,
    joined,
    masked,
    residual_autocorrelation,
    solve,
)
from repro.identification.uncertainty import Perturbation, attach_prior, bootstrap
from repro.model.dynamics import inverse_dynamics
from repro.model.parameters import NAMES


def parts(seed):
    rng = np.random.default_rng(seed)
    return [regression_of(rng.normal(size=(2, n, 9)), rng.normal(size=(2, n))) for n in (30, 50, 40)]


@given(seeds)
def test_joined_regressions_have_every_sample_and_least_squares_of_all_rows(seed):
    found, weights = joined(parts(seed), (1.0, 2.0, 0.5)), np.repeat([1.0, 2.0, 0.5], [60, 100, 80])
    rows, right = (np.concatenate(x) for x in zip(*((rows_of(p), p.tau.reshape(-1)) for p in parts(seed)), strict=True))
    expected = np.linalg.lstsq(weights[:, np.newaxis] * rows, weights * right)[0]
    np.testing.assert_allclose(solve(found.y, found.tau), expected, rtol=1e-6, atol=1e-9)
    assert found.t.size == 120
    assert (np.diff(found.t) > 0).all()
    assert {x.shape for x in (found.q, found.dq, found.ddq, found.mask, found.even_odd[0, ..., 0])} == {(2, 120)}


@pytest.mark.parametrize("name", sorted(METHODS))
def test_a_log_given_as_two_halves_gives_what_it_gave(name):
    whole = noisy_problem(2, 200, 0.01)
    both = joined([whole.take(np.arange(100)), whole.take(np.arange(100, 200))])
    np.testing.assert_allclose(beta_of(name, both), beta_of(name, whole), rtol=1e-6)


@pytest.fixture(scope="module")
def stopped():
    """A motion that slows down to a hold of five seconds and goes on; friction carries 0.5 N m during the hold."""
    t = np.arange(0.0, 18.0, 0.005)
    pace = 1.0 - 0.5 * (np.tanh((t - 6.0) / 0.2) - np.tanh((t - 11.0) / 0.2))
    q, dq, ddq = motion(np.cumsum(pace) * 0.005)
    dq, ddq = dq * pace, ddq * pace**2 + dq * np.gradient(pace, t)
    tau = inverse_dynamics(q, dq, ddq, BETA) + 0.5 * (pace < 1e-3)
    return prepare(Log(name="log.csv", t=t, q=q, tau=tau), FilterSettings(cutoff=5.0))


@pytest.mark.parametrize("name", ["ordinary", "weighted", "robust", "instrumental", "consistent"])
def test_gravity_is_right_in_spite_of_a_hold_that_friction_carries(stopped, name):
    without_standstill = drop_standstill(stopped)
    assert beta_of(name, without_standstill)[3:5] == pytest.approx(BETA[3:5], rel=0.05)
    assert np.abs(beta_of("ordinary", stopped)[3:5] / BETA[3:5] - 1).max() > 0.1
    # What remains is as it was, and most of what moves remains.
    rows, (begin, end) = without_standstill.mask, np.searchsorted(stopped.t, (7.0, 10.0))
    assert not rows[:, begin:end].any()
    assert np.delete(rows, slice(begin, end), axis=1).mean() > 0.8
    np.testing.assert_array_equal(without_standstill.tau[rows], stopped.tau[rows])
    np.testing.assert_array_equal(without_standstill.y[rows], stopped.y[rows])


def test_whiteness_of_a_residual_made_by_hand():
    # Centred -1.5, -0.5, 0.5, 1.5: 0.75 - 0.25 + 0.75 over 5 at a lag of one; at two -0.75 - 0.75.
    tau = np.array([[1.0, 2.0, 3.0, 4.0], [1.0, -1.0, 1.0, -1.0]])
    residual, flat = (regression_of(np.zeros((2, 4, 9)), x) for x in (tau, np.array([[2.0] * 4, [0.0] * 4])))
    assert residual_autocorrelation(residual, BETA, 1 / H) == pytest.approx((0.25, -0.75))
    assert residual_autocorrelation(residual, BETA, 0.5 / H) == pytest.approx((-0.3, 0.5))
    # A lag beyond the log, a residual that is constant, and one that is zero.
    assert (
        residual_autocorrelation(residual, BETA, 0.1 / H) == residual_autocorrelation(flat, BETA, 1 / H) == (0.0, 0.0)
    )


# A Gaussian prior, against Bayesian linear regression in closed form and a simulated arm with known truth.
SIZE = 0.05
R = noisy(BETA, size=SIZE)


def prior_of(**entries):
    mean, sd = np.zeros(9), np.full(9, np.inf)
    for name, (value, spread) in entries.items():
        mean[NAMES.index(name)], sd[NAMES.index(name)] = value, spread
    return Prior(mean, sd, SIZE**2)


def posterior(prior):
    """Mean and covariance of Bayesian linear regression with white noise of this size in each row."""
    before = np.diag(np.where(np.isfinite(prior.sd), 1.0 / prior.sd**2, 0.0))
    right = before @ prior.mean
    for relation in prior.relations:
        before = before + np.outer(relation.coefficients, relation.coefficients) / relation.sd**2
        right = right + relation.coefficients * relation.value / relation.sd**2
    covariance = np.linalg.inv(rows_of(R).T @ rows_of(R) / SIZE**2 + before)
    return covariance @ (rows_of(R).T @ R.tau.reshape(-1) / SIZE**2 + right), covariance


PRIOR = prior_of(
    I1=(BETA[0] + 4e-4, 4e-4), g1=(BETA[3] - 4e-3, 4e-3), b1=(BETA[5] + 1e-3, 1e-3), k2=(BETA[8] - 2e-3, 3e-3)
)


#: A relation of I2 and g2 that the log does not agree with by some of its standard errors, next to the prior.
OF_BOTH = np.eye(9)[1] - 0.05 * np.eye(9)[4]
RELATED = replace(PRIOR, relations=(Relation(OF_BOTH, 2e-4, OF_BOTH @ BETA + 4e-4),))


@pytest.mark.parametrize("prior", [PRIOR, RELATED], ids=["prior", "relation"])
@pytest.mark.parametrize("name", ["ordinary", "bounded", "consistent"])
def test_the_estimate_is_the_mean_of_the_posterior(name, prior):
    expected, _ = posterior(prior)
    assert (expected > 0.0).all()
    assert beta_of(name, replace(R, prior=prior)) == pytest.approx(expected, rel=1e-6, abs=1e-9)
    assert np.abs(expected - posterior(prior_of())[0]).max() > 5e-4


@pytest.mark.parametrize("name", sorted(METHODS))
def test_a_relation_of_nearly_no_uncertainty_is_satisfied(name):
    coefficients = np.zeros(9)
    coefficients[[1, 4]] = 1.0, -0.06
    prior = replace(prior_of(g1=(1.02 * BETA[3], 0.0)), relations=(Relation(coefficients, 1e-7),))
    beta = beta_of(name, replace(R, prior=prior))
    assert beta[1] == pytest.approx(0.06 * beta[4], abs=1e-5)
    assert beta[3] == 1.02 * BETA[3]


def test_a_relation_to_a_known_parameter_gives_the_other():
    """A measured length and a known g2 give I2."""
    coefficients = np.zeros(9)
    coefficients[[1, 4]] = 1.0, -0.06
    prior = replace(prior_of(g2=(0.9 * BETA[4], 0.0)), relations=(Relation(coefficients, 1e-7),))
    assert beta_of("ordinary", replace(R, prior=prior))[1] == pytest.approx(0.06 * 0.9 * BETA[4], abs=1e-5)


@pytest.mark.parametrize(("name", "share"), [("weighted", 0.05), ("robust", 0.6), ("instrumental", 0.05)])
def test_methods_that_weight_rows_are_between_the_log_and_the_prior(name, share):
    expected, covariance = posterior(PRIOR)
    error = np.abs(beta_of(name, replace(R, prior=PRIOR)) - expected)
    assert error.max() < share * np.sqrt(covariance.diagonal()).max()
    strong = beta_of(name, replace(R, prior=replace(PRIOR, sd=1e-4 * PRIOR.sd)))
    assert strong[[0, 3, 5, 8]] == pytest.approx(PRIOR.mean[[0, 3, 5, 8]], rel=1e-3)


def test_bounds_apply_next_to_a_prior():
    prior = prior_of(b1=(0.0, 1e-3), b2=(-0.5, 1e-3))
    rows = np.vstack([rows_of(R) / SIZE, np.diag([0.0] * 5 + [1e3, 1e3, 0.0, 0.0])])
    right = np.concatenate([R.tau.reshape(-1) / SIZE, prior.mean * 1e3])
    expected = lsq_linear(rows, right, (0.0, np.inf), tol=1e-14).x
    found = beta_of("bounded", replace(R, prior=prior))
    assert found == pytest.approx(expected, rel=1e-4, abs=1e-6)
    assert found[6] == 0.0


@pytest.mark.parametrize("name", [name for name in METHODS if name != "instrumental"])
def test_a_known_parameter_is_unchanged_and_the_others_are_fitted_to_the_rest(name):
    prior, known = prior_of(I1=(1.05 * BETA[0], 0.0), k1=(0.5 * BETA[7], 0.0)), [0, 7]
    r, method = replace(R, prior=prior), METHODS[name]
    estimate = method.estimate(r)
    assert estimate.beta[known] == pytest.approx(prior.mean[known], abs=0)
    assert method.repeat(r, estimate) == pytest.approx(estimate.beta, rel=1e-9)
    if name in ("ordinary", "bounded", "consistent"):
        rest = R.tau.reshape(-1) - rows_of(R)[:, known] @ prior.mean[known]
        expected = np.linalg.lstsq(np.delete(rows_of(R), known, axis=1), rest, rcond=None)[0]
        assert (expected > 0.0).all()
        assert np.delete(estimate.beta, known) == pytest.approx(expected, rel=1e-6)


def test_standard_errors_are_those_of_the_posterior():
    method, found = METHODS["ordinary"], []
    for seed in range(7):
        r = noisy(BETA, seed=seed, size=SIZE)
        attached, others = attach_prior(PRIOR, r, {})
        assert attached.prior.variance == pytest.approx(SIZE**2, rel=0.1)
        assert attached.prior.correlated == pytest.approx(1.0, abs=0.3)
        spread = bootstrap(method, attached, method.estimate(attached), others, np.random.default_rng(seed))
        found.append(spread.standard_error)
    _, covariance = posterior(PRIOR)
    assert np.median(found, axis=0) == pytest.approx(np.sqrt(covariance.diagonal()), rel=0.2)


def test_the_log_counts_by_its_whole_variance():
    # Two analyses 0.2 apart in g1: the log alone has this standard uncertainty, many times its sampling error.
    prior = prior_of(g1=(BETA[3] + 0.3, 0.1))
    apart = Perturbation(tuple(replace(R, tau=R.tau + step * R.y[..., 3]) for step in (-0.2, 0.2)))
    attached, others = attach_prior(prior, R, {"delay": apart})
    method = METHODS["ordinary"]
    estimate = method.estimate(attached)
    weight = 0.1**2 / (0.1**2 + 0.2**2)
    assert estimate.beta[3] == pytest.approx(weight * BETA[3] + (1.0 - weight) * prior.mean[3], abs=0.02)
    spread = bootstrap(method, attached, estimate, others, np.random.default_rng(1))
    assert spread.standard_error[3] == pytest.approx(0.1 * 0.2 / np.hypot(0.1, 0.2), rel=0.1)


def test_a_joint_without_rows_does_not_weaken_the_log():
    one = masked(R, np.array([[True], [False]]) & R.mask)
    assert attach_prior(PRIOR, one, {})[0].prior.variance == pytest.approx(SIZE**2, rel=0.1)


def test_what_the_motion_does_not_excite_comes_from_the_prior():
    blind = replace(R, y=R.y * (np.arange(9) != 3), tau=R.tau - BETA[3] * R.y[..., 3])
    assert (excitation(blind).rank, excitation(blind).determined[3]) == (8, False)
    for sd in (0.2, 0.0):
        seen, _ = attach_prior(prior_of(g1=(3.0, sd)), blind, {})
        assert (excitation(seen).rank, excitation(seen).determined[3]) == (9, True)
        for name in ("ordinary", "consistent", "weighted"):
            assert beta_of(name, seen)[3] == pytest.approx(3.0)
