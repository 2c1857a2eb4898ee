"""Preparation against logs that Eq. 1 made, and the least-squares solver against NumPy's and SciPy's."""

from dataclasses import replace

import log_example
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from log_example import BETA
from regression_example import broadband, log_from, random_regressor
from scipy.signal import butter, sosfiltfilt
from strategies import seeds

from repro.identification.filtering import (
    FILTERS,
    FilterSettings,
    choose_cutoff,
    choose_steepness,
    estimate_delay,
    prepare,
    smooth_motion,
)
from repro.identification.regression import drop_standstill
from repro.identification.solve import reduced_problem, solve
from repro.model.dynamics import regressor

LOG = log_from(log_example.motion)
BROAD = log_from(broadband, seconds=24.0)
#: Axis of the samples.
SIGNALS = {"t": 0, "y": 1, "tau": 1, "even_odd": 2, "q": 1, "dq": 1, "ddq": 1, "mask": 1}

every_filter = pytest.mark.parametrize("name", sorted(FILTERS))


def rounded(log, step):
    """The log as an encoder of this resolution records it."""
    return log if step == 0.0 else replace(log, q=step * np.round(log.q / step))


# Preparation.


@pytest.mark.slow
@every_filter
@pytest.mark.parametrize("cutoff", [5.0, 8.0])
def test_a_clean_log_gives_the_arm_back(name, cutoff):
    found = prepare(LOG, FilterSettings(name=name, cutoff=cutoff))
    beta = solve(found.y, found.tau)
    np.testing.assert_allclose(beta[:5], BETA[:5], rtol=0.004)
    np.testing.assert_allclose(beta[5:], BETA[5:], rtol=0.008)


@every_filter
def test_smoothed_motion_is_the_motion(name):
    found = prepare(LOG, FilterSettings(name=name, cutoff=8.0))
    for ours, exact in zip((found.q, found.dq, found.ddq), log_example.motion(found.t), strict=True):
        assert np.abs(ours - exact).max() < 0.01 * np.abs(exact).max()
    whole = smooth_motion(LOG.q, 1.0 / 200.0, FilterSettings(name=name, cutoff=8.0))
    for ours, part in zip((found.q, found.dq, found.ddq), whole, strict=True):
        kept = part[:, np.searchsorted(LOG.t, found.t)]
        np.testing.assert_allclose(ours, kept, rtol=0, atol=1e-9 * np.abs(part).max())


@pytest.mark.parametrize("cut", [0.1, 0.3, 2.0])
def test_the_cut_leaves_both_ends_out(cut):
    found = prepare(LOG, FilterSettings(cut=cut, samples_per_cycle=np.inf))
    assert found.t[0] == pytest.approx(LOG.t[0] + cut, abs=1e-9)
    assert found.t[-1] == pytest.approx(LOG.t[-1] - cut, abs=1.01 / 200.0)
    assert found.h == pytest.approx(1.0 / 200.0)


def test_interleaved_regressors_share_no_sample():
    """Noise on the even samples moves one of them alone."""
    moved = LOG.q.copy()
    moved[:, ::2] += 0.01 * np.random.default_rng(3).normal(size=moved[:, ::2].shape)
    clean, noisy = (prepare(log, FilterSettings()).even_odd for log in (LOG, replace(LOG, q=moved)))
    changed = [not np.array_equal(a, b) for a, b in zip(clean, noisy, strict=True)]
    assert sorted(changed) == [False, True]


@pytest.mark.parametrize("seconds", [0.1, 0.4, 0.6])
def test_a_log_that_the_cuts_leave_nothing_of_is_refused(seconds):
    n = round(200 * seconds)
    short = replace(LOG, t=LOG.t[:n], q=LOG.q[:, :n], tau=LOG.tau[:, :n])
    with pytest.raises(ValueError, match="leave nothing between cuts"):
        prepare(short, FilterSettings())


@pytest.mark.slow
@given(st.lists(st.integers(0, 100), min_size=1, max_size=30))
@settings(max_examples=20)
def test_take_gives_the_samples_asked_for_in_their_order(rows):
    found = prepare(LOG, FilterSettings())
    taken = found.take(np.array(rows))
    for field, axis in SIGNALS.items():
        for place, row in enumerate(rows):
            ours = np.take(getattr(taken, field), place, axis)
            np.testing.assert_array_equal(ours, np.take(getattr(found, field), row, axis))
        assert getattr(taken, field).shape[axis] == len(rows)
    assert taken.h == found.h


# Delay.


