"""Standard errors against textbook formulas and simulated data, and choices of the analysis."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from log_example import BETA, motion
from regression_example import H, autoregressive, exact, exciting, log_from, regression_of, rows_of, with_noise
from scipy import stats
from strategies import seeds

from repro.identification import uncertainty
from repro.identification.extra_terms import CERTAIN_EFFECTS, CONSTANTS, ExtraTerm
from repro.identification.filtering import FilterSettings, prepare
from repro.identification.least_squares import METHODS
from repro.identification.method import Estimate
from repro.identification.regression import correlation_time, drop_standstill, solve
from repro.identification.uncertainty import Perturbation, WeightedLog
from repro.model.dynamics import regressor
from repro.model.parameters import NAMES

N = 1500
T = H * np.arange(N)
ORDINARY = METHODS["ordinary"]
G1, G2, K1, K2 = (NAMES.index(name) for name in ("g1", "g2", "k1", "k2"))


def textbook(r):
    """Standard errors of ordinary least squares for white residuals of one size."""
    a, tau = rows_of(r), r.tau.reshape(-1)
    beta, energy = np.linalg.lstsq(a, tau, rcond=None)[:2]
    return beta, np.sqrt(np.diag(np.linalg.inv(a.T @ a)) * energy[0] / (tau.size - 9))


def ordinary_spread(r, seed, replicates=200, method=ORDINARY, perturbations=None):
    return uncertainty.bootstrap(
        method, r, method.estimate(r), perturbations or {}, np.random.default_rng(seed), replicates
    )


@pytest.mark.slow
def test_on_white_noise_standard_errors_are_those_of_the_textbook():
    r = exact(motion(T), noise=0.1 * np.random.default_rng(1).normal(size=(2, N)))
    beta, expected = textbook(r)
    spread = ordinary_spread(r, 2, 1000)
    assert spread.standard_error == pytest.approx(expected, rel=0.15)
    assert 0.5 * (spread.low + spread.high) == pytest.approx(beta, rel=1e-6, abs=1e-9)


@pytest.mark.slow
def test_on_correlated_noise_they_are_those_of_many_simulated_logs():
    n, rho, rng = 3000, 0.95, np.random.default_rng(9)
    clean = exciting(n)
    solver = np.linalg.pinv(rows_of(clean))
    simulated = np.std([solver @ autoregressive(rho, n, rng, 0.1).reshape(-1) for _ in range(600)], axis=0)
    logs = [replace(clean, tau=clean.tau + autoregressive(rho, n, rng, 0.1)) for _ in range(6)]
    claimed = np.mean([ordinary_spread(r, k).standard_error for k, r in enumerate(logs)], axis=0)
    white = np.mean([textbook(r)[1] for r in logs], axis=0)
    assert claimed == pytest.approx(simulated, rel=0.3)
    assert (claimed > 2.0 * white).all()
    assert (claimed[[G1, G2]] > 3.5 * white[[G1, G2]]).all()


def test_intervals_reach_as_far_as_students_t():
    # Residuals correlated throughout make the longest blocks: twenty, 19 degrees of freedom, 2.093 in every table.
    r = exciting(N)
    drifting = replace(r, tau=r.tau + 0.1 * np.sin(2 * np.pi * T / T[-1]))
    assert uncertainty.block_length(drifting.tau - drifting.y @ ORDINARY.estimate(drifting).beta, H) == N // 20
    spread = ordinary_spread(drifting, 3)
    assert (spread.high - spread.low) / (2 * spread.standard_error) == pytest.approx([2.093] * 9, abs=1e-3)


def test_where_the_jackknife_counts_students_t_has_five_degrees_of_freedom():
    # Friction that falls over the log moves every block alike, but not every sixth of the log: 2.571 in every table.
    r = exciting(N)
    tau = r.tau + 0.02 * np.random.default_rng(12).normal(size=r.tau.shape)
    tau[0] -= 0.4 * (T / T[-1] - 0.5) * np.tanh(20.0 * motion(T)[1][0])
    spread = ordinary_spread(replace(r, tau=tau), 3)
    factor = (spread.high - spread.low) / (2 * spread.standard_error)
    assert factor[K1] == pytest.approx(2.571, abs=1e-3)
    assert factor[K2] < 2.2


@pytest.mark.parametrize("rho", [0.5, 0.9, 0.95])
def test_correlation_time_of_an_autoregression_is_its_theory(rho):
    # The sum of rho^k from lag 0 on.
    times = []
    for seed in range(6):
        error = autoregressive(rho, 30_000, np.random.default_rng(seed))
        error[0] = 3.0 * np.random.default_rng(seed + 50).normal(size=30_000)  # the longer of both counts
        times.append(correlation_time(error + np.array([[5.0], [-2.0]]), 0.01) / 0.01)
    assert np.mean(times) == pytest.approx(1.0 / (1.0 - rho), rel=0.1)


@given(st.data())
def test_redrawn_samples_are_whole_stretches_of_the_log(data):
    n = data.draw(st.integers(1, 300))
    length = data.draw(st.integers(1, n))
    rows = uncertainty.resample(n, length, np.random.default_rng(data.draw(st.integers(0, 2**32 - 1))))
    assert rows.shape == (n,)
    assert 0 <= rows.min() <= rows.max() < n
    assert (np.diff(rows)[np.arange(1, n) % length != 0] == 1).all()


@pytest.mark.parametrize(
    ("names", "weight", "added"),
    [
        (["filters"], 1.0, lambda squares: np.mean(squares, axis=0)),
        # The largest shift counts, as the end of a rectangular distribution.
        (["torque offsets", "Stribeck friction"], 0.6, lambda squares: 0.6 * np.max(squares, axis=0) / 3.0),
    ],
)
def test_other_choices_add_the_square_of_their_shift(names, weight, added):
    rng = np.random.default_rng(10)
    r, *others = (exact(motion(T[:400]), noise=0.1 * rng.normal(size=(2, 400))) for _ in range(3))
    parts = [others] if len(names) == 1 else [[other] for other in others]
    rival = len(names) > 1
    perturbations = {name: Perturbation(tuple(part), weight, rival) for name, part in zip(names, parts, strict=True)}
    alone, together = ordinary_spread(r, 1), ordinary_spread(r, 1, perturbations=perturbations)
    beta, *moved = (np.linalg.lstsq(rows_of(o), o.tau.reshape(-1), rcond=None)[0] for o in (r, *others))
    expected = added([np.square(other - beta) for other in moved])
    assert together.standard_error**2 - alone.standard_error**2 == pytest.approx(expected, rel=1e-6)
    assert (together.high - together.low > alone.high - alone.low).all()


def test_a_method_that_is_biased_on_purpose_adds_its_bias():
    r = exact(motion(T[:400]), noise=0.1 * np.random.default_rng(11).normal(size=(2, 400)))
    bias = np.linspace(-0.4, 0.4, 9)
    biased = replace(ORDINARY, estimate=lambda x: Estimate(ORDINARY.estimate(x).beta + bias))
    without = ordinary_spread(r, 1, method=biased)
    with_bias = ordinary_spread(r, 1, method=replace(biased, unbiased=ORDINARY.estimate))
    assert with_bias.standard_error**2 - without.standard_error**2 == pytest.approx(bias**2, rel=1e-6, abs=1e-9)


def test_what_a_method_chose_is_kept_in_every_replicate():
    r, seen = exciting(400), []

    def refit(regression, choice):
        seen.append(choice)
        return ORDINARY.estimate(regression).beta

    chooser = replace(ORDINARY, estimate=lambda _: Estimate(BETA, choice=0.7), refit=refit)
    ordinary_spread(r, 0, 15, chooser, {"filters": Perturbation((r, r))})
    assert seen == [0.7] * (15 + uncertainty.GROUPS + 2)


# Choices of the analysis: projections against joint least squares, and what a log shows.
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
    left = uncertainty.project_out(regression_of(y, tau), x)
    np.testing.assert_allclose(solve(left.y, left.tau), beside, rtol=1e-6, atol=1e-9)


def test_a_column_that_others_contain_changes_nothing():
    rng = np.random.default_rng(5)
    y, tau, x = rng.normal(size=(2, 80, 9)), rng.normal(size=(2, 80)), rng.normal(size=(2, 80, 2))
    twice = np.concatenate([x, 3.0 * x[..., :1] - x[..., 1:]], axis=-1)
    once, again = (uncertainty.project_out(regression_of(y, tau), columns) for columns in (x, twice))
    np.testing.assert_allclose(again.y, once.y, atol=1e-12)
    np.testing.assert_allclose(again.tau, once.tau, atol=1e-12)


def test_terms_are_fitted_again_next_to_an_effect():
    """A torque constant that changes with the current looks like friction of the load, which must not keep its size."""
    q, dq, ddq = motion(LOG.t)
    friction, curved = loaded(q, dq, ddq), LOG.tau * np.abs(LOG.tau)
    log = with_noise(replace(LOG, tau=LOG.tau + 0.05 * friction + 0.02 * curved), 0.01, 3)
    terms = [ExtraTerm(f"load{joint}", 0.2, 0.01, 0.3, True) for joint in (1, 2)]  # four times as large as they are
    weighted = [WeightedLog(log, SETTINGS, terms=terms, load=BETA)]
    regression = uncertainty.join_filtered(weighted)
    found = uncertainty.unmodelled_effects(weighted, regression, regression)[CONSTANTS]
    assert found.weight > 0.9
    (r,) = found.regressions
    assert solve(r.y, r.tau)[:5] == pytest.approx(BETA[:5], rel=0.02)
    assert np.abs(solve(regression.y, regression.tau)[:5] / BETA[:5] - 1.0).max() > 0.04


@pytest.mark.parametrize(("share", "is_rival"), [(0.004, False), (-0.004, True)])
def test_a_rotor_too_small_for_a_test_widens_intervals_where_it_would_be_positive(share, is_rival):
    ddq2 = motion(LOG.t)[2][1]
    log = with_noise(replace(LOG, tau=LOG.tau + each(0.0, share * BETA[2]) * ddq2), 0.01, 1)
    found = effects(log)["inertia of the rotor of joint 2"]
    assert found.rival == is_rival
    assert found.weight > 0.4  # of the positive one F is 1, which no test would find


def effects(log, corrected=None):
    """Effects beyond Eq. 1 that a log may have, if one with its calibration errors corrected may explain it instead."""
    own, plain = (drop_standstill(prepare(one, SETTINGS)) for one in (log, corrected or log))
    return uncertainty.unmodelled_effects([WeightedLog(log, SETTINGS)], own, plain)


FRICTION = "both kinds of friction"


@pytest.mark.parametrize(
    ("name", "spoil"),
    [
        ("zero positions", lambda log, q, dq, ddq: (log.q + each(0.03, -0.02), log.tau)),
        ("torque offsets", lambda log, q, dq, ddq: (log.q, log.tau + each(0.2, -0.1))),
        (FRICTION, lambda log, q, dq, ddq: (log.q, log.tau + 0.1 * loaded(q, dq, ddq))),
        (FRICTION, lambda log, q, dq, ddq: (log.q, log.tau + 0.3 * near_rest(dq, 0.5))),
        (FRICTION, lambda log, q, dq, ddq: (log.q, log.tau + 0.3 * near_rest(dq, 0.1))),
        ("torque of period one turn", lambda log, q, dq, ddq: (log.q, log.tau + wave(q))),
        ("torque of period half a turn", lambda log, q, dq, ddq: (log.q, log.tau + wave(2.0 * q))),
    ],
)
def test_a_log_with_a_fault_asks_for_its_columns_and_gives_the_truth_with_them(name, spoil):
    q, dq, ddq = motion(LOG.t)
    positions, torque = spoil(LOG, q, dq, ddq)
    log = replace(LOG, q=positions, tau=torque)
    found, plain = effects(log)[name], prepare(log, SETTINGS)
    without_it, with_it = (np.abs(solve(r.y, r.tau) / BETA - 1)[:5].max() for r in (plain, *found.regressions))
    assert found.weight > 0.9
    assert with_it < 0.5 * without_it


def loaded(q, dq, ddq):
    return np.abs(regressor(q, dq, ddq)[..., :5] @ BETA[:5]) * np.tanh(20.0 * dq)


def near_rest(dq, speed):
    return np.tanh(20.0 * dq) * np.exp(-np.abs(dq) / speed)


def wave(angle):
    return each(0.3, -0.2) * np.cos(angle + each(0.0, 0.5))


@pytest.mark.parametrize("seed", range(3))
def test_errors_of_the_motion_once_more_shrink_an_estimate_as_they_did(seed):
    rng = np.random.default_rng(seed)
    y = np.tile(prepare(LOG, SETTINGS).y, (1, 200, 1))
    tau = y @ BETA
    y[..., :5] *= 1.0 + 0.2 * rng.choice([-1.0, 1.0], size=(*tau.shape, 5))
    found = regression_of(y, tau)
    once, twice = (solve(r.y, r.tau)[:5] / BETA[:5] for r in (found, uncertainty.simex(found)))
    off = np.abs(once - 1.0).max()
    assert off > 0.04
    assert np.abs(2.0 * once - twice - 1.0).max() < 0.5 * off


def test_a_log_that_eq_1_explains_asks_for_next_to_nothing():
    found = [effects(with_noise(LOG, 0.05, seed)) for seed in range(10)]
    weights = [effect.weight for of_log in found for name, effect in of_log.items() if name not in CERTAIN_EFFECTS]
    assert np.mean(weights) < 0.2


@pytest.mark.parametrize("which", [0, 1])
def test_another_lambda_is_one_of_the_perturbations(which):
    true = SETTINGS.friction_steepness * uncertainty.STEEPNESS_FACTORS[which]
    log = replace(LOG, tau=regressor(*motion(LOG.t), true) @ BETA)
    plain = drop_standstill(prepare(log, SETTINGS))
    found = uncertainty.perturbations([WeightedLog(log, SETTINGS)], plain)["lambda"]
    off = [np.abs(r.tau - r.y @ solve(r.y, r.tau)).max() for r in (*found.regressions, plain)]
    assert off[which] < 0.3 * min(off[1 - which], off[2])
    assert not found.rival


@pytest.mark.parametrize(("zero", "size", "explains"), [(0.05, 1.0, True), (0.0, 0.0, False)])
def test_an_effect_that_explains_a_log_without_its_correction_has_weight(zero, size, explains):
    # The log is corrected by 0.05 rad: wrongly if its zero is right and it has another effect.
    q = LOG.q + each(zero - 0.05, 0.0)
    recorded = with_noise(replace(LOG, q=q, tau=LOG.tau + size * wave(2.0 * q)), 0.02, 4)
    found = effects(recorded, replace(recorded, q=q + each(0.05, 0.0)))["torque of period half a turn"]
    assert found.rival
    if explains:
        (r,) = found.regressions
        assert found.weight > 0.9
        assert solve(r.y, r.tau)[:5] == pytest.approx(BETA[:5], rel=0.03)
    else:
        assert found.weight < 0.05


def test_f_is_that_of_nested_models():
    rng = np.random.default_rng(1)
    y, x = rng.normal(size=(2, 400, 9)), rng.normal(size=(2, 400, 1))
    plain = regression_of(y, rng.normal(size=(2, 400)) + 0.12 * x[..., 0])
    assert uncertainty.f_statistic(plain, plain, 2, np.ones((2, 1)))[0] == 0.0
    rows = np.concatenate([y, x], axis=-1).reshape(800, 10)
    before, after = (np.linalg.lstsq(rows[:, :k], plain.tau.reshape(-1))[1][0] for k in (9, 10))
    f, critical = uncertainty.f_statistic(plain, uncertainty.project_out(plain, x), 1, np.ones((2, 1)))
    # Samples are independent but for a correlation time that chance makes a little longer than a sample.
    assert f == pytest.approx((before / after - 1.0) * 790, rel=0.15)
    assert critical == pytest.approx(stats.f.isf(0.05, 1, 790), rel=0.01)


def test_the_noise_of_one_joint_does_not_hide_an_effect_on_the_other():
    rng = np.random.default_rng(2)
    y, x = rng.normal(size=(2, 400, 9)), rng.normal(size=(2, 400, 1))
    x[0] = 0.0
    plain = regression_of(y, each(40.0, 1.0) * rng.normal(size=(2, 400)) + 0.2 * x[..., 0])
    f, _ = uncertainty.f_statistic(plain, uncertainty.project_out(plain, x), 1, each(40.0, 1.0) ** -2.0)
    rows = np.concatenate([y[1], x[1]], axis=-1)  # the joint by itself
    before, after = (np.linalg.lstsq(rows[:, :k], plain.tau[1])[1][0] for k in (9, 10))
    assert f == pytest.approx((before / after - 1.0) * 390, rel=0.2)
