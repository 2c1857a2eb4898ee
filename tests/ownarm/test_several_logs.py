"""Several logs of one arm as one fit: one delay, faults of each its own, and one that disagrees is named."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from log_example import BETA, motion
from ownarm_problem import ARM, loaded, silent, solved
from regression_example import log_from, resting

from repro.identification.extra_terms import ExtraTerm
from repro.identification.least_squares import METHODS
from repro.logs.log import Log
from repro.ownarm.evaluate import add_runs
from repro.ownarm.outputs import write_result
from repro.ownarm.prepare import Options
from repro.ownarm.prior import read_prior
from repro.ownarm.problem import join_logs, make_problem

OPTIONS = Options(("ordinary", "consistent"), "unused")


def noisy_log(name, seed, beta=BETA, delay=0.0, zero=0.0, noise=0.02):
    """A log of its own stretch of the known motion."""
    rng = np.random.default_rng(seed)
    log = log_from(lambda t: motion(t + 3.0 * seed), seconds=15.0, beta=beta, delay=delay)
    q, tau = log.q + np.array([[zero], [0.0]]), log.tau + noise * rng.normal(size=log.tau.shape)
    return loaded(Log(name=name, t=log.t, q=q, tau=tau))


def result_of(*logs):
    problem = make_problem(logs, (), ARM, OPTIONS)
    return problem, *solved(problem, OPTIONS.methods)


@pytest.fixture(scope="module")
def two():
    return result_of(noisy_log("a.csv", 0, delay=0.004), noisy_log("b.csv", 1, delay=0.004, zero=0.08))


@pytest.mark.slow
def test_logs_have_one_delay_and_each_its_faults(two):
    problem, result, _ = two
    assert [log.settings.delay for log in problem.logs] == pytest.approx([0.004, 0.004], abs=5e-4)
    assert problem.logs[0].settings.delay == problem.logs[1].settings.delay
    assert [fault.name for fault in problem.logs[1].faults] == ["zero1"]
    assert problem.logs[1].faults[0].value == pytest.approx(-0.08, abs=0.005)
    assert not problem.logs[0].faults
    assert any(line.startswith("in b.csv the zero of joint 1") for line in result.warnings)
    assert sum("no single arm file corrects them all" in line for line in result.warnings) == 1
    assert [len(faults) for faults in result.setup] == [0, 1]


def test_logs_whose_delays_differ_do_not_tell_the_common_one_better_than_that():
    logs = make_problem([noisy_log("a.csv", 0, delay=0.004), noisy_log("a.csv", 0, delay=0.006)], (), ARM, OPTIONS).logs
    assert [log.settings.delay for log in logs] == pytest.approx([0.005] * 2, abs=2e-4)
    assert [log.delay_error for log in logs] == pytest.approx([0.001] * 2, rel=0.1)


def near(pose, name, seed=1, size=0.1, noise=0.1, zero=0.0, ripple=0.0):
    """A short log that hardly leaves a pose, with the zero of joint 2 off, or with torque ripple."""

    def moved(t):
        q, dq, ddq = motion(t + 3.0 * seed)
        return np.array(pose)[:, None] + size * q, size * dq, size * ddq

    log = log_from(moved, seconds=6.0)
    tau = log.tau + ripple * np.sin(9.0 * log.q) + noise * np.random.default_rng(seed).normal(size=log.tau.shape)
    return loaded(Log(name=name, t=log.t, q=log.q + np.array([[0.0], [zero]]), tau=tau))


def faults_of(*logs):
    return [{fault.name: fault.value for fault in log.faults} for log in make_problem(logs, (), ARM, OPTIONS).logs]


@pytest.mark.slow
def test_a_log_that_does_not_show_its_fault_is_put_right_beside_another():
    wrong = near((1.0, -0.6), "slow.csv", noise=0.3, zero=0.15)
    assert faults_of(wrong) == [{}]
    assert faults_of(wrong, noisy_log("a.csv", 0)) == [{"zero2": pytest.approx(-0.15, abs=0.01)}, {}]


@pytest.mark.slow
def test_beside_a_log_that_is_wrong_right_ones_are_not_blamed():
    """Each of the three would look wrong beside the other two: that which gains most is put right first."""
    logs = near((1.0, -0.6), "a.csv", 5, 0.5), near((0.3, 0.9), "b.csv", 6, 0.4), near((1.0, 0.2), "c.csv", 7, zero=0.2)
    assert faults_of(*logs) == [{}, {}, {"zero2": pytest.approx(-0.2, abs=0.03)}]


@pytest.mark.slow
def test_a_zero_that_the_other_logs_contradict_is_not_applied():
    rippled = near((0.3, 0.9), "ripple.csv", 2, size=0.15, noise=0.02, ripple=0.15)
    assert faults_of(rippled)[0].keys() == {"zero1"}
    assert faults_of(rippled, noisy_log("a.csv", 3), noisy_log("b.csv", 1)) == [{}, {}, {}]


@pytest.mark.slow
@pytest.mark.parametrize(("scales", "found"), [((1.0, 1.4), False), ((1.4, 1.4), True)])
def test_a_torque_constant_is_of_the_arm_and_not_of_a_log(scales, found):
    logs = [noisy_log(f"{seed}.csv", seed) for seed in (4, 5)]
    factors = [np.array([[1.0], [scale]]) for scale in scales]
    wrong = [loaded(replace(log.log, tau=log.log.tau * f)) for log, f in zip(logs, factors, strict=True)]
    assert [("scale2" in faults) for faults in faults_of(*wrong)] == [found, found]


def test_the_fit_is_of_both_and_each_is_foretold_by_the_other(two):
    _, result, _ = two
    assert [log.name for log in (result.log, *result.more_logs)] == ["a.csv", "b.csv"]
    for method in result.methods:
        assert method.fit.log == "a.csv + b.csv"
        assert [score.log for score in method.halves] == ["a.csv", "b.csv"]
        assert max(max(score.relative_rms) for score in method.halves) < 0.1
        estimates = [parameter.estimate for parameter in method.parameters]
        assert estimates[:5] == pytest.approx(BETA[:5], rel=0.03)
    assert not any("disagrees" in line for line in result.warnings)


@pytest.mark.slow
def test_a_log_of_another_arm_is_named():
    other = BETA * np.array([1.8, 1.7, 1.6, 1.7, 1.8, 1, 1, 1, 1])
    _, result, _ = result_of(
        noisy_log("a.csv", 0), noisy_log("b.csv", 1), noisy_log("c.csv", 2), noisy_log("odd.csv", 3, beta=other)
    )
    assert sum("disagrees" in line for line in result.warnings) == 1
    assert any(line.startswith("the log odd.csv disagrees with the others") for line in result.warnings)


def runs_of(problem, result):
    return add_runs(result, problem, METHODS.values(), 1, silent)


def test_logs_of_one_arm_agree_from_run_to_run(two, tmp_path):
    problem, result, curves = two
    assert result.spread == ()
    assert "runs.csv" not in write_result(tmp_path / "one", result, curves, ARM)
    result = runs_of(problem, result)
    assert [run.log for run in result.runs] == ["a.csv", "b.csv"]
    for k, row in enumerate(result.spread):
        alone = [run.parameters[k] for run in result.runs]
        assert row.estimates == tuple(p.estimate for p in alone)
        assert row.range == pytest.approx(abs(row.estimates[0] - row.estimates[1]))
        assert row.together == result.best.parameters[k].estimate
    for row, truth in zip(result.spread[:5], BETA, strict=False):
        assert row.agree
        assert row.estimates == pytest.approx([truth, truth], rel=0.05)
    assert "runs.csv" in write_result(tmp_path / "two", result, curves, ARM)
    table = pd.read_csv(tmp_path / "two" / "runs.csv")
    assert table["log"].to_list() == 9 * ["a.csv", "b.csv"]
    assert table["estimate"].to_numpy() == pytest.approx(np.ravel([row.estimates for row in result.spread]))
    assert 'id="runs"' in (tmp_path / "two" / "report.html").read_text()


@pytest.mark.slow
def test_logs_of_two_arms_disagree_from_run_to_run():
    other = BETA * np.array([1, 1, 1, 1.5, 1.5, 1, 1, 1, 1])
    problem, result, _ = result_of(noisy_log("a.csv", 0), noisy_log("odd.csv", 1, beta=other))
    result = runs_of(problem, result)
    assert {row.name for row in result.spread if row.agree is False} >= {"g1", "g2"}


def test_a_noisy_log_counts_less():
    """Weights are those of the errors: beside a log with a hundred times the noise the good one hardly moves."""
    good, noisy = noisy_log("a.csv", 0), noisy_log("n.csv", 1, noise=2.0)
    problem = make_problem((good, noisy), (), ARM, OPTIONS)
    sizes = [float(np.abs(log.moving.tau).max()) for log in problem.logs]
    n = problem.logs[0].moving.t.size
    kept = [np.abs(problem.moving.tau[:, :n]).max() / sizes[0], np.abs(problem.moving.tau[:, n:]).max() / sizes[1]]
    assert kept[0] > 5 * kept[1]


def test_a_noisy_log_does_not_hide_the_rotor():
    def with_rotor(name, seed, noise):
        log = noisy_log(name, seed, noise=noise)
        _, _, (_, ddq) = motion(log.log.t + 3.0 * seed)
        return replace(log, log=replace(log.log, tau=log.log.tau + np.stack([0.0 * ddq, 0.1 * BETA[2] * ddq])))

    alone = make_problem((with_rotor("a.csv", 0, 0.02),), (), ARM, OPTIONS).first
    beside = make_problem((with_rotor("a.csv", 0, 0.02), with_rotor("n.csv", 1, 1.0)), (), ARM, OPTIONS).first
    assert [term.name for term in alone.taken] == [term.name for term in beside.taken] == ["rotor2"]
    assert beside.taken[0].value == pytest.approx(0.1 * BETA[2], rel=0.1)


def test_a_log_with_an_idle_joint_counts_as_much_as_its_other_joint_is_good():
    problem = make_problem((noisy_log("a.csv", 0), loaded(resting(1, 0.3))), (), ARM, OPTIONS)
    n, idle = problem.logs[0].moving.t.size, problem.logs[1].moving
    assert np.abs(problem.moving.tau[:, n:]).max() == pytest.approx(np.abs(idle.tau).max())


def test_logs_with_different_terms_can_be_joined():
    logs = make_problem((noisy_log("a.csv", 0), noisy_log("b.csv", 1)), (), ARM, OPTIONS).logs
    ours = [replace(log, terms=(ExtraTerm("rotor2", 0.01, 1e-4, 0.5, True),)) for log in logs]
    one, each = (join_logs(with_rotor)[0] for with_rotor in ((logs[0], ours[1]), ours))
    np.testing.assert_array_equal(one.y, each.y)


def test_detection_limits_do_not_depend_on_the_joint_whose_torque_constant_is_wrong():
    logs = [noisy_log(name, seed) for seed, name in enumerate(("a.csv", "b.csv"))]
    logs = [replace(one, log=replace(one.log, tau=one.log.tau * np.array([[1.3], [1.0]]))) for one in logs]
    found = []
    for g1 in (BETA[3], 1.3 * BETA[3]):
        prior = read_prior({"g1": {"value": g1, "sd": 0.01}})
        found.append(make_problem(logs, (), ARM, replace(OPTIONS, prior=prior)).first)
    assert [log.faults[0].name for log in found] == ["scale1", "scale2"]
    assert [log.hidden["zero2"] for log in found] == [pytest.approx(found[0].hidden["zero2"], rel=0.01)] * 2


def test_a_poor_log_does_not_veto_the_torque_constant_that_a_good_one_shows():
    good, poor = noisy_log("a.csv", 0), near((0.3, 0.9), "slow.csv", noise=0.3)
    wrong = [loaded(replace(log.log, tau=log.log.tau * np.array([[1.0], [1.15]]))) for log in (good, poor)]
    assert faults_of(*wrong)[0] == {"scale2": pytest.approx(1.15, abs=0.01)}


def test_a_log_is_not_predicted_from_one_that_does_not_determine_it():
    def one_joint(joint, name):
        log = log_from(lambda t: tuple(x * (np.arange(2) == joint)[:, np.newaxis] for x in motion(t)), seconds=15.0)
        return loaded(replace(log, name=name, tau=log.tau + 0.02 * np.random.default_rng(joint).normal(size=(2, 1))))

    _, result, _ = result_of(one_joint(0, "first.csv"), one_joint(1, "second.csv"))
    assert not any("disagrees" in line for line in result.warnings)
    assert all(max(score.relative_rms) < 1.0 for score in result.best.halves)
