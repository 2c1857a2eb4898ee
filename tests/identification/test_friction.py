"""Friction beyond Eq. 1: found in logs that hold it, in none that do not, and taken out only where it is asked for."""

from dataclasses import replace

import numpy as np
import pytest
from log_example import BETA, motion
from ownarm_problem import ARM, loaded
from regression_example import log_from

from repro.identification.extra_terms import FrictionTerm, find_friction, subtract_friction
from repro.identification.filtering import FilterSettings
from repro.identification.solve import solve
from repro.model.dynamics import inverse_dynamics
from repro.ownarm.prepare import Options, make_problem

SETTINGS = FilterSettings(cutoff=4.0, delay=0.004)
RIGID = np.where(np.arange(9) < 5, BETA, 0.0)


def load_friction(t):
    q, dq, ddq = motion(t + SETTINGS.delay)  # when the torque recorded at `t` acts
    return np.abs(inverse_dynamics(q, dq, ddq, RIGID)) * np.tanh(20.0 * dq)


def stribeck(t):
    dq = motion(t + SETTINGS.delay)[1]
    return np.tanh(20.0 * dq) * np.exp(-((dq / 0.5) ** 2))


def log_with(load=(0.0, 0.0), rest=(0.0, 0.0), seed=0, noise=0.02):
    log = log_from(motion, seconds=40.0, delay=SETTINGS.delay)
    more = np.array(load)[:, None] * load_friction(log.t) + np.array(rest)[:, None] * stribeck(log.t)
    return replace(log, tau=log.tau + more + noise * np.random.default_rng(seed).normal(size=log.tau.shape))


def ready_of(log, friction):
    log = loaded(log)
    return make_problem((log,), (log,), ARM, Options(("ordinary",), "unused", friction=friction))


@pytest.mark.parametrize(
    ("load", "rest", "names"),
    [
        ((0.1, 0.0), (0.0, 0.0), ["load1"]),
        ((0.1, 0.15), (0.0, 0.0), ["load1", "load2"]),
        ((0.0, 0.0), (0.0, 0.2), ["stribeck2"]),
        ((0.1, 0.0), (0.0, 0.2), ["load1", "stribeck2"]),
    ],
)
def test_what_is_there_is_found_with_its_size(load, rest, names):
    found = {term.name: term for term in find_friction(log_with(load, rest), SETTINGS, True) if term.taken}
    assert list(found) == names
    true = dict(zip(("load1", "load2", "stribeck1", "stribeck2"), (*load, *rest), strict=True))
    for name, term in found.items():
        assert term.value == pytest.approx(true[name], rel=0.2)
        assert term.gain > 0.2


@pytest.mark.parametrize("seed", range(5))
def test_nothing_is_found_where_there_is_nothing(seed):
    assert find_friction(log_with(seed=seed), SETTINGS, True) == ()


def test_taken_out_is_what_was_put_in():
    terms = [FrictionTerm("load1", 0.1, 0.0, 0.0, True), FrictionTerm("stribeck2", 0.2, 0.0, 0.0, True)]
    inside = slice(100, -100)  # the ends, where filters do not see both sides, apart
    spoilt, clean = log_with((0.1, 0.0), (0.0, 0.2), noise=0.0), log_with(noise=0.0)
    left = subtract_friction(spoilt, SETTINGS, BETA, terms).tau - clean.tau
    put_in = 0.1 * load_friction(log_with().t)[0], 0.2 * stribeck(log_with().t)[1]
    for joint in (0, 1):
        assert np.std(left[joint, inside]) < 0.1 * np.std(put_in[joint][inside])


def test_only_where_it_is_asked_for_is_it_taken_and_then_friction_of_eq_1_comes_out_right():
    log = log_with((0.15, 0.0))
    without, asked = (ready_of(log, friction) for friction in (False, True))
    assert [(term.name, term.taken) for term in without.logs[0].terms] == [("load1", False)]
    assert [(term.name, term.taken) for term in asked.logs[0].terms] == [("load1", True)]
    assert np.array_equal(without.logs[0].loaded.log.tau, log.tau)
    k1 = [solve(problem.moving.y, problem.moving.tau)[7] for problem in (without, asked)]
    assert abs(k1[0] - BETA[7]) > 0.05
    assert k1[1] == pytest.approx(BETA[7], rel=0.15)
    # The validation log, here the same, is corrected the same way.
    ((loaded, _),) = asked.validation
    assert loaded.log.tau == pytest.approx(asked.logs[0].loaded.log.tau)
