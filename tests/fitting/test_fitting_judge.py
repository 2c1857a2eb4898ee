"""One method on one problem: verdicts, intervals, consistency and scores."""

from dataclasses import replace
from unittest.mock import Mock

import numpy as np
import pytest
from fitting_problem import ARM, judged, noisy, problem_of, problem_of_logs, silent, solved, write_log
from hypothesis import example, given
from hypothesis import strategies as st
from log_example import BETA
from regression_example import exciting

from repro.fitting import prepare
from repro.fitting.evaluate import Fit, evaluate, fit, fit_all, inconsistency
from repro.fitting.prepare import load_log
from repro.fitting.text import AT_BOUND, IMPOSSIBLE, NO_INTERVAL, NOT_EXCITED, NOT_FROM_ZERO, known_to
from repro.identification.filtering import MAX_DELAY
from repro.identification.least_squares import METHODS
from repro.identification.method import Estimate, Method
from repro.identification.uncertainty import Uncertainty
from repro.logs.diagnostics import left_out_torque
from repro.model.parameters import NAMES, is_positive_definite

pytestmark = pytest.mark.slow

#: Standard normal numbers.
WHITE = np.random.default_rng(8).normal(size=(2, 4800))


@example([-0.5, 0.0, -0.2, *[0.1] * 6])
@example([0.5, -0.1, 0.2, *[0.1] * 6])
@example([0.5, -0.1, 0.2, -0.3, *[0.1] * 5])
@given(st.lists(st.floats(-1.0, 1.0), min_size=9, max_size=9))
def test_parameters_are_inconsistent_exactly_where_a_reason_is_given(beta):
    beta = np.array(beta)
    why = inconsistency(beta)
    opposed = beta[1] * beta[3] * beta[4] < 0.0
    assert (why == "") == bool(is_positive_definite(beta) and not opposed)
    assert ("I2 g1 g2 = " in why) == opposed
    for k, name in enumerate(NAMES):
        assert (f"{name} = {beta[k]:.3g} is negative" in why) == bool(k >= 5 and beta[k] < 0.0)
    assert ("I3 (I1 - I3) = " in why) == (not is_positive_definite([*beta[:3], *np.ones(6)]))


@pytest.mark.parametrize(
    ("late", "torque", "why"),
    [
        (0.05, lambda log: log.tau, "delay"),
        (0.0, lambda log: [[1.0], [0.0]] * log.tau + [[0.0], [3.0]] * WHITE, "joint 2"),
        (0.0, lambda log: log.tau[:, ::-1], "0 % of the squared torque of joint 2"),
        (0.0, lambda log: 0.4 * np.tanh(20.0 * np.gradient(log.q, log.t, axis=1)), "friction"),
        (0.0, lambda log: log.tau, ""),
        (0.0, lambda log: log.tau + 5.0 * log.tau.std(axis=1, keepdims=True) * WHITE, ""),
    ],
    ids=["delay", "noise", "another motion", "friction compensation", "good", "noise above the motion"],
)
def test_no_interval_is_claimed_where_eq_1_does_not_explain_the_torque(tmp_path, late, torque, why):
    """Noise that is white is averaged away; a torque of another motion is not."""
    loaded = load_log(write_log(tmp_path / "log.csv", seconds=24.0, late=late), ARM)
    tau = torque(loaded.log) + 1e-3 * WHITE
    problem = problem_of_logs(replace(loaded, log=replace(loaded.log, tau=tau)))
    rows = judged(problem).parameters
    assert bool(problem.doubt) == bool(why)
    if why:
        assert {(p.low, p.high) for p in rows} == {(None, None)}
        verdicts = {p.verdict for p in rows} - {NOT_EXCITED}
        assert all(why in text for text in verdicts)
    else:
        assert all(p.low < true < p.high for p, true in zip(rows[3:5], BETA[3:5], strict=True))


