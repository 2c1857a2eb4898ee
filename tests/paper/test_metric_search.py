"""The search for the formulas of Algorithm 2 and the motion of Table 7, and checks of the published similarities."""

import numpy as np
import pytest
from claims_example import printed_as
from experiment_example import full_config
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import distance

from repro.paper import metric_search
from repro.paper.metric_candidates import CANDIDATES, Pair
from repro.paper.metric_search import CHOSEN, CHOSEN_MOTION, MOTIONS, SAMPLING_PERIOD, RandomMotion, band_number_motion
from repro.paper.published import load_published
from repro.signals.dct import dct2low, spectrum
from repro.signals.metric import MetricSettings, metr2ev
from repro.signals.trajectories import identification_trajectory

PUBLISHED = load_published()


def signal(seed, shape=(3, 2, 150)):
    return np.random.default_rng(seed).normal(0.3, 1.0, shape).cumsum(-1)


def error(factor, name, x, y):
    (candidate,) = [c for c in CANDIDATES if (c.factor, c.name) == (factor, name)]
    return candidate.measure(Pair(x, y))


def test_identical_signals_have_similarity_one():
    x = signal(0)
    for c in CANDIDATES:
        argument = x if c.factor == "time" else spectrum(x)
        same = c.measure(Pair(argument, argument.copy()))
        assert same.shape == (3, 2)
        np.testing.assert_allclose(same, 0.0, atol=1e-7, err_msg=c.name)


def test_time_formulas_against_independent_ones():
    x, y = signal(1, (2, 150)), signal(2, (2, 150))
    for j in range(2):
        u, v = x[j], y[j]
        expected = {
            "mean square": distance.sqeuclidean(u, v) / u.size,
            "maximum": distance.chebyshev(u, v),
            "mean absolute": distance.cityblock(u, v) / u.size,
            "energy": distance.sqeuclidean(u, v) / np.dot(u, u),
            "relative 1-norm": distance.cityblock(u, v) / distance.cityblock(u, 0 * u),
            "cosine": distance.cosine(u, v),
            "correlation": distance.correlation(u, v),
            "unit vectors": distance.euclidean(u / np.linalg.norm(u), v / np.linalg.norm(v)),
            "mean square by variance": np.mean((u - v) ** 2) / np.var(u),
            "rms by range": np.sqrt(np.mean((u - v) ** 2)) / (u.max() - u.min()),
            "mean square by common peak": np.mean((u - v) ** 2) / np.abs(x).max() ** 2,
        }
        for name, value in expected.items():
            assert error("time", name, x, y)[j] == pytest.approx(value, rel=1e-9), name


@pytest.mark.parametrize("name", [c.name for c in CANDIDATES if "symmetric" in c.name or "geometric" in c.name])
def test_a_symmetric_formula_is_so(name):
    x, y = signal(5, (2, 150)), 3.0 * signal(6, (2, 150))
    np.testing.assert_allclose(error("time", name, x, y), error("time", name, y, x))


def test_frequency_formulas_against_independent_ones():
    s, t = signal(3, (2, 150)), signal(4, (2, 150))
    for j in range(2):
        a, b = np.abs(s[j]), np.abs(t[j])
        p, q = s[j] ** 2, t[j] ** 2
        expected = {
            "absolute | 1-norm | 1-norm": distance.cityblock(a / a.sum(), b / b.sum()),
            "power | maximum | maximum": distance.chebyshev(p / p.max(), q / q.max()),
            "log | - | correlation": distance.correlation(np.log(1 + a), np.log(1 + b)),
            "signed | none | rms": np.sqrt(distance.sqeuclidean(s[j], t[j]) / s[j].size),
            "signed | sum | 2-norm": distance.euclidean(s[j] / s[j].sum(), t[j] / t[j].sum()),
        }
        for name, value in expected.items():
            assert error("frequency", name, s, t)[j] == pytest.approx(value, rel=1e-9), name


@given(st.integers(0, 10_000), st.floats(0.01, 100.0))
@settings(max_examples=25, deadline=None)
def test_chosen_frequency_formula_is_a_function_of_the_cosine_of_the_signals(seed, scale):
    # Parseval: the orthonormal DCT-II keeps inner products.
    x, y = signal(seed), scale * signal(seed + 20_000)
    found = error("frequency", CHOSEN["frequency"], spectrum(x), spectrum(y))
    cosine = np.sum(x * y, -1) / np.sqrt(np.sum(x**2, -1) * np.sum(y**2, -1))
    np.testing.assert_allclose(found, np.sqrt(2.0 - 2.0 * cosine), rtol=1e-9)
    np.testing.assert_allclose(found, error("time", "unit vectors", x, y), rtol=1e-9)


def test_chosen_candidates_are_the_project_metric():
    scores = metric_search.score_candidates(identification_trajectory(), PUBLISHED)
    cells = metric_search.abstract_check(PUBLISHED)
    for factor, name in CHOSEN.items():
        (k,) = [i for i, c in enumerate(CANDIDATES) if (c.factor, c.name) == (factor, name)]
        np.testing.assert_allclose(scores[k].ravel(), cells[factor], rtol=1e-12)