@pytest.mark.slow
@pytest.mark.parametrize("rate", [100.0, 300.0, 1000.0])
@pytest.mark.parametrize("late", [-7.3, 4.1])
def test_delay_is_found_at_any_rate_and_in_noise(rate, late):
    log = log_from(broadband, rate=rate, delay=1e-3 * late)
    noise = 0.05 * log.tau.std() * np.random.default_rng(2).normal(size=log.tau.shape)
    noisy = rounded(replace(log, tau=log.tau + noise), 1e-4)
    assert 1e3 * estimate_delay(noisy, FilterSettings(cutoff=6.0))[0] == pytest.approx(late, abs=0.3)


@pytest.mark.slow
@every_filter
@pytest.mark.parametrize("late", [-0.008, 0.009])
def test_a_delay_is_found_and_taken_out(name, late):
    """Positive: what is recorded now acts so much later."""
    log = log_from(log_example.motion, delay=late)
    assert estimate_delay(log, FilterSettings(name=name))[0] == pytest.approx(late, abs=3e-4)
    blind, corrected = (prepare(log, FilterSettings(name=name, delay=d)) for d in (0.0, late))
    np.testing.assert_allclose(solve(corrected.y, corrected.tau), BETA, rtol=0.01)
    assert np.abs(solve(blind.y, blind.tau) / BETA - 1.0).max() > 0.05


@pytest.mark.parametrize("late", [-0.03, 0.03])
def test_a_delay_beyond_reach_ends_at_the_limit_of_its_side(late):
    log = log_from(log_example.motion, delay=late)
    found, error = estimate_delay(log, FilterSettings())
    assert found == pytest.approx(np.sign(late) * 0.02, abs=1e-4)
    assert error == 0.02


# Standstill.


@pytest.mark.parametrize(("share", "all_count"), [(0.05, True), (0.19, True), (0.21, False), (0.6, False)])
def test_standstill_counts_for_a_joint_that_moves_a_fifth_of_the_time(share, all_count):
    whole = prepare(LOG, FilterSettings())
    n = whole.t.size
    moves = np.arange(n) < share * n
    held = replace(whole, dq=np.stack([np.where(moves, 1.0, 0.01), np.ones(n)]))
    kept = drop_standstill(held)
    np.testing.assert_array_equal(kept.mask[0], moves | all_count)
    assert kept.mask[1].all()
    assert kept.tau[0, ~moves].any() == all_count


# Cut-off.


@pytest.mark.slow
@every_filter
def test_a_coarser_encoder_lowers_the_cutoff(name):
    steps = (0.0, 1e-4, 3e-3, 1e-2, 3e-2, 0.1)
    chosen = [choose_cutoff(rounded(BROAD, step), FilterSettings(name=name)) for step in steps]
    hertz = [choice.hertz for choice in chosen]
    assert hertz == sorted(hertz, reverse=True)
    assert hertz[0] == chosen[0].highest == pytest.approx(10.0)
    assert "the most that is used" in chosen[0].reason
    assert hertz[-1] < 6.0
    assert "times its noise" in chosen[-1].reason


@pytest.mark.slow
@every_filter
@pytest.mark.parametrize("edge", [3.0, 6.0])
def test_the_cutoff_ends_where_torque_noise_begins(name, edge):
    noise = np.random.default_rng(0).normal(size=BROAD.tau.shape)
    noise = 30.0 * sosfiltfilt(butter(8, edge, "high", fs=200.0, output="sos"), noise, axis=-1)
    choice = choose_cutoff(replace(BROAD, tau=BROAD.tau + noise), FilterSettings(name=name))
    assert choice.hertz == pytest.approx(edge, abs=1.0)
    assert "explains less than half" in choice.reason
    assert f"{choice.hertz:.3g} Hz" in choice.reason


@pytest.mark.slow
@pytest.mark.parametrize("rate", [40.0, 60.0, 100.0, 200.0, 1000.0])
@pytest.mark.parametrize(("step", "noise"), [(0.0, 0.0), (0.3, 0.0), (0.0, 100.0), (0.3, 100.0)])
def test_the_cutoff_stays_within_its_bounds(rate, step, noise):
    log = rounded(log_from(broadband, rate=rate), step)
    log = replace(log, tau=log.tau + noise * np.random.default_rng(1).normal(size=log.tau.shape))
    choice = choose_cutoff(log, FilterSettings())
    assert choice.highest == pytest.approx(min(10.0, rate / 10.0))
    assert 1.0 <= choice.hertz <= choice.highest
    assert choice.coherence.shape == choice.position.shape == (2, choice.frequency.size)
    assert (choice.coherence >= 0.0).all()
    assert (choice.coherence <= 1.0 + 1e-9).all()
    if step == 0.0 and noise == 0.0:
        assert choice.hertz == choice.highest
    else:
        assert choice.hertz < 0.6 * choice.highest


