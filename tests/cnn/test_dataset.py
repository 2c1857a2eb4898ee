"""Training samples by numeric substitution (Eq. 8, Section IV-A), and torques beyond Eq. 1."""

from dataclasses import replace
from typing import get_args

import literal
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import seeds

from repro.cnn.dataset import (
    STRIBECK_VELOCITY,
    DataSettings,
    SampledMotion,
    UnmodelledSettings,
    draw_samples,
    draw_unmodelled,
    sample_motion,
    stack_motions,
)
from repro.cnn.image import ImageSettings
from repro.cnn.priors import GuessSettings, Prior
from repro.model.dynamics import LAMBDA, inverse_dynamics
from repro.signals.dct import SignalSettings, dct2low, dct2sub, image_regressor
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


@pytest.mark.parametrize(("label", "tolerance"), [("largest-torque", 2e-5), ("physical", 2e-3)])
@given(seeds, st.sampled_from(get_args(Prior)))
def test_guess_and_label_together_rebuild_the_torque_of_the_image(label, tolerance, seed, prior):
    """With physical labels its shape alone: the parameters are not in units of the largest torque."""
    samples = draw(seed, prior=prior, label=label, image=BARE, guess=FAR)
    alpha, psi = alpha_psi(samples)
    columns = SAMPLED.model.reshape(-1, 9)  # psi = 2 alpha - f(beta_n)
    guesses = np.linalg.lstsq(columns, (2 * alpha - psi).reshape(len(alpha), -1).T, rcond=None)[0].T
    rebuilt = np.einsum("jma,na->njm", SAMPLED.torque, guesses + samples.residual)
    largest = np.abs(rebuilt).max((1, 2), keepdims=True)
    np.testing.assert_allclose(rebuilt / (largest if label == "physical" else 1.0), alpha, rtol=0, atol=tolerance)
    assert (np.abs(np.log(largest)).max() > 0.1) == (label == "physical")


@given(seeds)
def test_right_guess_has_label_zero_and_psi_equal_to_alpha(seed):
    same = SampledMotion(SAMPLED.model, SAMPLED.model)  # a torque that f rebuilds without error
    samples = draw(seed, motion=same, image=BARE, guess=EXACT)
    alpha, psi = alpha_psi(samples)
    np.testing.assert_array_equal(samples.residual, 0.0)
    np.testing.assert_allclose(psi, alpha, rtol=0, atol=1e-6)


# Torques beyond Eq. 1, against sums that are written out.


PUBLISHED = SignalSettings()
PUBLISHED_MOTION = identification_trajectory(PUBLISHED.duration, PUBLISHED.h)
WITH_EFFECTS = sample_motion(PUBLISHED_MOTION, PUBLISHED, unmodelled=True)
BETA = np.array([[0.3, 0.02, 0.1, 0.9, 0.2, 0.1, 0.05, 0.4, 0.3], [0.6, 0.1, 0.2, 0.3, 0.4, 0.2, 0.1, 0.1, 0.2]])


class Fixed:
    """A generator whose uniform draws are their upper end, or a given phase."""

    def __init__(self, phase=0.0, which=0):
        self._phase, self._which = phase, which

    def uniform(self, low, high, size):
        return np.full(size, self._phase if high == 2 * np.pi else high)

    def integers(self, high, size):
        return np.full(size, self._which)

    def standard_normal(self, size):
        return np.ones(size)


def torque(settings, largest=1.0, **fixed):
    return draw_unmodelled(Fixed(**fixed), BETA, np.full((2, 1), largest), WITH_EFFECTS.unmodelled, settings)


def subsampled(x):
    return dct2sub(dct2low(x, PUBLISHED.h, PUBLISHED.c_f, PUBLISHED.omega_unit), PUBLISHED.samples)


def test_stribeck_friction_adds_to_coulomb_friction():
    fade = np.tanh(LAMBDA * PUBLISHED_MOTION.dq) - np.tanh(PUBLISHED_MOTION.dq / STRIBECK_VELOCITY)
    for arm, found in zip(BETA, torque(UnmodelledSettings(stribeck=0.3)), strict=True):
        np.testing.assert_allclose(found, subsampled(0.3 * arm[7:, np.newaxis] * fade), atol=1e-12)


