"""The desired motions T1-T4 that validate an identified arm (Section VI, Fig. 21-22).

The paper names them: a filtered random vector, a circle, a motion profile and a sinusoidal trajectory, T1, T2
and T4 multiplied by a window. What it does not give (bandwidth of the random vector, centre and period of the circle,
levels of the profile, frequencies of the sinusoids) is chosen here.
"""

from typing import Literal

import numpy as np

from repro.model.dynamics import ArmGeometry, inverse_kinematics
from repro.model.parameters import Array
from repro.signals.dct import dct2dev
from repro.signals.trajectories import Motion, quintic, random_trajectory, sample_times

#: Samples of T1-T4, as many as the board's memory holds: 20.48 s at 2.5 ms.
SAMPLES = 8192

# T1: with the range of the motion and 12 bands, least squares scores on T1 what the paper prints for it, to 1 point.
T1_BANDS = 12.0
RangeOf = Literal["motion", "numbers"]

# T2: turns, and distance of the centre over the reach. At 0.8 straight below joint 1 the circle stays
# between 0.7 and 0.9 of the reach: joint 2 bends by 50 to 90 degrees, far from straight and from folded, and gravity
# is not at its largest.
CIRCLE_TURNS = 5
CIRCLE_CENTRE = 0.8
CIRCLE_RADIUS = 0.1  # 3.15 cm of 31.5 cm

# T3: levels that the moves end at (rad), over the range of T1 and Eq. 10: both joints, each alone, both again.
# A move takes 12 % and a hold 5 % of the time, 2.46 s and 1.02 s; the remaining time is rest at either end.
PROFILE_LEVELS = np.array([[1.2, 1.2, -0.6, -1.2, 0.6, 0.0], [-0.8, 1.2, 1.2, -0.4, -1.2, 0.0]])
PROFILE_MOVE = 0.12
PROFILE_HOLD = 0.05

# T4: one sinusoid a joint. 0.4 and 0.25 Hz have no short common period, so the joints meet in many phases.
SINE_AMPLITUDE = np.array([[1.0], [1.0]])  # rad
SINE_FREQUENCY = np.array([[0.25], [0.4]])  # Hz

#: Coefficient of the window f_g at the start and at the end (Section VI), 1/s^2.
WINDOW_COEFFICIENT = 0.2


def start_and_end_window(time: Array) -> Array:
    """Compute f_g = 1 - exp(-0.2 t^2) - exp(-0.2 (T - t)^2) of Section VI, T the largest of the times (N,) in s."""
    a = WINDOW_COEFFICIENT
    return np.asarray(1.0 - np.exp(-a * time**2) - np.exp(-a * (time.max() - time) ** 2))


def _sampled(time: Array, q: Array, h: float) -> Motion:
    """Add derivatives by Eq. 6, without filtering, to positions (2, N)."""
    dq = dct2dev(q, h, 0.0)
    return Motion(time, q, dq, dct2dev(dq, h, 0.0))


def random_motion(
    rng: np.random.Generator,
    bands: float = T1_BANDS,
    limit: float = 1.2,
    range_of: RangeOf = "motion",
    samples: int = SAMPLES,
    h: float = 2.5e-3,
) -> Motion:
    """Compute T1: uniform random numbers, filtered by Eq. 14 and windowed.

    `bands` is the DCT-II band at which the gain of Eq. 14 is 1/e. The range of Section VI, -limit to limit (rad), is of
    each joint's filtered motion, or of the numbers before the filter (`range_of`).
    """
    motion = random_trajectory(rng, samples * h, h, bands**-2.0, "index", (-limit, limit))
    q = motion.q
    if range_of == "motion":
        q = limit * q / np.abs(q).max(axis=1, keepdims=True)
    return _sampled(motion.time, q * start_and_end_window(motion.time), h)


def circle_motion(geometry: ArmGeometry, samples: int = SAMPLES, h: float = 2.5e-3) -> Motion:
    """Compute T2: a circle of the tip, windowed in joint space, so that the arm swings out of rest onto it and back."""
    time = sample_times(samples * h, h)
    angle = 2.0 * np.pi * CIRCLE_TURNS * time / (samples * h)
    circle = CIRCLE_RADIUS * np.stack([np.sin(angle), -np.cos(angle)])
    tip = geometry.reach * (circle + np.array([[0.0], [-CIRCLE_CENTRE]]))
    return _sampled(time, inverse_kinematics(tip, geometry) * start_and_end_window(time), h)


def profile_motion(samples: int = SAMPLES, h: float = 2.5e-3) -> Motion:
    """Compute T3: quintic moves from rest to rest, with a hold after each; at rest at q = 0 at both ends."""
    time = sample_times(samples * h, h)
    total = samples * h
    moves = PROFILE_LEVELS.shape[1]
    rest = 0.5 * (1.0 - moves * PROFILE_MOVE - (moves - 1) * PROFILE_HOLD)
    levels = np.concatenate([np.zeros((2, 1)), PROFILE_LEVELS], axis=1)
    still = np.zeros((2, 2))
    q = np.zeros((2, time.size))
    for k in range(moves):
        since = time - (rest + k * (PROFILE_MOVE + PROFILE_HOLD)) * total
        duration = PROFILE_MOVE * total
        move = (since >= 0.0) & (since < duration)
        start, end = np.vstack([levels[:, k], still]), np.vstack([levels[:, k + 1], still])
        q[:, move] = quintic(since[move], duration, start, end)
        q[:, since >= duration] = levels[:, k + 1, None]
    return _sampled(time, q, h)


def sinusoidal_motion(samples: int = SAMPLES, h: float = 2.5e-3) -> Motion:
    """Compute T4: a sinusoid for each joint, windowed."""
    time = sample_times(samples * h, h)
    q = SINE_AMPLITUDE * np.sin(2.0 * np.pi * SINE_FREQUENCY * time)
    return _sampled(time, q * start_and_end_window(time), h)
