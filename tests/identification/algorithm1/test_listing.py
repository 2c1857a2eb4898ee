"""Lines 1 to 12 of Algorithm 1 against the same lines written out, and Eq. 15 by hand."""

from dataclasses import replace

import literal
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from repro.identification.algorithm1.preprocessing import derivatives, filtered, fit2trt, prepare
from repro.identification.algorithm1.search import SearchSettings, select
from repro.model.dynamics import inverse_dynamics
from repro.signals.dct import SignalSettings, dct2dev
from repro.signals.trajectories import identification_trajectory

SIGNALS = SignalSettings(h=0.02, samples=60)
MARGIN = 25
MOTION = identification_trajectory(SIGNALS.duration, SIGNALS.h, MARGIN)
TAU = inverse_dynamics(MOTION.q, MOTION.dq, MOTION.ddq, literal.ARMS["N1"])
N = MOTION.q.shape[1]  # 521
CUT = (MARGIN, N - MARGIN)
PEAK = TAU.max()
MEAN = np.random.default_rng(0).normal(size=(2, CUT[1] - CUT[0])) + 2.0


def prepared(q=MOTION.q, tau=TAU, tau_mean=MEAN, signals=SIGNALS, cut=CUT, **further):
    return prepare(filtered(q, tau, signals, *cut), tau_mean, signals, **further)


def signal(found, name):
    """A signal of line 12, or of the regression that lines 30 and 31 compare on."""
    return getattr(found.regression if name in ("q", "dq", "ddq", "tau", "y") else found, name)


def test_fit2trt_by_hand():
    tau = np.array([[3.0, 0.0, 1e-12], [4.0, 2.0, 0.0]])  # norms 5 and 2, and a sample without a level
    tau_mean = np.array([[6.0, 0.6, 7.0], [8.0, -0.8, 7.0]])  # norms 10 and 1
    assert fit2trt(tau, tau_mean) == pytest.approx((10 / 5 + 1 / 2) / 2, rel=1e-15)


@pytest.mark.parametrize("normalise", [False, True])
def test_lines_1_to_12(normalise):
    found = prepared(signals=replace(SIGNALS, normalise_motion=normalise))
    dq = literal.derivative(MOTION.q, SIGNALS.h, SIGNALS.c_f)  # 1
    ddq = literal.derivative(dq, SIGNALS.h, SIGNALS.c_f)  # 2
    tau = literal.low_pass(TAU, SIGNALS.h, SIGNALS.c_f)  # 3
    q_c, dq_c, ddq_c, tau_c = (x[:, CUT[0] : CUT[1]] for x in (MOTION.q, dq, ddq, tau))  # 4
    c_p = np.mean(np.sqrt((MEAN**2).sum(0)) / np.sqrt((tau_c**2).sum(0)))  # 5
    scaled = tau_c * c_p  # 6
    q_s, dq_s, ddq_s, tau_s = (literal.subsample(x, SIGNALS.samples) for x in (q_c, dq_c, ddq_c, scaled))  # 7
    tau_n = tau_s / np.abs(tau_s).max()  # 12

    def same(a, b):
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-10 * np.abs(b).max())

    for name, expected in (("q", q_c), ("dq", dq_c), ("ddq", ddq_c), ("tau", tau_c)):
        same(signal(found, name), expected)
    same(found.alpha, tau_n)
    assert found.c_p == pytest.approx(c_p, rel=1e-10)
    assert found.torque_scale * found.c_p == pytest.approx(np.abs(tau_s).max(), rel=1e-10)
    assert np.abs(found.alpha).max() == 1.0
    image_motion = [q_s, dq_s, ddq_s]
    if normalise:
        image_motion = [x / np.abs(x).max(1, keepdims=True) for x in image_motion]
    for arm in literal.ARMS.values():
        same(found.model @ arm, inverse_dynamics(*image_motion, arm))
        same(found.y_sub @ arm, inverse_dynamics(q_s, dq_s, ddq_s, arm))
        same(found.regression.y @ arm, inverse_dynamics(q_c, dq_c, ddq_c, arm))


