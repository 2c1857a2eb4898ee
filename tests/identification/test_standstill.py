"""Standstill: static friction holds any torque, and must not be fitted as if Eq. 1 said so."""

import numpy as np
import pytest
from log_example import BETA, motion

from repro.identification.methods.every import METHODS
from repro.identification.methods.interface import joint_variance
from repro.identification.parallel import FilterSettings, prepare
from repro.identification.standstill import STILL, without_standstill
from repro.logs.log import Log
from repro.model.dynamics import inverse_dynamics


def stopped():
    """A motion that slows down to a hold of five seconds and goes on; friction carries 0.5 N m during the hold."""
    t = np.arange(0.0, 18.0, 0.005)
    pace = 1.0 - 0.5 * (np.tanh((t - 6.0) / 0.2) - np.tanh((t - 11.0) / 0.2))
    s = np.cumsum(pace) * 0.005
    q, dq, ddq = motion(s)
    dq, ddq = dq * pace, ddq * pace**2 + dq * np.gradient(pace, t)
    tau = inverse_dynamics(q, dq, ddq, BETA)
    tau[:, pace < 1e-3] += 0.5
    return Log("log.csv", t, q, tau), (7.0, 10.0)


@pytest.fixture(scope="module")
def regression():
    log, hold = stopped()
    return prepare(log, FilterSettings(cutoff=5.0)), hold


def test_rows_of_the_hold_weigh_nothing_and_the_rest_is_unchanged(regression):
    whole, (begin, end) = regression
    moving = without_standstill(whole)
    inside = (whole.t > begin) & (whole.t < end)
    assert not moving.moving[:, inside].any()
    assert not moving.tau[:, inside].any()
    assert not moving.y[:, inside].any()
    kept = moving.moving
    assert np.array_equal(moving.tau[kept], whole.tau[kept])
    assert np.array_equal(moving.y[kept], whole.y[kept])
    assert (np.abs(whole.dq[kept]) >= STILL).all()
    assert kept[:, ~inside].mean() > 0.8


@pytest.mark.parametrize("name", ["ordinary", "weighted", "robust", "instrumental", "consistent"])
def test_gravity_is_found_beside_a_hold_that_friction_carries(regression, name):
    whole, _ = regression
    beta = METHODS[name].estimate(without_standstill(whole)).beta
    assert beta[3:5] == pytest.approx(BETA[3:5], rel=0.05)
    worse = METHODS["ordinary"].estimate(whole).beta
    assert np.abs(worse[3:5] / BETA[3:5] - 1).max() > 0.1


def test_the_scale_of_the_errors_is_that_of_the_moving_samples(regression):
    whole, _ = regression
    moving = without_standstill(whole)
    beta = 1.1 * np.asarray(BETA)
    for joint in range(2):
        rows = moving.moving[joint]
        error = whole.tau[joint, rows] - whole.y[joint, rows] @ beta
        assert joint_variance(moving, beta)[joint, 0] == pytest.approx(np.mean(error**2))
