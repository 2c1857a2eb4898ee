"""The identification trajectory (Eq. 10) and random validation trajectories."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import seeds

from repro.signals.trajectories import identification_trajectory, random_trajectory

H = 2.5e-3

# Weights of the eighth-order central difference, offsets -4 to 4.
STENCIL = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0.0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])


def central_difference(x, h):
    """Derivative of x at its inner samples, shape (..., N - 8)."""
    windows = np.lib.stride_tricks.sliding_window_view(x, 9, axis=-1)
    return windows @ STENCIL / h


def test_identification_trajectory_is_eq10():
    motion = identification_trajectory()
    t = np.arange(3770) * 0.0025
    np.testing.assert_allclose(motion.time, t, rtol=1e-15)
    np.testing.assert_allclose(motion.q[0], np.sin(t) + 0.1 * np.cos(2.5 * t + 3.0), rtol=0, atol=1e-13)
    np.testing.assert_allclose(motion.q[1], -np.cos(t) - 0.1 * np.sin(2.5 * t + 3.0), rtol=0, atol=1e-13)


@pytest.mark.parametrize(("duration", "h"), [(3.0 * np.pi, H), (20.48, H), (5.0, 1e-3)])
def test_derivatives_are_exact(duration, h):
    motion = identification_trajectory(duration, h)
    inner = slice(4, -4)
    np.testing.assert_allclose(central_difference(motion.q, h), motion.dq[:, inner], rtol=0, atol=1e-10)
    np.testing.assert_allclose(central_difference(motion.dq, h), motion.ddq[:, inner], rtol=0, atol=1e-10)


def test_margin_continues_the_trajectory_on_both_sides():
    bare, wide = identification_trajectory(5.0), identification_trajectory(5.0, margin=40)
    assert wide.time.size == bare.time.size + 80
    for name in ("time", "q", "dq", "ddq"):
        np.testing.assert_allclose(getattr(wide, name)[..., 40:-40], getattr(bare, name), rtol=0, atol=1e-13)
    np.testing.assert_allclose(np.diff(wide.time), H, rtol=1e-9)
    # The derivatives hold across both joins and to the ends.
    np.testing.assert_allclose(central_difference(wide.q, H), wide.dq[:, 4:-4], rtol=0, atol=1e-10)
    np.testing.assert_allclose(central_difference(wide.dq, H), wide.ddq[:, 4:-4], rtol=0, atol=1e-10)


def make_random(seed, low=0.0, high=1.0, c_f=1e-3):
    return random_trajectory(np.random.default_rng(seed), 5.0, H, c_f, "rad_per_s", (low, high))


@given(seed=seeds, low=st.floats(-2.0, 0.0), span=st.floats(0.1, 3.0))
def test_random_trajectory_stays_in_its_range_around_the_middle(seed, low, span):
    # The Gaussian low-pass averages with positive weights, so it cannot leave the range of the numbers.
    motion = make_random(seed, low, low + span)
    assert motion.q.min() >= low
    assert motion.q.max() <= low + span
    # Mean of 2000 uniform numbers: six standard errors.
    assert (abs(motion.q.mean(-1) - (low + 0.5 * span)) < 6.0 * span / np.sqrt(12.0 * 2000)).all()
