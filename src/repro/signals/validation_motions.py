"""The desired motions T1-T4 that validate an identified arm (Section VI, Fig. 21-22).

The paper names them: a filtered random vector, a circle, a motion profile and a sinusoid, T1, T2 and T4 multiplied by a
window. It prints the range of T1's numbers and the radius of the circle. What it does not print has a setting.
"""

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from annotated_types import Ge, Le

from repro.keys import SECTION, Integer, Joints, Key, Positive, Real
from repro.model.dynamics import ArmGeometry, inverse_kinematics
from repro.model.parameters import Array
from repro.signals.dct import dct2low
from repro.signals.trajectories import Motion, quintic, sample_times, sampled_motion

#: Samples of a motion: what its window and the board's memory need.
Length = Annotated[Integer, Ge(101), Le(8192), Key("length of the motion", "samples", "Fig. 22, 23")]
#: What has the range of T1 that Section VI gives: each joint's filtered motion, or the numbers before the filter.
RangeOf = Literal["motion", "numbers"]

CIRCLE_RADIUS = 0.1  # of T2 over the reach: 3.15 cm of 31.5 cm

# T3: levels that the moves end at (rad) before their factor: both joints, each alone, both again. A move takes 12 % and
# a hold 5 % of the time; the remaining time is rest at either end.
PROFILE_LEVELS = np.array([[1.2, 1.2, -0.6, -1.2, 0.6, 0.0], [-0.8, 1.2, 1.2, -0.4, -1.2, 0.0]])
PROFILE_MOVE, PROFILE_HOLD = 0.12, 0.05

WINDOW_COEFFICIENT = 0.2  # coefficient of the window f_g at the start and at the end (Section VI), 1/s^2


@dataclass(frozen=True)
class RandomMotion:
    """T1: uniform random numbers, filtered by Eq. 14."""

    __pydantic_config__ = SECTION

    samples: Length = 8192
    bands: Annotated[
        Real,
        Ge(0.1),
        Le(1e9),
        Key("DCT-II band where its filter has a gain of 1/e", "bands", "Eq. 14, Table 10"),
    ] = 12.0
    range_rad: Annotated[Positive, Key("range, between minus and plus this", "rad", "published: Section VI")] = 1.2
    range_of: Annotated[
        RangeOf, Key("what has this range: the filtered motion, or the numbers before the filter", source="Section VI")
    ] = "motion"


@dataclass(frozen=True)
class Circle:
    """T2: a circle of the tip about a point straight below joint 1."""

    __pydantic_config__ = SECTION

    samples: Length = 8192
    turns: Annotated[Positive, Key("turns of the circle", "turns", "Table 10")] = 5.0
    centre: Annotated[Real, Ge(0.1), Le(0.9), Key("distance of its centre from joint 1", "reach", "Table 10")] = 0.8


@dataclass(frozen=True)
class Profile:
    """T3: moves from rest to rest."""

    __pydantic_config__ = SECTION

    samples: Length = 8192
    levels: Annotated[Positive, Key("factor of its levels", "", "Table 10")] = 1.0


@dataclass(frozen=True)
class Sinusoid:
    """T4: one sinusoid for each joint."""

    __pydantic_config__ = SECTION

    samples: Length = 8192
    amplitude_rad: Annotated[Joints, Key("amplitude of each joint", "rad", "Table 10")] = (1.0, 1.0)
    frequency_hz: Annotated[Joints, Key("frequency of each joint", "Hz", "Table 10")] = (0.25, 0.4)


def start_and_end_window(time: Array) -> Array:
    """Compute f_g = 1 - exp(-0.2 t^2) - exp(-0.2 (T - t)^2) of Section VI, T the largest of the times (N,) in s."""
    a = WINDOW_COEFFICIENT
    return np.asarray(1.0 - np.exp(-a * time**2) - np.exp(-a * (time.max() - time) ** 2))


def random_motion(rng: np.random.Generator, t1: RandomMotion, h: float) -> Motion:
    """Compute T1, windowed."""
    q = dct2low(rng.uniform(-t1.range_rad, t1.range_rad, (2, t1.samples)), h, t1.bands**-2.0, "index")
    if t1.range_of == "motion":
        q = t1.range_rad * q / np.abs(q).max(axis=1, keepdims=True)
    return sampled_motion(q * start_and_end_window(sample_times(t1.samples * h, h)), h)


def circle_motion(t2: Circle, geometry: ArmGeometry, h: float) -> Motion:
    """Compute T2, windowed in joint space, so that the arm swings out of rest onto the circle and back."""
    time = sample_times(t2.samples * h, h)
    angle = 2.0 * np.pi * t2.turns * time / (t2.samples * h)
    circle = CIRCLE_RADIUS * np.stack([np.sin(angle), -np.cos(angle)])
    tip = geometry.reach * (circle + np.array([[0.0], [-t2.centre]]))
    return sampled_motion(inverse_kinematics(tip, geometry) * start_and_end_window(time), h)


def profile_motion(t3: Profile, h: float) -> Motion:
    """Compute T3: quintic moves from rest to rest, with a hold after each; at rest at q = 0 at both ends."""
    time, total, moves = sample_times(t3.samples * h, h), t3.samples * h, PROFILE_LEVELS.shape[1]
    rest = 0.5 * (1.0 - moves * PROFILE_MOVE - (moves - 1) * PROFILE_HOLD)
    levels = t3.levels * np.concatenate([np.zeros((2, 1)), PROFILE_LEVELS], axis=1)
    q, still, duration = np.zeros((2, time.size)), np.zeros((2, 2)), PROFILE_MOVE * total
    for k in range(moves):
        since = time - (rest + k * (PROFILE_MOVE + PROFILE_HOLD)) * total
        move = (since >= 0.0) & (since < duration)
        start, end = np.vstack([levels[:, k], still]), np.vstack([levels[:, k + 1], still])
        q[:, move] = quintic(since[move], duration, start, end)
        q[:, since >= duration] = levels[:, k + 1, None]
    return sampled_motion(q, h)


def sinusoidal_motion(t4: Sinusoid, h: float) -> Motion:
    """Compute T4, windowed."""
    time = sample_times(t4.samples * h, h)
    q = np.array(t4.amplitude_rad)[:, None] * np.sin(2.0 * np.pi * np.array(t4.frequency_hz)[:, None] * time)
    return sampled_motion(q * start_and_end_window(time), h)
