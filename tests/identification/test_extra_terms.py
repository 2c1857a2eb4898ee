"""Friction and rotor beyond Eq. 1 in logs of a known arm: each is found with its size, and none where there is none."""

from dataclasses import replace

import numpy as np
import pytest
from fitting_problem import loaded, problem_of_logs
from log_example import BETA, motion
from regression_example import beta_of, log_from, with_noise

from repro.identification.extra_terms import ExtraTerm, subtract_terms
from repro.identification.filtering import MIN_ERROR_REDUCTION, FilterSettings
from repro.identification.log import Log
from repro.identification.regression import solve
from repro.identification.term_selection import best_subset, cross_validation_error, find_terms
from repro.model.dynamics import inverse_dynamics

pytestmark = pytest.mark.slow

DELAYED = FilterSettings(cutoff=4.0, delay=0.004)
RIGID = np.where(np.arange(9) < 5, BETA, 0.0)


def load_friction(t):
    q, dq, ddq = motion(t + DELAYED.delay)  # when the torque recorded at `t` acts
    return np.abs(inverse_dynamics(q, dq, ddq, RIGID)) * np.tanh(20.0 * dq)


def stribeck(t, speed=0.5):
    dq = motion(t + DELAYED.delay)[1]
    return np.tanh(20.0 * dq) * np.exp(-((dq / speed) ** 2))


def log_with(load1=0.0, load2=0.0, stribeck2=0.0, rotor2=0.0, seed=0, noise=0.02, seconds=20.0):
    log = log_from(motion, seconds=seconds, delay=DELAYED.delay)
    more = np.array([[load1], [load2]]) * load_friction(log.t)
    more[1] += stribeck2 * stribeck(log.t)[1] + rotor2 * motion(log.t + DELAYED.delay)[2][1]
    return with_noise(replace(log, tau=log.tau + more), noise, seed)


def ready_of(log, friction):
    nearly = loaded(replace(log, tau=log.tau * (1.0 + 1e-9)))
    return problem_of_logs(loaded(log), validation=(nearly,), friction=friction)


@pytest.mark.parametrize(
    "sizes", [{"load1": 0.1}, {"load1": 0.1, "load2": 0.15}, {"stribeck2": 0.2}, {"load1": 0.1, "stribeck2": 0.2}]
)
def test_what_is_there_is_found_with_its_size(sizes):
    found = [term for term in find_terms([(log_with(**sizes), DELAYED)], True)[0] if term.taken]
    assert [term.name for term in found] == [*sizes]
    assert [term.value for term in found] == pytest.approx([*sizes.values()], rel=0.2)
    assert all(term.gain > 0.2 for term in found)


@pytest.mark.parametrize("more", [*({"seed": k} for k in range(5)), {"load1": -0.1}, {"rotor2": -0.1 * BETA[2]}])
def test_no_term_is_found_where_there_is_none_or_one_that_would_drive_the_arm(more):
    assert find_terms([(log_with(**more), DELAYED)], True)[0] == ()


def test_the_rotor_of_joint_2_is_subtracted_unasked_and_the_delay_does_not_absorb_it():
    problem = ready_of(log_with(rotor2=0.4 * BETA[2]), friction=False)
    (term,) = problem.first.taken
    assert (term.name, term.value) == ("rotor2", pytest.approx(0.4 * BETA[2], rel=0.05))
    assert problem.first.settings.delay == pytest.approx(DELAYED.delay, abs=3e-4)
    assert beta_of("ordinary", problem.without_standstill)[:5] == pytest.approx(BETA[:5], rel=0.01)


@pytest.mark.parametrize("joint", [0, 1])
def test_a_term_is_judged_by_the_errors_of_its_own_joint(joint):
    """The other joint's errors are fifty times as large as what the tenth column explains of this one's."""
    rng = np.random.default_rng(3 + joint)
    a = rng.normal(size=(2, 600, 10))
    a[1 - joint, :, 9] = 0.0
    b = a[..., :9] @ BETA + rng.normal(size=(2, 600)) * np.where(np.arange(2) == joint, 0.02, 5.0)[:, None]
    b[joint] += 0.1 * a[joint, :, 9]
    assert best_subset(a, b, {0: 0.05}, by_joint=True) == [0]
    assert best_subset(a, b, {0: 0.05}) == []


@pytest.mark.parametrize("seed", [4, 9])
def test_elastic_gears_are_not_taken_for_a_rotor(seed):
    rng, t, beta = np.random.default_rng(seed), np.arange(6000) / 300.0, [0.215, 0.114, 0.028, 5.76, 1.52]
    size = rng.normal(0.0, 0.35, (2, 12)) / np.sqrt(np.arange(1, 13))
    w, phase = 0.2 * np.pi * np.arange(1, 13), rng.uniform(0.0, 2.0 * np.pi, (2, 12))
    turned = np.exp(1j * (w * t[:, None, None] + phase))
    q, dq, ddq = (np.einsum("njk,jk->jn", turned, size * (1j * w) ** order).imag for order in range(3))
    load = inverse_dynamics(q, dq, ddq, np.array([*beta, 0, 0, 0, 0]))
    tau = inverse_dynamics(q, dq, ddq, np.array([*beta, 0.38, 0.079, 0.41, 0.077]))
    elastic = q + np.radians(0.6) * load / np.abs(load).max(axis=1, keepdims=True)  # behind the encoder
    noise = 0.02 * np.sqrt(np.mean(tau**2, axis=1, keepdims=True)) * rng.normal(size=tau.shape)
    for rotor, found in ((0.0, []), (0.1 * beta[2], ["rotor2"])):
        log = Log(name="elastic", t=t, q=elastic, tau=tau + noise + np.array([[0.0], [rotor]]) * ddq)
        terms = find_terms([(log, FilterSettings(cutoff=5.0))], False)[0]
        assert [term.name for term in terms if term.taken] == found


