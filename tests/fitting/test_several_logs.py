"""Several logs of one arm as one fit: one delay, calibration errors of each log, and one that disagrees is named."""

import re
from dataclasses import replace

import numpy as np
import pytest
from fitting_problem import ARM, loaded, problem_of_logs, silent, solved
from log_example import BETA, motion
from regression_example import log_from, resting

from repro.fitting.evaluate import add_runs
from repro.fitting.prior import read_prior
from repro.fitting.recommend import disagreeing
from repro.identification import filtering
from repro.identification.least_squares import METHODS
from repro.identification.log import Log

pytestmark = pytest.mark.slow


def noisy_log(name, seed, noise=0.02, zero=(0.0, 0.0), pose=(0.0, 0.0), size=1.0, beta=BETA, delay=0.0):
    """A stretch of the known motion, or of a small one near a pose; zeros may be off."""

    def moved(t):
        q, dq, ddq = motion(t + 3.0 * seed)
        return np.reshape(pose, (2, 1)) + size * q, size * dq, size * ddq

    log = log_from(moved, seconds=15.0 if size == 1.0 else 6.0, beta=beta, delay=delay)
    tau = log.tau + noise * np.random.default_rng(seed).normal(size=log.tau.shape)
    return loaded(Log(name=name, t=log.t, q=log.q + np.reshape(zero, (2, 1)), tau=tau))


def near(pose, name, seed=1, size=0.1, noise=0.1, zero=0.0):
    return noisy_log(name, seed, noise, (0.0, zero), pose, size)


def scaled(log, *factors):
    return loaded(replace(log.log, tau=log.log.tau * np.reshape(factors, (2, 1))))


def calibration_errors_of(*logs):
    return [{error.name: error.value for error in log.calibration_errors} for log in problem_of_logs(*logs).logs]


def spread_of_runs(problem, result):
    return add_runs(result, problem, METHODS.values(), 1, silent).spread


def test_logs_have_one_delay_and_one_fit_and_each_its_faults():
    logs = noisy_log("a.csv", 0, delay=0.004), noisy_log("b.csv", 1, delay=0.004, zero=(0.08, 0.0))
    problem = problem_of_logs(*logs)
    result, _ = solved(problem)
    assert [log.settings.delay for log in problem.logs] == pytest.approx([0.004, 0.004], abs=5e-4)
    assert problem.logs[0].settings.delay == problem.logs[1].settings.delay
    assert [[error.name for error in log.calibration_errors] for log in problem.logs] == [[], ["zero1"]]
    assert problem.logs[1].calibration_errors[0].value == pytest.approx(-0.08, abs=0.005)
    other = noisy_log("c.csv", 2, delay=0.004)  # is corrected as all logs are, so not at all
    ((predicted, _),) = problem_of_logs(*logs[::-1], validation=(other,)).validation
    np.testing.assert_array_equal(predicted.log.q, other.log.q)
    assert sum("b.csv" in line for line in result.warnings) == 2  # its zero, and the lines of the arm file
    assert not list(disagreeing(problem, result.best))
    assert [p.estimate for p in result.best.parameters[:5]] == pytest.approx(BETA[:5], rel=0.03)
    assert [score.log for score in result.best.halves] == ["a.csv", "b.csv"]
    assert max(max(score.relative_rms) for score in result.best.halves) < 0.1
    assert result.spread == ()
    for row, truth in zip(spread_of_runs(problem, result)[:5], BETA, strict=False):
        assert row.agree
        assert row.estimates == pytest.approx([truth, truth], rel=0.05)


def test_logs_have_one_lambda_and_one_cutoff(monkeypatch):
    choose, hertz = filtering.choose_cutoff, iter((5.0, 5.0, 5.0, 3.0, 5.0, 5.0))  # the last log needs less, at last
    monkeypatch.setattr(filtering, "choose_cutoff", lambda *given: replace(choose(*given), hertz=next(hertz)))
    logs = [loaded(log_from(motion, steepness=s, delay=1e-3 * s / 20.0)) for s in (100.0, 20.0)]
    settings = [log.settings for log in problem_of_logs(*logs, arm=replace(ARM, friction_steepness=None)).logs]
    assert {(s.cutoff, s.friction_steepness) for s in settings} == {(3.0, 50.0)}


