"""Regressions: several logs as one, standstill, the correlation of residuals, and a Gaussian prior."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from log_example import BETA, motion
from ownarm_problem import noisy
from regression_example import H, beta_of, noisy_problem, regression_of
from scipy.optimize import lsq_linear
from strategies import seeds

from repro.identification.excitation import excitation
from repro.identification.filtering import FilterSettings, prepare
from repro.identification.least_squares import METHODS
from repro.identification.regression import (
    STANDSTILL_SPEED,
    Prior,
    drop_standstill,
    joined,
    masked,
    residual_autocorrelation,
)
from repro.identification.solve import solve
from repro.identification.uncertainty import Perturbation, attach_prior, bootstrap
from repro.logs.log import Log
from repro.model.dynamics import inverse_dynamics


def parts(seed, sizes=(30, 50, 40)):
    rng = np.random.default_rng(seed)
    return [regression_of(rng.normal(size=(2, n, 9)), rng.normal(size=(2, n))) for n in sizes]


@given(seeds)
def test_least_squares_of_all_is_that_of_all_rows(seed):
    found = joined(parts(seed), (1.0, 2.0, 0.5))
    rows = [(w * p.y.reshape(-1, 9), w * p.tau.reshape(-1)) for w, p in zip((1.0, 2.0, 0.5), parts(seed), strict=True)]
    expected = np.linalg.lstsq(np.concatenate([y for y, _ in rows]), np.concatenate([tau for _, tau in rows]))[0]
    np.testing.assert_allclose(solve(found.y, found.tau), expected, rtol=1e-6, atol=1e-9)


def test_times_go_on_and_every_signal_has_all_samples():
    found = joined(parts(0))
    assert found.t.size == 120
    assert (np.diff(found.t) > 0).all()
    for name, axis in (("y", 1), ("tau", 1), ("q", 1), ("dq", 1), ("ddq", 1), ("mask", 1), ("even_odd", 2)):
        assert getattr(found, name).shape[axis] == 120


@pytest.mark.parametrize("name", sorted(METHODS))
def test_a_log_given_as_two_halves_gives_what_it_gave(name):
    whole = noisy_problem(2, 200, 0.01)
    both = joined([whole.take(np.arange(100)), whole.take(np.arange(100, 200))])
    np.testing.assert_allclose(beta_of(name, both), beta_of(name, whole), rtol=1e-6)


# Standstill.


def stopped():
    """A motion that slows down to a hold of five seconds and goes on; friction carries 0.5 N m during the hold."""
    t = np.arange(0.0, 18.0, 0.005)
    pace = 1.0 - 0.5 * (np.tanh((t - 6.0) / 0.2) - np.tanh((t - 11.0) / 0.2))
    s = np.cumsum(pace) * 0.005
    q, dq, ddq = motion(s)
    dq, ddq = dq * pace, ddq * pace**2 + dq * np.gradient(pace, t)
    tau = inverse_dynamics(q, dq, ddq, BETA)
    tau[:, pace < 1e-3] += 0.5
    return Log(name="log.csv", t=t, q=q, tau=tau), (7.0, 10.0)


@pytest.fixture(scope="module")
def regression():
    log, hold = stopped()
    return prepare(log, FilterSettings(cutoff=5.0)), hold


def test_rows_of_the_hold_weigh_nothing_and_the_rest_is_unchanged(regression):
    whole, (begin, end) = regression
    moving = drop_standstill(whole)
    inside = (whole.t > begin) & (whole.t < end)
    assert not moving.mask[:, inside].any()
    assert not moving.tau[:, inside].any()
    assert not moving.y[:, inside].any()
    kept = moving.mask
    assert np.array_equal(moving.tau[kept], whole.tau[kept])
    assert np.array_equal(moving.y[kept], whole.y[kept])
    assert (np.abs(whole.dq[kept]) >= STANDSTILL_SPEED).all()
    assert kept[:, ~inside].mean() > 0.8


@pytest.mark.parametrize("name", ["ordinary", "weighted", "robust", "instrumental", "consistent"])
def test_gravity_is_found_beside_a_hold_that_friction_carries(regression, name):
    whole, _ = regression
    beta = beta_of(name, drop_standstill(whole))
    assert beta[3:5] == pytest.approx(BETA[3:5], rel=0.05)
    worse = beta_of("ordinary", whole)
    assert np.abs(worse[3:5] / BETA[3:5] - 1).max() > 0.1


# Residuals.


def test_whiteness_of_a_residual_made_by_hand():
    # Centred -1.5, -0.5, 0.5, 1.5: 0.75 - 0.25 + 0.75 over 5 at a lag of one; at two -0.75 - 0.75.
    tau = np.array([[1.0, 2.0, 3.0, 4.0], [1.0, -1.0, 1.0, -1.0]])
    zero = np.zeros((2, 4, 9))
    assert residual_autocorrelation(regression_of(zero, tau, H), BETA, 1 / H) == pytest.approx((0.25, -0.75))
    assert residual_autocorrelation(regression_of(zero, tau, H), BETA, 0.5 / H) == pytest.approx((-0.3, 0.5))
    # A lag beyond the log, a residual that is constant, and one that is zero.
    assert residual_autocorrelation(regression_of(zero, tau, H), BETA, 0.1 / H) == (0.0, 0.0)
    assert residual_autocorrelation(regression_of(zero, np.array([[2.0] * 4, [0.0] * 4]), H), BETA, 1 / H) == (0.0, 0.0)


# A Gaussian prior, against Bayesian linear regression in closed form and a simulated arm with known truth.


SIZE = 0.05
NOTHING = np.full(9, np.inf)


def prior_of(**entries):
    names = ("I1", "I2", "I3", "g1", "g2", "b1", "b2", "k1", "k2")
    mean, sd = np.zeros(9), NOTHING.copy()
    for name, (value, spread) in entries.items():
        mean[names.index(name)], sd[names.index(name)] = value, spread
    return Prior(mean, sd)


def posterior(regression, prior, variance):
    """Mean and covariance of Bayesian linear regression with white noise of this variance in each row."""
    rows, tau = regression.y.reshape(-1, 9), regression.tau.reshape(-1)
    before = np.diag(np.where(np.isfinite(prior.sd), 1.0 / prior.sd**2, 0.0))
    covariance = np.linalg.inv(rows.T @ rows / variance + before)
    return covariance @ (rows.T @ tau / variance + before @ prior.mean), covariance


PRIOR = prior_of(
    I1=(BETA[0] + 4e-4, 4e-4), g1=(BETA[3] - 4e-3, 4e-3), b1=(BETA[5] + 1e-3, 1e-3), k2=(BETA[8] - 2e-3, 3e-3)
)


@pytest.mark.parametrize("name", ["ordinary", "bounded", "consistent"])
def test_the_estimate_is_the_mean_of_the_posterior(name):
    r = noisy(BETA, size=SIZE)
    r = replace(r, prior=replace(PRIOR, variance=SIZE**2))
    expected, _ = posterior(r, PRIOR, SIZE**2)
    alone, _ = posterior(r, prior_of(), SIZE**2)
    assert (expected > 0.0).all()
    assert METHODS[name].estimate(r).beta == pytest.approx(expected, rel=1e-6, abs=1e-9)
    assert np.abs(expected - alone).max() > 5e-4


@pytest.mark.parametrize(("name", "share"), [("weighted", 0.05), ("robust", 0.6), ("instrumental", 0.05)])
def test_methods_that_weight_rows_are_between_the_log_and_the_prior(name, share):
    r = noisy(BETA, size=SIZE)
    r = replace(r, even_odd=np.stack([r.y, r.y]))
    found = METHODS[name].estimate(replace(r, prior=replace(PRIOR, variance=SIZE**2))).beta
    expected, covariance = posterior(r, PRIOR, SIZE**2)
    assert np.abs(found - expected).max() < share * np.sqrt(covariance.diagonal()).max()
    strong = METHODS[name].estimate(replace(r, prior=Prior(PRIOR.mean, 1e-4 * PRIOR.sd, SIZE**2))).beta
    assert strong[[0, 3, 5, 8]] == pytest.approx(PRIOR.mean[[0, 3, 5, 8]], rel=1e-3)


def test_bounds_apply_next_to_a_prior():
    r, prior = noisy(BETA, size=SIZE), prior_of(b1=(0.0, 1e-3), b2=(-0.5, 1e-3))
    r = replace(r, prior=replace(prior, variance=SIZE**2))
    rows = np.vstack([r.y.reshape(-1, 9) / SIZE, np.diag([0.0] * 5 + [1e3, 1e3, 0.0, 0.0])])
    right = np.concatenate([r.tau.reshape(-1) / SIZE, prior.mean * 1e3])
    expected = lsq_linear(rows, right, (0.0, np.inf), tol=1e-14).x
    found = METHODS["bounded"].estimate(r).beta
    assert found == pytest.approx(expected, rel=1e-4, abs=1e-6)
    assert found[6] == 0.0


def test_known_parameters_count_as_determined():
    still = replace(noisy(BETA, size=SIZE), y=np.zeros_like(noisy(BETA, size=SIZE).y))
    assert excitation(replace(still, prior=Prior(BETA, np.zeros(9)))).rank == 9
    assert excitation(replace(still, prior=Prior(BETA, np.r_[np.zeros(4), np.full(5, np.inf)]))).rank == 4


@pytest.mark.parametrize("name", [name for name in METHODS if name != "instrumental"])
def test_a_known_parameter_is_kept_and_the_others_are_fitted_to_the_rest(name):
    r, prior = noisy(BETA, size=SIZE), prior_of(I1=(1.05 * BETA[0], 0.0), k1=(0.5 * BETA[7], 0.0))
    kept = [0, 7]
    free = [k for k in range(9) if k not in kept]
    found = METHODS[name].estimate(replace(r, prior=prior)).beta
    assert found[kept] == pytest.approx(prior.mean[kept], abs=0)
    if name in ("ordinary", "bounded", "consistent"):
        rest = r.tau.reshape(-1) - r.y.reshape(-1, 9)[:, kept] @ prior.mean[kept]
        expected = np.linalg.lstsq(r.y.reshape(-1, 9)[:, free], rest, rcond=None)[0]
        assert (expected > 0.0).all()
        assert found[free] == pytest.approx(expected, rel=1e-6)
    assert METHODS[name].repeat(replace(r, prior=prior), METHODS[name].estimate(replace(r, prior=prior))) == (
        pytest.approx(found, rel=1e-9)
    )


def test_standard_errors_are_those_of_the_posterior():
    method, found = METHODS["ordinary"], []
    for seed in range(7):
        r = noisy(BETA, seed=seed, size=SIZE)
        attached, others = attach_prior(PRIOR, r, {})
        assert attached.prior.variance == pytest.approx(SIZE**2, rel=0.1)
        assert attached.prior.correlated == pytest.approx(1.0, abs=0.3)
        spread = bootstrap(method, attached, method.estimate(attached), others, np.random.default_rng(seed))
        found.append(spread.standard_error)
    _, covariance = posterior(r, PRIOR, SIZE**2)
    assert np.median(found, axis=0) == pytest.approx(np.sqrt(covariance.diagonal()), rel=0.2)


def test_the_log_counts_by_its_whole_variance():
    # Two analyses 0.2 apart in g1: the log alone has this standard uncertainty, many times its sampling error.
    r, prior = noisy(BETA, size=SIZE), prior_of(g1=(BETA[3] + 0.3, 0.1))
    apart = Perturbation(tuple(replace(r, tau=r.tau + step * r.y[..., 3]) for step in (-0.2, 0.2)))
    attached, others = attach_prior(prior, r, {"delay": apart})
    method = METHODS["ordinary"]
    estimate = method.estimate(attached)
    weight = 0.1**2 / (0.1**2 + 0.2**2)
    assert estimate.beta[3] == pytest.approx(weight * BETA[3] + (1.0 - weight) * prior.mean[3], abs=0.02)
    spread = bootstrap(method, attached, estimate, others, np.random.default_rng(1))
    assert spread.standard_error[3] == pytest.approx(0.1 * 0.2 / np.hypot(0.1, 0.2), rel=0.1)


def test_a_joint_without_rows_does_not_weaken_the_log():
    r = noisy(BETA, size=SIZE)
    one = masked(r, np.array([[True], [False]]) & r.mask)
    assert attach_prior(PRIOR, one, {})[0].prior.variance == pytest.approx(SIZE**2, rel=0.1)


def test_what_the_motion_does_not_excite_comes_from_the_prior():
    r = noisy(BETA, size=SIZE)
    blind = replace(r, y=r.y * np.array([1, 1, 1, 0, 1, 1, 1, 1, 1]), tau=r.tau - BETA[3] * r.y[..., 3])
    assert (excitation(blind).rank, excitation(blind).determined[3]) == (8, False)
    for sd in (0.2, 0.0):
        seen, _ = attach_prior(prior_of(g1=(3.0, sd)), blind, {})
        assert (excitation(seen).rank, excitation(seen).determined[3]) == (9, True)
        for name in ("ordinary", "consistent", "weighted"):
            assert METHODS[name].estimate(seen).beta[3] == pytest.approx(3.0)
