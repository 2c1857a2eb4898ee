"""Trajectories, desired motions of the five recordings, and the limits they must keep."""

from dataclasses import replace

import numpy as np
import pytest
from experiment_example import refused
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.fft import dct, idct
from strategies import seeds

from repro.model.dynamics import ArmGeometry, forward_kinematics, inverse_dynamics
from repro.signals import programs, validation_motions
from repro.signals.programs import check_limits, identification_reference, peaks, reference_trajectory
from repro.signals.trajectories import identification_trajectory, quintic, random_trajectory

H = 2.5e-3
ARM = np.array([0.12, 0.0026375, 0.0227235, 0.95, 0.07838, 0.08, 0.00361, 0.4538, 0.31])
GEOMETRY = ArmGeometry(0.165, 0.150)
SETTINGS = programs.TrajectorySettings()
# Torque of each joint at full PWM (N m) and speed (rad/s) of the board (Section III, V-C).
TORQUE_LIMIT, SPEED_LIMIT = (2.7192, 2.7314), 8.0
LIMITS = (TORQUE_LIMIT, SPEED_LIMIT)


def rng(seed=1):
    return np.random.default_rng(seed)


MOTIONS = {
    "T1": validation_motions.random_motion(rng(), validation_motions.RandomMotion(), H),
    "T2": validation_motions.circle_motion(validation_motions.Circle(), GEOMETRY, H),
    "T3": validation_motions.profile_motion(validation_motions.Profile(), H),
    "T4": validation_motions.sinusoidal_motion(validation_motions.Sinusoid(), H),
}


states = st.lists(st.floats(-3.0, 3.0), min_size=6, max_size=6).map(lambda v: np.reshape(v, (3, 2)))


@pytest.mark.slow
@given(start=states, end=states, duration=st.floats(0.1, 10.0))
def test_quintic_meets_both_states(start, end, duration):
    """Fit a fifth-degree polynomial through samples, and read its ends."""
    t = np.linspace(0.0, duration, 30)
    for joint, positions in enumerate(quintic(t, duration, start, end)):
        p = np.polynomial.Polynomial.fit(t, positions, 5)
        for k in range(3):
            scale = np.abs([start, end]).max() * max(duration, 1 / duration) ** 2 + 1
            np.testing.assert_allclose(p.deriv(k)(0.0), start[k, joint], rtol=0, atol=1e-8 * scale)
            np.testing.assert_allclose(p.deriv(k)(duration), end[k, joint], rtol=0, atol=1e-8 * scale)


@pytest.mark.parametrize("name", MOTIONS)
def test_motions_last_the_whole_memory_from_rest_to_rest_with_derivatives_that_belong_to_them(name):
    motion = MOTIONS[name]
    assert motion.q.shape == motion.dq.shape == motion.ddq.shape == (2, 8192)
    assert motion.time[-1] == pytest.approx(8191 * H)
    np.testing.assert_allclose(motion.q[:, [0, -1]], 0.0, atol=1e-12)
    assert np.abs(motion.dq[:, [0, -1]]).max() < 0.01
    for x, dx in ((motion.q, motion.dq), (motion.dq, motion.ddq)):
        np.testing.assert_allclose(x[:, :1] + np.cumsum(dx[:, 1:], axis=1) * H, x[:, 1:], rtol=0, atol=1e-10)


@pytest.mark.parametrize(("bands", "limit"), [(5.0, 1.2), (12.0, 1.2), (12.0, 0.3), (100.0, 1.2)])
def test_random_motion_of_a_range_reaches_it_before_the_window(bands, limit):
    motion = validation_motions.random_motion(rng(5), validation_motions.RandomMotion(8192, bands, limit), H)
    gains = np.exp(-((np.arange(8192.0) / bands) ** 2))  # Eq. 14 at each band of the DCT-II
    filtered = idct(dct(rng(5).uniform(-1.2, 1.2, (2, 8192)), norm="ortho") * gains, norm="ortho")
    scaled = limit * filtered / np.abs(filtered).max(axis=1, keepdims=True)
    window = validation_motions.start_and_end_window(motion.time)
    np.testing.assert_allclose(motion.q, scaled * window, rtol=0, atol=1e-12)


