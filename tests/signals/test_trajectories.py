"""The identification trajectory (Eq. 10) and random validation trajectories."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import seeds

from repro.signals.dct import spectrum
from repro.signals.trajectories import identification_trajectory, random_trajectory, sample_times

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


@given(stretch=st.floats(0.1, 10.0))
def test_time_scaling_keeps_the_shape(stretch):
    base = identification_trajectory()
    slow = identification_trajectory(stretch * 3.0 * np.pi, stretch * H)
    np.testing.assert_allclose(slow.time, stretch * base.time, rtol=1e-13)
    np.testing.assert_allclose(slow.q, base.q, rtol=0, atol=1e-12)
    np.testing.assert_allclose(stretch * slow.dq, base.dq, rtol=0, atol=1e-12)
    np.testing.assert_allclose(stretch**2 * slow.ddq, base.ddq, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("duration", "h", "count"), [(3.0 * np.pi, H, 3770), (20.48, H, 8192), (1.0, 0.4, 2), (1.0, 0.3, 3), (1.0, 0.5, 2)]
)
def test_sample_times_start_at_zero_and_step_by_h(duration, h, count):
    t = sample_times(duration, h)
    assert t.shape == (count,)
    assert t[0] == 0.0
    np.testing.assert_allclose(np.diff(t), h, rtol=1e-9)


def test_margin_continues_the_trajectory_on_both_sides():
    bare, wide = identification_trajectory(5.0), identification_trajectory(5.0, margin=40)
    assert wide.time.size == bare.time.size + 80
    for name in ("time", "q", "dq", "ddq"):
        np.testing.assert_allclose(getattr(wide, name)[..., 40:-40], getattr(bare, name), rtol=0, atol=1e-13)
    np.testing.assert_allclose(np.diff(wide.time), H, rtol=1e-9)
    # The derivatives hold across both joins and to the ends.
    np.testing.assert_allclose(central_difference(wide.q, H), wide.dq[:, 4:-4], rtol=0, atol=1e-10)
    np.testing.assert_allclose(central_difference(wide.dq, H), wide.ddq[:, 4:-4], rtol=0, atol=1e-10)


def test_negative_margin_is_refused():
    with pytest.raises(ValueError, match=r"^margin: must not be negative, got -1"):
        identification_trajectory(margin=-1)


@pytest.mark.parametrize("make", [sample_times, identification_trajectory])
@pytest.mark.parametrize(("duration", "h"), [(0.0, H), (H, H), (-1.0, H)])
def test_too_few_samples_are_refused(make, duration, h):
    with pytest.raises(ValueError, match=r"^duration: .*fewer than two samples"):
        make(duration, h)


@pytest.mark.parametrize(
    ("duration", "h", "name"), [(1.0, 0.0, "h"), (1.0, -H, "h"), (np.nan, H, "duration"), (np.inf, H, "duration")]
)
def test_durations_that_are_no_durations_are_refused(duration, h, name):
    with pytest.raises(ValueError, match=rf"^{name}: "):
        sample_times(duration, h)


def make_random(seed, low=0.0, high=1.0, unit="rad_per_s", c_f=1e-3, duration=5.0):
    return random_trajectory(np.random.default_rng(seed), duration, H, c_f, unit, low, high)


def test_random_trajectory_repeats_with_its_seed():
    one, again, other = make_random(7), make_random(7), make_random(8)
    for name in ("time", "q", "dq", "ddq"):
        np.testing.assert_array_equal(getattr(one, name), getattr(again, name))
    assert not np.allclose(one.q, other.q, atol=1e-3)


@pytest.mark.parametrize(
    ("unit", "c_f", "cut"),
    # omega = 4 / sqrt(c_f), where the Gaussian is exp(-16), as a band number k of N = 2000 samples.
    [
        ("rad_per_s", 1e-3, 4 / np.sqrt(1e-3) * 5.0 / np.pi),
        ("hertz", 0.1, 4 / np.sqrt(0.1) * 10.0),
        ("index", 1e-2, 40.0),
    ],
)
def test_random_trajectory_is_band_limited(unit, c_f, cut):
    bands = np.abs(spectrum(make_random(3, unit=unit, c_f=c_f).q))
    cut = int(np.ceil(cut))
    assert cut < 1900
    noise = 1.0 / np.sqrt(12.0)  # spread of the uniform numbers, the same in every band
    assert (bands[:, cut:] < 5.0 * noise * np.exp(-16.0)).all()
    assert (bands[:, 1 : cut // 8].std(-1) > 0.3 * noise).all()  # and what should pass does


@given(seed=seeds, low=st.floats(-2.0, 0.0), span=st.floats(0.1, 3.0))
def test_random_trajectory_stays_in_its_range_around_the_middle(seed, low, span):
    # The Gaussian low-pass averages with positive weights, so it cannot leave the range of the numbers.
    motion = make_random(seed, low, low + span)
    assert motion.q.min() >= low
    assert motion.q.max() <= low + span
    # Mean of 2000 uniform numbers: six standard errors.
    assert (abs(motion.q.mean(-1) - (low + 0.5 * span)) < 6.0 * span / np.sqrt(12.0 * 2000)).all()


def test_random_trajectory_derivatives_are_those_of_its_position():
    motion = make_random(11, c_f=1e-2)
    # Each backward difference sits half a sample early: the velocity by one half, the acceleration by one.
    middle = 0.5 * (motion.dq[:, 1:] + motion.dq[:, :-1])
    slope = central_difference(motion.q, H)
    np.testing.assert_allclose(middle[:, 4:-3], slope, rtol=0, atol=1e-3 * np.abs(slope).max())
    bend = central_difference(slope, H)
    np.testing.assert_allclose(motion.ddq[:, 9:-7], bend, rtol=0, atol=1e-3 * np.abs(bend).max())


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"c_f": -1.0}, "c_f"),
        ({"unit": "octave"}, "unit"),
        ({"duration": H}, "duration"),
        ({"low": 1.0, "high": 0.0}, "(low|high)"),
        pytest.param({"high": np.nan}, "high"),
    ],
)
def test_broken_arguments_are_named(change, name):
    with pytest.raises(ValueError, match=rf"^{name}\b"):
        make_random(0, **change)
