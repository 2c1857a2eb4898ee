"""Spread over guesses, its calibration, and novel motions."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from repro.identification.algorithm1.conformal import (
    MIN_WIDTH,
    distances,
    normalised_errors,
    spread_of,
    stretch_factors,
)


def arms(rng, n, bias=0.5, guesses=40):
    """Estimates that share an error half again as wide as their scatter, and the truth."""
    truth = rng.uniform(0.1, 1.0, (n, 9))
    shared = truth + bias * 0.1 * rng.standard_normal((n, 9))
    return shared[:, np.newaxis] + 0.05 * rng.standard_normal((n, guesses, 9)), truth


def covered(errors, factors):
    """Share (levels, 9) of arms whose parameter lies within centre +- factor x width."""
    return (errors <= factors[:, np.newaxis]).mean(axis=1)


def test_centre_and_width_are_median_and_central_range():
    estimates = np.linspace(0.0, 1.0, 101)[:, np.newaxis] * np.arange(1.0, 10.0)
    centre, width = spread_of(estimates)
    np.testing.assert_allclose(centre, 0.5 * np.arange(1.0, 10.0))
    np.testing.assert_allclose(width, 0.34 * np.arange(1.0, 10.0))
    assert (spread_of(np.ones((10, 9)))[1] == MIN_WIDTH).all()


@pytest.mark.parametrize("bias", [0.0, 1.0, 4.0])
def test_calibrated_intervals_cover_arms_drawn_alike_whatever_the_network(bias):
    rng = np.random.default_rng(1)
    levels = (0.5, 0.9, 0.95)
    known, truth = arms(rng, 400, bias)
    factors = stretch_factors(normalised_errors(known, truth), levels)
    share = covered(normalised_errors(*arms(rng, 4000, bias)), factors)
    for row, level in zip(share, levels, strict=True):
        # 400 arms calibrate a share to about sqrt(p (1 - p) / 400).
        assert np.abs(row.mean() - level) < 2 * np.sqrt(level * (1 - level) / 400)


@given(st.integers(20, 200), st.sampled_from([0.5, 0.8, 0.9]), st.integers(0, 2**32 - 1))
@settings(max_examples=30)
def test_the_calibration_arms_themselves_are_covered_as_promised(n, level, seed):
    errors = normalised_errors(*arms(np.random.default_rng(seed), n))
    share = covered(errors, stretch_factors(errors, [level]))
    assert (share >= level).all()
    assert (share <= level + 2 / n).all()


def test_too_few_arms_for_a_level_are_refused():
    errors = normalised_errors(*arms(np.random.default_rng(0), 15))
    with pytest.raises(ValueError, match=r"15 arms can calibrate shares of 0 to 0\.9375"):
        stretch_factors(errors, [0.95])


def test_a_motion_is_as_far_as_its_nearest_neighbour():
    base = np.random.default_rng(2).standard_normal((4, 2, 30, 9))
    motions = np.concatenate([base, base + 0.01 * base[:1], 5.0 * base[:1]])
    found = distances(motions)
    assert found[0] == pytest.approx(0.01)
    assert found[-1] == pytest.approx(np.sqrt(np.mean((5 - 1.01) ** 2)) / 5)
    np.testing.assert_allclose(distances(base[:1] * np.arange(1.0, 10.0), motions * np.arange(1.0, 10.0)), [0.0])
