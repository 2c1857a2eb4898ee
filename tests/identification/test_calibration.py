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
from repro.identification.extra_terms import ExtraTerm, best_subset, find_terms, subtract_terms
from repro.identification.filtering import FilterSettings, prepare
from repro.identification.regression import drop_standstill, solve
from repro.model.dynamics import inverse_dynamics

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
    log = noisy(1, small(0.3, seconds=6.0), size=0.1)
    others = [drop_standstill(prepare(noisy(2), SETTINGS))]
    alone, both = calibration_limits(log, SETTINGS, ()), calibration_limits(log, SETTINGS, (), others)
    assert all(both[name] < alone[name] for name in CANDIDATES)
    assert both["scale2"] < 0.5 * alone["scale2"]
    scale = 1.0 + 1.5 * both["scale2"]
    wrong = spoilt(log, scale2=scale)
    assert find_calibration_errors(wrong, SETTINGS) == ()
    (error,) = find_calibration_errors(wrong, SETTINGS, others)
    assert (error.name, error.value) == ("scale2", pytest.approx(scale, abs=4 * error.error))


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


# Friction beyond Eq. 1.

DELAYED = FilterSettings(cutoff=4.0, delay=0.004)
RIGID = np.where(np.arange(9) < 5, BETA, 0.0)


def load_friction(t):
    q, dq, ddq = motion(t + DELAYED.delay)  # when the torque recorded at `t` acts
    return np.abs(inverse_dynamics(q, dq, ddq, RIGID)) * np.tanh(20.0 * dq)


def stribeck(t):
    dq = motion(t + DELAYED.delay)[1]
    return np.tanh(20.0 * dq) * np.exp(-((dq / 0.5) ** 2))


def log_with(load1=0.0, load2=0.0, stribeck2=0.0, rotor2=0.0, seed=0, noise=0.02, seconds=20.0):
    log = log_from(motion, seconds=seconds, delay=DELAYED.delay)
    more = np.array([[load1], [load2]]) * load_friction(log.t)
    more[1] += stribeck2 * stribeck(log.t)[1] + rotor2 * motion(log.t + DELAYED.delay)[2][1]
    return with_noise(replace(log, tau=log.tau + more), noise, seed)


def ready_of(log, friction):
    nearly = loaded(replace(log, tau=log.tau * (1.0 + 1e-9)))
    return problem_of_logs(loaded(log), validation=(nearly,), friction=friction)


@pytest.mark.parametrize(
    "sizes", [{"load1": 0.1}, {"load1": 0.1, "load2": 0.15}, {"stribeck2": 0.2}, {"load1": 0.1, "stribeck2": 0.2}]
)
def test_what_is_there_is_found_with_its_size(sizes):
    found = [term for term in find_terms([(log_with(**sizes), DELAYED)], True) if term.taken]
    assert [term.name for term in found] == [*sizes]
    assert [term.value for term in found] == pytest.approx([*sizes.values()], rel=0.2)
    assert all(term.gain > 0.2 for term in found)


@pytest.mark.parametrize("more", [*({"seed": k} for k in range(5)), {"load1": -0.1}, {"rotor2": -0.1 * BETA[2]}])
def test_no_term_is_found_where_there_is_none_or_one_that_would_drive_the_arm(more):
    assert find_terms([(log_with(**more), DELAYED)], True) == ()


def test_a_scale_of_joint_2_may_as_well_be_one_of_joint_1():
    errors = [CalibrationError("zero1", 0.02, 1e-3, 0.3, 0.1), CalibrationError("scale2", 0.8, 0.01, 0.3, 0.1)]
    zero, scale = calibration.blame_joint_1(errors)
    assert zero == errors[0]
    assert (scale.name, scale.value, scale.error) == ("scale1", pytest.approx(1.25), pytest.approx(0.01 / 0.64))


