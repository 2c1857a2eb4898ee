"""Regressions that would have been as good: projections against joint least squares, and what a log asks for."""

import numpy as np
import pytest
from hypothesis import given
from log_example import BETA, motion
from regression_example import log_from, problem
from scipy import stats
from strategies import seeds

from repro.identification.alternatives import BEYOND, CHANCE, alternatives, asked_for, columns_of, smeared, without
from repro.identification.parallel import FilterSettings, prepare
from repro.identification.solve import solve
from repro.model.dynamics import regressor

SETTINGS = FilterSettings()
LOG = log_from(motion)


def each(first, second):
    """A number for each joint."""
    return np.array([[first], [second]])


@given(seeds)
def test_taking_columns_out_is_fitting_them_beside_the_nine(seed):
    rng = np.random.default_rng(seed)
    y, tau, x = rng.normal(size=(2, 80, 9)), rng.normal(size=(2, 80)), rng.normal(size=(2, 80, 3))
    beside = np.linalg.lstsq(np.concatenate([y, x], axis=-1).reshape(160, 12), tau.reshape(-1))[0][:9]
    left = without(problem(y, tau), x)
    np.testing.assert_allclose(solve(left.y, left.tau), beside, rtol=1e-6, atol=1e-9)


def test_rows_of_standstill_take_no_part_in_the_projection():
    rng = np.random.default_rng(0)
    found = problem(rng.normal(size=(2, 40, 9)), rng.normal(size=(2, 40)))
    found.moving[:, :10] = False
    left = without(found, rng.normal(size=(2, 40, 2)))
    np.testing.assert_array_equal(left.tau[:, :10], found.tau[:, :10])


@pytest.mark.parametrize(
    ("name", "spoil"),
    [
        ("zero positions", lambda log, q, dq, ddq: (log.q + each(0.03, -0.02), log.tau)),
        ("torque offsets", lambda log, q, dq, ddq: (log.q, log.tau + each(0.2, -0.1))),
        ("load-dependent friction", lambda log, q, dq, ddq: (log.q, log.tau + 0.1 * loaded(q, dq, ddq))),
        ("Stribeck friction", lambda log, q, dq, ddq: (log.q, log.tau + 0.3 * near_rest(dq))),
    ],
)
def test_a_log_with_a_fault_asks_for_its_columns_and_gives_the_truth_with_them(name, spoil):
    q, dq, ddq = motion(LOG.t)
    positions, torque = spoil(LOG, q, dq, ddq)
    log = type(LOG)("log.csv", LOG.t, positions, torque)
    found = alternatives(log, SETTINGS)[name]
    plain, (other,) = prepare(log, SETTINGS), found.regressions
    without_it, with_it = (np.abs(solve(r.y, r.tau) / BETA - 1)[:5].max() for r in (plain, other))
    assert found.weight > 0.9
    assert with_it < 0.5 * without_it


def loaded(q, dq, ddq):
    return np.abs(regressor(q, dq, ddq)[..., :5] @ BETA[:5]) * np.tanh(20.0 * dq)


def near_rest(dq):
    return np.tanh(20.0 * dq) * np.exp(-((dq / 0.5) ** 2))


def shrunk(seed, error):
    """Inertia and gravity by least squares as shares of the truth, and with the errors of the motion once more."""
    rng = np.random.default_rng(seed)
    y = prepare(LOG, SETTINGS).y
    n = y.shape[1]
    wrong, tau = np.tile(y, (1, 200, 1)), np.tile(y @ BETA, (1, 200))
    wrong[..., :5] *= 1.0 + error * rng.choice([-1.0, 1.0], size=(2, 200 * n, 5))
    found = problem(wrong, tau)
    again = smeared(found)
    return tuple(solve(r.y, r.tau)[:5] / BETA[:5] for r in (found, again))


@pytest.mark.parametrize("seed", range(3))
def test_errors_of_the_motion_once_more_shrink_an_estimate_as_they_did(seed):
    once, twice = shrunk(seed, 0.2)
    off = np.abs(once - 1.0).max()
    assert off > 0.04
    assert np.abs(2.0 * once - twice - 1.0).max() < 0.5 * off


def test_a_log_that_eq_1_explains_asks_for_next_to_nothing():
    rng = np.random.default_rng(3)
    weights = []
    for _ in range(10):
        noisy = type(LOG)("log.csv", LOG.t, LOG.q, LOG.tau + 0.05 * rng.normal(size=LOG.tau.shape))
        found = alternatives(noisy, SETTINGS)
        weights.append([found[name].weight for name in BEYOND])
    assert np.mean(weights) < 0.2


def test_the_columns_of_a_zero_position_are_the_change_of_the_torque():
    made = columns_of(BEYOND["zero positions"], LOG, SETTINGS, BETA)
    turned = type(LOG)("log.csv", LOG.t, LOG.q + each(0.0, 0.01), LOG.tau)
    change = (prepare(turned, SETTINGS).y - prepare(LOG, SETTINGS).y) @ BETA / 0.01
    np.testing.assert_allclose(made[..., 1], change, atol=0.02 * np.abs(change).max())


def test_chance_is_the_f_that_two_columns_reach_in_one_log_of_twenty():
    assert pytest.approx(stats.f.isf(0.05, 2, 10_000), rel=0.01) == CHANCE


def test_what_chance_explains_weighs_nothing():
    rng = np.random.default_rng(1)
    y, tau = rng.normal(size=(2, 400, 9)), rng.normal(size=(2, 400))
    plain = problem(y, tau)
    assert asked_for(plain, plain, 2) == 0.0
    much = rng.normal(size=(2, 400, 1))
    strong = problem(y, tau + 5.0 * much[..., 0])
    assert asked_for(strong, without(strong, much), 1) > 1.0 - CHANCE / 100
