"""Training samples by numeric substitution (Eq. 8, Section IV-A), and torques beyond Eq. 1."""

from dataclasses import replace
from types import SimpleNamespace
from typing import get_args

import literal
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import seeds

from repro.cnn import dataset
from repro.cnn.dataset import DataSettings, UnmodelledSettings, draw_unmodelled, sample_motion, stack_motions
from repro.cnn.image import ImageSettings
from repro.cnn.priors import Prior
from repro.model.dynamics import LAMBDA, inverse_dynamics
from repro.signals.dct import SignalSettings, image_regressor
from repro.signals.trajectories import identification_trajectory

# 471 samples over the published 3 pi s.
SIGNALS = SignalSettings(sampling_period_s=0.02, image_samples=60)
MOTION = identification_trajectory(SIGNALS.duration_s, SIGNALS.sampling_period_s)
SAMPLED = sample_motion(MOTION, SIGNALS, unmodelled=True)

#: With a divisor of 1 the factors are alpha and psi themselves.
BARE = ImageSettings("constant", 1.0)
EXACT, FAR = ({"exact_share": share, "near_share": 0.0} for share in (1.0, 0.0))


def draw(seed=0, n=8, motion=SAMPLED, **choices):
    return dataset.draw_samples(np.random.default_rng(seed), n, motion, DataSettings(**choices))


def alpha_psi(samples):
    """Signals of the samples, in double precision."""
    return samples.v[:, :, 0].astype(float), samples.u[:, :, 0].astype(float)


@pytest.mark.parametrize("arm", literal.ARMS)
def test_torque_is_the_filtered_and_subsampled_inverse_dynamics(arm):
    tau = inverse_dynamics(MOTION.q, MOTION.dq, MOTION.ddq, literal.ARMS[arm])
    expected = literal.subsample(
        literal.low_pass(tau, SIGNALS.sampling_period_s, SIGNALS.filter_coefficient), SIGNALS.image_samples
    )
    found = SAMPLED.torque @ literal.ARMS[arm]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11)


@pytest.mark.parametrize("normalise", [False, True])
def test_model_is_equation_1_on_the_subsampled_motion(normalise):
    chosen = replace(SIGNALS, normalise_motion=normalise)
    motion = [literal.subsample(x, SIGNALS.image_samples) for x in (MOTION.q, MOTION.dq, MOTION.ddq)]
    if normalise:  # Eq. 8: every signal of every joint by its own maximum
        motion = [np.stack([row / max(row.max(), -row.min()) for row in x]) for x in motion]
    sampled = sample_motion(MOTION, chosen)
    for arm in literal.ARMS.values():
        np.testing.assert_allclose(sampled.model @ arm, inverse_dynamics(*motion, arm), rtol=0, atol=1e-11)
    np.testing.assert_array_equal(sampled.torque, SAMPLED.torque)  # the torque is always that of the real motion
    np.testing.assert_array_equal(image_regressor(MOTION.q, MOTION.dq, MOTION.ddq, chosen), sampled.model)


@pytest.mark.parametrize(("label", "tolerance"), [("largest-torque", 2e-5), ("physical", 2e-3)])
@given(seeds, st.sampled_from(get_args(Prior)))
def test_guess_and_label_together_rebuild_the_torque_of_the_image(label, tolerance, seed, prior):
    """With physical labels its shape alone: the parameters are not in units of the largest torque."""
    samples = draw(seed, prior=prior, label=label, image=BARE, **FAR)
    alpha, psi = alpha_psi(samples)
    columns = SAMPLED.model.reshape(-1, 9)  # psi = 2 alpha - f(beta_n)
    guesses = np.linalg.lstsq(columns, (2 * alpha - psi).reshape(len(alpha), -1).T, rcond=None)[0].T
    rebuilt = np.einsum("jma,na->njm", SAMPLED.torque, guesses + samples.residual)
    largest = np.abs(rebuilt).max((1, 2), keepdims=True)
    np.testing.assert_allclose(rebuilt / (largest if label == "physical" else 1.0), alpha, rtol=0, atol=tolerance)
    assert (np.abs(np.log(largest)).max() > 0.1) == (label == "physical")


@given(seeds)
def test_right_guess_has_label_zero_and_psi_equal_to_alpha(seed):
    same = dataset.SampledMotion(SAMPLED.model, SAMPLED.model)  # a torque that f rebuilds without error
    samples = draw(seed, motion=same, image=BARE, **EXACT)
    alpha, psi = alpha_psi(samples)
    np.testing.assert_array_equal(samples.residual, 0.0)
    np.testing.assert_allclose(psi, alpha, rtol=0, atol=1e-6)


BETA = np.array([[0.3, 0.02, 0.1, 0.9, 0.2, 0.1, 0.05, 0.4, 0.3], [0.6, 0.1, 0.2, 0.3, 0.4, 0.2, 0.1, 0.1, 0.2]])


