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
from repro.signals.metric import TorqueScorer
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


NO_SPREAD = {"spread_low": 1e-12, "spread_high": 2e-12}


def refined(reader, beta_m, restarts=7, passes=3, search=SEARCH, seed=0, keep=100, **spread):
    settings = RefinementSettings(restarts, keep, passes, **(spread or NO_SPREAD))
    return refine(reader, beta_m, PREPARED, search, settings, np.random.default_rng(seed))


def similarity(beta):
    return TorqueScorer(PREPARED.tau / PREPARED.largest, PREPARED.y)(beta).total.mean(-1)


@pytest.mark.parametrize("passes", [1, 2, 3])
def test_contracting_network_converges_to_the_truth(passes):
    beta_m = TRUTH * np.random.default_rng(0).uniform(0.6, 1.5, (5, 9))
    found = refined(Reader(0.5), beta_m, restarts=0, passes=passes)
    error = np.abs(found - TRUTH).max(1)
    assert error.min() < 1e-9 + np.abs(beta_m - TRUTH).max() / 2**passes


def test_perfect_network_is_right_in_one_pass():
    found = refined(Reader(1.0), start(), passes=1)
    np.testing.assert_allclose(found[5:], np.broadcast_to(TRUTH, (7 + 12, 9)), rtol=1e-12)


def test_candidates_of_every_pass_are_kept():
    beta_m = start()
    reader = Reader(0.5)
    found = refined(reader, beta_m, keep=6)
    assert found.shape == (5 + 7 + 3 * 6, 9)
    np.testing.assert_array_equal(found[:5], beta_m)
    for k, guess in enumerate([*reader.guesses]):
        size = 7 if k == 0 else 6
        at = 5 if k == 0 else 12 + 6 * (k - 1)
        assert guess.shape == (size, 9)
        np.testing.assert_allclose(found[at : at + size], guess + 0.5 * (TRUTH - guess), rtol=1e-12)
    assert reader.images == 7 + 3 * 6


def test_the_most_similar_estimates_are_fed_back():
    reader = Reader(0.5)
    found = refined(reader, start(), keep=4, passes=2)
    for k, known in ((1, found[:12]), (2, found[:16])):
        best = known[np.argsort(-similarity(known), kind="stable")[:4]]
        np.testing.assert_allclose(reader.guesses[k], best, atol=1e-10)


def test_guesses_are_spread_by_the_size_asked_for():
    reader = Reader(0.0)
    beta_m = np.tile(TRUTH, (4000, 1)) + 1.0  # far from the floor of the range
    refined(reader, beta_m, restarts=0, passes=1, keep=4000, spread_low=0.01, spread_high=0.04)
    spread = (reader.guesses[1] - beta_m).std(1, ddof=1)
    assert 0.001 < spread.min() < spread.max() < 0.1
    # Log-uniform from 0.01 to 0.04: the median is 0.02.
    assert np.median(np.abs(reader.guesses[1] - beta_m)) == pytest.approx(0.02 * 0.6745, rel=0.1)


def test_drift_after_a_good_pass_costs_nothing():
    """A network that is right once and wrong afterwards: the good pass must still be among the candidates."""
    answers = iter([np.tile(TRUTH, (5, 1)), start(10, 1), start(15, 2)])
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
def test_infeasible_estimates_are_not_kept(feasibility):
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
    refined(reader, start(), search=replace(SEARCH, low=0.01), spread_low=0.2, spread_high=2.0)
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
    np.testing.assert_allclose(found, np.tile(TRUTH, (3 + 3 + 6, 1)), rtol=1e-12)
    assert refined(Reader(), np.empty((0, 9)), restarts=0).shape == (0, 9)


def test_real_network_is_read_through_and_the_generator_alone_decides():
    network = literal.untrained(gain=2.0)
    first, again, other = (
        refined(ResidualReader(network, ImageSettings(), PREPARED), start(), seed=seed) for seed in (0, 0, 1)
    )
    np.testing.assert_array_equal(first, again)
    assert first.shape != other.shape or not np.array_equal(first, other)
    assert (first > 0).all()


@pytest.mark.parametrize(
    "wrong",
    [{"restarts": -1}, {"keep": 0}, {"passes": 0}, {"spread_low": 0.0}, {"spread_low": 0.1, "spread_high": 0.1}],
)
def test_wrong_budgets_are_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        RefinementSettings(**wrong)