def test_a_log_of_another_arm_is_named_and_disagrees_from_run_to_run():
    other = BETA * np.array([1.8, 1.7, 1.6, 1.7, 1.8, 1, 1, 1, 1])
    problem = problem_of_logs(noisy_log("odd.csv", 0), noisy_log("b.csv", 1), noisy_log("odd.csv", 3, beta=other))
    result, _ = solved(problem)
    (line,) = disagreeing(problem, result.best)
    assert line in result.warnings and "odd.csv" in line
    assert float(re.findall(r"([\d.]+) %", line)[1]) < 0.5  # fitted alone: of the last log, not of the first
    assert {row.name for row in spread_of_runs(problem, result) if row.agree is False} >= {"I1", "I2", "g1", "g2"}


def test_logs_whose_delays_differ_do_not_determine_the_common_one_better_than_that():
    logs = problem_of_logs(noisy_log("a.csv", 0, delay=0.004), noisy_log("a.csv", 0, delay=0.006)).logs
    assert [log.settings.delay for log in logs] == pytest.approx([0.005] * 2, abs=2e-4)
    assert [log.delay_error for log in logs] == pytest.approx([0.001] * 2, rel=0.1)
    stated = problem_of_logs(noisy_log("a.csv", 0, delay=0.004), arm=replace(ARM, delay=0.0))
    assert stated.first.settings.delay == 0.0


def test_a_log_that_does_not_show_its_fault_is_corrected_next_to_another():
    wrong = near((1.0, -0.6), "slow.csv", noise=0.3, zero=0.15)
    assert calibration_errors_of(wrong) == [{}]
    assert calibration_errors_of(wrong, noisy_log("a.csv", 0)) == [{"zero2": pytest.approx(-0.15, abs=0.01)}, {}]


@pytest.mark.parametrize(("shows", "zero", "corrected"), [(True, 0.0, False), (True, 0.15, True), (False, 0.15, True)])
def test_a_validation_log_is_corrected_as_the_fitted_one_unless_it_shows_that_it_is_right(shows, zero, corrected):
    other = noisy_log("b.csv", 2, zero=(0.0, zero)) if shows else near((1.0, -0.6), "b.csv", noise=0.3, zero=zero)
    ((predicted, _),) = problem_of_logs(noisy_log("a.csv", 1, zero=(0.0, 0.15)), validation=(other,)).validation
    change = float(np.mean(predicted.log.q[1] - other.log.q[1]))
    assert change == pytest.approx(-0.15 if corrected else 0.0, abs=0.01)


def test_next_to_a_log_that_is_wrong_right_ones_are_not_blamed():
    """Each of the three would look wrong next to the other two: that which gains most is corrected first."""
    logs = near((1.0, -0.6), "a.csv", 5, 0.5), near((0.3, 0.9), "b.csv", 6, 0.4), near((1.0, 0.2), "c.csv", 7, zero=0.2)
    assert calibration_errors_of(*logs) == [{}, {}, {"zero2": pytest.approx(-0.2, abs=0.03)}]


def test_a_zero_that_the_other_logs_contradict_is_not_applied():
    log = near((1.0, -0.6), "cable.csv", 2, size=0.15, noise=0.02).log
    cable = loaded(replace(log, tau=log.tau + 0.15 * np.cos(2.0 * log.q.sum(axis=0))))  # turns with link 2
    assert calibration_errors_of(cable)[0].keys() == {"zero2"}
    assert calibration_errors_of(cable, noisy_log("a.csv", 3), noisy_log("b.csv", 1)) == [{}, {}, {}]


