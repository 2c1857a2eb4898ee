"""Calibration errors and friction in logs of a known arm: each is found with its size, and none where there is none."""

from dataclasses import replace

import numpy as np
import pytest
from fitting_problem import ARM, loaded, problem_of_logs
from log_example import BETA, motion
from regression_example import beta_of, log_from, with_noise

from repro.fitting.prior import read_prior
from repro.fitting.problem import SCALE_OF_JOINT_1
from repro.fitting.text import calibration_lines
from repro.identification import calibration
from repro.identification.calibration import CANDIDATES, CalibrationError, calibration_limits, find_calibration_errors
from repro.identification.filtering import FilterSettings, prepare
from repro.identification.regression import drop_standstill, solve

pytestmark = pytest.mark.slow

SETTINGS = FilterSettings()
CLEAN = log_from(motion, seconds=12.0)


def noisy(seed, log=CLEAN, size=0.03):
    return with_noise(log, size, seed)


def small(share, seconds=20.0):
    """A log of the known motion about the origin, so much smaller."""
    return log_from(lambda t: tuple(share * x for x in motion(t)), seconds=seconds)


def spoilt(log, zero1=0.0, zero2=0.0, offset1=0.0, offset2=0.0, scale2=1.0):
    zero, factor, offset = np.array([[[zero1], [zero2]], [[1.0], [scale2]], [[offset1], [offset2]]])
    return replace(log, q=log.q - zero, tau=factor * log.tau + offset)


@pytest.mark.parametrize(
    "errors",
    [
        {"zero1": 0.17, "zero2": -0.05},
        {"offset1": 0.2},
        {"scale2": 0.5},
        {"zero1": -0.06, "offset2": 0.15},
        {"scale2": 1.4, "zero2": 0.08},
    ],
    ids="-".join,
)
def test_calibration_errors_are_found_with_their_size(errors):
    log = spoilt(noisy(1), **errors)
    found = find_calibration_errors(log, SETTINGS)
    assert {error.name for error in found} == set(errors)
    for error in found:
        none = float(error.name == "scale2")
        assert error.value - none == pytest.approx(errors[error.name] - none, rel=0.1, abs=0.004)
        assert error.after < 0.9 * error.before
    r = prepare(calibration.correct_calibration(log, {error.name: error.value for error in found}), SETTINGS)
    np.testing.assert_allclose(solve(r.y, r.tau)[:5], BETA[:5], rtol=0.1)


@pytest.mark.parametrize("zero", [{"zero1": 0.17}, {"zero2": -0.17}], ids=str)
def test_a_zero_is_found_where_the_arm_hardly_leaves_it(zero):
    """Without it the fit is so poor that a full step of Gauss-Newton goes anywhere."""
    found = find_calibration_errors(spoilt(noisy(1, small(0.2)), **zero), SETTINGS)
    assert {error.name: pytest.approx(error.value, abs=0.005) for error in found} == zero


@pytest.mark.parametrize(
    ("wrong", "noise", "others"),
    [({"zero2": -0.08}, 0.03, []), ({"zero2": -0.08}, 0.5, ["zero1", "offset2"]), ({"offset1": 0.3}, 0.9, ["zero1"])],
    ids=str,
)
def test_a_fault_that_a_log_can_hardly_tell_from_another_says_so(wrong, noise, others):
    (error,) = find_calibration_errors(spoilt(noisy(1, size=noise), **wrong), SETTINGS)
    assert [error.name] == [*wrong]
    assert [*error.instead] == others


def test_a_log_without_a_fault_has_none():
    assert sum(bool(find_calibration_errors(noisy(seed), SETTINGS)) for seed in range(20)) <= 1


@pytest.mark.parametrize(("periods", "size"), [((1, 2), 0.1), ((2, 1), 0.2), ((5, 1), 0.15)], ids=str)
def test_a_torque_of_the_position_is_no_fault_and_does_not_hide_one(periods, size):
    """A period of a turn, as of an eccentric gear, looks much like a wrong zero or an offset."""
    log = noisy(5)
    wave = size * np.cos(np.array(periods)[:, np.newaxis] * log.q + 0.4)
    log = replace(log, tau=log.tau + wave)
    assert find_calibration_errors(log, SETTINGS) == ()
    assert "zero1" in [error.name for error in find_calibration_errors(spoilt(log, zero1=0.15), SETTINGS)]


@pytest.mark.parametrize("name", CANDIDATES)
def test_a_fault_is_found_from_the_size_that_is_said(name):
    """Half of it is not, half as much again is: both rules hold for a column added to the nine, but for curvature."""
    log = noisy(3, size=0.2)
    size = calibration_limits(log, SETTINGS, ())[name]

    def found(share):
        value = share * size + (name == "scale2")
        return [error.name for error in find_calibration_errors(spoilt(log, **{name: value}), SETTINGS)]

    assert found(0.5) == []
    assert found(1.5) == [name]


