"""The self-test says that noise makes the error on a log of Eq. 1, and that it does not on one with other friction."""

from dataclasses import replace
from functools import partial
from unittest.mock import Mock

import numpy as np
import pytest
from fitting_problem import ARM, OPTIONS, loaded, problem_of_logs, silent, solved
from log_example import BETA
from regression_example import broadband, log_from

from repro.fitting import evaluate
from repro.fitting.evaluate import add_self_test, inverse_errors, self_test, synthetic_log
from repro.fitting.text import self_test_verdict
from repro.identification.calibration import correct_calibration
from repro.identification.filtering import prepare
from repro.identification.least_squares import METHODS
from repro.identification.log import Log, uniform
from repro.logs.torque_limits import quantisation_step
from repro.model.parameters import NAMES

pytestmark = pytest.mark.slow

STEP, NOISE, LATE = 1e-4, 0.05, 0.004
#: Sines up to 3 Hz, so that the torque at the frequencies looked at is nearly all of the motion.
slow = partial(broadband, top=3.0, lines=20)


def recorded(stribeck=0.0, zero=0.0, jitter=0.0):
    """A log of the known arm: noise in the torque, encoder steps, a torque that is recorded too early."""
    rng = np.random.default_rng(0)
    log = log_from(slow, seconds=20.0, delay=LATE)
    speed = slow(log.t + LATE)[1]
    more = stribeck * np.tanh(20.0 * speed) * np.exp(-((speed / 0.3) ** 2))
    t = log.t + np.append(0.0, jitter * rng.uniform(-1.0, 1.0, log.t.size - 1))
    q = np.stack([np.interp(t, log.t, joint) for joint in log.q]) + np.array([[zero], [0.0]])
    tau = np.stack([np.interp(t, log.t, joint) for joint in log.tau + more])
    tau += NOISE * rng.normal(size=tau.shape)
    raw = Log(name="log.csv", t=t, q=STEP * np.rint(q / STEP), tau=tau)
    return replace(loaded(uniform(raw)), recorded=raw)


def ordinary_self_test(problem):
    method = METHODS["ordinary"]
    return self_test(problem, method, method.estimate(problem.without_standstill).beta, ARM, OPTIONS, silent)


@pytest.fixture(scope="module")
def clean():
    problem = problem_of_logs(recorded())
    return problem, ordinary_self_test(problem)


def test_the_estimates_are_the_truth(clean):
    _, test = clean
    assert [p.name for p in test.parameters] == list(NAMES)
    for p in test.parameters:
        assert p.low < p.high  # as they would not be without noise
        assert p.low <= p.median <= p.high
        assert p.intervals == test.draws == 5
        assert p.median == pytest.approx(p.true, rel=0.1, abs=0.02)
    assert np.mean([p.hold / p.intervals for p in test.parameters]) >= 0.9


def test_where_eq_1_is_right_the_noise_that_was_put_in_is_the_error(clean):
    """White noise of the torque through both filters leaves a share of its size that only the filters decide."""
    problem, test = clean
    assert not test.model_wrong
    assert not test.model_wrong and self_test_verdict(test)
    # Each log's noise is another draw: their errors agree to a quarter.
    assert test.error == pytest.approx(test.real, rel=0.25)
    log, settings = problem.first.loaded.log, problem.first.settings
    noise = replace(log, tau=NOISE * np.random.default_rng(9).normal(size=log.tau.shape))
    filtered = np.sqrt(np.mean(prepare(noise, settings).tau ** 2, axis=-1))
    torque = np.sqrt(np.mean(problem.regression.tau**2, axis=-1))
    assert test.error == pytest.approx(filtered / torque, rel=0.3)


def test_stribeck_friction_is_distinguished_from_noise():
    test = ordinary_self_test(problem_of_logs(recorded(stribeck=0.6), friction=False))
    assert test.model_wrong
    assert max(test.real) > 2 * max(test.error)


def test_a_synthetic_log_is_recorded_as_the_real_one_was():
    original = recorded(jitter=2e-4, zero=0.08)
    (ready,) = problem_of_logs(original).logs
    assert [error.name for error in ready.calibration_errors] == ["zero1"]
    synthetic = synthetic_log(ready, BETA, np.random.default_rng(0))
    assert synthetic.recorded.t == pytest.approx(original.recorded.t)
    assert [quantisation_step(q) for q in synthetic.recorded.q] == pytest.approx([STEP, STEP], rel=1e-3)
    inside = slice(60, -60)  # without the ends, where filters do not see both sides
    assert synthetic.recorded.q[:, inside] == pytest.approx(original.recorded.q[:, inside], abs=20 * STEP)
    # Differences of neighbours are nearly all noise, which is taken a little too large rather than too small.
    made, noise = (np.std(np.diff(one.recorded.tau, 2)[:, inside], axis=-1) for one in (synthetic, original))
    assert ((0.95 * noise < made) & (made < 1.5 * noise)).all()
    (again,) = problem_of_logs(synthetic, cutoff=ready.settings.cutoff).logs
    assert [error.name for error in again.calibration_errors] == ["zero1"]
    assert again.calibration_errors[0].value == pytest.approx(ready.calibration_errors[0].value, abs=0.005)
    assert again.settings.delay == pytest.approx(ready.settings.delay, abs=1e-3)


def test_rounded_time_stamps_are_no_jitter():
    """Taken for the instants, stamps rounded to 1 ms would move a sample by up to 0.5 ms."""
    original = recorded()
    t = np.round(np.arange(original.log.t.size) / 210.0, 3)
    raw = replace(original.recorded, t=t)
    (ready,) = problem_of_logs(replace(original, log=uniform(raw), recorded=raw)).logs
    synthetic = synthetic_log(ready, BETA, np.random.default_rng(0))
    assert synthetic.recorded.t == pytest.approx(t)
    rough = [np.std(np.diff(q, 3), axis=-1) for q in (synthetic.recorded.q, raw.q)]
    assert rough[0] == pytest.approx(rough[1], rel=0.1)


def test_logs_are_simulated_by_their_longest_pieces_and_prepared_together(monkeypatch):
    whole = recorded().recorded  # the piece with missing samples is the shorter one as it is recorded
    used = np.where(whole.t < 10.0, np.arange(whole.t.size) % 50 != 7, whole.t > 10.1)
    raw = replace(whole, t=whole.t[used], q=whole.q[:, used], tau=whole.tau[:, used])
    problem = problem_of_logs(recorded(zero=0.05), replace(loaded(uniform(raw)), recorded=raw))
    monkeypatch.setattr(evaluate, "DRAWS", 1)
    monkeypatch.setattr(evaluate, "prepare_logs", Mock(wraps=evaluate.prepare_logs))
    ordinary_self_test(problem)
    assert [log.recorded.t.size for log in evaluate.prepare_logs.call_args.args[0]] == [4000, 1960]


def test_a_method_without_intervals_has_no_self_test(clean):
    problem, _ = clean
    result, _ = solved(problem)
    mute = replace(result, methods=tuple(replace(m, claims_intervals=False) for m in result.methods))
    assert add_self_test(mute, problem, ARM, OPTIONS, silent) == mute


def test_the_inverse_of_a_correction_restores_the_log():
    log, errors = recorded().log, {"zero2": 0.05, "offset2": 0.3, "scale2": 1.4, "offset1": -0.1}
    again = correct_calibration(correct_calibration(log, errors), inverse_errors(errors))
    np.testing.assert_allclose([again.q, again.tau], [log.q, log.tau])