def test_the_image_may_show_the_motion_that_was_sent():
    """f of the image is on it, and nothing else: torque, comparison and selection stay with the measured motion."""
    sent = MOTION.q + 0.01 * np.sin(np.arange(N) / 50.0)
    ours = prepared()
    other = prepared(image_motion=[x[:, slice(*CUT)] for x in derivatives(sent, SIGNALS)])
    for name in ("q", "dq", "ddq", "tau", "alpha", "y_sub", "y"):
        np.testing.assert_array_equal(signal(ours, name), signal(other, name))
    expected = prepared(q=sent)
    np.testing.assert_array_equal(other.model, expected.model)
    assert np.abs(other.model - ours.model).max() > 1e-3
    same = prepared(image_motion=[x[:, slice(*CUT)] for x in derivatives(MOTION.q, SIGNALS)])
    np.testing.assert_array_equal(same.model, ours.model)


@settings(max_examples=20)
@given(st.floats(0.01, 100.0))
def test_level_of_the_training_torque_cancels(factor):
    """c_p enters in line 6 and leaves in line 32, so it changes neither the signals nor the parameters."""
    ours, other = prepared(), prepared(tau_mean=factor * MEAN)
    assert other.c_p == pytest.approx(factor * ours.c_p, rel=1e-12)
    for name in ("tau", "alpha", "torque_scale", "model", "y_sub", "y"):
        np.testing.assert_array_equal(signal(ours, name), signal(other, name))
    beta_m = np.stack(list(literal.ARMS.values()))
    first, second = (select(beta_m, p, SearchSettings()) for p in (ours, other))
    np.testing.assert_allclose(first.beta, second.beta, rtol=1e-12)
    assert first.similarity == second.similarity


def slowed(times, beta, margin=MARGIN):
    """The trajectory run so many times slower, torques exact for the derivatives that lines 1 and 2 take."""
    motion = identification_trajectory(times * SIGNALS.duration, SIGNALS.h, margin)
    dq = dct2dev(motion.q, SIGNALS.h, 0.0)
    return motion.q, inverse_dynamics(motion.q, dq, dct2dev(dq, SIGNALS.h, 0.0), beta)


def in_canonical_time(beta, pace):
    """Eq. 1 in t' = pace t: inertias times pace^2, viscous friction times pace, the rest as it is."""
    i, g, b, k = beta[:3], beta[3:5], beta[5:7], beta[7:]
    return np.concatenate([pace**2 * i, g, pace * b, k])


@settings(max_examples=20)
@given(st.floats(0.4, 3.0), st.sampled_from(sorted(literal.ARMS)))
def test_a_trajectory_run_slower_is_the_same_arm_in_canonical_time(times, arm):
    truth = literal.ARMS[arm]
    q, tau = slowed(times, truth)
    n, exact = q.shape[1] - 2 * MARGIN, replace(SIGNALS, c_f=0.0)
    pace = MEAN.shape[1] / n
    found = prepared(q, tau, np.ones((2, n)), exact, (MARGIN, MARGIN + n), time_scale=pace)
    canonical = in_canonical_time(truth, pace)
    r = found.regression
    np.testing.assert_allclose(r.y @ canonical, r.tau, rtol=0, atol=1e-10 * np.abs(r.tau).max())
    np.testing.assert_allclose(found.to_recorded_time(canonical), truth, rtol=1e-12)
    np.testing.assert_allclose(found.to_recorded_time(np.stack([canonical] * 3)), np.stack([truth] * 3), rtol=1e-12)
    chosen = select(np.stack([0.7 * canonical[::-1], canonical / found.torque_scale]), found, SearchSettings())
    np.testing.assert_allclose(chosen.beta, truth, rtol=1e-9)
    assert chosen.similarity == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("cut", [(-1, 400), (0, 60), (400, 460), (300, 200), (N, None), (0, N + 200)])
def test_cuts_that_do_not_fit_are_refused(cut):
    with pytest.raises(ValueError, match="begin, end"):
        prepared(cut=cut)


@pytest.mark.parametrize(
    ("change", "rule"),
    [
        ({"tau": TAU[:, :-1]}, "differ"),
        ({"q": MOTION.q[0], "tau": TAU[0]}, "last two axes"),
        ({"tau": np.where(PEAK > TAU, TAU, np.nan)}, "finite"),
        ({"q": np.where(MOTION.q == MOTION.q.max(), np.inf, MOTION.q)}, "finite"),
        ({"tau": np.zeros_like(TAU)}, "zero throughout"),
        ({"tau_mean": MEAN[:, :-1]}, "differ"),
    ],
)
def test_wrong_signals_are_refused(change, rule):
    with pytest.raises(ValueError, match=rule):
        prepared(**change)
