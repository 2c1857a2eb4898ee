"""Algorithm 1 against its listing run line by line, and Eq. 15 by hand."""

from dataclasses import replace

import literal
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from repro.cnn.image import ImageSettings
from repro.identification.algorithm1.preprocessing import derivatives, filtered, fit2trt, prepare
from repro.identification.algorithm1.search import ResidualEstimator, SearchSettings, search, select
from repro.model.dynamics import inverse_dynamics
from repro.signals.dct import SignalSettings
from repro.signals.metric import MetricSettings
from repro.signals.trajectories import identification_trajectory

SIGNALS = SignalSettings(sampling_period_s=0.02, image_samples=literal.SMALL.image_size)
MARGIN = 25
MOTION = identification_trajectory(SIGNALS.duration_s, SIGNALS.sampling_period_s, MARGIN)
N1 = literal.ARMS["N1"]
TAU = inverse_dynamics(MOTION.q, MOTION.dq, MOTION.ddq, N1)
N = MOTION.q.shape[1]  # 521
CUT = (MARGIN, N - MARGIN)
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


def test_the_image_may_show_the_motion_that_was_sent():
    """f of the image is on it, and nothing else: torque, comparison and selection stay with the measured motion."""
    sent = MOTION.q + 0.01 * np.sin(np.arange(N) / 50.0)
    ours = prepared()
    other = prepared(image_motion=[x[:, slice(*CUT)] for x in derivatives(sent, SIGNALS)])
    for name in ("q", "dq", "ddq", "tau", "alpha", "y_sub", "y"):
        np.testing.assert_array_equal(signal(ours, name), signal(other, name))
    np.testing.assert_array_equal(other.model, prepared(q=sent).model)
    assert np.abs(other.model - ours.model).max() > 1e-3


@settings(max_examples=20)
@given(st.floats(0.01, 100.0))
def test_level_of_the_training_torque_cancels(factor):
    """c_p enters in line 6 and leaves in line 32, so it changes neither the signals nor the parameters."""
    ours, other = prepared(), prepared(tau_mean=factor * MEAN)
    assert other.c_p == pytest.approx(factor * fit2trt(ours.regression.tau, MEAN), rel=1e-12)
    for name in ("tau", "alpha", "torque_scale", "model", "y_sub", "y"):
        np.testing.assert_array_equal(signal(ours, name), signal(other, name))
    beta_m = np.stack(list(literal.ARMS.values()))
    first, second = (select(beta_m, p, SearchSettings()) for p in (ours, other))
    np.testing.assert_allclose(first.beta, second.beta, rtol=1e-12)
    assert first.similarity == second.similarity


@settings(max_examples=20)
@given(st.floats(0.4, 3.0), st.sampled_from(sorted(literal.ARMS)), st.sampled_from([1.0, 0.03, 40.0]))
def test_a_trajectory_run_slower_is_the_same_arm_in_canonical_time(times, arm, strength):
    truth = strength * literal.ARMS[arm]
    q = identification_trajectory(times * SIGNALS.duration_s, SIGNALS.sampling_period_s, MARGIN).q
    n, exact = q.shape[1] - 2 * MARGIN, replace(SIGNALS, c_f=0.0)
    pace = MEAN.shape[1] / n
    tau = inverse_dynamics(*derivatives(q, exact), truth)
    found = prepared(q, tau, np.ones((2, n)), exact, (MARGIN, MARGIN + n), time_scale=pace)
    canonical = truth * pace ** np.array([2, 2, 2, 0, 0, 1, 1, 0, 0])  # Eq. 1 in t' = pace t
    r = found.regression
    np.testing.assert_allclose(r.y @ canonical, r.tau, rtol=0, atol=1e-10 * np.abs(r.tau).max())
    np.testing.assert_allclose(found.to_recorded_time(np.stack([canonical] * 3)), np.stack([truth] * 3), rtol=1e-12)
    answer = canonical / found.torque_scale
    chosen = select(np.stack([0.7 * answer[::-1], answer]), found, SearchSettings())
    np.testing.assert_allclose(chosen.beta, truth, rtol=1e-9)
    assert chosen.similarity == pytest.approx(1.0, abs=1e-3)
    plain = replace(exact, normalise_motion=False)
    found = prepared(q, tau, np.ones((2, n)), plain, (MARGIN, MARGIN + n), time_scale=pace)
    np.testing.assert_array_equal(found.model, found.y_sub)  # the image has the same Coulomb friction


@pytest.mark.parametrize("cut", [(-1, 400), (0, 44), (400, 444), (300, 200), (N, None), (0, N + 200)])
def test_cuts_that_do_not_fit_are_refused(cut):
    with pytest.raises(ValueError, match="begin, end"):
        prepared(cut=cut)


@pytest.mark.parametrize(
    ("change", "rule"),
    [
        ({"tau": TAU[:, :-1]}, "differ"),
        ({"q": MOTION.q[0], "tau": TAU[0]}, "last two axes"),
        ({"tau": np.where(TAU.max() > TAU, TAU, np.nan)}, "finite"),
        ({"q": np.where(MOTION.q == MOTION.q.max(), np.inf, MOTION.q)}, "finite"),
        ({"tau": np.zeros_like(TAU)}, "zero throughout"),
        ({"tau_mean": MEAN[:, :-1]}, "differ"),
    ],
)
def test_wrong_signals_are_refused(change, rule):
    with pytest.raises(ValueError, match=rule):
        prepared(**change)


