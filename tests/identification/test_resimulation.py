"""How well parameters predict: torque errors by hand, motions against SciPy's integrator and the simulated board."""

import time
from dataclasses import replace

import numpy as np
import pytest
from log_example import BETA, RATE, log_of, motion, recording
from regression_example import regression_of
from scipy.integrate import solve_ivp

from repro.identification.filtering import FilterSettings
from repro.identification.log import Log
from repro.identification.scores import WINDOW, integrate, position_errors, relative_rms, similarity
from repro.model.dynamics import forward_dynamics, inverse_dynamics
from repro.model.parameters import NAMES

#: A drive that holds each sample acts half a period late.
HELD = FilterSettings(delay=0.5 / RATE)
#: I2 from which on M(q) is not positive definite.
EDGE = 2.0 * np.sqrt(BETA[2] * (BETA[0] - BETA[2]))


def changed(name, factor, beta=BETA):
    """The parameters with one multiplied."""
    return beta * np.where(np.array(NAMES) == name, factor, 1.0)


@pytest.fixture(scope="module")
def held():
    """Four seconds of the known arm under a controller whose torque is held over each sample, by SciPy."""
    t = np.arange(round(4.0 * RATE)) / RATE
    wanted = motion(t)
    forward = inverse_dynamics(*wanted, BETA)
    x = np.concatenate([wanted[0][:, 0], wanted[1][:, 0]])
    q, tau = np.empty((2, t.size)), np.empty((2, t.size))
    for k in range(t.size):
        q[:, k] = x[:2]
        tau[:, k] = u = forward[:, k] + 5.0 * (wanted[0][:, k] - x[:2]) + 0.3 * (wanted[1][:, k] - x[2:])

        def derivative(_, state, u=u):
            return np.concatenate([state[2:], forward_dynamics(state[:2], state[2:], u, BETA)])

        x = solve_ivp(derivative, (0.0, 1.0 / RATE), x, rtol=1e-8, atol=1e-10).y[:, -1]
    return Log(name="held.csv", t=t, q=q, tau=tau)


def error(log, beta, settings=HELD):
    return position_errors(log, settings, beta[np.newaxis])[0]


def test_relative_rms_by_hand():
    y, tau = np.zeros((2, 4, 9)), np.array([[3.0, -3.0, 3.0, -3.0], [0.0, 0.0, 8.0, 6.0]])
    y[0, :, 0] = 1.0, -1.0, 1.0, -1.0  # rebuilt +-2 of +-3 N m
    y[1, :, 4] = 3.0, 4.0, 8.0, 6.0  # rebuilt to an error of 3 and 4 N m; both RMS have the same count
    beta = np.array([2.0, 0, 0, 0, 1.0, 0, 0, 0, 0])
    assert relative_rms(regression_of(y, tau), beta) == pytest.approx((1 / 3, 0.5))


def test_the_error_of_a_joint_without_torque_is_over_the_torques_that_add_up_to_nothing():
    """Inertia and gravity of 3 N m that cancel but for 0.03: 1 % of them, not 100 % of what is left."""
    y, beta = np.zeros((2, 4, 9)), np.array([1.0, 0, 0, 1.0, 0, 0, 0, 0, 0])
    y[0, :, 0], y[0, :, 3] = 3.0, -2.97
    r = regression_of(y, np.zeros((2, 4)))
    assert relative_rms(r, beta) == pytest.approx((0.03 / 5.97, 0.0))
    assert relative_rms(r, 0.0 * beta) == similarity(r, beta) == (0.0, 0.0)


@pytest.mark.slow
def test_wrong_parameters_err_more_the_more_they_are_wrong(held):
    names, factors = ("I1", "I3", "g1", "g2", "k1"), (1.0, 1.05, 1.2, 1.5)
    wrong = np.stack([changed(name, factor) for name in names for factor in factors])
    errors = np.reshape(position_errors(held, HELD, wrong), (len(names), len(factors), 2))
    assert (np.diff(errors, axis=1) > 0.0).all()
    assert (errors[:, 2] > 10.0 * errors[:, 0]).all()