def test_a_torque_constant_is_corrected_in_all_logs_or_none_and_a_poor_log_has_no_veto():
    logs = noisy_log("a.csv", 4), scaled(noisy_log("b.csv", 5), 1.0, 1.4)
    assert all("scale2" not in errors for errors in calibration_errors_of(*logs))
    logs = noisy_log("a.csv", 0), near((0.3, 0.9), "slow.csv", noise=0.3)
    assert calibration_errors_of(*(scaled(log, 1.0, 1.15) for log in logs))[0] == {
        "scale2": pytest.approx(1.15, abs=0.01)
    }


def test_detection_limits_do_not_depend_on_the_joint_whose_torque_constant_is_wrong():
    log = scaled(noisy_log("a.csv", 1), 1.3, 1.0)
    priors = [read_prior({"g1": {"value": g1, "sd": 0.01}}) for g1 in (BETA[3], 1.3 * BETA[3])]
    first = [problem_of_logs(log, prior=prior).first for prior in priors]
    assert [log.calibration_errors[0].name for log in first] == ["scale1", "scale2"]
    assert first[0].calibration_limits["zero2"] == pytest.approx(first[1].calibration_limits["zero2"], rel=0.01)


def test_a_noisy_log_counts_less_and_one_with_an_idle_joint_as_much_as_its_other_joint_is_good():
    def weights(*logs):
        problem = problem_of_logs(*logs)
        parts = np.split(problem.without_standstill.tau, [problem.logs[0].without_standstill.t.size], 1)
        pairs = zip(parts, problem.logs, strict=True)
        return [np.abs(part).max() / np.abs(log.without_standstill.tau).max() for part, log in pairs]

    good, noisy = weights(noisy_log("a.csv", 0), noisy_log("n.csv", 1, noise=2.0))
    assert good > 5 * noisy
    assert weights(noisy_log("a.csv", 0), loaded(resting(1, 0.3)))[1] == pytest.approx(1.0)


def test_a_noisy_log_does_not_hide_the_rotor():
    def with_rotor(name, seed, noise):
        log = noisy_log(name, seed, noise=noise)
        _, _, (_, ddq) = motion(log.log.t + 3.0 * seed)
        return replace(log, log=replace(log.log, tau=log.log.tau + np.stack([0.0 * ddq, 0.1 * BETA[2] * ddq])))

    (term,) = problem_of_logs(with_rotor("a.csv", 0, 0.02), with_rotor("n.csv", 1, 1.0)).first.taken
    assert (term.name, term.value) == ("rotor2", pytest.approx(0.1 * BETA[2], rel=0.1))


def test_a_log_is_not_predicted_from_one_that_does_not_determine_it():
    def one_joint(joint, name):
        log = log_from(lambda t: tuple(x * (np.arange(2) == joint)[:, np.newaxis] for x in motion(t)), seconds=8.0)
        return loaded(replace(log, name=name, tau=log.tau + 0.02 * np.random.default_rng(joint).normal(size=(2, 1))))

    problem = problem_of_logs(one_joint(0, "first.csv"), one_joint(1, "second.csv"))
    result, _ = solved(problem)
    assert not list(disagreeing(problem, result.best))
    assert [score.log for score in result.best.halves] == ["second half", "first half"]


def test_a_log_without_torque_changes_no_estimate_and_hides_no_zero():
    good = noisy_log("good.csv", 2, zero=(0.06, 0.0))
    fall = noisy_log("fall.csv", 5)
    noise = 0.002 * np.random.default_rng(9).normal(size=fall.log.tau.shape)
    fall = loaded(replace(fall.log, tau=noise))
    alone, together = problem_of_logs(good), problem_of_logs(good, fall)
    assert [log.name for log, _ in together.validation] == ["fall.csv"]
    assert [error.name for error in together.first.calibration_errors] == ["zero1"]
    estimates = [METHODS["weighted"].estimate(problem.without_standstill).beta for problem in (together, alone)]
    np.testing.assert_array_equal(*estimates)
