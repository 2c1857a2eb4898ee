"""Zero-phase filters and preparation against logs that Eq. 1 made, and least squares against NumPy and SciPy."""

from dataclasses import replace

import log_example
import numpy as np
import pytest
from experiment_example import refused
from hypothesis import given, settings
from hypothesis import strategies as st
from log_example import BETA
from regression_example import broadband, log_from, random_regressor, regression_of, sinusoids, with_noise
from scipy.signal import butter, sosfiltfilt
from strategies import seeds

from repro.identification import filtering
from repro.identification.filtering import FILTERS, FilterSettings, choose_cutoff, estimate_delay, prepare
from repro.identification.regression import drop_standstill, reduced_problem, solve

pytestmark = pytest.mark.slow

LOG = log_from(log_example.motion)
BROAD = log_from(broadband, seconds=24.0)

every_filter = pytest.mark.parametrize("name", sorted(FILTERS))


def rounded(log, step):
    """The log as an encoder of this resolution records it."""
    return log if step == 0.0 else replace(log, q=step * np.round(log.q / step))


# Filters against sines and the cosine series written out.
H = 1.0 / 200.0
T = H * np.arange(4000)
#: Away from the edges.
MIDDLE = slice(1000, 3000)


@every_filter
@pytest.mark.parametrize(("rate", "cutoff"), [(100, 2.0), (100, 5.0), (200, 1.0), (200, 5.0), (200, 10.0), (1000, 5.0)])
def test_power_is_halved_at_the_stated_frequency(name, rate, cutoff):
    """The gain is that of a long sine, by least squares in its middle."""
    turn = 2 * np.pi * cutoff / rate * np.arange(20 * rate)
    waves, middle = np.stack([np.sin(turn), np.cos(turn)], axis=-1), slice(5 * rate, 15 * rate)
    filtered = FILTERS[name].apply(waves[:, 0], 1.0 / rate, cutoff, 0)
    assert np.linalg.norm(np.linalg.lstsq(waves[middle], filtered[middle])[0]) == pytest.approx(np.sqrt(0.5), rel=0.03)


@every_filter
@settings(max_examples=20)
@given(seeds)
def test_derivatives_of_slow_sines_are_the_analytic_ones(name, seed):
    rng = np.random.default_rng(seed)
    frequency, amplitude = rng.uniform(0.05, 0.5, (2, 4)), rng.normal(size=(2, 4))
    exact = sinusoids(T, amplitude, frequency, rng.uniform(0, 2 * np.pi, (2, 4)))
    for order, expected in enumerate(exact):
        error = np.abs(FILTERS[name].apply(exact[0], H, 15.0, order) - expected)[:, MIDDLE]
        assert error.max() < 2e-3 * np.abs(expected).max()


@every_filter
@settings(max_examples=20)
@given(seeds, st.floats(-5.0, 5.0), st.sampled_from([0, 1, 2]))
def test_filters_are_linear(name, seed, factor, order):
    x, other = np.random.default_rng(seed).normal(size=(2, 3, 300))
    apply = FILTERS[name].apply
    together, apart = apply(x + factor * other, H, 5.0, order), apply(x, H, 5.0, order)
    expected = apart + factor * apply(other, H, 5.0, order)
    np.testing.assert_allclose(together, expected, rtol=0, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize(("n", "cutoff"), [(2, 30.0), (31, 3.0), (31, 30.0), (120, 3.0), (121, 50.0)])
def test_the_pair_and_its_derivatives_are_those_of_the_cosine_series(n, cutoff):
    x, i, t, step = np.random.default_rng(n).normal(size=n), np.arange(n), H * np.arange(n), 1e-4 * H
    bands = np.array([np.sum(x * np.cos(np.pi * k * (2 * i + 1) / (2 * n))) * (2 - (k == 0)) / n for k in range(n)])
    omega = np.pi * i / (n * H)
    # Half power at the cut-off: exp(-c omega^2) = 2^(-1/2).
    gain = 2.0 ** (-0.5 * (omega / (2 * np.pi * cutoff)) ** 2)

    def series(at):
        return np.sum(gain * bands * np.cos(omega * (at[:, np.newaxis] + H / 2)), axis=-1)

    def derivative(at):
        # A complex step subtracts nothing and so loses no digits.
        return series(at + 1e-20j).imag / 1e-20

    curvature = (derivative(t + step) - derivative(t - step)) / (2 * step)
    np.testing.assert_allclose(filtering.dct_pair(x, H, cutoff), series(t), rtol=0, atol=1e-12)
    for order, expected in ((1, derivative(t)), (2, curvature)):
        found = filtering.dct_pair(x, H, cutoff, order)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6 * np.abs(expected).max())


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
    assert sorted(np.array_equal(a, b) for a, b in zip(clean, noisy, strict=True)) == [False, True]


