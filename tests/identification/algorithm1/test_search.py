"""Algorithm 1: the batched search against the listing run line by line, and what it does with perfect estimates."""

from dataclasses import replace

import literal
import numpy as np
import pytest

from repro.cnn.image import ImageSettings
from repro.identification.algorithm1.preprocessing import filtered, prepare
from repro.identification.algorithm1.search import ResidualEstimator, SearchSettings, search, select
from repro.model.dynamics import inverse_dynamics
from repro.signals.dct import SignalSettings, dct2dev
from repro.signals.metric import MetricSettings
from repro.signals.trajectories import identification_trajectory

SIGNALS = SignalSettings(h=0.02, samples=literal.SMALL.image_size)
MARGIN = 25
MOTION = identification_trajectory(SIGNALS.duration, SIGNALS.h, MARGIN)
N = MOTION.q.shape[1]
CUT = (MARGIN, N - MARGIN)
MEAN = np.random.default_rng(0).normal(size=(2, CUT[1] - CUT[0])) + 2.0
N1 = literal.ARMS["N1"]
TAU = inverse_dynamics(MOTION.q, MOTION.dq, MOTION.ddq, N1)

# Guesses near the level of the answer and residuals of about 0.1: with random weights every branch is taken.
NETWORK = literal.untrained(gain=2.0)
SEARCH = SearchSettings(executions=12, inner_limit=6, threshold=0.62, high=0.5)


def make(tau=TAU, tau_mean=MEAN, signals=SIGNALS):
    return prepare(filtered(MOTION.q, tau, signals, *CUT), tau_mean, signals)


def constant(*rows):
    """Estimator that answers with the given estimates in turn, whatever the guesses."""
    return literal.Estimator(lambda guess: np.stack([rows[k % len(rows)] for k in range(len(guess))]))


def exact_signals():
    """Signals that Eq. 1 explains without error: no filter, torque from the very derivatives that line 1 takes."""
    signals = replace(SIGNALS, c_f=0.0)
    dq = dct2dev(MOTION.q, SIGNALS.h, 0.0)
    return signals, (MOTION.q, dq, dct2dev(dq, SIGNALS.h, 0.0))


@pytest.mark.parametrize(
    ("seed", "normalise", "settings"),
    [(3, False, SEARCH), (4, True, SEARCH), (5, False, replace(SEARCH, metric=MetricSettings(exponent=0.5)))],
    ids=["published", "normalised motion", "other metric"],
)
def test_batched_search_is_the_listing(seed, normalise, settings):
    signals = replace(SIGNALS, normalise_motion=normalise)
    prepared = make(signals=signals)
    reader = ResidualEstimator(NETWORK, ImageSettings(), prepared)
    found = search(reader, prepared, settings, np.random.default_rng(seed))
    chosen = select(found.beta, prepared, settings)
    streams = np.random.default_rng(seed).spawn(settings.executions)
    beta_m, execution, n_e, images, beta_o, similarity = literal.algorithm1(
        literal.plain_twin(NETWORK), MOTION.q, TAU, MEAN, signals, CUT, settings, streams
    )
    # Every branch was taken, none by a hair.
    ended = {k for k, n in zip(execution, n_e, strict=True) if n >= SEARCH.threshold}
    assert len(beta_m) >= 20
    assert images >= len(beta_m) + 15
    assert 5 <= len(ended) <= SEARCH.executions - 3
    assert np.abs(np.array(n_e) - SEARCH.threshold).min() > 1e-3
    # The listing finishes one execution before it starts the next; rounds of one guess each come in another order.
    order = np.argsort(found.execution, kind="stable")
    np.testing.assert_array_equal(found.execution[order], execution)
    np.testing.assert_allclose(found.beta[order], beta_m, rtol=0, atol=1e-5)
    np.testing.assert_allclose(found.similarity[order], n_e, rtol=0, atol=1e-4)
    assert reader.images == images
    np.testing.assert_allclose(chosen.beta, beta_o, rtol=1e-4)
    assert chosen.similarity == pytest.approx(similarity, abs=1e-4)


