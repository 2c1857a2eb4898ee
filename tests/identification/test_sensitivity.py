"""Regressions that would have been as good: projections against joint least squares, and what a log asks for."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from log_example import BETA, motion
from regression_example import log_from, regression_of
from scipy import stats
from strategies import seeds

from repro.identification.filtering import FilterSettings, prepare
from repro.identification.solve import solve
from repro.identification.uncertainty import (
    UNMODELLED_EFFECTS,
    filtered_columns,
    perturbations,
    project_out,
    shrinkage,
    simex,
    unmodelled_effects,
)
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
    left = project_out(regression_of(y, tau), x)
    np.testing.assert_allclose(solve(left.y, left.tau), beside, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize(
    ("name", "spoil"),
    [
        ("zero positions", lambda log, q, dq, ddq: (log.q + each(0.03, -0.02), log.tau)),
        ("torque offsets", lambda log, q, dq, ddq: (log.q, log.tau + each(0.2, -0.1))),
        ("load-dependent friction", lambda log, q, dq, ddq: (log.q, log.tau + 0.1 * loaded(q, dq, ddq))),
        ("Stribeck friction", lambda log, q, dq, ddq: (log.q, log.tau + 0.3 * near_rest(dq, 0.5))),
        ("Stribeck friction", lambda log, q, dq, ddq: (log.q, log.tau + 0.3 * near_rest(dq, 0.1))),
        ("torque of period one turn", lambda log, q, dq, ddq: (log.q, log.tau + wave(q))),
        ("torque of period half a turn", lambda log, q, dq, ddq: (log.q, log.tau + wave(2.0 * q))),
    ],
)
def test_a_log_with_a_fault_asks_for_its_columns_and_gives_the_truth_with_them(name, spoil):
    q, dq, ddq = motion(LOG.t)
    positions, torque = spoil(LOG, q, dq, ddq)
    log = replace(LOG, q=positions, tau=torque)
    found = perturbations(log, SETTINGS)[name]
    plain, (other,) = prepare(log, SETTINGS), found.regressions
    without_it, with_it = (np.abs(solve(r.y, r.tau) / BETA - 1)[:5].max() for r in (plain, other))
    assert found.weight > 0.9
    assert with_it < 0.5 * without_it


def loaded(q, dq, ddq):
    return np.abs(regressor(q, dq, ddq)[..., :5] @ BETA[:5]) * np.tanh(20.0 * dq)


def near_rest(dq, speed):
    return np.tanh(20.0 * dq) * np.exp(-np.abs(dq) / speed)


def wave(angle):
    return each(0.3, -0.2) * np.cos(angle + each(0.0, 0.5))


def shrunk(seed, error):
    """Inertia and gravity by least squares as shares of the truth, and with the errors of the motion once more."""
    rng = np.random.default_rng(seed)
    y = prepare(LOG, SETTINGS).y
    n = y.shape[1]
    wrong, tau = np.tile(y, (1, 200, 1)), np.tile(y @ BETA, (1, 200))
    wrong[..., :5] *= 1.0 + error * rng.choice([-1.0, 1.0], size=(2, 200 * n, 5))
    found = regression_of(wrong, tau)
    again = simex(found)
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
        noisy = replace(LOG, tau=LOG.tau + 0.05 * rng.normal(size=LOG.tau.shape))
        found = perturbations(noisy, SETTINGS)
        weights.append([found[name].weight for name in UNMODELLED_EFFECTS])
    assert np.mean(weights) < 0.2


def half_turn(log):
    return replace(log, tau=log.tau + each(0.2, -0.1) * np.cos(2.0 * log.q + each(0.3, 1.0)))


@pytest.mark.parametrize(("zero", "change", "explains"), [(0.05, half_turn, True), (0.0, lambda log: log, False)])
def test_an_effect_that_explains_a_log_without_its_correction_has_weight(zero, change, explains):
    # The log is corrected by 0.05 rad: wrongly if its zero is right and it has another effect.
    noise = 0.02 * np.random.default_rng(4).normal(size=LOG.tau.shape)
    recorded = change(replace(LOG, q=LOG.q + each(zero - 0.05, 0.0), tau=LOG.tau + noise))
    corrected = replace(recorded, q=recorded.q + each(0.05, 0.0))
    found = unmodelled_effects(recorded, SETTINGS, prepare(corrected, SETTINGS))["torque of period half a turn"]
    assert found.rival
    assert bool(found.weight > 0.9) is explains
    if explains:
        (r,) = found.regressions
        assert solve(r.y, r.tau)[:5] == pytest.approx(BETA[:5], rel=0.03)
    else:
        assert found.weight < 0.05


def test_the_columns_of_a_zero_position_are_the_change_of_the_torque():
    [columns] = filtered_columns(UNMODELLED_EFFECTS["zero positions"], LOG, SETTINGS, BETA)
    turned = replace(LOG, q=LOG.q + each(0.0, 0.01))
    change = (prepare(turned, SETTINGS).y - prepare(LOG, SETTINGS).y) @ BETA / 0.01
    np.testing.assert_allclose(columns[..., 1], change, atol=0.02 * np.abs(change).max())


def test_the_weight_is_one_minus_the_critical_value_over_f():
    rng = np.random.default_rng(1)
    y, x = rng.normal(size=(2, 400, 9)), rng.normal(size=(2, 400, 1))
    plain = regression_of(y, rng.normal(size=(2, 400)) + 0.3 * x[..., 0])
    assert shrinkage(plain, plain, 2) == 0.0
    rows = np.concatenate([y, x], axis=-1).reshape(800, 10)
    before, after = (np.linalg.lstsq(rows[:, :k], plain.tau.reshape(-1))[1][0] for k in (9, 10))
    f = (before / after - 1.0) * 790
    expected = 1.0 - stats.f.isf(0.05, 1, 790) / f
    # Samples are independent but for a correlation time that chance makes a little longer than a sample.
    assert 0.0 < shrinkage(plain, project_out(plain, x), 1) == pytest.approx(expected, abs=0.03)