@pytest.mark.parametrize("seconds", [0.1, 0.4, 0.6])
def test_a_log_that_the_cuts_leave_nothing_of_is_refused(seconds):
    n = round(200 * seconds)
    short = replace(LOG, t=LOG.t[:n], q=LOG.q[:, :n], tau=LOG.tau[:, :n])
    refused(prepare, short, FilterSettings())


@every_filter
@pytest.mark.parametrize(("late", "cutoff"), [(-0.008, 8.0), (0.009, 5.0)])
def test_a_delay_is_found_and_without_it_the_arm_is_right(name, late, cutoff):
    """Positive: what is recorded now acts so much later."""
    log, blind = log_from(log_example.motion, delay=late), FilterSettings(name=name, cutoff=cutoff)
    assert estimate_delay(log, blind)[0] == pytest.approx(late, abs=3e-4)
    wrong, corrected = (prepare(log, settings) for settings in (blind, replace(blind, delay=late)))
    error = np.abs(solve(corrected.y, corrected.tau) / BETA - 1.0)
    assert error[:5].max() < 0.004
    assert error[5:].max() < 0.008
    assert np.abs(solve(wrong.y, wrong.tau) / BETA - 1.0).max() > 0.05


@pytest.mark.parametrize("late", [-0.03, 0.03])
def test_a_delay_beyond_reach_ends_at_the_limit_of_its_side(late):
    log = log_from(log_example.motion, delay=late)
    assert estimate_delay(log, FilterSettings()) == (pytest.approx(np.sign(late) * 0.02, abs=1e-4), 0.02)


def test_the_standard_error_of_a_delay_is_its_scatter():
    log = log_from(log_example.motion, delay=0.004)  # in the middle of the range that needs no evidence
    noise = 0.3 * np.random.default_rng(0).normal(size=(24, *log.tau.shape))
    delays, errors = np.transpose([estimate_delay(replace(log, tau=log.tau + n), FilterSettings()) for n in noise])
    assert 0.95 < np.mean(errors) / np.std(delays) < 1.35


@pytest.mark.parametrize(("share", "all_count"), [(0.05, True), (0.19, True), (0.21, False), (0.6, False)])
def test_standstill_counts_for_a_joint_that_moves_a_fifth_of_the_time(share, all_count):
    whole = prepare(LOG, FilterSettings())
    n = whole.t.size
    moves = np.arange(n) < share * n
    kept = drop_standstill(replace(whole, dq=np.stack([np.where(moves, 1.0, 0.01), np.ones(n)])))
    np.testing.assert_array_equal(kept.mask[0], moves | all_count)
    assert kept.mask[1].all()
    assert kept.tau[0, ~moves].any() == all_count


@every_filter
def test_a_coarser_encoder_lowers_the_cutoff(name):
    steps = (0.0, 1e-4, 3e-3, 1e-2, 3e-2, 0.1)
    chosen = [choose_cutoff(rounded(BROAD, step), FilterSettings(name=name)) for step in steps]
    hertz = [choice.hertz for choice in chosen]
    assert hertz == sorted(hertz, reverse=True)
    assert hertz[0] == chosen[0].highest == pytest.approx(10.0)
    assert hertz[-1] < 6.0


