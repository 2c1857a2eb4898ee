"""Reference trajectories as the board plays them, and the limits of speed and torque that they keep.

The board calls a reference trajectory a program: the identification run of Eq. 10 (ID) and the motions that validate.
"""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from repro.errors import InputError
from repro.model.dynamics import ArmGeometry, inverse_dynamics
from repro.model.parameters import Array
from repro.signals.trajectories import Motion, identification_trajectory, quintic
from repro.signals.validation_motions import (
    Circle,
    Profile,
    RandomMotion,
    Sinusoid,
    circle_motion,
    profile_motion,
    random_motion,
    sinusoidal_motion,
)

#: Torque of each joint, N m, and joint speed, rad/s, that a motion may need at most.
Limits = tuple[tuple[float, float], float]
MEMORY_SAMPLES = 8192  # samples that the board's memory holds: 20.48 s at 2.5 ms


@dataclass(frozen=True)
class ReferenceTrajectory:
    """Reference trajectory of one recording: the trajectory proper is ``q[:, n1:n2]``, what **cut** keeps."""

    name: str
    q: Array  # desired positions (2, N), rad; the arm hangs at rest before the first
    n1: int
    n2: int
    h: float  # sampling period, s

    def __post_init__(self) -> None:
        """Refuse more samples than the memory holds."""
        samples = self.q.shape[1]
        if samples > MEMORY_SAMPLES:
            raise InputError.at(
                f"trajectory {self.name}: length", f"{samples} samples", f"at most the memory's {MEMORY_SAMPLES}"
            )


@dataclass(frozen=True)
class TrajectorySettings:
    """Settings of the five reference trajectories."""

    geometry: ArmGeometry = field(default_factory=lambda: ArmGeometry(0.165, 0.150))  # for the circle of T2
    duration: float = 3.0 * np.pi  # of the trajectory of Eq. 10, s
    h: float = 2.5e-3  # sampling period, s
    margin: int = 40  # samples of Eq. 10 before and after the trajectory proper, which take the filter's edges
    lead_in: float = 0.75  # time to bring the hanging arm onto Eq. 10, s
    t1: RandomMotion = field(default_factory=RandomMotion)
    t2: Circle = field(default_factory=Circle)
    t3: Profile = field(default_factory=Profile)
    t4: Sinusoid = field(default_factory=Sinusoid)


def identification_reference(settings: TrajectorySettings) -> ReferenceTrajectory:
    """Build ID: lead-in, margin, trajectory of Eq. 10, margin."""
    h, margin, n = settings.h, settings.margin, round(settings.lead_in / settings.h)
    motion = identification_trajectory(settings.duration, h, margin)
    state = np.stack([motion.q[:, 0], motion.dq[:, 0], motion.ddq[:, 0]])  # one sample after the lead-in from rest
    lead = quintic(h * np.arange(n, dtype=np.float64), n * h, np.zeros((3, 2)), state)
    q = np.concatenate([lead, motion.q], axis=1)
    return ReferenceTrajectory("ID", q, n + margin, q.shape[1] - margin, h)


class ValidationMotion(NamedTuple):
    """A validation motion: the function that samples it, whether it is drawn at random, whether the paper has it."""

    make: Callable[[TrajectorySettings, np.random.Generator], Motion]
    random: bool = False
    published: bool = True


#: Motions that only validate, in the order of tables and figures.
VALIDATION: dict[str, ValidationMotion] = {
    "T1": ValidationMotion(lambda s, rng: random_motion(rng, s.t1, s.h), random=True),
    "T2": ValidationMotion(lambda s, _: circle_motion(s.t2, s.geometry, s.h)),
    "T3": ValidationMotion(lambda s, _: profile_motion(s.t3, s.h)),
    "T4": ValidationMotion(lambda s, _: sinusoidal_motion(s.t4, s.h)),
}
PROGRAMS = ("ID", *VALIDATION)  # the motion that parameters are identified from, then those
SPAN = f"{PROGRAMS[1]} to {PROGRAMS[-1]}"  # the validation motions in words


def reference_trajectory(name: str, settings: TrajectorySettings, rng: np.random.Generator) -> ReferenceTrajectory:
    """Build the reference trajectory of this name; only a random motion uses `rng`."""
    if name == "ID":
        return identification_reference(settings)
    motion = VALIDATION[name].make(settings, rng)
    return ReferenceTrajectory(name, motion.q, 0, motion.q.shape[1], settings.h)


def peaks(desired: ReferenceTrajectory, beta: Array) -> tuple[Array, Array]:
    """Compute the peak speed (2,), rad/s, and torque (2,), N m, that a reference trajectory needs of an arm."""
    q = np.pad(desired.q, ((0, 0), (2, 0)))  # the arm hangs at rest before the first sample: position and speed 0
    step = np.diff(q) / desired.h
    dq = 0.5 * (step[:, 1:] + step[:, :-1])
    torque = inverse_dynamics(q[:, 1:-1], dq, np.diff(step) / desired.h, beta)
    return np.abs(step).max(-1), np.abs(torque).max(-1)


def check_limits(desired: ReferenceTrajectory, beta: Array, limits: Limits) -> None:
    """Raise InputError if a joint would exceed its torque or speed; call it before anything is sent."""
    (torque_limit, speed_limit), (speed, torque) = limits, peaks(desired, beta)
    rows = (("speed", "rad/s", speed, (speed_limit, speed_limit)), ("torque", "N m", torque, torque_limit))
    for quantity, unit, needed, allowed in rows:
        for joint in range(2):
            if not needed[joint] <= allowed[joint]:
                place = f"trajectory {desired.name}: joint {joint + 1} {quantity}"
                raise InputError.at(place, f"{needed[joint]:.4g} {unit}", f"at most {allowed[joint]:g} {unit}")


def permitted_trajectory(
    name: str, settings: TrajectorySettings, rng: np.random.Generator, beta: Array, limits: Limits, draws: int = 100
) -> ReferenceTrajectory:
    """Build a reference trajectory that keeps the limits; a random one is drawn up to `draws` times."""
    for _ in range(draws - 1 if name in VALIDATION and VALIDATION[name].random else 0):
        desired = reference_trajectory(name, settings, rng)
        with suppress(InputError):
            check_limits(desired, beta, limits)
            return desired
    desired = reference_trajectory(name, settings, rng)
    check_limits(desired, beta, limits)
    return desired