# Steepness of friction.


@pytest.mark.slow
@every_filter
@pytest.mark.parametrize("steepness", [20.0, 100.0])
def test_steepness_is_recovered(name, steepness):
    log = log_from(log_example.motion, steepness=steepness)
    noise = 0.003 * np.random.default_rng(4).normal(size=log.tau.shape)
    noisy = rounded(replace(log, tau=log.tau + noise), 1e-5)
    assert choose_steepness(noisy, FilterSettings(name=name, friction_steepness=7.0)) == steepness


# Least squares.


@pytest.mark.slow
@given(seeds, st.booleans())
def test_solution_is_numpy_s(seed, weighted):
    rng = np.random.default_rng(seed)
    y = random_regressor(rng, int(rng.integers(12, 60)))
    tau = rng.normal(size=y.shape[:2])
    weight = rng.uniform(0.01, 10.0, tau.shape) if weighted else None
    root = np.ones_like(tau) if weight is None else np.sqrt(weight)
    expected, *_ = np.linalg.lstsq((root[..., np.newaxis] * y).reshape(-1, 9), (root * tau).reshape(-1))
    np.testing.assert_allclose(solve(y, tau, weight), expected, rtol=1e-8, atol=1e-9 * np.abs(expected).max())


@pytest.mark.slow
@given(seeds, st.floats(-3.0, 3.0).filter(lambda x: abs(x) > 0.1))
def test_of_collinear_columns_the_shortest_solution_is_taken(seed, ratio):
    """Shortest in torque: columns have unit length when lengths are compared."""
    rng = np.random.default_rng(seed)
    y = rng.normal(size=(2, 40, 9)) * 10.0 ** rng.uniform(-1, 1, 9)
    y[..., 7] = ratio * y[..., 5]
    tau = rng.normal(size=(2, 40))
    flat = y.reshape(80, 9)
    length = np.linalg.norm(flat, axis=0)
    expected, *_ = np.linalg.lstsq(flat / length, tau.reshape(-1), rcond=1e-10)
    np.testing.assert_allclose(length * solve(y, tau), expected, rtol=1e-7, atol=1e-9)
    plain, *_ = np.linalg.lstsq(flat, tau.reshape(-1), rcond=1e-10)
    left = [np.linalg.norm(flat @ beta - tau.reshape(-1)) for beta in (solve(y, tau), plain)]
    assert left[0] == pytest.approx(left[1], rel=1e-10)


@pytest.mark.slow
@given(seeds, st.sampled_from(["all", "joint 2 still", "collinear", "straight", "no motion"]))
def test_reduced_rows_hold_the_whole_cost_and_have_the_shortest_solution(seed, kind):
    rng = np.random.default_rng(seed)
    q, dq, ddq = rng.normal(size=(3, 2, 50))
    if kind in {"joint 2 still", "straight"}:
        q[1], dq[1], ddq[1] = 0.0 if kind == "straight" else 0.4, 0.0, 0.0
    y = regressor(q, dq, ddq) * (kind != "no motion")
    if kind == "collinear":
        y[..., 6] = 2.0 * y[..., 8]
    tau = y @ BETA + 0.1 * rng.normal(size=(2, 50))
    r, c, scale = reduced_problem(y, tau)
    assert len(r) == len(c) <= 18
    assert np.linalg.matrix_rank(r, tol=1e-9) == 9
    found = np.linalg.lstsq(r, c, rcond=1e-12)[0] / scale
    np.testing.assert_allclose(scale * found, scale * solve(y, tau), rtol=0, atol=1e-6 * np.linalg.norm(tau))
    one, other = rng.normal(size=(2, 9))
    whole = np.sum((y @ one - tau) ** 2) - np.sum((y @ other - tau) ** 2)
    rows = np.sum((r @ (scale * one) - c) ** 2) - np.sum((r @ (scale * other) - c) ** 2)
    # Where directions are undetermined, the rows that pull on them are in the cost, too.
    pulled = 1e-6 * max(np.sum((scale * beta) ** 2) for beta in (one, other)) * (kind != "all")
    assert rows == pytest.approx(whole, rel=1e-8, abs=1e-8 + pulled)