@pytest.mark.parametrize(("which", "cycles"), [(0, 3), (3, 17), (5, 31)])
def test_a_ripple_turns_with_the_joint(which, cycles):
    found = torque(UnmodelledSettings(ripple=0.05), largest=2.0, phase=0.7, which=which)
    expected = subsampled(0.1 * np.sin(cycles * PUBLISHED_MOTION.q + 0.7))
    np.testing.assert_allclose(found, [expected, expected], atol=1e-12)


def test_a_late_torque_is_the_torque_of_a_moment_ago():
    late = 1e-3
    smooth = BETA * ([1.0] * 7 + [0.0] * 2)  # friction that jumps is not of first order
    found = draw_unmodelled(Fixed(), smooth, np.ones((2, 1)), WITH_EFFECTS.unmodelled, UnmodelledSettings(delay_s=late))
    before = identification_trajectory(PUBLISHED.duration, PUBLISHED.h / 10)  # to read it between samples
    t = np.maximum(PUBLISHED_MOTION.time - late, 0.0)
    for arm, change in zip(smooth, found, strict=True):
        fine = inverse_dynamics(before.q, before.dq, before.ddq, arm)
        shifted = np.stack([np.interp(t, before.time, joint) for joint in fine])
        now = inverse_dynamics(PUBLISHED_MOTION.q, PUBLISHED_MOTION.dq, PUBLISHED_MOTION.ddq, arm)
        error = change - subsampled(shifted - now)
        assert np.abs(error[:, 3:-3]).max() < 0.03 * np.abs(change).max()


def test_noise_is_a_share_of_the_largest_torque():
    rng = np.random.default_rng(0)
    levels = UnmodelledSettings(noise=0.02)
    found = np.stack(
        [draw_unmodelled(rng, BETA, np.array([[1.0], [3.0]]), WITH_EFFECTS.unmodelled, levels) for _ in range(3000)]
    )
    rms = np.sqrt((found**2).mean((0, 2, 3)))
    np.testing.assert_allclose(rms, 0.02 / np.sqrt(3) * np.array([1.0, 3.0]), rtol=0.05)  # uniform on 0 to 0.02


def test_nothing_beyond_changes_no_sample():
    bare = replace(WITH_EFFECTS, unmodelled=None)
    same = [draw_samples(np.random.default_rng(3), 16, each, DataSettings()) for each in (WITH_EFFECTS, bare)]
    np.testing.assert_array_equal(same[0].u, same[1].u)
    with pytest.raises(ValueError, match="unmodelled"):
        draw_samples(np.random.default_rng(3), 16, bare, DataSettings(unmodelled=UnmodelledSettings(0.1)))


def test_samples_of_many_motions_are_those_of_the_motion_they_drew():
    slow = identification_trajectory(PUBLISHED.duration, PUBLISHED.h)
    other = sample_motion(replace(slow, dq=0.5 * slow.dq, ddq=0.25 * slow.ddq), PUBLISHED, unmodelled=True)
    both = stack_motions([WITH_EFFECTS, other])
    levels = DataSettings(unmodelled=UnmodelledSettings(0.2, 0.05, 0.01, 1e-3))
    for data in (DataSettings(), levels):
        n = 64
        found = draw_samples(np.random.default_rng(1), n, both, data)
        # The same stream on a stack of one motion twice: equal where that motion was drawn.
        twice = (stack_motions([motion, motion]) for motion in (WITH_EFFECTS, other))
        first, second = (draw_samples(np.random.default_rng(1), n, each, data) for each in twice)
        of_first, of_second = ((found.u == each.u).all((1, 2, 3)) for each in (first, second))
        assert (of_first | of_second).all()
        assert 10 < of_first.sum() < n - 10


def test_one_model_for_all_motions():
    both = stack_motions([WITH_EFFECTS, WITH_EFFECTS], WITH_EFFECTS.model)
    measured = stack_motions([WITH_EFFECTS, WITH_EFFECTS])
    found, expected = (draw_samples(np.random.default_rng(5), 8, each, DataSettings()) for each in (both, measured))
    np.testing.assert_allclose(found.u, expected.u, atol=1e-6)
