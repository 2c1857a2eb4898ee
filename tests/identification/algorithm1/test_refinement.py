"""Refinement: estimates fed back as guesses (ours, not the paper's), its runs and its controls."""

from dataclasses import replace
from functools import cache

import literal
import numpy as np
import pytest

from repro.cnn.image import ImageSettings
from repro.identification.algorithm1.preprocessing import filtered, prepare
from repro.identification.algorithm1.refinement import Algorithm1, RefinementSettings, uniform_guesses
from repro.identification.algorithm1.search import SearchSettings, select
from repro.model.dynamics import inverse_dynamics
from repro.model.parameters import FEASIBILITY
from repro.signals.dct import SignalSettings
from repro.signals.metric import TorqueScorer
from repro.signals.trajectories import identification_trajectory

SIGNALS = SignalSettings(sampling_period_s=0.02, image_samples=literal.SMALL.image_size)
MOTION = identification_trajectory(SIGNALS.duration_s, SIGNALS.sampling_period_s)
TAU = inverse_dynamics(MOTION.q, MOTION.dq, MOTION.ddq, literal.ARMS["N4"])
PREPARED = prepare(filtered(MOTION.q, TAU, SIGNALS), np.ones_like(TAU), SIGNALS)
TRUTH = literal.ARMS["N4"] / PREPARED.torque_scale
SEARCH = SearchSettings()


def towards_truth(share=0.5):
    """Estimator that moves each guess towards the truth by a share of the way."""
    return literal.Estimator(lambda guess: guess + share * (TRUTH - guess))


def refined(estimator, beta_m, restarts=7, passes=3, search=SEARCH, seed=0, keep=100, feed_back=True, **moves):
    settings, rng = RefinementSettings(restarts, keep, passes, **moves), np.random.default_rng(seed)
    algorithm1 = Algorithm1("published", None, ImageSettings(), search, settings)
    candidates = algorithm1.restart(estimator, beta_m, rng)
    return algorithm1.refine(estimator if feed_back else None, candidates, PREPARED, rng)


def similarity(beta):
    return TorqueScorer(PREPARED.regression.tau / PREPARED.torque_scale, PREPARED.regression.y)(beta).total.mean(-1)


def near(n, seed=0, size=0.3):
    """Candidates about the truth."""
    return TRUTH * np.random.default_rng(seed).uniform(1 - size, 1 + size, (n, 9))


def literal_pass(best, estimator, rng, keep, reach, jitter, low, feed_back):
    """One pass, candidate by candidate; the truth's check is that all nine are positive."""
    n = len(best)
    a, b = rng.integers(n, size=(2, n))
    length = rng.uniform(0.0, reach, (n, 1))
    noise = rng.standard_normal((n, 9))
    guesses = [[max(best[i][k] + length[i, 0] * (best[a[i]][k] - best[b[i]][k]) + jitter * noise[i][k], low)
                for k in range(9)] for i in range(n)]  # fmt: skip
    pool = [*best, *np.array(guesses)]
    if feed_back:
        pool += [*estimator.estimate(np.array(guesses))]
    pool = [beta for beta in pool if min(beta) > 0]
    return sorted(pool, key=lambda beta: -similarity(beta[None])[0])[:keep]


@pytest.mark.parametrize("feed_back", [True, False])
@pytest.mark.parametrize(("keep", "read"), [(4, 4), (30, 4), (4, 2)])
def test_passes_are_those_of_the_literal_listing(keep, read, feed_back):
    estimator, rng = towards_truth(0.1), np.random.default_rng(5)
    fresh = estimator.estimate(rng.uniform(SEARCH.guess_low, SEARCH.guess_high, (7, 9)))
    best = sorted([*near(6), *fresh], key=lambda beta: -similarity(beta[None])[0])[:keep]
    for k in range(4):
        best = literal_pass(best, estimator, rng, keep, 0.6, 1e-3, SEARCH.guess_low, feed_back and k < read)
    moves = {"reach": 0.6, "jitter": 1e-3, "read_passes": read}
    found = refined(towards_truth(0.1), near(6), passes=4, keep=keep, seed=5, feed_back=feed_back, **moves)
    np.testing.assert_allclose(found, best, rtol=1e-9)


def test_selection_alone_finds_a_badly_conditioned_arm():
    """Some parameters hardly change the torque: moves of one size for all nine do not get there."""
    arm = np.array([0.12, 0.0026375, 0.0227235, 0.95, 0.07838, 0.08, 0.00361, 0.4538, 0.31])
    tau = inverse_dynamics(MOTION.q, MOTION.dq, MOTION.ddq, arm)
    prepared = prepare(filtered(MOTION.q, tau, SIGNALS), np.ones_like(tau), SIGNALS)
    algorithm1 = Algorithm1("published", None, ImageSettings(), SEARCH, RefinementSettings(restarts=0))
    before, after = [], []
    for seed in range(5):
        rng = np.random.default_rng(seed)
        beta_m = rng.uniform(1e-3, 1.0, (500, 9))
        found = algorithm1.refine(None, beta_m, prepared, rng)
        before.append(select(beta_m, prepared, SEARCH).similarity)
        after.append(select(found, prepared, SEARCH).similarity)
    assert max(before) < 0.9
    # The filter rounds the torque's steps, so the arm itself does not reach 1.
    assert np.median(after) > select(arm[None] / prepared.torque_scale, prepared, SEARCH).similarity - 1e-3


