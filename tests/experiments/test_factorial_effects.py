"""Effects of the factorial: known ones are recovered, and the intervals cover over experiments and training seeds."""

import itertools

import numpy as np
import pytest
from factorial_example import MAIN, PAIRS, READER, READER_PAIRS, factorial_scores
from scipy import stats

from repro_studies.factorial import effects, interval

NAMES = tuple(MAIN)


@pytest.fixture(scope="module")
def found():
    return effects(factorial_scores()).set_index(["of", "effect", "response"])


def test_known_effects_are_recovered_with_intervals_of_zero_width(found):
    """Experiments shift every cell alike, so that they leave no spread; the search seeds are averaged."""
    known = MAIN | {" x ".join(pair): size for pair, size in PAIRS.items()}
    effects_of_cnn = found.loc["cnn"]
    for effect in [*NAMES, *(" x ".join(pair) for pair in itertools.combinations(NAMES, 2))]:
        size = known.get(effect, 0.0)
        # With Algorithm 1 alone, an interaction with the reader is part of the main effect.
        size -= READER_PAIRS.get(effect, 0.0)
        for response, factor in (("id", 1.0), ("validation", 2.0)):
            row = effects_of_cnn.loc[(effect, response)]
            np.testing.assert_allclose(row[["value", "low", "high"]].astype(float), factor * size, atol=1e-12)
            assert (row["experiments"], row["training_seeds"]) == (3, 2)


def test_effects_on_the_error_and_of_the_reader_are_recovered(found):
    expected = {
        ("reader", "reader", "id"): READER,
        # The desired motion is half its effect above the mean over both.
        ("reader, desired motion", "reader", "id"): READER - 0.5 * MAIN["image_motion"],
        ("reader", "reader x training", "id"): READER_PAIRS["training"],
        ("reader", "reader x metric", "id"): 0.0,
    }
    for name in ("image_motion", "training"):
        # With the energy formula and Algorithm 1 alone, interactions with them are part of the main effect.
        expected["cnn", name, "error"] = -MAIN[name] - PAIRS.get((name, "metric"), 0.0) + READER_PAIRS.get(name, 0.0)
    assert found["value"][list(expected)].tolist() == pytest.approx([*expected.values()], abs=1e-12)
    assert not [effect for _, effect, response in found.index if response == "error" and "metric" in effect]


def test_a_level_that_differs_between_experiments_widens_the_interval():
    scores = factorial_scores()
    desired = scores["image_motion"].eq("desired") & scores["experiment"].eq(2)
    scores.loc[desired, "id"] += 0.3
    row = effects(scores).set_index(["of", "effect", "response"]).loc[("cnn", "image_motion", "id")]
    assert row["value"] == pytest.approx(MAIN["image_motion"] + 0.1, abs=1e-12)
    # By hand: three experiments with 0.2, 0.5 and 0.2, without a spread over the training seeds.
    half = stats.t.ppf(0.975, 2) * np.std([0.2, 0.5, 0.2], ddof=1) / np.sqrt(3)
    np.testing.assert_allclose([row["low"], row["high"]], [0.3 - half, 0.3 + half], atol=1e-12)


# --- Intervals ----------------------------------------------------------------------------------------------------


def test_intervals_by_hand():
    """Row means 1.5 and 4.5 have the variance 4.5, column means 2 and 4 the variance 2."""
    mean, low, high = interval(np.array([[1.0, 2.0], [3.0, 6.0]]))
    variance = 4.5 / 2 + 2.0 / 2
    freedom = variance**2 / ((4.5 / 2) ** 2 / 1 + (2.0 / 2) ** 2 / 1)
    half = stats.t.ppf(0.975, freedom) * np.sqrt(variance)
    np.testing.assert_allclose([mean, low, high], [3.0, 3.0 - half, 3.0 + half], rtol=1e-12)
    assert interval(np.array([[0.7]])) == (0.7, 0.7, 0.7)


@pytest.mark.parametrize("shape", [(12, 1), (1, 12)])
def test_with_one_kind_of_sample_it_is_the_t_interval(shape):
    values = np.random.default_rng(4).normal(size=12)
    expected = stats.t.interval(0.95, 11, values.mean(), stats.sem(values))
    mean, low, high = interval(values.reshape(shape))
    np.testing.assert_allclose([mean, low, high], [values.mean(), *expected], rtol=1e-12)
