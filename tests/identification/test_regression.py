"""Regressions: several logs as one, samples of standstill, and the correlation of residuals."""

import numpy as np
import pytest
from hypothesis import given
from log_example import BETA, motion
from regression_example import H, beta_of, noisy_problem, regression_of
from strategies import seeds

from repro.identification.filtering import FilterSettings, prepare
from repro.identification.least_squares import METHODS
from repro.identification.regression import (
    STANDSTILL_SPEED,
    drop_standstill,
    joined,
    residual_autocorrelation,
)
from repro.identification.solve import solve
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