def test_uniform_guesses_fill_the_range_of_line_17_as_often_as_algorithm_1_guesses_at_most():
    search = replace(SEARCH, executions=40, inner_limit=50, low=0.2, high=1.7)
    found = uniform_guesses(search, np.random.default_rng(3))
    assert found.shape == (2000, 9)
    assert 0.2 < found.min() < found.max() < 1.7
    np.testing.assert_allclose(np.quantile(found, [0.1, 0.9], axis=0).T, [[0.35, 1.55]] * 9, atol=0.06)


@pytest.mark.parametrize("feasibility", ["positive", "positive-definite"])
@pytest.mark.parametrize("feed_back", [True, False])
def test_infeasible_candidates_are_not_kept(feasibility, feed_back):
    possible = FEASIBILITY[feasibility]
    beta_m = near(40, size=0.9)
    beta_m = beta_m[possible(beta_m)]
    estimator = literal.Estimator(lambda guess: guess - [0.0, 0.3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    search = replace(SEARCH, feasibility=feasibility)
    moves = {"restarts": 0, "passes": 4, "keep": 10_000, "jitter": 0.05}
    found = refined(estimator, beta_m, search=search, feed_back=feed_back, **moves)
    assert possible(found).all()
    # There is room for all, so only the impossible are missing; a guess is never below `low`.
    every = len(beta_m) * (3 if feed_back else 2) ** 4
    assert len(beta_m) < len(found) <= every
    assert (len(found) == every) == (feasibility == "positive" and not feed_back)


def test_where_every_estimate_is_impossible_the_refinement_starts_from_the_nearest_possible_ones():
    """A network that reads one parameter of a small arm a little below zero, whatever the guess."""
    low = TRUTH.copy()
    low[1] = -0.01
    estimator = literal.Estimator(lambda guess: np.tile(low, (len(guess), 1)) + 0.01 * guess * (low > 0))
    best = refined(estimator, np.empty((0, 9)), passes=60)
    assert (best > 0).all()
    assert similarity(best).max() > 0.8


def test_no_candidates_remain_none():
    assert refined(towards_truth(), np.empty((0, 9)), restarts=0).shape == (0, 9)


# Algorithm 1 with its refinement.


@cache
def estimates(starts, seed, uniform_seed=None, variant="published", passes=10, gain=2.0):
    """Every estimate; without `uniform_seed` the control without a network is left out."""
    search = SearchSettings(executions=3, inner_limit=5, guess_high=0.5)
    refinement = RefinementSettings(restarts=30, keep=20, passes=passes, read_passes=1)
    algorithm1 = Algorithm1(variant, literal.untrained(gain=gain), ImageSettings(), search, refinement, starts)
    uniform = None if uniform_seed is None else np.random.default_rng((uniform_seed, 2))
    found, _ = algorithm1.run(PREPARED, np.random.default_rng(seed), np.random.default_rng((seed, 1)), uniform)
    return found


@pytest.mark.parametrize("method", ["algorithm1+refinement", "algorithm1+local-search", "differential-evolution"])
def test_more_starts_never_end_lower_and_some_end_higher(method):
    found = [[estimates(starts, seed, seed)[method] for seed in range(5)] for starts in (1, 4)]
    one, four = np.array([[estimate.details["similarity"] for estimate in row] for row in found])
    assert (four >= one - 1e-12).all()
    assert (four > one).any()


def test_the_network_has_no_part_in_the_control_and_the_control_none_in_the_rest():
    one, other, without = estimates(2, 0, 7), estimates(2, 1, 7, gain=5.0), estimates(2, 0)
    control = "differential-evolution"
    np.testing.assert_array_equal(one[control].beta, other[control].beta)
    assert one[control].details["images"] == 0
    assert (one["algorithm1+local-search"].beta != other["algorithm1+local-search"].beta).any()
    assert list(one) == [*without, control]
    for method, estimate in without.items():
        np.testing.assert_array_equal(one[method].beta, estimate.beta)
        assert one[method].details == estimate.details


@pytest.mark.parametrize(("variant", "passes"), [("tracked", 10), ("published", 0)])
def test_the_control_belongs_to_the_refinement_of_the_published_network_alone(variant, passes):
    assert "differential-evolution" not in estimates(1, 0, 7, variant=variant, passes=passes)
