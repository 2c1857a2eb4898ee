"""The desired motions T1-T4 that validate an identified arm (Section VI, Fig. 21-22).

The paper names them: a filtered random vector, a circle, a motion profile and a sinusoid, T1, T2 and T4 multiplied by a
window. Bandwidth, centre and period of the circle, levels of the profile and frequencies are chosen here.
"""

from typing import Literal

import numpy as np

from repro.model.dynamics import ArmGeometry, inverse_kinematics
from repro.model.parameters import Array
from repro.signals.dct import dct2low
from repro.signals.trajectories import Motion, quintic, sample_times, sampled_motion

#: What has the range of T1 that Section VI gives: each joint's filtered motion, or the numbers before the filter.
RangeOf = Literal["motion", "numbers"]

# T2: turns, distance of the centre below joint 1 over the reach, and radius over the reach (3.15 cm of 31.5 cm). Joint
# 2 bends by 50 to 90 degrees, far from straight and from folded, and gravity is not at its largest.
CIRCLE_TURNS, CIRCLE_CENTRE, CIRCLE_RADIUS = 5, 0.8, 0.1

# T3: levels that the moves end at (rad), over the range of T1 and Eq. 10: both joints, each alone, both again.
# A move takes 12 % and a hold 5 % of the time, 2.46 s and 1.02 s; the remaining time is rest at either end.
PROFILE_LEVELS = np.array([[1.2, 1.2, -0.6, -1.2, 0.6, 0.0], [-0.8, 1.2, 1.2, -0.4, -1.2, 0.0]])
PROFILE_MOVE, PROFILE_HOLD = 0.12, 0.05

# T4: one sinusoid a joint. 0.4 and 0.25 Hz have no short common period, so the joints meet in many phases.
SINE_AMPLITUDE = np.array([[1.0], [1.0]])  # rad
SINE_FREQUENCY = np.array([[0.25], [0.4]])  # Hz

WINDOW_COEFFICIENT = 0.2  # coefficient of the window f_g at the start and at the end (Section VI), 1/s^2


def start_and_end_window(time: Array) -> Array:
    """Compute f_g = 1 - exp(-0.2 t^2) - exp(-0.2 (T - t)^2) of Section VI, T the largest of the times (N,) in s."""
    a = WINDOW_COEFFICIENT
    return np.asarray(1.0 - np.exp(-a * time**2) - np.exp(-a * (time.max() - time) ** 2))


def random_motion(
    rng: np.random.Generator, bands: float, limit: float, range_of: RangeOf, samples: int, h: float
) -> Motion:
    """Compute T1: random numbers in -limit to limit, rad, filtered by Eq. 14 (gain 1/e at band `bands`), windowed."""
    q = dct2low(rng.uniform(-limit, limit, (2, samples)), h, bands**-2.0, "index")
    if range_of == "motion":
        q = limit * q / np.abs(q).max(axis=1, keepdims=True)
    return sampled_motion(q * start_and_end_window(sample_times(samples * h, h)), h)


def circle_motion(geometry: ArmGeometry, samples: int, h: float) -> Motion:
    """Compute T2: a circle of the tip, windowed in joint space, so that the arm swings out of rest onto it and back."""
    time = sample_times(samples * h, h)
    angle = 2.0 * np.pi * CIRCLE_TURNS * time / (samples * h)
    circle = CIRCLE_RADIUS * np.stack([np.sin(angle), -np.cos(angle)])
    tip = geometry.reach * (circle + np.array([[0.0], [-CIRCLE_CENTRE]]))
    return sampled_motion(inverse_kinematics(tip, geometry) * start_and_end_window(time), h)


def profile_motion(samples: int, h: float) -> Motion:
    """Compute T3: quintic moves from rest to rest, with a hold after each; at rest at q = 0 at both ends."""
    time, total, moves = sample_times(samples * h, h), samples * h, PROFILE_LEVELS.shape[1]
    rest = 0.5 * (1.0 - moves * PROFILE_MOVE - (moves - 1) * PROFILE_HOLD)
    levels = np.concatenate([np.zeros((2, 1)), PROFILE_LEVELS], axis=1)
    q, still, duration = np.zeros((2, time.size)), np.zeros((2, 2)), PROFILE_MOVE * total
    for k in range(moves):
        since = time - (rest + k * (PROFILE_MOVE + PROFILE_HOLD)) * total
        move = (since >= 0.0) & (since < duration)
        start, end = np.vstack([levels[:, k], still]), np.vstack([levels[:, k + 1], still])
        q[:, move] = quintic(since[move], duration, start, end)
        q[:, since >= duration] = levels[:, k + 1, None]
    return sampled_motion(q, h)


def sinusoidal_motion(samples: int, h: float) -> Motion:
    """Compute T4: a sinusoid for each joint, windowed."""
    time = sample_times(samples * h, h)
    q = SINE_AMPLITUDE * np.sin(2.0 * np.pi * SINE_FREQUENCY * time)
    return sampled_motion(q * start_and_end_window(time), h)