@pytest.mark.parametrize(
    ("left", "by_friction", "at_limit", "delay", "why"),
    [
        ((0.49, 0.1), (1.0, 1.0), (0.0, 0.0), 0.0, ""),
        ((0.1, 0.51), (1.0, 1.0), (0.0, 0.0), 0.0, "49 % of the squared torque of joint 2"),
        ((0.041, 0.0), (1.0, 1.0), (0.51, 0.0), 0.0, "51 %"),
        ((0.041, 0.0), (1.0, 1.0), (0.49, 0.0), 0.0, ""),
        ((0.039, 0.2), (1.0, 1.0), (0.51, 0.0), 0.0, ""),
        ((0.4, 0.3), (0.5, 0.47), (0.0, 0.0), 0.0, "friction"),
        ((0.4, 0.3), (0.5, 0.49), (0.0, 0.0), 0.0, ""),
        ((0.4, 0.0), (0.7, 1.0), (0.0, 0.0), 0.0, "friction"),
        ((0.1, 0.1), (1.0, 1.0), (0.0, 0.0), 0.995 * MAX_DELAY, "delay"),
        ((0.1, 0.1), (1.0, 1.0), (0.0, 0.0), -0.985 * MAX_DELAY, ""),
    ],
)
def test_intervals_are_doubted_from_their_limits_on(monkeypatch, left, by_friction, at_limit, delay, why):
    shares = {True: np.array(left), False: np.array(by_friction)}
    monkeypatch.setattr(prepare, "unexplained", lambda _, subset=None: shares[subset is None].copy())
    monkeypatch.setattr(prepare, "saturated", {"recorded": np.arange(1000) < 1000.0 * np.array(at_limit)[:, None]}.get)
    monkeypatch.setattr(prepare, "smoothed", lambda _: Mock(noisy_joints=list))
    found = prepare._interval_doubt(Mock(loaded=Mock(recorded="recorded"), settings=Mock(delay=delay)), ARM)
    assert why in found and bool(found) == bool(why)


def test_a_saturated_torque_is_left_out_of_the_fit(tmp_path):
    """A sensor that ends at 70 % of the largest torque of joint 1, and at 90 % of that of joint 2."""
    log = load_log(write_log(tmp_path / "log.csv"), ARM).log
    noisy_torque = log.tau + 0.01 * np.random.default_rng(3).normal(size=log.tau.shape)
    most = np.array([[0.7], [0.9]]) * np.abs(noisy_torque).max(axis=1, keepdims=True)
    loaded = load_log(replace(log, tau=np.clip(noisy_torque, -most, most)), ARM)
    np.testing.assert_array_equal(loaded.log.left_out, np.abs(noisy_torque) >= most)
    assert len(list(left_out_torque(loaded.log))) == 2
    found = {}
    for name, used in (("without", loaded), ("with", replace(loaded, log=replace(loaded.log, left_out=None)))):
        rows = judged(problem_of_logs(used)).parameters
        found[name] = max(abs(p.estimate / true - 1.0) for p, true in zip(rows[:5], BETA, strict=False))
    assert found["without"] < 0.3 * found["with"]
    assert found["with"] > 0.08


def test_the_verdict_names_a_condition_that_holds_whatever_the_size_of_the_torque():
    factor = 1e-4
    # Inertia that is not positive definite without the condition, and viscous friction that would be negative.
    beta = BETA.copy()
    beta[2], beta[6] = 0.005, -0.05
    r = noisy(beta, n=300)
    r = replace(r, tau=factor * r.tau)
    result, _ = solved(problem_of(r), ("consistent", "ordinary"))
    m, free = result.methods
    b2 = m.parameters[6]
    assert (b2.verdict, b2.estimate, b2.standard_error, b2.low, b2.high) == (AT_BOUND, 0.0, None, None, None)
    assert free.parameters[6].low < factor * beta[6] < free.parameters[6].high
    assert (m.consistent, free.consistent) == (True, False)
    assert [p.verdict for p in m.parameters].count(AT_BOUND) == 1
    assert result.excitation.unexcited == ()


