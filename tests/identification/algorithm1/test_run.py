"""Algorithm 1 with its refinement on one arm: what more starts of the refinement bring."""

from functools import cache

import literal
import numpy as np
import pytest

from repro.cnn.dataset import SignalSettings
from repro.cnn.image import ImageSettings
from repro.identification.algorithm1.listing import filtered, prepare
from repro.identification.algorithm1.refinement import RefinementSettings
from repro.identification.algorithm1.run import Algorithm1
from repro.identification.algorithm1.search import SearchSettings
from repro.model.dynamics import inverse_dynamics
from repro.signals.trajectories import identification_trajectory

SIGNALS = SignalSettings(h=0.02, samples=literal.SMALL.image_size)
MOTION = identification_trajectory(SIGNALS.duration, SIGNALS.h)
TAU = inverse_dynamics(MOTION.q, MOTION.dq, MOTION.ddq, literal.ARMS["N4"])
PREPARED = prepare(filtered(MOTION.q, TAU, SIGNALS), np.ones_like(TAU), SIGNALS)


@cache
def run(starts, seed):
    network = literal.untrained(gain=2.0)
    search = SearchSettings(executions=3, inner_limit=5, high=0.5)
    refinement = RefinementSettings(restarts=30, keep=20, passes=10, read_passes=1, starts=starts)
    algorithm1 = Algorithm1("published", network, ImageSettings(), search, refinement)
    found, _ = algorithm1.run(PREPARED, np.random.default_rng(seed), np.random.default_rng((seed, 1)))
    return {method: estimate.details["similarity"] for method, estimate in found.items()}


@pytest.mark.parametrize("method", ["algorithm1+refinement", "algorithm1+local-search"])
def test_more_starts_never_end_lower_and_some_end_higher(method):
    one, four = (np.array([run(starts, seed)[method] for seed in range(5)]) for starts in (1, 4))
    assert (four >= one - 1e-12).all()
    assert (four > one).any()


def test_starts_leave_the_search_alone():
    assert run(1, 0)["algorithm1"] == run(4, 0)["algorithm1"]