def torque(settings, motion=SAMPLED, beta=BETA, largest=1.0, phase=0.0, which=0):
    """Draws are the upper end of their range, but for phase and number of the ripple."""
    drawn = SimpleNamespace(
        uniform=lambda low, high, size: np.full(size, phase if high == 2 * np.pi else high),
        integers=lambda high, size: np.full(size, which),
        standard_normal=np.ones,
    )
    return draw_unmodelled(drawn, beta, np.full((2, 1), largest), motion.unmodelled, settings)


def subsampled(x, signals=SIGNALS):
    return literal.subsample(
        literal.low_pass(x, signals.sampling_period_s, signals.filter_coefficient), signals.image_samples
    )


def test_stribeck_friction_adds_to_coulomb_friction():
    fade = np.tanh(LAMBDA * MOTION.dq) - np.tanh(MOTION.dq / dataset.STRIBECK_VELOCITY)
    for arm, found in zip(BETA, torque(UnmodelledSettings(stribeck=0.3)), strict=True):
        np.testing.assert_allclose(found, subsampled(0.3 * arm[7:, np.newaxis] * fade), atol=1e-12)


@pytest.mark.parametrize(("which", "cycles"), [(0, 3), (3, 17), (5, 31)])
def test_a_ripple_turns_with_the_joint(which, cycles):
    found = torque(UnmodelledSettings(ripple=0.05), largest=2.0, phase=0.7, which=which)
    expected = subsampled(0.1 * np.sin(cycles * MOTION.q + 0.7))
    np.testing.assert_allclose(found, [expected, expected], atol=1e-12)


def test_a_late_torque_is_the_torque_of_a_moment_ago():
    late, signals = 1e-3, replace(SIGNALS, h=4e-3)
    now, fine = (
        identification_trajectory(signals.duration_s, h)
        for h in (signals.sampling_period_s, signals.sampling_period_s / 10)
    )
    smooth = BETA * ([1.0] * 7 + [0.0] * 2)  # friction that jumps is not of first order
    changes = torque(UnmodelledSettings(delay_s=late), sample_motion(now, signals, unmodelled=True), smooth)
    for arm, change in zip(smooth, changes, strict=True):
        tau, between = (inverse_dynamics(motion.q, motion.dq, motion.ddq, arm) for motion in (now, fine))
        shifted = np.stack([np.interp(np.maximum(now.time - late, 0.0), fine.time, joint) for joint in between])
        error = change - subsampled(shifted - tau, signals)
        assert np.abs(error[:, 3:-3]).max() < 0.03 * np.abs(change).max()


def test_noise_is_a_share_of_the_largest_torque():
    beta, largest = np.repeat(BETA, 3000, axis=0), np.repeat([[1.0], [3.0]], 3000, axis=0)
    levels = UnmodelledSettings(noise=0.02)
    found = draw_unmodelled(np.random.default_rng(0), beta, largest, SAMPLED.unmodelled, levels)
    rms = np.sqrt((found.reshape(2, 3000, -1) ** 2).mean((1, 2)))
    np.testing.assert_allclose(rms, 0.02 / np.sqrt(3) * np.array([1.0, 3.0]), rtol=0.05)  # uniform on 0 to 0.02


def test_nothing_beyond_changes_no_sample():
    bare = replace(SAMPLED, unmodelled=None)
    np.testing.assert_array_equal(draw(3, 16, SAMPLED).u, draw(3, 16, bare).u)
    with pytest.raises(ValueError, match="unmodelled"):
        draw(3, 16, bare, unmodelled=UnmodelledSettings(0.1))


@pytest.mark.parametrize("levels", [UnmodelledSettings(), UnmodelledSettings(0.2, 0.05, 0.01, 1e-3)])
def test_samples_of_many_motions_are_those_of_the_motion_they_drew(levels):
    slow = replace(MOTION, dq=0.5 * MOTION.dq, ddq=0.25 * MOTION.ddq)
    motions = (SAMPLED, sample_motion(slow, SIGNALS, unmodelled=True))
    found = draw(1, 64, stack_motions(motions), unmodelled=levels)
    # The same stream on a stack of one motion twice: equal where that motion was drawn.
    twice = (draw(1, 64, stack_motions([motion, motion]), unmodelled=levels) for motion in motions)
    of_first, of_second = ((found.u == each.u).all((1, 2, 3)) for each in twice)
    assert (of_first | of_second).all()
    assert 10 < of_first.sum() < 54


def test_one_model_for_all_motions():
    other = replace(SAMPLED, model=2.0 * SAMPLED.model)
    found, expected = stack_motions([SAMPLED, other], SAMPLED.model), stack_motions([SAMPLED, SAMPLED])
    np.testing.assert_allclose(draw(5, 8, found).u, draw(5, 8, expected).u, atol=1e-6)