@every_filter
@pytest.mark.parametrize("edge", [3.0, 6.0])
def test_the_cutoff_ends_where_torque_noise_begins(name, edge):
    noise = np.random.default_rng(0).normal(size=BROAD.tau.shape)
    noise = 30.0 * sosfiltfilt(butter(8, edge, "high", fs=200.0, output="sos"), noise, axis=-1)
    choice = choose_cutoff(replace(BROAD, tau=BROAD.tau + noise), FilterSettings(name=name))
    assert choice.hertz == pytest.approx(edge, abs=1.0)
    assert f"{choice.hertz:.3g} Hz" in choice.reason


@pytest.mark.parametrize("rate", [40.0, 100.0, 1000.0])
@pytest.mark.parametrize(("step", "noise"), [(0.0, 0.0), (0.3, 0.0), (0.0, 100.0), (0.3, 100.0)])
def test_the_cutoff_stays_within_its_bounds(rate, step, noise):
    choice = choose_cutoff(with_noise(rounded(log_from(broadband, rate=rate), step), noise, 1), FilterSettings())
    assert choice.highest == pytest.approx(min(10.0, rate / 10.0))
    assert 1.0 <= choice.hertz <= choice.highest
    assert choice.coherence.shape == choice.position.shape == (2, choice.frequency.size)
    assert 0.0 <= choice.coherence.min() <= choice.coherence.max() <= 1.0 + 1e-9
    if step == 0.0 and noise == 0.0:
        assert choice.hertz == choice.highest
    else:
        assert choice.hertz < 0.6 * choice.highest


@every_filter
@pytest.mark.parametrize("steepness", [20.0, 100.0])
def test_steepness_is_recovered(name, steepness):
    noisy = rounded(with_noise(log_from(log_example.motion, steepness=steepness), 0.003, 4), 1e-5)
    assert filtering.choose_steepness([(noisy, FilterSettings(name=name, friction_steepness=7.0))]) == steepness


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


@given(seeds, st.sampled_from(["all", "joint 2 still", "collinear", "straight", "no motion"]))
def test_reduced_rows_hold_the_whole_cost_and_have_the_shortest_solution(seed, kind):
    rng = np.random.default_rng(seed)
    still = 1 if kind in {"joint 2 still", "straight"} else None
    y = random_regressor(rng, 50, still, 0.0 if kind == "straight" else 0.4) * (kind != "no motion")
    if kind == "collinear":
        y[..., 6] = 2.0 * y[..., 8]
    tau = y @ BETA + 0.1 * rng.normal(size=(2, 50))
    r, c, scale = reduced_problem(regression_of(y, tau))
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


def test_rows_that_a_wrong_torque_reaches_through_the_filters_are_left_out():
    wrong = np.zeros(LOG.tau.shape, dtype=bool)
    wrong[0, 1000:1040] = True
    damaged = replace(LOG, tau=LOG.tau + 5.0 * wrong)
    setting = FilterSettings()
    whole, r = prepare(LOG, setting), prepare(replace(damaged, left_out=wrong), setting)
    assert r.mask[1].all()
    out = r.t[~r.mask[0]]
    assert 4.8 < out.min() < 5.0 and 5.2 < out.max() < 5.4
    np.testing.assert_allclose(r.tau[r.mask], whole.tau[r.mask], atol=0.05 * 5.0)
    np.testing.assert_array_equal(drop_standstill(r).mask, drop_standstill(whole).mask & r.mask)
    error = [np.abs(solve(x.y, x.tau) - BETA).max() for x in (r, prepare(damaged, setting))]
    assert error[0] < 0.2 * error[1]
    assert error[1] > 0.1
    choices = [choose_cutoff(log, setting) for log in (LOG, replace(damaged, left_out=wrong), damaged)]
    undamaged, repaired, spoiled = (np.interp(2.5, choice.frequency, choice.coherence[0]) for choice in choices)
    assert spoiled < repaired - 0.05
    assert repaired == pytest.approx(undamaged, abs=0.02)
    assert estimate_delay(replace(damaged, left_out=wrong), setting)[0] == pytest.approx(0.0, abs=1e-3)
