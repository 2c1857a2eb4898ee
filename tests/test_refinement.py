"""Refinement: estimates fed back as guesses (ours, not the paper's)."""

from dataclasses import replace

import literal
import numpy as np
import pytest
from conftest import seeds
from hypothesis import given, settings

from repro.cnn.dataset import SignalSettings
from repro.cnn.image import ImageSettings
from repro.identify.algorithm1 import SearchSettings, select
from repro.identify.prepare import prepare
from repro.identify.refinement import RefinementSettings, refine
from repro.identify.residual import ResidualReader
from repro.model.dynamics import inverse_dynamics
from repro.signals.trajectories import identification_trajectory

SIGNALS = SignalSettings(h=0.02, samples=literal.SMALL.image_size)
MOTION = identification_trajectory(SIGNALS.duration, SIGNALS.h)
TAU = inverse_dynamics(MOTION.q, MOTION.dq, MOTION.ddq, literal.ARMS["N4"])
PREPARED = prepare(MOTION.q, TAU, np.ones_like(TAU), SIGNALS)
TRUTH = literal.ARMS["N4"] / PREPARED.largest
SEARCH = SearchSettings()


class Reader:
    """Reader that moves each guess towards the truth by a share of the way."""

    def __init__(self, share=0.5, move=None):
        self.images = 0
        self.guesses = []
        self._move = move or (lambda guess: guess + share * (TRUTH - guess))

    def estimate(self, guess):
        self.images += len(guess)
        self.guesses.append(guess)
        return self._move(guess)


def start(n=5, seed=0):
    return np.random.default_rng(seed).uniform(0.05, 2.0, (n, 9))


def refined(reader, beta_m, restarts=7, passes=3, search=SEARCH, seed=0):
    return refine(reader, beta_m, search, RefinementSettings(restarts, passes), np.random.default_rng(seed))


@pytest.mark.parametrize("passes", [1, 4, 30])
def test_contracting_network_converges_to_the_truth(passes):
    beta_m = start()
    found = refined(Reader(0.5), beta_m, restarts=0, passes=passes)
    np.testing.assert_allclose(found[-5:] - TRUTH, (beta_m - TRUTH) / 2**passes, rtol=0, atol=1e-12)


def test_perfect_network_is_right_in_one_pass():
    found = refined(Reader(1.0), start(), passes=1)
    np.testing.assert_allclose(found[5:], np.broadcast_to(TRUTH, (7 + 12, 9)), rtol=1e-12)


def test_candidates_of_every_pass_are_kept():
    beta_m = start()
    reader = Reader(0.5)
    found = refined(reader, beta_m)
    assert found.shape == (5 + 7 + 3 * 12, 9)
    np.testing.assert_array_equal(found[:5], beta_m)
    fresh = reader.guesses[0]
    assert fresh.shape == (7, 9)
    guess = np.concatenate([beta_m, TRUTH + 0.5 * (fresh - TRUTH)])
    np.testing.assert_allclose(found[5:12], guess[5:], rtol=1e-12)
    for k in range(3):
        np.testing.assert_allclose(reader.guesses[k + 1], guess, rtol=1e-12)
        guess = TRUTH + 0.5 * (guess - TRUTH)
        np.testing.assert_allclose(found[12 + 12 * k : 24 + 12 * k], guess, rtol=1e-12)
    assert reader.images == 7 + 3 * 12


def test_drift_after_a_good_pass_costs_nothing():
    """A network that is right once and wrong afterwards: the good pass must still be among the candidates."""
    answers = iter([np.tile(TRUTH, (5, 1)), start(5, 1), start(5, 2)])
    reader = Reader(move=lambda guess: next(answers) if len(guess) else guess)
    found = refined(reader, start(), restarts=0)
    assert (np.abs(found - TRUTH).max(1) < 1e-12).sum() == 5
    assert select(found, PREPARED, SEARCH).similarity >= select(TRUTH[None], PREPARED, SEARCH).similarity - 1e-12


@settings(max_examples=25)
@given(seeds)
def test_similarity_never_falls(seed):
    rng = np.random.default_rng(seed)
    beta_m = TRUTH * rng.uniform(0.6, 1.5, (4, 9))
    wander = Reader(move=lambda guess: guess + rng.normal(scale=0.1, size=guess.shape))
    before = select(beta_m, PREPARED, SEARCH).similarity
    assert select(refined(wander, beta_m), PREPARED, SEARCH).similarity >= before - 1e-12


def test_similarity_rises_with_a_network_that_helps():
    beta_m = TRUTH * np.random.default_rng(0).uniform(0.6, 1.5, (4, 9))
    before = select(beta_m, PREPARED, SEARCH).similarity
    assert select(refined(Reader(0.5), beta_m), PREPARED, SEARCH).similarity > before + 0.05


@pytest.mark.parametrize("feasibility", ["positive", "positive-definite"])
def test_infeasible_estimates_are_not_kept_but_go_on(feasibility):
    """An estimate outside is no candidate, yet the next pass may bring it back."""
    bad = TRUTH.copy()
    if feasibility == "positive":
        bad[1] = -0.1
    else:
        bad[0] = 0.5 * bad[2]  # all positive, but I1 must exceed I3
    answers = iter([np.tile(bad, (2, 1)), np.tile(TRUTH, (2, 1))])
    reader = Reader(move=lambda guess: next(answers) if len(guess) else guess)
    found = refined(reader, start(2), restarts=0, passes=2, search=replace(SEARCH, feasibility=feasibility))
    assert found.shape == (4, 9)
    np.testing.assert_array_equal(found[2:], np.tile(TRUTH, (2, 1)))


def test_fresh_estimates_that_are_infeasible_are_not_kept():
    found = refined(Reader(move=lambda guess: -np.ones_like(guess)), start(), passes=1)
    np.testing.assert_array_equal(found, start())


def test_guesses_fed_back_stay_in_the_range_seen_in_training():
    reader = Reader(move=lambda guess: guess - 0.4)
    refined(reader, start(), search=replace(SEARCH, low=0.01))
    for guess in reader.guesses:
        assert guess.min() >= 0.01
    assert reader.guesses[-1].min() == 0.01


def test_fresh_guesses_fill_the_range_of_line_17():
    reader = Reader()
    refined(reader, start(), restarts=500, search=replace(SEARCH, low=0.2, high=0.7))
    fresh = reader.guesses[0]
    assert fresh.shape == (500, 9)
    assert 0.2 <= fresh.min() < 0.21
    assert 0.69 < fresh.max() <= 0.7


def test_no_candidates_to_start_from():
    found = refined(Reader(1.0), np.empty((0, 9)), restarts=3, passes=2)
    np.testing.assert_allclose(found, np.tile(TRUTH, (9, 1)), rtol=1e-12)
    assert refined(Reader(), np.empty((0, 9)), restarts=0).shape == (0, 9)


def test_real_network_is_read_through_and_the_generator_alone_decides():
    network = literal.untrained(gain=2.0)
    first, again, other = (
        refined(ResidualReader(network, ImageSettings(), PREPARED), start(), seed=seed) for seed in (0, 0, 1)
    )
    np.testing.assert_array_equal(first, again)
    assert first.shape != other.shape or not np.array_equal(first, other)
    assert (first > 0).all()


@pytest.mark.parametrize("wrong", [{"restarts": -1}, {"passes": 0}])
def test_wrong_budgets_are_refused(wrong):
    with pytest.raises(ValueError, match="restarts, passes"):
        RefinementSettings(**wrong)