@pytest.mark.parametrize("right", [RandomMotion(3770, 10.0), band_number_motion(2000)], ids=["bandwidth", "length"])
def test_search_recovers_the_formulas_and_the_motion_that_made_a_table(right):
    wanted = {"time": "rms by range", "frequency": "absolute | 1-norm | 1-norm"}
    motion = right.draw(np.random.default_rng([6, 0]))  # the first trajectory of seed 6
    scores = metric_search.score_candidates(motion, PUBLISHED)
    made = {
        f"table07/N{arm + 1}/{c.factor}/joint{joint + 1}": f"{100 * scores[k, arm, joint]:.2f}"
        for k, c in enumerate(CANDIDATES)
        if wanted[c.factor] == c.name
        for arm, joint in np.ndindex(4, 2)
    }
    motions = (RandomMotion(3770, 5.0), RandomMotion(3770, 10.0), band_number_motion(2000), band_number_motion(3000))
    scored = metric_search.score_motions(printed_as(made), seed=6, repeats=1, motions=motions)
    table = metric_search.rank_candidates(scored)
    best = table[table["rank"] == 1].set_index("factor")
    assert best["candidate"].to_dict() == wanted
    assert (best[["samples", "bandwidth"]] == [right.samples, right.bandwidth]).all(axis=None)
    assert (best["rank_high"] == 1).all()  # each three arms lead to the same formulas


def test_gain_at_the_bandwidth_of_a_motion_is_1_over_e():
    motion = RandomMotion(4000, 12.0)
    noise = np.random.default_rng(0).uniform(0.0, 1.0, (2, 4000))
    gain = spectrum(motion.draw(np.random.default_rng(0)).q) / spectrum(noise)
    bands = np.array([0, 1, 20, 80])
    expected = np.exp(-((bands / (12.0 * 4000 * 0.0025 / np.pi)) ** 2))
    np.testing.assert_allclose(gain[:, bands], [expected, expected])


def test_the_band_number_motion_counts_omega_in_bands():
    motion = band_number_motion(600)
    assert [motion.bands, band_number_motion(3770).bands] == pytest.approx([100.0, 100.0])
    numbers = np.random.default_rng(1).uniform(0.0, 1.0, (2, 600))
    expected = dct2low(numbers, SAMPLING_PERIOD, 1e-4, "index")
    np.testing.assert_allclose(motion.draw(np.random.default_rng(1)).q, expected, atol=1e-12)


def test_the_chosen_motion_is_that_of_the_configuration():
    config = full_config()
    numeric, signals = config.numeric, config.signals
    assert signals.sampling_period_s == SAMPLING_PERIOD
    assert band_number_motion(numeric.validation_samples, signals.filter_coefficient) == CHOSEN_MOTION
    assert CHOSEN_MOTION in MOTIONS


def test_ranks_without_an_arm_use_the_other_three_and_choose_the_motion_again():
    errors = {
        # Good at the first motion but for N4; at the second motion good throughout.
        "energy": [[0.1, 0.1, 0.1, 9.0], [2.0, 2.0, 2.0, 2.0]],
        "rms": [[1.0, 1.0, 1.0, 1.0], [50.0, 50.0, 50.0, 50.0]],
        "cosine": [[3.0, 0.5, 0.5, 0.5], [60.0, 60.0, 60.0, 60.0]],
    }
    motions = (RandomMotion(3770, 1.0), RandomMotion(3770, 2.0))
    log_error = np.full((2, len(CANDIDATES), 4, 2), 100.0)  # of all other candidates
    for name, of_motions in errors.items():
        log_error[:, [c.name for c in CANDIDATES].index(name)] = np.array(of_motions)[..., None]
    scores = metric_search.Scores(motions, log_error, np.ones((2, 4, 2)), PUBLISHED)
    table = metric_search.rank_candidates(scores).set_index("candidate")
    # All arms: rms 1, cosine sqrt((9 + 0.75) / 4) = 1.56, energy 2 at the second motion.
    assert table.loc[["rms", "cosine", "energy"], "rank"].tolist() == [1, 2, 3]
    assert table.loc["energy", ["rms_log_error_best", "bandwidth"]].tolist() == pytest.approx([2.0, 2.0])
    assert table.loc["cosine", "rms_log_error_best"] == pytest.approx(np.sqrt(9.75 / 4))
    assert table.loc["rms", "rms_log_error_mean"] == pytest.approx(25.5)
    # Without N1: cosine 0.5, rms 1, energy 2. Without N4: energy 0.1, rms 1, cosine 1.78. Without N2 or N3: 1, 1.79, 2.
    spans = table.loc[["energy", "rms", "cosine"], ["rank_low", "rank_high"]]
    assert spans.to_numpy().tolist() == [[1, 3], [1, 2], [1, 3]]
    # All other time formulas have the same error, and share the place after these.
    assert set(table[table["factor"] == "time"]["rank"]) == {1, 2, 3, 4}


@given(st.integers(0, 10_000), st.floats(0.5, 2.0), st.floats(0.05, 0.5))
@settings(max_examples=50, deadline=None)
def test_bound_of_the_mean_square_torque_is_valid_and_reached_at_the_best_scale(seed, scale, noise):
    rng = np.random.default_rng(seed)
    x = 0.3 * rng.normal(size=200)
    y = x + noise * 0.3 * rng.normal(size=200)
    best = y * (x @ y) / (y @ y)
    for rebuilt, reached in ((best, True), (scale * best, abs(scale - 1) < 1e-3)):
        s = metr2ev(x, rebuilt, MetricSettings(time_formula="mean-square"))
        pair = {"time": f"{100 * float(s.time):.6f}", "frequency": f"{100 * float(s.frequency):.6f}"}
        cells = {f"table10/T1/least-squares/{factor}/joint1": value for factor, value in pair.items()}
        other = {"table10/T1/algorithm1/time/joint1": "1.00"}
        bounds = metric_search.torque_bounds(printed_as(cells | other)).set_index(["case", "joint"])
        largest = bounds.loc[("T1", 1), "largest_mean_square"]
        assert largest >= np.mean(x**2) * (1 - 1e-9)
        assert not reached or largest == pytest.approx(np.mean(x**2), rel=1e-3)