def test_logs_of_one_arm_have_one_rotor():
    logs = [log_with(rotor2=0.1 * BETA[2], seed=seed, noise=0.1, seconds=15.0 + seed) for seed in (1, 2, 3)]
    (term,) = (term for term in find_terms([(log, DELAYED) for log in logs], False)[0] if term.taken)
    assert term.value == pytest.approx(0.1 * BETA[2], rel=0.2)
    alone = [term.error for log in logs for term in find_terms([(log, DELAYED)], False)[0]]
    assert all(term.error < error for error in alone)


def test_taken_out_is_what_was_put_in():
    terms = [ExtraTerm("load1", 0.1, 0.0, 0.0, True), ExtraTerm("stribeck2", 0.2, 0.0, 0.0, True)]
    spoilt, clean = log_with(load1=0.1, stribeck2=0.2, noise=0.0), log_with(noise=0.0)
    left = subtract_terms(spoilt, DELAYED, BETA, terms).tau - clean.tau
    size = [np.std(x[:, 100:-100], axis=1) for x in (left, spoilt.tau - clean.tau)]  # where filters see both sides
    assert (size[0] < 0.1 * size[1]).all()


@pytest.mark.parametrize("speed", [0.15, 0.38])
def test_stribeck_friction_fades_at_the_speed_of_the_log_and_leaves_the_friction_of_eq_1_right(speed):
    log = log_with()
    log = replace(log, tau=log.tau + np.array([[0.0], [0.25]]) * stribeck(log.t, speed))
    problem = ready_of(log, friction=True)
    assert [term.name for term in problem.first.taken] == ["stribeck2"]
    assert problem.first.settings.stribeck_speed == pytest.approx(speed, rel=0.2)  # half a step of the grid
    assert problem.first.taken[0].value == pytest.approx(0.25, rel=0.1)
    r = problem.without_standstill
    assert solve(r.y, r.tau)[[6, 8]] == pytest.approx(BETA[[6, 8]], rel=0.06)
    shifts = [solve(p.y, p.tau)[8] - BETA[8] for p in problem.perturbations["speed of Stribeck friction"].regressions]
    assert shifts[0] * shifts[1] < 0.0  # a faster one and a slower one


def test_a_term_is_subtracted_from_each_piece_by_itself():
    log, terms = log_with(), [ExtraTerm("rotor2", 0.01, 0.0, 0.0, True)]
    n = log.t.size // 2
    split = replace(log, t=log.t + 2.0 * (np.arange(log.t.size) >= n), breaks=(n,))
    halves = [subtract_terms(piece, DELAYED, BETA, terms).tau for piece in split.pieces]
    np.testing.assert_array_equal(subtract_terms(split, DELAYED, BETA, terms).tau, np.concatenate(halves, axis=1))


def test_only_where_it_is_asked_for_is_it_taken_and_then_friction_of_eq_1_comes_out_right():
    log = log_with(load1=0.15)
    without, asked = (ready_of(log, friction) for friction in (False, True))
    assert [(term.name, term.taken) for term in without.logs[0].terms] == [("load1", False)]
    assert [(term.name, term.taken) for term in asked.logs[0].terms] == [("load1", True)]
    assert np.array_equal(without.logs[0].loaded.log.tau, log.tau)
    k1 = [solve(problem.without_standstill.y, problem.without_standstill.tau)[7] for problem in (without, asked)]
    assert abs(k1[0] - BETA[7]) > 0.05
    assert k1[1] == pytest.approx(BETA[7], rel=0.15)
    # The validation log, nearly the same, is corrected the same way.
    ((loaded, _),) = asked.validation
    assert loaded.log.tau == pytest.approx(asked.logs[0].loaded.log.tau)


def rows_with_tenth(share, seed=5, n=6000):
    """Random rows and torque, of whose error without the tenth column that column explains this share."""
    rng = np.random.default_rng(seed)
    a = rng.normal(size=(2, n, 10))
    return a, a @ [*BETA, np.sqrt(share)] + np.sqrt(1.0 - share) * rng.normal(size=(2, n))


@pytest.mark.parametrize(("share", "chosen"), [(0.17, []), (0.23, [0])])
def test_a_column_must_reduce_the_squared_error_by_a_fifth(share, chosen):
    assert best_subset(*rows_with_tenth(share), {0: MIN_ERROR_REDUCTION}) == chosen


def test_cross_validation_is_least_squares_on_five_blocks_of_six():
    a, b = rows_with_tenth(0.5, n=600)
    error = np.zeros(2)
    for left_out in np.split(np.arange(600), 6):
        rest = np.delete(np.arange(600), left_out)
        x = np.linalg.lstsq(a[:, rest].reshape(-1, 10), b[:, rest].ravel(), rcond=None)[0]
        error += ((b - a @ x)[:, left_out] ** 2).sum(axis=1)
    np.testing.assert_allclose(cross_validation_error(a, b), error, rtol=1e-9)