@pytest.mark.parametrize(
    "change", [{"delay": HELD.delay - 0.005}, {"delay": HELD.delay + 0.005}, {"friction_steepness": 5.0}]
)
def test_delay_and_steepness_of_friction_count(held, change):
    assert max(error(held, BETA, replace(HELD, **change))) > 10 * max(error(held, BETA))


def test_windows_begin_from_the_recorded_state(held):
    # An error that grows for as long as the log lasts would be far above one that half a second makes.
    long = log_of(recording(np.arange(round(30 * RATE)) / RATE))
    beta = changed("b1", 1.3)
    assert max(error(long, beta, FilterSettings())) < 2.0 * max(error(held, beta)) + 1e-3


def test_inertia_that_is_not_positive_definite_has_no_motion(held):
    for k, wrong in ((1, 1.01 * EDGE), (1, -1.01 * EDGE), (2, -0.01), (2, 0.0), (0, 0.02)):
        assert error(held, np.where(np.arange(9) == k, wrong, BETA)) is None
    assert error(held, np.where(np.arange(9) == 1, 0.9 * EDGE, BETA)) is not None


def test_steps_are_short_enough_for_the_pose_with_the_least_inertia():
    beta = np.array([0.04, 0.0399, 0.02, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0])  # with joint 1 held, four times the inertia
    _, dq = integrate([0.0, 0.01, 0.02], np.zeros((2, 3)), [0.0, 0.0], [0.0, 1e-3], beta, 20.0)
    assert np.abs(dq).max() <= 1e-3


def test_negative_friction_is_simulated_as_it_is():
    driven = np.array([*BETA[:5], -0.03, 0.04, 0.2, -0.05])
    log = log_of(recording(beta=driven))
    true = error(log, driven, FilterSettings())
    assert max(true) < 3e-3
    for name in ("b1", "k2"):
        assert max(error(log, changed(name, 0.0, driven), FilterSettings())) > 5 * max(true)


#: Friction so negative that the speed overflows within a window, more or less stiff.
RUN_AWAY = [changed("b1", -500.0), changed("b2", -400.0), changed("b2", -1000.0)]
#: M(q) positive definite by a hair only.
NEARLY_SINGULAR = [np.array([BETA[0], sign * (1.0 - by) * EDGE, *BETA[2:]]) for sign, by in ((1, 1e-9), (-1, 1e-13))]
NEARLY_SINGULAR += [changed("I3", 1e-9, changed("I2", 0.0)), 1e-9 * BETA]


def test_a_bad_set_neither_spoils_nor_slows_the_others(held):
    good = [BETA, changed("g1", 1.2)]
    alone = position_errors(held, HELD, np.stack(good))
    begin = time.perf_counter()
    together = position_errors(held, HELD, np.stack([*NEARLY_SINGULAR, *good]))
    assert time.perf_counter() - begin < 5.0  # with steps short enough for a nearly singular M(q), minutes
    assert together == [None] * len(NEARLY_SINGULAR) + alone
    beside = position_errors(held, HELD, np.stack([*RUN_AWAY, *good]))
    assert beside[: len(RUN_AWAY)] == [None] * len(RUN_AWAY)
    for found, expected in zip(beside[len(RUN_AWAY) :], alone, strict=True):
        assert found == pytest.approx(expected, rel=1e-3, abs=5e-6)  # steps are shorter


def test_a_log_shorter_than_a_window_has_no_motion(held):
    longest = round((2 * HELD.cut + WINDOW) * RATE)
    for n, there in ((longest, False), (longest + 2, True)):
        short = replace(held, t=held.t[:n], q=held.q[:, :n], tau=held.tau[:, :n])
        assert (error(short, BETA) is not None) == there