@pytest.mark.parametrize("feasibility", ["positive", "positive-definite"])
def test_infeasible_estimates_are_never_kept(feasibility):
    """The best fit has a negative parameter, or an inertia matrix that is not positive definite: it must lose."""
    beta = N1.copy()
    if feasibility == "positive":
        beta[1] = -0.1
    else:
        beta[0] = 0.5 * beta[2]
    prepared = make(inverse_dynamics(MOTION.q, MOTION.dq, MOTION.ddq, beta))
    best, allowed = beta / prepared.torque_scale, N1 / prepared.torque_scale
    settings = SearchSettings(6, 5, feasibility=feasibility)
    found = search(constant(best, allowed), prepared, settings, np.random.default_rng(0))
    np.testing.assert_array_equal(found.beta, np.broadcast_to(allowed, found.beta.shape))
    assert set(found.execution) <= set(range(6))
    chosen = select(found.beta, prepared, settings)
    np.testing.assert_allclose(chosen.beta / chosen.beta[0], N1 / N1[0], rtol=1e-12)


def test_no_possible_estimate_gives_zeros():
    prepared = make()
    estimator = constant(-N1)
    found = search(estimator, prepared, SearchSettings(5, 4), np.random.default_rng(0))
    assert found.beta.shape == (0, 9)
    assert found.execution.shape == found.similarity.shape == (0,)
    assert estimator.images == 20
    chosen = select(found.beta, prepared, SearchSettings())
    np.testing.assert_array_equal(chosen.beta, np.zeros(9))
    assert chosen.similarity == 0.0


@pytest.mark.parametrize("arm", literal.ARMS)
@pytest.mark.parametrize("strength", [1.0, 0.03, 40.0])
def test_perfect_network_recovers_the_parameters(arm, strength):
    signals, motion = exact_signals()
    truth = strength * literal.ARMS[arm]
    prepared = make(inverse_dynamics(*motion, truth), signals=signals)
    found = search(constant(truth / prepared.torque_scale), prepared, SearchSettings(5, 3), np.random.default_rng(0))
    chosen = select(found.beta, prepared, SearchSettings())
    np.testing.assert_allclose(chosen.beta, truth, rtol=1e-10)
    assert chosen.similarity == pytest.approx(1.0, abs=1e-3)


# Lines 17 to 21 for many guesses.

GUESSES = np.random.default_rng(0).uniform(1e-3, 3.0, (20, 9))


def reader(scale="shared-max", prepared=None):
    return ResidualEstimator(literal.untrained(), ImageSettings(scale), make() if prepared is None else prepared)


@pytest.mark.parametrize("scale", ["shared-max", "channel-max", "constant"])
@pytest.mark.parametrize("normalise", [False, True])
def test_estimates_are_those_of_single_images_and_the_plain_network(scale, normalise):
    prepared = make(signals=replace(SIGNALS, normalise_motion=normalise))
    found = reader(scale, prepared).estimate(GUESSES)
    motion = [
        literal.subsample(x, SIGNALS.samples)
        for x in (prepared.regression.q, prepared.regression.dq, prepared.regression.ddq)
    ]
    if normalise:
        motion = [x / np.abs(x).max(1, keepdims=True) for x in motion]
    plain = literal.plain_twin(literal.untrained())
    for guess, estimate in zip(GUESSES, found, strict=True):
        r = literal.read(plain, literal.guess_image(prepared.alpha, motion, guess, scale))
        np.testing.assert_allclose(estimate, guess + r, rtol=0, atol=1e-5 * max(1.0, np.abs(r).max()))
    assert found.dtype == np.float64


@pytest.mark.parametrize("batch", [1, 7, 20, 1000])
def test_size_of_the_batches_does_not_matter(batch, monkeypatch):
    expected = reader().estimate(GUESSES)
    monkeypatch.setattr("repro.identification.algorithm1.search.BATCH", batch)
    np.testing.assert_allclose(reader().estimate(GUESSES), expected, rtol=0, atol=1e-5)