def with_interval(share, reach):
    """The verdict on b2 that moves a share of joint 2's RMS torque, known to this share of it."""
    r, beta = exciting(400), BETA.copy()
    beta[6] = share * np.sqrt(np.mean(r.tau[1] ** 2)) / np.sqrt(np.mean(r.y[1, :, 6] ** 2))
    far = np.full(9, reach * beta[6])
    found = Fit(METHODS["ordinary"], Estimate(beta.copy()), Uncertainty(0.5 * far, beta - far, beta + far), ())
    return evaluate(found, problem_of(r), (None,)).parameters[6].verdict


def test_a_parameter_that_moves_next_to_nothing_is_not_excited_unless_it_is_known():
    # Just below and above a five-hundredth of the RMS torque of joint 2.
    assert with_interval(0.0019, 1.5) == NOT_EXCITED
    assert with_interval(0.0021, 1.5) == NOT_FROM_ZERO, known_to
    assert with_interval(0.0019, 0.03) == with_interval(0.0021, 0.03) == known_to("3")
    assert with_interval(1e-5, 0.3) == known_to("30")


def test_only_what_depends_on_where_masses_are_may_be_negative():
    far = 0.1 * BETA
    found = Fit(METHODS["ordinary"], Estimate(-BETA), Uncertainty(0.5 * far, -BETA - far, -BETA + far), ())
    rows = evaluate(found, problem_of(exciting(400)), (None,)).parameters
    assert [p.name for p in rows if p.verdict != IMPOSSIBLE] == ["I2", "g1", "g2"]


def test_a_method_without_intervals_or_consistent_parameters_says_so():
    coupled = BETA * np.where(np.arange(9) == 1, 3.0, 1.0)  # I2 of no two links
    plain = Method("algorithm1", "A", "cnn_identification", lambda _: Estimate(coupled), claims_intervals=False)
    problem = problem_of(noisy(BETA))
    (found,) = fit_all(problem, [plain], 1, silent)
    assert found.halves == ()  # each would train another network
    m = evaluate(found, problem, (None,))
    assert (m.claims_intervals, m.consistent) == (False, False)
    assert {p.verdict for p in m.parameters} == {NO_INTERVAL}
    assert {(p.standard_error, p.low, p.high) for p in m.parameters} == {(None, None, None)}


def test_standstill_is_left_out_of_the_fit_and_judged():
    # Where the arm stands still, static friction adds a torque that Eq. 1 does not hold.
    r = exciting(800)
    still = np.zeros((2, 800), dtype=bool)
    still[:, 100:140] = still[1, 500:530] = True
    held = replace(r, tau=r.tau + 0.3 * still)
    counts = ~still
    without_standstill = replace(held, y=held.y * counts[..., np.newaxis], tau=held.tau * counts, mask=counts)
    problem = problem_of(held, without_standstill=without_standstill)
    found = fit(METHODS["ordinary"], problem, 1, True, silent)
    assert found.estimate.beta == pytest.approx(BETA, rel=1e-6)
    assert found.spread.standard_error == pytest.approx(np.zeros(9), abs=1e-6)
    expected = 0.3 * np.sqrt(still.mean(1)) / np.sqrt(np.mean(held.tau**2, axis=1))
    assert evaluate(found, problem, (None,)).fit.relative_rms == pytest.approx(tuple(expected), rel=1e-6)
    # The first half, which holds most of the standstill, is predicted with it and fitted without it.
    second, first = found.halves
    late = 0.3 * np.sqrt(still[:, 400:].mean(1)) / np.sqrt(np.mean(held.tau[:, 400:] ** 2, axis=1))
    assert second.relative_rms == pytest.approx(tuple(late), rel=1e-6, abs=1e-9)
    assert min(first.relative_rms) > 0.01
    # A method that sees the log as signals is given all of it.
    seen = []
    plain = Method("a", "A", "", lambda x: seen.append(x) or Estimate(BETA), False, needs_all_samples=True)
    fit(plain, problem, 1, False, silent)
    assert seen == [held]
