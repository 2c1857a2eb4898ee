"""Algorithm 1 with its refinement on one arm: what more starts bring, and the control without a network."""

from functools import cache

import literal
import numpy as np
import pytest

from repro.cnn.image import ImageSettings
from repro.identification.algorithm1.preprocessing import filtered, prepare
from repro.identification.algorithm1.refinement import Algorithm1, RefinementSettings
from repro.identification.algorithm1.search import SearchSettings, select
from repro.model.dynamics import inverse_dynamics, rebuild_torque
from repro.signals.sampling import SignalSettings
from repro.signals.trajectories import identification_trajectory

SIGNALS = SignalSettings(h=0.02, samples=literal.SMALL.image_size)
MOTION = identification_trajectory(SIGNALS.duration, SIGNALS.h)
TAU = inverse_dynamics(MOTION.q, MOTION.dq, MOTION.ddq, literal.ARMS["N4"])
PREPARED = prepare(filtered(MOTION.q, TAU, SIGNALS), np.ones_like(TAU), SIGNALS)


@cache
def estimates(starts, seed, uniform_seed=None, variant="published", passes=10, gain=2.0, limit=5, keep=20):
    """Every estimate; without `uniform_seed` the control without a network is left out."""
    search = SearchSettings(executions=3, inner_limit=limit, high=0.5)
    refinement = RefinementSettings(restarts=30, keep=keep, passes=passes, read_passes=1, starts=starts)
    algorithm1 = Algorithm1(variant, literal.untrained(gain=gain), ImageSettings(), search, refinement)
    uniform = None if uniform_seed is None else np.random.default_rng((uniform_seed, 2))
    found, _ = algorithm1.run(PREPARED, np.random.default_rng(seed), np.random.default_rng((seed, 1)), uniform)
    return found


def run(starts, seed):
    return {method: found.details["similarity"] for method, found in estimates(starts, seed, seed).items()}


@pytest.mark.parametrize("method", ["algorithm1+refinement", "algorithm1+local-search", "differential-evolution"])
def test_more_starts_never_end_lower_and_some_end_higher(method):
    one, four = (np.array([run(starts, seed)[method] for seed in range(5)]) for starts in (1, 4))
    assert (four >= one - 1e-12).all()
    assert (four > one).any()


def test_starts_leave_the_search_alone():
    assert run(1, 0)["algorithm1"] == run(4, 0)["algorithm1"]


def test_the_control_without_a_network_finds_the_arm_and_reads_no_image():
    control = estimates(1, 0, 7, passes=150, limit=200, keep=100)["differential-evolution"]
    assert control.details["images"] == 0
    # The filter rounds the torque's steps, so the arm itself does not reach 1.
    truth = select(literal.ARMS["N4"][None] / PREPARED.torque_scale, PREPARED, SearchSettings()).similarity
    assert control.details["similarity"] > truth - 1e-3
    torque = rebuild_torque(PREPARED.regression.y, control.beta)
    assert np.linalg.norm(torque - PREPARED.regression.tau) < 0.1 * np.linalg.norm(PREPARED.regression.tau)


def test_the_network_has_no_part_in_the_control_and_the_control_none_in_the_rest():
    one, other, without = estimates(2, 0, 7), estimates(2, 1, 7, gain=5.0), estimates(2, 0)
    control = "differential-evolution"
    np.testing.assert_array_equal(one[control].beta, other[control].beta)
    assert (one["algorithm1+local-search"].beta != other["algorithm1+local-search"].beta).any()
    assert list(one) == [*without, control]
    for method, estimate in without.items():
        np.testing.assert_array_equal(one[method].beta, estimate.beta)
        assert one[method].details == estimate.details


def test_the_control_has_guesses_and_moves_of_its_own_source():
    first, second = (estimates(1, 0, seed)["differential-evolution"].beta for seed in (7, 8))
    assert (first != second).any()


@pytest.mark.parametrize(("variant", "passes"), [("tracked", 10), ("published", 0)])
def test_the_control_belongs_to_the_refinement_of_the_published_network_alone(variant, passes):
    assert "differential-evolution" not in estimates(1, 0, 7, variant=variant, passes=passes)
