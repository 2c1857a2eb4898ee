"""The whole of `repro identify` but its command line, on a known arm."""

from dataclasses import replace

import numpy as np
import pytest
from log_example import BETA, motion
from ownarm_problem import ARM, identify, prepared_from_file, write_log

from repro.errors import InputError
from repro.identification.excitation import torque_fraction
from repro.identification.least_squares import METHODS
from repro.identification.method import Estimate
from repro.model.parameters import NAMES
from repro.ownarm.evaluate import Fit, assemble
from repro.ownarm.prepare import Options, load_log
from repro.ownarm.problem import make_problem
from repro.ownarm.text import COMBINED, NOT_EXCITED

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return identify(tmp_path_factory.mktemp("whole"))


def test_every_method_finds_the_arm_and_predicts_another_motion(whole):
    _, result, _ = whole
    assert [m.method for m in result.methods] == list(METHODS)
    for m in result.methods:
        found = np.array([p.estimate for p in m.parameters])
        assert found == pytest.approx(BETA, rel=0.02), m.method
        assert found[:5] == pytest.approx(BETA[:5], rel=0.002), m.method
        assert m.consistent
        assert all(p.verdict.startswith("known to") for p in m.parameters)
        assert all(p.low < p.estimate < p.high and p.standard_error > 0.0 for p in m.parameters)
        (s,) = m.validation
        assert s.log == "other.csv"
        for each in (s, m.fit, *m.halves):
            assert max(each.relative_rms) < 0.01
            assert min(each.similarity) > 0.99
        assert max(s.position_rms) < 2e-3
        assert max(m.fit.position_rms) < 2e-3
        assert [h.log for h in m.halves] == ["second half", "first half"]
        assert all(h.position_rms is None for h in m.halves)


def test_the_result_says_what_was_done(whole):
    problem, result, _ = whole
    assert result.arm == "test arm"
    assert not result.simulated
    assert result.reason.startswith("smallest mean torque error on the validation logs")
    assert ["the log is short, 12 s" in line for line in result.warnings] == [True]
    p = result.preparation
    assert (p.cutoff, p.cutoff_reason) == (problem.first.settings.cutoff, problem.first.cutoff.reason)
    assert 1.0 <= p.cutoff <= 10.0
    assert p.delay == pytest.approx(0.0, abs=2e-4)
    assert (p.friction_steepness, p.samples) == (20.0, problem.regression.t.size)
    assert p.rate == pytest.approx((p.samples - 1) / np.ptp(problem.regression.t))
    e = result.excitation
    assert (e.rank, e.unexcited, e.base_parameters) == (9, (), NAMES)
    assert all(0.0 < share < 2.0 for share in e.share)
    assert sum(e.share) > 1.0


def test_each_method_is_judged_by_its_own_parameters(whole):
    problem, _, _ = whole
    names, betas = ("ordinary", "bounded"), (1.1 * BETA, BETA)
    found = [Fit(METHODS[n], Estimate(b), None, ()) for n, b in zip(names, betas, strict=True)]
    result, curves = assemble(problem, found, ARM)
    assert result.recommended == "bounded"
    assert result.excitation.share == pytest.approx(torque_fraction(problem.moving, BETA))
    for m, beta in zip(result.methods, betas, strict=True):
        assert [p.estimate for p in m.parameters] == list(beta)
        for s, each in zip(curves.signals, (m.fit, *m.validation), strict=True):
            error = np.linalg.norm(s.tau - s.rebuilt[m.method], axis=1) / np.linalg.norm(s.tau, axis=1)
            assert each.relative_rms == pytest.approx(tuple(error), rel=1e-9)
            assert max(each.relative_rms) == pytest.approx(beta[0] / BETA[0] - 1.0, abs=0.01)
            assert (max(each.position_rms) < 2e-3) == (beta is betas[1])