# Lines 13 to 32.
SEARCH = SearchSettings(executions=12, inner_limit=6, threshold=0.62, guess_high=0.5)


def constant(*rows):
    """Estimator that answers with the given estimates in turn, whatever the guesses."""
    return literal.Estimator(lambda guess: np.stack([rows[k % len(rows)] for k in range(len(guess))]))


@pytest.mark.parametrize(
    ("seed", "normalise", "scale", "gain", "batch", "settings"),
    [
        (3, False, "shared-max", 2.0, 100, SEARCH),
        (4, True, "channel-max", 4.0, 7, SEARCH),
        (5, False, "constant", 8.0, 1, replace(SEARCH, metric=MetricSettings(exponent=0.5))),
    ],
    ids=["published", "normalised motion and channels, small batches", "constant divisor, other metric, single images"],
)
def test_batched_search_is_the_listing(monkeypatch, seed, normalise, scale, gain, batch, settings):
    """Guesses near the level of the answer and residuals of about 0.1: with random weights every branch is taken."""
    network = literal.untrained(gain=gain)
    monkeypatch.setattr("repro.identification.algorithm1.search.BATCH", batch)
    signals = replace(SIGNALS, normalise_motion=normalise)
    ready = prepared(signals=signals)
    reader = ResidualEstimator(network, ImageSettings(scale), ready)
    found = search(reader, ready, settings, np.random.default_rng(seed))
    chosen = select(found.beta, ready, settings)
    streams = np.random.default_rng(seed).spawn(settings.executions)
    given = (literal.plain_twin(network), MOTION.q, TAU, MEAN, signals, CUT, settings, streams, scale)
    beta_m, execution, n_e, images, beta_o, similarity = literal.algorithm1(*given)
    # Every branch was taken, none by a hair.
    ended = {k for k, n in zip(execution, n_e, strict=True) if n >= SEARCH.threshold}
    assert len(beta_m) >= 20
    assert images >= len(beta_m) + 15
    assert 5 <= len(ended) <= SEARCH.executions - 3
    assert np.abs(np.array(n_e) - SEARCH.threshold).min() > 1e-3
    # The listing finishes one execution before it starts the next; rounds of one guess each come in another order.
    order, listed = np.argsort(found.beta[:, 0]), np.argsort(np.array(beta_m)[:, 0])
    np.testing.assert_allclose(found.beta[order], np.array(beta_m)[listed], rtol=0, atol=1e-5)
    np.testing.assert_allclose(found.similarity[order], np.array(n_e)[listed], rtol=0, atol=1e-4)
    assert reader.images == images
    np.testing.assert_allclose(chosen.beta, beta_o, rtol=1e-4)
    assert chosen.similarity == pytest.approx(similarity, abs=1e-4)


@pytest.mark.parametrize(("kept", "batch"), [(5, 3), (40, 100), (1000, 4)])
def test_a_search_keeps_the_most_similar_and_a_longer_one_contains_it(monkeypatch, kept, batch):
    """Every guess is an estimate here, so that the published search would keep all 60."""
    ready = prepared()

    def run(executions):
        settings = replace(SEARCH, executions=executions, threshold=1.0)
        found = search(literal.Estimator(lambda guess: guess), ready, settings, np.random.default_rng(2))
        return {tuple(beta): n for beta, n in zip(found.beta, found.similarity, strict=True)}

    every, longer = run(10), run(14)
    assert len(every) == 60 and every.keys() < longer.keys()
    monkeypatch.setattr("repro.identification.algorithm1.search.BATCH", batch)
    monkeypatch.setattr("repro.identification.algorithm1.search.KEPT", kept)
    assert run(10).keys() == set(sorted(every, key=every.get)[-kept:])


@pytest.mark.parametrize("feasibility", ["positive", "positive-definite"])
def test_infeasible_estimates_are_never_kept(feasibility):
    """The best fit has a negative parameter, or an inertia matrix that is not positive definite: it must lose."""
    beta = N1.copy()
    if feasibility == "positive":
        beta[1] = -0.1
    else:
        beta[0] = 0.5 * beta[2]
    ready = prepared(tau=inverse_dynamics(MOTION.q, MOTION.dq, MOTION.ddq, beta))
    best, allowed = beta / ready.torque_scale, N1 / ready.torque_scale
    settings = SearchSettings(6, 5, feasibility=feasibility)
    found = search(constant(best, allowed), ready, settings, np.random.default_rng(0))
    np.testing.assert_array_equal(found.beta, np.broadcast_to(allowed, found.beta.shape))
    chosen = select(found.beta, ready, settings)
    np.testing.assert_allclose(chosen.beta / chosen.beta[0], N1 / N1[0], rtol=1e-12)


def test_no_possible_estimate_gives_zeros():
    ready = prepared()
    estimator = constant(-N1)
    found = search(estimator, ready, SearchSettings(5, 4), np.random.default_rng(0))
    assert (found.beta.shape, found.similarity.shape, estimator.images) == ((0, 9), (0,), 20)
    chosen = select(found.beta, ready, SearchSettings())
    assert (chosen.beta.tolist(), chosen.similarity) == ([0.0] * 9, 0.0)
