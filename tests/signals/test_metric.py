"""The similarity ``metr2ev`` and its fast form for many parameter sets (Algorithm 2, Tables 7 and 10)."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.fft import dct
from strategies import seeds

from repro.model.dynamics import inverse_dynamics, regressor
from repro.signals.metric import PUBLISHED_METRIC, TIME_FORMULAS, MetricSettings, TorqueScorer, metr2ev
from repro.signals.trajectories import identification_trajectory


def literal(x, y, formula):
    """Time and frequency similarity of two single signals, in the order of Algorithm 2."""
    error = np.linalg.norm(x - y) ** 2
    time = 1.0 - error / (x.size if formula == "mean-square" else np.linalg.norm(x) ** 2)
    big_x, big_y = dct(x, type=2, norm="ortho"), dct(y, type=2, norm="ortho")
    frequency = 1.0 - np.linalg.norm(big_x / np.linalg.norm(big_x) - big_y / np.linalg.norm(big_y))
    return max(time, 0.0) ** 0.4, max(frequency, 0.0) ** 0.4


@given(seed=seeds, n=st.integers(2, 400), unit=st.floats(1e-3, 1e3))
def test_equal_signals_score_one(seed, n, unit):
    x = unit * np.random.default_rng(seed).normal(size=n)
    score = metr2ev(x, x.copy())
    assert score.time == score.frequency == score.total == 1.0


@pytest.mark.parametrize("formula", TIME_FORMULAS)
@given(seed=seeds, n=st.integers(2, 400), level=st.floats(1e-2, 0.5), gain=st.floats(0.7, 1.3))
def test_equals_the_literal_formula(formula, seed, n, level, gain):
    x, noise = np.random.default_rng(seed).normal(size=(2, n))
    y = gain * (x + level * np.linalg.norm(x) / np.linalg.norm(noise) * noise)
    time, frequency = literal(x, y, formula)
    score = metr2ev(x, y, MetricSettings(formula))
    np.testing.assert_allclose([score.time, score.frequency], [time, frequency], rtol=0, atol=1e-12)
    assert 0.0 < score.frequency < 1.0
    np.testing.assert_allclose(score.total, time * frequency, rtol=0, atol=1e-12)


@pytest.mark.parametrize("angle", [1e-9, 1e-12])
def test_frequency_resolves_nearly_equal_signals(angle):
    x, y = np.array([1.0, 0.0]), np.array([np.cos(angle), np.sin(angle)])
    distance = 1.0 - metr2ev(x, y, MetricSettings(exponent=1.0)).frequency
    assert distance == pytest.approx(angle, rel=1e-3, abs=1e-15)


def test_far_opposite_orthogonal_and_zero_signals_score_zero():
    x = np.random.default_rng(2).normal(size=60)
    assert metr2ev(x, x + 0.1).time > metr2ev(100.0 * x, 100.0 * x + 10.0).time == 0.0
    turn = np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)
    for rebuilt in (-np.sin(turn), np.cos(turn), np.zeros(64)):
        score = metr2ev(np.sin(turn), rebuilt)
        assert score.frequency == score.total == 0.0
    assert metr2ev(np.array([1.0, -2.0, 0.5]), np.zeros(3)).time == 0.0


MOTION = identification_trajectory()
Y = regressor(MOTION.q, MOTION.dq, MOTION.ddq)


def score_both_ways(true, betas, settings=PUBLISHED_METRIC):
    """Similarity of `betas` to the arm `true` on Eq. 10: by inner products, and by metr2ev on the signals."""
    tau = inverse_dynamics(MOTION.q, MOTION.dq, MOTION.ddq, true)
    rebuilt = inverse_dynamics(MOTION.q, MOTION.dq, MOTION.ddq, betas)
    return TorqueScorer(tau, Y, settings)(betas), metr2ev(tau, rebuilt, settings)


@pytest.mark.parametrize("formula", TIME_FORMULAS)
@settings(max_examples=25)
@given(seed=seeds)
def test_scorer_equals_metr2ev_for_random_parameters(formula, seed):
    rng = np.random.default_rng(seed)
    true = rng.uniform(1e-3, 1.0, 9)
    betas = true * rng.uniform(0.3, 1.7, (40, 9))
    betas[:5] = rng.uniform(-3.0, 3.0, (5, 9))
    fast, slow = score_both_ways(true, betas, MetricSettings(formula))
    for quick, exact in ((fast.time, slow.time), (fast.frequency, slow.frequency)):
        # Near 0 the power 0.4 turns a rounding of 1e-15 into 1e-6; elsewhere it stays small.
        tolerance = np.where(exact < 1e-3, 1e-6, 1e-11)
        np.testing.assert_array_less(np.abs(quick - exact), tolerance)


@settings(max_examples=40)
@given(seed=seeds, exponent=st.integers(-16, -3))
def test_scorer_equals_metr2ev_for_nearly_equal_parameters(seed, exponent):
    # 1 - cos cancels to about 1e-15, so the distance of the spectra is known to about 5e-8 and no better.
    rng = np.random.default_rng(seed)
    true = rng.uniform(1e-3, 1.0, 9)
    betas = true * (1.0 + 10.0**exponent * rng.uniform(-1.0, 1.0, (20, 9)))
    betas[0] = true
    fast, slow = score_both_ways(true, betas)
    np.testing.assert_allclose(fast.time, slow.time, rtol=0, atol=1e-13)
    np.testing.assert_allclose(fast.frequency, slow.frequency, rtol=0, atol=1e-7)


TAU, REGRESSOR = np.ones((2, 6)), np.ones((2, 6, 9))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: metr2ev(np.zeros(4), np.ones(4)), r"^x: .*zero throughout"),
        (lambda: metr2ev(np.stack([np.ones(4), np.zeros(4)]), np.ones(4)), r"^x: .*zero throughout"),
        (lambda: metr2ev(np.ones(4), np.ones(5)), r"^x, y: lengths differ"),
        (lambda: metr2ev(np.array([1.0, np.nan]), np.ones(2)), r"^x: every sample must be finite"),
        (lambda: metr2ev(np.empty(0), np.empty(0)), r"^x: .*at least one sample"),
        (lambda: TorqueScorer(TAU * [[1.0], [0.0]], REGRESSOR), r"^tau: .*zero throughout"),
        (lambda: TorqueScorer(TAU, REGRESSOR)(np.full(9, np.nan)), r"^beta: "),
    ],
)
def test_broken_arguments_are_named(call, message):
    with pytest.raises(ValueError, match=message):
        call()
