"""Training samples by numeric substitution (Eq. 8, Section IV-A)."""

from dataclasses import replace
from typing import get_args

import literal
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import seeds

from repro.cnn.dataset import DataSettings, SampledMotion, draw_samples, sample_motion
from repro.cnn.image import ImageSettings
from repro.cnn.priors import GuessSettings, Prior
from repro.model.dynamics import inverse_dynamics
from repro.signals.dct import SignalSettings, image_regressor
from repro.signals.trajectories import identification_trajectory

# 471 samples over the published 3 pi s.
SIGNALS = SignalSettings(h=0.02, samples=60)
MOTION = identification_trajectory(SIGNALS.duration, SIGNALS.h)
SAMPLED = sample_motion(MOTION, SIGNALS)

#: With a divisor of 1 the factors are alpha and psi themselves.
BARE = ImageSettings("constant", 1.0)
EXACT = GuessSettings(exact_share=1.0, near_share=0.0)
FAR = GuessSettings(exact_share=0.0, near_share=0.0)


def draw(seed=0, n=8, motion=SAMPLED, **choices):
    return draw_samples(np.random.default_rng(seed), n, motion, DataSettings(**choices))


def alpha_psi(samples):
    """Signals of the samples, in double precision."""
    return samples.v[:, :, 0].astype(float), samples.u[:, :, 0].astype(float)


def guesses(samples, model):
    """Guesses that psi = 2 alpha - f(beta_n) was made with, read off the images."""
    alpha, psi = alpha_psi(samples)
    columns = model.reshape(-1, 9)
    return np.linalg.lstsq(columns, (2 * alpha - psi).reshape(len(alpha), -1).T, rcond=None)[0].T


@pytest.mark.parametrize("arm", literal.ARMS)
def test_torque_is_the_filtered_and_subsampled_inverse_dynamics(arm):
    tau = inverse_dynamics(MOTION.q, MOTION.dq, MOTION.ddq, literal.ARMS[arm])
    expected = literal.subsample(literal.low_pass(tau, SIGNALS.h, SIGNALS.c_f), SIGNALS.samples)
    found = SAMPLED.torque @ literal.ARMS[arm]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11)


@pytest.mark.parametrize("normalise", [False, True])
def test_model_is_equation_1_on_the_subsampled_motion(normalise):
    chosen = replace(SIGNALS, normalise_motion=normalise)
    motion = [literal.subsample(x, SIGNALS.samples) for x in (MOTION.q, MOTION.dq, MOTION.ddq)]
    if normalise:  # Eq. 8: every signal of every joint by its own maximum
        motion = [np.stack([row / max(row.max(), -row.min()) for row in x]) for x in motion]
    sampled = sample_motion(MOTION, chosen)
    for arm in literal.ARMS.values():
        np.testing.assert_allclose(sampled.model @ arm, inverse_dynamics(*motion, arm), rtol=0, atol=1e-11)
    np.testing.assert_array_equal(sampled.torque, SAMPLED.torque)  # the torque is always that of the real motion
    direct = image_regressor(MOTION.q, MOTION.dq, MOTION.ddq, chosen)
    np.testing.assert_array_equal(direct, sampled.model)


@given(seeds, st.sampled_from(get_args(Prior)))
def test_label_and_guess_together_are_the_arm_in_units_of_the_largest_torque(seed, prior):
    """Read the guess off the image, add the label: that set must rebuild the torque the image shows."""
    samples = draw(seed, prior=prior, image=BARE, guess=FAR)
    beta_bar = guesses(samples, SAMPLED.model) + samples.residual
    rebuilt = np.einsum("jma,na->njm", SAMPLED.torque, beta_bar)
    alpha, _ = alpha_psi(samples)
    np.testing.assert_allclose(rebuilt, alpha, rtol=0, atol=2e-5)


@given(seeds)
def test_with_physical_labels_a_sample_is_the_arm_itself(seed):
    """Guess and label add up to parameters whose torque has the shape of the image's, not its size."""
    samples = draw(seed, label="physical", image=BARE, guess=FAR)
    beta = guesses(samples, SAMPLED.model) + samples.residual
    rebuilt = np.einsum("jma,na->njm", SAMPLED.torque, beta)
    alpha, _ = alpha_psi(samples)
    largest = np.abs(rebuilt).max((1, 2), keepdims=True)
    np.testing.assert_allclose(rebuilt / largest, alpha, rtol=0, atol=2e-3)
    assert np.abs(np.log(largest)).max() > 0.1


@given(seeds)
def test_right_guess_has_label_zero_and_psi_equal_to_alpha(seed):
    same = SampledMotion(SAMPLED.model, SAMPLED.model)  # a torque that f rebuilds without error
    samples = draw(seed, motion=same, image=BARE, guess=EXACT)
    alpha, psi = alpha_psi(samples)
    np.testing.assert_array_equal(samples.residual, 0.0)
    np.testing.assert_allclose(psi, alpha, rtol=0, atol=1e-6)


def test_right_guess_is_only_near_alpha_on_the_published_trajectory():
    """Subsampling a torque and rebuilding it from a subsampled motion differ where tanh(20 dq) turns over."""
    signals = SignalSettings()
    sampled = sample_motion(identification_trajectory(signals.duration, signals.h), signals)
    samples = draw(0, 400, sampled, image=BARE, guess=EXACT)
    alpha, psi = alpha_psi(samples)
    np.testing.assert_array_equal(samples.residual, 0.0)
    worst = np.abs(psi - alpha).max((1, 2))
    assert 0.02 < np.median(worst) < 0.06
    assert worst.max() < 0.2
    smooth = SampledMotion(sampled.torque * ([1.0] * 7 + [0.0] * 2), sampled.model * ([1.0] * 7 + [0.0] * 2))
    alpha, psi = alpha_psi(draw(0, 400, smooth, image=BARE, guess=EXACT))
    assert np.abs(psi - alpha).max() < 0.02