def test_the_rotor_of_joint_2_is_subtracted_unasked_and_the_delay_does_not_absorb_it():
    problem = ready_of(log_with(rotor2=0.4 * BETA[2]), friction=False)
    (term,) = problem.first.taken
    assert (term.name, term.value) == ("rotor2", pytest.approx(0.4 * BETA[2], rel=0.05))
    assert problem.first.settings.delay == pytest.approx(DELAYED.delay, abs=3e-4)
    assert beta_of("ordinary", problem.without_standstill)[:5] == pytest.approx(BETA[:5], rel=0.01)


@pytest.mark.parametrize("joint", [0, 1])
def test_a_term_is_judged_by_the_errors_of_its_own_joint(joint):
    """The other joint's errors are fifty times as large as what the tenth column explains of this one's."""
    rng = np.random.default_rng(3 + joint)
    a = rng.normal(size=(2, 600, 10))
    a[1 - joint, :, 9] = 0.0
    b = a[..., :9] @ BETA + rng.normal(size=(2, 600)) * np.where(np.arange(2) == joint, 0.02, 5.0)[:, None]
    b[joint] += 0.1 * a[joint, :, 9]
    assert best_subset(a, b, {0: 0.05}, by_joint=True) == [0]
    assert best_subset(a, b, {0: 0.05}) == []


def test_logs_of_one_arm_have_one_rotor():
    logs = [log_with(rotor2=0.1 * BETA[2], seed=seed, noise=0.1, seconds=15.0 + seed) for seed in (1, 2, 3)]
    (term,) = (term for term in find_terms([(log, DELAYED) for log in logs], False) if term.taken)
    assert term.value == pytest.approx(0.1 * BETA[2], rel=0.2)
    alone = [term.error for log in logs for term in find_terms([(log, DELAYED)], False)]
    assert all(term.error < error for error in alone)


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


def test_taken_out_is_what_was_put_in():
    terms = [ExtraTerm("load1", 0.1, 0.0, 0.0, True), ExtraTerm("stribeck2", 0.2, 0.0, 0.0, True)]
    spoilt, clean = log_with(load1=0.1, stribeck2=0.2, noise=0.0), log_with(noise=0.0)
    left = subtract_terms(spoilt, DELAYED, BETA, terms).tau - clean.tau
    size = [np.std(x[:, 100:-100], axis=1) for x in (left, spoilt.tau - clean.tau)]  # where filters see both sides
    assert (size[0] < 0.1 * size[1]).all()


def test_a_term_is_subtracted_from_each_piece_by_itself():
    log, terms = log_with(), [ExtraTerm("rotor2", 0.01, 0.0, 0.0, True)]
    n = log.t.size // 2
    split = replace(log, t=log.t + 2.0 * (np.arange(log.t.size) >= n), breaks=(n,))
    halves = [subtract_terms(piece, DELAYED, BETA, terms).tau for piece in split.pieces]
    np.testing.assert_array_equal(subtract_terms(split, DELAYED, BETA, terms).tau, np.concatenate(halves, axis=1))


def test_only_where_it_is_asked_for_is_it_taken_and_then_friction_of_eq_1_comes_out_right():
    log = log_with(load1=0.15)
    without, asked = (ready_of(log, friction) for friction in (False, True))
    assert [(term.name, term.taken) for term in without.logs[0].terms] == [("load1", False)]
    assert [(term.name, term.taken) for term in asked.logs[0].terms] == [("load1", True)]
    assert np.array_equal(without.logs[0].loaded.log.tau, log.tau)
    k1 = [solve(problem.without_standstill.y, problem.without_standstill.tau)[7] for problem in (without, asked)]
    assert abs(k1[0] - BETA[7]) > 0.05
    assert k1[1] == pytest.approx(BETA[7], rel=0.15)
    # The validation log, nearly the same, is corrected the same way.
    ((loaded, _),) = asked.validation
    assert loaded.log.tau == pytest.approx(asked.logs[0].loaded.log.tau)