@pytest.mark.parametrize("late", [-0.006, 0.0, 0.005])
def test_the_delay_is_found(tmp_path, late):
    assert prepared_from_file(tmp_path, late=late).first.settings.delay == pytest.approx(late, abs=3e-4)


@pytest.mark.parametrize("steepness", [10.0, 50.0])
def test_the_steepness_of_friction_is_found_where_it_is_not_given(tmp_path, steepness):
    auto = prepared_from_file(tmp_path, replace(ARM, friction_steepness=None), steepness=steepness)
    assert auto.first.settings.friction_steepness == steepness
    given_one = prepared_from_file(tmp_path, replace(ARM, friction_steepness=33.0), steepness=steepness)
    assert given_one.first.settings.friction_steepness == 33.0


def test_a_cutoff_that_is_given_is_used(tmp_path):
    problem = prepared_from_file(tmp_path, options=Options(("ordinary",), tmp_path, cutoff=3.5))
    assert problem.first.settings.cutoff == problem.first.cutoff.hertz == 3.5
    assert problem.first.cutoff.reason == "given by the user"
    kept = [r.h for r in problem.as_good["filters"].regressions]  # eight samples a period of the cut-off
    assert min(kept) < problem.regression.h < max(kept)
    with pytest.raises(InputError, match=r"^cutoff: found 60 Hz, expected .* 200 Hz of log\.csv"):
        prepared_from_file(tmp_path, options=Options(("ordinary",), tmp_path, cutoff=60.0))


def test_a_validation_log_too_slow_for_the_cutoff_is_named(tmp_path):
    log = load_log(write_log(tmp_path / "log.csv"), ARM)
    slow = load_log(write_log(tmp_path / "slow.csv", seconds=30.0, rate=10.0), ARM)
    with pytest.raises(InputError, match=r"^cutoff: found 5 Hz, expected .* 10 Hz of slow\.csv"):
        make_problem((log,), (slow,), ARM, Options(("ordinary",), tmp_path, cutoff=5.0))


def stretched(t):
    """The motion with joint 2 held straight."""
    q, dq, ddq = motion(t)
    q[1], dq[1], ddq[1] = 0.0, 0.0, 0.0
    return q, dq, ddq


def test_an_arm_with_a_joint_at_rest_is_told_what_its_log_can_tell(tmp_path):
    names = tuple(sorted(set(METHODS) - {"parsimonious"}))  # whose penalty takes seconds to choose
    problem, result, _ = identify(tmp_path, names, moved=stretched)
    e = result.excitation
    assert e.rank == 4
    # Which of two equal columns stands first is a matter of rounding.
    assert {frozenset(words.split(" + 1 ")) for words in e.base_parameters} == {
        frozenset(names) for names in (("I1", "I2"), ("g1", "g2"), ("b1",), ("k1",))
    }
    assert {"b2", "k2"} <= set(e.unexcited)
    assert not {"g1", "b1", "k1"} & set(e.unexcited)
    assert any("4 combinations" in line for line in result.warnings)
    assert not problem.regression.mask[1].any()  # what holds a joint that never moves is not known
    for m in result.methods:
        p = dict(zip(NAMES, m.parameters, strict=True))
        assert {p[name].verdict for name in ("I1", "I2", "g1", "g2")} == {COMBINED}
        assert {p[name].verdict for name in ("I3", "b2", "k2")} == {NOT_EXCITED}
        assert {(p[name].estimate, p[name].low, p[name].high) for name in ("b2", "k2")} == {(0.0, None, None)}
        for name in ("b1", "k1"):
            assert p[name].estimate == pytest.approx(BETA[NAMES.index(name)], rel=0.02), (m.method, name)
        for one, other in (("I1", "I2"), ("g1", "g2")):
            whole = sum(BETA[NAMES.index(name)] for name in (one, other))
            assert p[one].estimate + p[other].estimate == pytest.approx(whole, rel=0.01), m.method
        assert max(m.fit.relative_rms) < 0.01
