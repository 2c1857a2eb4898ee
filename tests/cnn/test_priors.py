"""Where training arms and guesses come from (Section IV-A)."""

from typing import get_args

import literal
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import seeds

from repro.cnn.priors import GuessSettings, Prior, sample_beta, training_guess
from repro.model.parameters import STANDARD_GRAVITY, is_positive_definite

I1, I2, I3, G1, G2 = range(5)
FRICTION = slice(5, 9)
MANY = 20_000


def arms(prior, n=MANY, seed=0):
    return sample_beta(np.random.default_rng(seed), n, prior)


@given(seeds, st.sampled_from(get_args(Prior)), st.integers(0, 50))
def test_arms_are_positive_and_of_the_size_asked_for(seed, prior, n):
    beta = arms(prior, n, seed)
    assert beta.shape == (n, 9)
    assert ((beta > 0.0) & (beta < np.inf)).all()


@pytest.mark.parametrize(("prior", "median"), [("uniform", 0.5005), ("log-uniform", np.sqrt(1e-3))])
def test_simple_priors_fill_their_range_independently(prior, median):
    beta = arms(prior)
    assert 1e-3 <= beta.min() < beta.max() <= 1.0
    assert beta.min(0).max() < 1.5e-3
    assert beta.max(0).min() > 0.995
    np.testing.assert_allclose(np.median(beta, 0), median, rtol=0.06)
    assert np.abs(np.corrcoef(beta.T) - np.eye(9)).max() < 0.04


def test_link_prior_gives_arms_that_could_be_built():
    beta = arms("links")
    assert is_positive_definite(beta).all()
    # I2 = 2 m2 l1 lc2 and g2 = m2 lc2 g, so both tell l1; then g1 - m2 l1 g leaves m1 lc1 g, also positive.
    l1 = 0.5 * beta[:, I2] / beta[:, G2] * STANDARD_GRAVITY
    assert 0.05 <= l1.min() < 0.06
    assert 0.55 < l1.max() <= 0.6
    # I3 g / g2 = lc2 + J2 / (m2 lc2) is a length of link 2, which is drawn apart from link 1.
    length2 = beta[:, I3] / beta[:, G2] * STANDARD_GRAVITY
    assert abs(np.corrcoef(np.log(l1), np.log(length2))[0, 1]) < 0.04
    # A mass at least that far out is needed for the coupling: I3 > m2 lc2^2 and m2 <= 3.
    assert (beta[:, I3] > (beta[:, G2] / STANDARD_GRAVITY) ** 2 / 3.0).all()
    assert 1e-3 <= beta[:, FRICTION].min() < beta[:, FRICTION].max() <= 1.0


def test_published_ranges_cannot_reach_the_published_arms():
    beta = arms("published")
    assert 0.5 * 0.02 < beta[:, I2].max() <= 2 * 1.0 * 0.1 * 0.1  # 2 m2 l1 lc2 at the upper end of every range
    assert min(arm[I2] for arm in literal.ARMS.values()) > 20 * 0.02
    # Lever arms of 0.1 m and masses of 1 kg bound the gravity loads too.
    assert beta[:, G2].max() <= 0.1 * STANDARD_GRAVITY
    assert beta[:, G1].max() <= 0.2 * STANDARD_GRAVITY
    assert beta[:, I3].max() <= 1.0 * 0.01 + 1.0
    assert 1e-3 <= beta[:, FRICTION].min() < beta[:, FRICTION].max() <= 1.0
    np.testing.assert_allclose(np.median(beta[:, FRICTION], 0), 0.5, atol=0.02)


def test_training_guesses_are_exact_near_and_uniform_in_the_chosen_shares():
    chosen = GuessSettings(exact_share=0.3, near_share=0.5, near_low=1e-6, near_high=1e-4)
    right = arms("uniform", MANY, 5)
    guess = training_guess(np.random.default_rng(0), right, chosen)
    miss = np.abs(guess - right).max(1)
    exact, near = miss == 0, (miss > 0) & (miss < 1e-3)
    assert [exact.mean(), near.mean()] == pytest.approx([0.3, 0.5], abs=0.015)
    far = guess[~exact & ~near]
    assert 1e-3 <= far.min() <= far.max() <= 3.0
    np.testing.assert_allclose(far.mean(0), 1.5005, atol=0.06)
    # The size of a near miss is log-uniform: on the logarithmic axis half lie below the geometric mean. The
    # largest of nine normal errors is about 1.9 sizes.
    assert np.median(miss[near]) == pytest.approx(1.9e-5, rel=0.15)


def test_near_guesses_stay_above_the_smallest_guess():
    guess = training_guess(np.random.default_rng(6), np.full((5000, 9), 2e-3), GuessSettings(0.001, 3.0, 0.0, 1.0))
    assert guess.min() == 1e-3