def test_a_scale_that_a_log_alone_does_not_show_shows_with_another_log():
    log = noisy(4, small(0.4, seconds=5.0), size=0.15)
    others = [drop_standstill(prepare(noisy(2), SETTINGS))]
    alone, both = calibration_limits(log, SETTINGS, ()), calibration_limits(log, SETTINGS, (), others)
    assert all(both[name] < alone[name] for name in CANDIDATES)
    scale = 1.0 + 1.3 * both["scale2"]
    wrong = spoilt(log, scale2=scale)
    assert find_calibration_errors(wrong, SETTINGS) == ()
    (error,) = find_calibration_errors(wrong, SETTINGS, others)
    assert (error.name, error.value) == ("scale2", pytest.approx(scale, abs=4 * error.error))


def with_torque_friction(log, share):
    """The log of an arm whose joint 2 has Coulomb friction of this share of the torque that its drive applies."""
    speed = np.gradient(log.q[1], log.t)
    directions = np.tanh(SETTINGS.friction_steepness * speed) * np.sign(log.tau[1])
    return replace(log, tau=log.tau / np.stack([np.ones_like(speed), 1.0 - share * directions]))


@pytest.mark.parametrize("share", [0.2, 0.4])
def test_friction_in_proportion_to_the_torque_is_no_scale_and_hides_none(share):
    log = noisy(1, with_torque_friction(CLEAN, share))
    assert "scale2" not in {error.name for error in find_calibration_errors(log, SETTINGS)}
    assert "scale2" in {error.name for error in find_calibration_errors(spoilt(log, scale2=1.6), SETTINGS)}


def test_what_is_put_right_is_not_among_what_may_be_hidden():
    log = spoilt(noisy(1), zero1=0.1)
    found = find_calibration_errors(log, SETTINGS)
    limits = calibration_limits(calibration.correct_calibration(log, {"zero1": found[0].value}), SETTINGS, found)
    assert {*limits} == {*CANDIDATES} - {"zero1"}
    assert limits == pytest.approx(calibration_limits(noisy(1), SETTINGS, found), rel=0.1)


@pytest.mark.parametrize("scale", [-0.2, 0.1, 20.0])
def test_a_scale_that_no_torque_constant_is_off_by_is_not_claimed(scale):
    assert "scale2" not in {error.name for error in find_calibration_errors(spoilt(noisy(1), scale2=scale), SETTINGS)}


def test_a_joint_that_never_moves_has_no_scale_and_no_offset():
    still = replace(noisy(2), q=CLEAN.q * [[1.0], [0.0]])
    assert all(error.name in ("zero1", "offset1", "zero2") for error in find_calibration_errors(still, SETTINGS))
    assert {*calibration_limits(still, SETTINGS, ())} <= {"zero1", "offset1", "zero2"}


def test_a_log_that_tells_nothing_of_a_fault_hides_any_size_of_it():
    limits = calibration_limits(noisy(1, small(0.02), size=5.0), SETTINGS, ())
    assert (limits["zero2"], limits["scale2"]) == (None, None)
    # A limit of an offset between the largest torques of the joints.
    for joint, size in ((0, [[6.0], [0.02]]), (1, [[0.02], [6.0]])):
        rough = noisy(1, small(0.05), np.array(size))
        limit = calibration_limits(rough, SETTINGS, ())[f"offset{joint + 1}"]
        assert np.abs(rough.tau[1 - joint]).max() < limit < np.abs(rough.tau[joint]).max()


def test_a_scale_of_joint_2_may_as_well_be_one_of_joint_1():
    errors = [CalibrationError("zero1", 0.02, 1e-3, 0.3, 0.1), CalibrationError("scale2", 0.8, 0.01, 0.3, 0.1)]
    zero, scale = calibration.blame_joint_1(errors)
    assert zero == errors[0]
    assert (scale.name, scale.value, scale.error) == ("scale1", pytest.approx(1.25), pytest.approx(0.01 / 0.64))


@pytest.mark.parametrize(("wrong", "beta"), [(1, 1.0), (2, 1.0), (None, 1.2)])
def test_a_prior_tells_which_torque_constant_is_wrong(wrong, beta):
    factor = np.array([[1.0 / 1.4], [1.0]] if wrong == 1 else [[1.0], [1.4]])
    log = replace(noisy(1), tau=noisy(1).tau * factor)
    prior = read_prior({"g1": {"value": beta * BETA[3], "sd": 0.02}, "k1": {"value": 9.0, "sd": 1.0}})
    problem = problem_of_logs(loaded(log), methods=("instrumental",), prior=prior)
    (error,) = problem.first.calibration_errors
    assert (error.name, error.value) == (f"scale{wrong or 2}", pytest.approx(factor.prod(), rel=0.02))
    if wrong is None:
        both = problem.without_standstill, *problem.perturbations[SCALE_OF_JOINT_1].regressions
        second, first = (beta_of("instrumental", replace(r, prior=None)) for r in both)
        assert first == pytest.approx(1.4 * second, rel=0.01)
    assert (SCALE_OF_JOINT_1 in problem.perturbations) is (wrong is None)
    lines = "\n".join(calibration_lines([error], ARM, wrong is None))
    assert "torque_scale" in lines
    assert ("--prior" in lines) is (wrong is None)