def test_circle_is_a_tenth_of_the_reach():
    motion = MOTIONS["T2"]
    full = np.abs(validation_motions.start_and_end_window(motion.time) - 1.0) < 1e-6
    assert full.sum() > 1000
    tip = forward_kinematics(motion.q[:, full], GEOMETRY)[1]
    np.testing.assert_allclose(np.hypot(tip[0], tip[1] + 0.252), 0.0315, rtol=0, atol=1e-6)
    # away from straight and folded
    assert np.abs(np.sin(motion.q[1, full])).min() > 0.7


def test_profile_moves_and_holds():
    motion = MOTIONS["T3"]
    still = (np.abs(motion.dq) < 1e-9).all(0)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], still, [False]]).astype(int)))
    lengths = np.diff(edges.reshape(-1, 2), axis=1).ravel() * H
    holds = lengths[lengths > 0.1]
    assert holds.size == 7  # rest, five holds, rest
    np.testing.assert_allclose(holds[1:-1], 1.024, rtol=0, atol=0.02)
    np.testing.assert_allclose(np.abs(motion.q).max(1), 1.2, rtol=0, atol=1e-12)
    one, other = np.abs(motion.dq) > 1e-3
    assert [(one & ~other).any(), (other & ~one).any(), (one & other).any()] == [True] * 3
    assert np.abs(motion.ddq).max() < 10.0  # no step in velocity


def test_sinusoids_have_their_frequencies():
    motion = MOTIONS["T4"]
    for joint, frequency in ((0, 0.25), (1, 0.4)):
        bins = np.abs(np.fft.rfft(motion.q[joint], 8 * 8192))
        assert np.fft.rfftfreq(8 * 8192, H)[bins.argmax()] == pytest.approx(frequency, abs=0.01)
        assert np.abs(motion.q[joint]).max() == pytest.approx(1.0, abs=0.01)


def test_identification_reference_contains_eq_10():
    p = identification_reference(SETTINGS)
    assert p.q.shape == (2, 300 + 40 + 3770 + 40)
    assert (p.n1, p.n2) == (340, 4110)
    np.testing.assert_array_equal(p.q[:, p.n1 : p.n2], identification_trajectory().q)
    np.testing.assert_array_equal(p.q[:, 300:], identification_trajectory(margin=40).q)
    np.testing.assert_array_equal(p.q[:, 0], 0.0)
    # Joined without a step in position, velocity or acceleration.
    jerk = np.diff(p.q, n=3) / H**3
    assert np.abs(jerk[:, 290:310]).max() < 500.0  # a step of 1 rad/s^2 in acceleration would give 400 more
    assert np.abs(np.diff(p.q, n=2)[:, 290:310]).max() / H**2 < 5.0


def test_a_program_longer_than_the_memory_is_refused():
    error = refused(identification_reference, replace(SETTINGS, duration=20.48))
    assert (error.place, error.found) == ("trajectory ID: length", "8572 samples")
    longer = replace(SETTINGS, t3=validation_motions.Profile(8193))
    assert refused(reference_trajectory, "T3", longer, rng()).place == "trajectory T3: length"
    longest = replace(SETTINGS, duration=8192 * H - 380 * H)
    assert identification_reference(longest).q.shape[1] == 8192


def test_random_motion_is_drawn_again_until_it_keeps_the_limits():
    """With 45 bands, of which a fifth of the draws keep the torque limit; with the default 12 all do."""
    fast = replace(SETTINGS, t1=validation_motions.RandomMotion(bands=45.0))
    beyond = reference_trajectory("T1", fast, rng(0))
    assert refused(check_limits, beyond, ARM, LIMITS).place == "trajectory T1: joint 1 torque"
    generator = rng(0)
    draws = [reference_trajectory("T1", fast, generator) for _ in range(10)]
    kept = next(p for p in draws if (peaks(p, ARM)[1] <= TORQUE_LIMIT).all())
    np.testing.assert_array_equal(programs.permitted_trajectory("T1", fast, rng(0), ARM, LIMITS).q, kept.q)
    error = refused(programs.permitted_trajectory, "T1", fast, rng(0), ARM, LIMITS, draws=1)
    assert error.place == "trajectory T1: joint 1 torque"
    for seed in range(20):
        check_limits(reference_trajectory("T1", SETTINGS, rng(seed)), ARM, LIMITS)


