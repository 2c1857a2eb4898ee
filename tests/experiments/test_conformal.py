"""Spread over guesses, its calibration, and novel motions."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import seeds

from repro.experiments.coverage import MIN_WIDTH, distances, normalised_errors, spread_of, stretch_factors


def arms(n, seed):
    """Estimates that share an error as wide as their scatter, and the truth."""
    rng = np.random.default_rng(seed)
    truth = rng.uniform(0.1, 1.0, (n, 9))
    shared = truth + 0.05 * rng.standard_normal((n, 9))
    return shared[:, np.newaxis] + 0.05 * rng.standard_normal((n, 40, 9)), truth


def test_centre_and_width_are_median_and_central_range():
    estimates = np.linspace(0.0, 1.0, 101)[:, np.newaxis] * np.arange(1.0, 10.0)
    centre, width = spread_of(estimates)
    np.testing.assert_allclose(centre, 0.5 * np.arange(1.0, 10.0))
    np.testing.assert_allclose(width, 0.34 * np.arange(1.0, 10.0))
    assert (spread_of(np.ones((10, 9)))[1] == MIN_WIDTH).all()


@given(st.integers(20, 200), st.sampled_from([0.5, 0.8, 0.9]), seeds)
@settings(max_examples=30)
def test_the_share_of_calibration_arms_covered_is_the_promised_one_of_one_arm_more(n, level, seed):
    errors = normalised_errors(*arms(n, seed))
    np.testing.assert_array_equal((errors <= stretch_factors(errors, [level])).sum(axis=0), np.ceil(level * (n + 1)))


def test_too_few_arms_for_a_level_are_refused():
    with pytest.raises(ValueError, match=r"15 arms can calibrate shares of 0 to 0\.9375"):
        stretch_factors(normalised_errors(*arms(15, 0)), [0.95])


def test_a_motion_is_as_far_as_its_nearest_neighbour():
    base = np.random.default_rng(2).standard_normal((4, 2, 30, 9))
    motions = np.concatenate([base, base + 0.01 * base[:1], 5.0 * base[:1]])
    found = distances(motions)
    assert found[0] == pytest.approx(0.01)
    assert found[-1] == pytest.approx(np.sqrt(np.mean((5 - 1.01) ** 2)) / 5)
    np.testing.assert_allclose(distances(base[:1] * np.arange(1.0, 10.0), motions * np.arange(1.0, 10.0)), [0.0])
