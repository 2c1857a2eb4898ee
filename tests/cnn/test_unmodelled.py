"""Torques beyond Eq. 1: what each level adds, held against sums that are written out."""

from dataclasses import replace

import numpy as np
import pytest

from repro.cnn.dataset import (
    STRIBECK_VELOCITY,
    DataSettings,
    UnmodelledSettings,
    draw_samples,
    draw_unmodelled,
    sample_motion,
    stack_motions,
)
from repro.model.dynamics import LAMBDA, inverse_dynamics
from repro.signals.dct import SignalSettings, dct2low, dct2sub
from repro.signals.trajectories import identification_trajectory

SIGNALS = SignalSettings()
MOTION = identification_trajectory(SIGNALS.duration, SIGNALS.h)
SAMPLED = sample_motion(MOTION, SIGNALS, unmodelled=True)
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
    return draw_unmodelled(Fixed(**fixed), BETA, np.full((2, 1), largest), SAMPLED.unmodelled, settings)


def subsampled(x):
    return dct2sub(dct2low(x, SIGNALS.h, SIGNALS.c_f, SIGNALS.omega_unit), SIGNALS.samples)


def test_stribeck_friction_adds_to_coulomb_friction():
    fade = np.tanh(LAMBDA * MOTION.dq) - np.tanh(MOTION.dq / STRIBECK_VELOCITY)
    for arm, found in zip(BETA, torque(UnmodelledSettings(stribeck=0.3)), strict=True):
        np.testing.assert_allclose(found, subsampled(0.3 * arm[7:, np.newaxis] * fade), atol=1e-12)


@pytest.mark.parametrize(("which", "cycles"), [(0, 3), (3, 17), (5, 31)])
def test_a_ripple_turns_with_the_joint(which, cycles):
    found = torque(UnmodelledSettings(ripple=0.05), largest=2.0, phase=0.7, which=which)
    expected = subsampled(0.1 * np.sin(cycles * MOTION.q + 0.7))
    np.testing.assert_allclose(found, [expected, expected], atol=1e-12)


def test_a_late_torque_is_the_torque_of_a_moment_ago():
    late = 1e-3
    smooth = BETA * ([1.0] * 7 + [0.0] * 2)  # friction that jumps is not of first order
    found = draw_unmodelled(Fixed(), smooth, np.ones((2, 1)), SAMPLED.unmodelled, UnmodelledSettings(delay_s=late))
    before = identification_trajectory(SIGNALS.duration, SIGNALS.h / 10)  # to read it between samples
    t = np.maximum(MOTION.time - late, 0.0)
    for arm, change in zip(smooth, found, strict=True):
        fine = inverse_dynamics(before.q, before.dq, before.ddq, arm)
        shifted = np.stack([np.interp(t, before.time, joint) for joint in fine])
        now = inverse_dynamics(MOTION.q, MOTION.dq, MOTION.ddq, arm)
        error = change - subsampled(shifted - now)
        assert np.abs(error[:, 3:-3]).max() < 0.03 * np.abs(change).max()


def test_noise_is_a_share_of_the_largest_torque():
    rng = np.random.default_rng(0)
    levels = UnmodelledSettings(noise=0.02)
    found = np.stack(
        [draw_unmodelled(rng, BETA, np.array([[1.0], [3.0]]), SAMPLED.unmodelled, levels) for _ in range(3000)]
    )
    rms = np.sqrt((found**2).mean((0, 2, 3)))
    np.testing.assert_allclose(rms, 0.02 / np.sqrt(3) * np.array([1.0, 3.0]), rtol=0.05)  # uniform on 0 to 0.02


def test_nothing_beyond_changes_no_sample():
    bare = replace(SAMPLED, unmodelled=None)
    same = [draw_samples(np.random.default_rng(3), 16, each, DataSettings()) for each in (SAMPLED, bare)]
    np.testing.assert_array_equal(same[0].u, same[1].u)
    with pytest.raises(ValueError, match="unmodelled"):
        draw_samples(np.random.default_rng(3), 16, bare, DataSettings(unmodelled=UnmodelledSettings(0.1)))


def test_samples_of_many_motions_are_those_of_the_motion_they_drew():
    slow = identification_trajectory(SIGNALS.duration, SIGNALS.h)
    other = sample_motion(replace(slow, dq=0.5 * slow.dq, ddq=0.25 * slow.ddq), SIGNALS, unmodelled=True)
    both = stack_motions([SAMPLED, other])
    levels = DataSettings(unmodelled=UnmodelledSettings(0.2, 0.05, 0.01, 1e-3))
    for data in (DataSettings(), levels):
        n = 64
        found = draw_samples(np.random.default_rng(1), n, both, data)
        # The same stream on a stack of one motion twice: equal where that motion was drawn.
        twice = (stack_motions([motion, motion]) for motion in (SAMPLED, other))
        first, second = (draw_samples(np.random.default_rng(1), n, each, data) for each in twice)
        of_first, of_second = ((found.u == each.u).all((1, 2, 3)) for each in (first, second))
        assert (of_first | of_second).all()
        assert 10 < of_first.sum() < n - 10


def test_one_model_for_all_motions():
    both = stack_motions([SAMPLED, SAMPLED], SAMPLED.model)
    measured = stack_motions([SAMPLED, SAMPLED])
    found, expected = (draw_samples(np.random.default_rng(5), 8, each, DataSettings()) for each in (both, measured))
    np.testing.assert_allclose(found.u, expected.u, atol=1e-6)