def test_peaks_of_a_motion_known_exactly():
    """Eq. 10 with its exact derivatives; the differences are accurate to h^2."""
    exact = identification_trajectory()
    q = exact.q - exact.q[:, :1]
    speed, torque = peaks(programs.ReferenceTrajectory("ID", q, 0, q.shape[1], H), ARM)
    np.testing.assert_allclose(speed, np.abs(exact.dq).max(1), rtol=1e-3)
    # Inside the run; at its first sample the jump from rest to the trajectory's speed is counted too.
    inner = inverse_dynamics(q[:, 1:], exact.dq[:, 1:], exact.ddq[:, 1:], ARM)
    assert (torque >= np.abs(inner).max(1) - 1e-3).all()
    moving = programs.ReferenceTrajectory("ID", q[:, 1:], 0, q.shape[1] - 1, H)  # the first sample is not at rest
    np.testing.assert_array_equal(peaks(moving, ARM)[1], torque)


@settings(max_examples=30)
@given(joint=st.integers(0, 1), at=st.integers(0, 99), seed=seeds)
def test_a_jump_at_any_sample_is_refused(joint, at, seed):
    """Also at the first sample, which the arm would have to reach from rest at q = 0."""
    q = np.random.default_rng(seed).uniform(-1e-6, 1e-6, (2, 100))
    q[joint, at:] += 1.01 * SPEED_LIMIT * H
    error = refused(check_limits, programs.ReferenceTrajectory("T4", q, 0, 100, H), ARM, LIMITS)
    assert error.place == f"trajectory T4: joint {joint + 1} speed"
    assert float(error.found.split()[0]) == pytest.approx(1.01 * SPEED_LIMIT, rel=0.01)


@pytest.mark.parametrize("joint", [0, 1])
def test_torque_limit_of_each_joint(joint):
    p = reference_trajectory("T4", SETTINGS, rng())
    enough, low = 1.01 * peaks(p, ARM)[1], 0.99 * peaks(p, ARM)[1]
    check_limits(p, ARM, (tuple(enough), SPEED_LIMIT))
    error = refused(check_limits, p, ARM, (tuple(np.where(np.arange(2) == joint, low, enough)), SPEED_LIMIT))
    assert error.place == f"trajectory T4: joint {joint + 1} torque"
    assert float(error.found.split()[0]) == pytest.approx(peaks(p, ARM)[1][joint], rel=1e-2)


@pytest.mark.parametrize(("duration", "h", "margin"), [(3.0 * np.pi, H, 0), (20.48, H, 40), (5.0, 1e-3, 25)])
def test_identification_trajectory_and_its_derivatives_are_eq10(duration, h, margin):
    motion = identification_trajectory(duration, h, margin)
    time, pace = np.arange(-margin, round(duration / h) + margin) * h, 3.0 * np.pi / duration
    np.testing.assert_allclose(motion.time, time, rtol=1e-15)
    t = pace * time
    sine, cosine = np.sin(2.5 * t + 3.0), np.cos(2.5 * t + 3.0)
    for found, joint1, joint2 in (
        (motion.q, np.sin(t) + 0.1 * cosine, -np.cos(t) - 0.1 * sine),
        (motion.dq / pace, np.cos(t) - 0.25 * sine, np.sin(t) - 0.25 * cosine),
        (motion.ddq / pace**2, -np.sin(t) - 0.625 * cosine, np.cos(t) + 0.625 * sine),
    ):
        np.testing.assert_allclose(found, [joint1, joint2], rtol=0, atol=1e-13)


@given(seed=seeds)
def test_random_trajectory_stays_in_its_range_around_the_middle(seed):
    # The Gaussian low-pass averages with positive weights, so it cannot leave the range of the numbers.
    motion = random_trajectory(rng(seed), 5.0, H, 1e-3, "rad_per_s")
    assert 0.0 <= motion.q.min() <= motion.q.max() <= 1.0
    # Mean of 2000 uniform numbers: six standard errors.
    assert (abs(motion.q.mean(-1) - 0.5) < 6.0 / np.sqrt(12.0 * 2000)).all()
