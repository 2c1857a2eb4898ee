"""Desired positions as the board plays them: the identification run of Eq. 10 and the motions that validate."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from repro.errors import InputError
from repro.model.parameters import Array
from repro.signals.kinematics import ArmGeometry
from repro.signals.quintic import quintic
from repro.signals.trajectories import Motion, identification_trajectory
from repro.signals.validation_motions import (
    T1_BANDS,
    RangeOf,
    circle_motion,
    profile_motion,
    random_motion,
    sinusoidal_motion,
)

#: Samples that the board's memory holds.
MEMORY_SAMPLES = 8192


@dataclass(frozen=True)
class Program:
    """Desired positions of one recording.

    Attributes
    ----------
    name : str
        Key of `MOTIONS`, or of a user's own.
    q : array of shape (2, N)
        Desired position at each sampling instant, rad; the arm hangs at rest before the first.
    n1, n2 : int
        The trajectory proper is ``q[:, n1:n2]``, what **cut** of Algorithm 1 keeps.
    h : float
        Sampling period, s.

    Raises
    ------
    InputError
        If there are more samples than the board's memory holds.
    ValueError
        If `q` is not a finite ``(2, N)`` or n1 and n2 do not lie in it in this order.
    """

    name: str
    q: Array
    n1: int
    n2: int
    h: float

    def __post_init__(self) -> None:
        if self.q.ndim != 2 or self.q.shape[0] != 2 or not np.isfinite(self.q).all():
            raise ValueError(f"q: must be finite of shape (2, N), got shape {self.q.shape}.")
        samples = self.q.shape[1]
        if not 0 <= self.n1 < self.n2 <= samples:
            raise ValueError(f"n1, n2: must be 0 <= n1 < n2 <= {samples}, got {self.n1} and {self.n2}.")
        if samples > MEMORY_SAMPLES:
            raise InputError.at(
                f"trajectory {self.name}: length", f"{samples} samples", f"at most the memory's {MEMORY_SAMPLES}"
            )


@dataclass(frozen=True)
class ProgramSettings:
    """What the five programs need.

    Attributes
    ----------
    geometry : ArmGeometry
        Link lengths, for the circle of T2.
    duration : float
        Of the trajectory of Eq. 10, s.
    h : float
        Sampling period, s.
    margin : int
        Samples of Eq. 10 before and after the trajectory proper, which take the filter's edges.
    lead_in : float
        Time to bring the hanging arm onto Eq. 10, s.
    validation_samples : int
        Length of T1-T4.
    t1_bands : float
        DCT-II band at which the filter of T1 has a gain of 1/e.
    t1_limit : float
        Range of T1, -t1_limit to t1_limit, rad.
    t1_range_of : {"motion", "numbers"}
        What has that range, see `repro.signals.validation_motions.random_motion`.
    """

    geometry: ArmGeometry = field(default_factory=lambda: ArmGeometry(0.165, 0.150))
    duration: float = 3.0 * np.pi
    h: float = 2.5e-3
    margin: int = 40
    lead_in: float = 0.75
    validation_samples: int = MEMORY_SAMPLES
    t1_bands: float = T1_BANDS
    t1_limit: float = 1.2
    t1_range_of: RangeOf = "motion"


def lead_in(q: Array, dq: Array, ddq: Array, samples: int, h: float) -> Array:
    """Positions that bring the arm from rest at q = 0 into a given state.

    Parameters
    ----------
    q, dq, ddq : arrays of shape (2,)
        Position (rad), velocity (rad/s) and acceleration (rad/s^2) one sample after the last one returned.
    samples : int
        Number of samples.
    h : float
        Sampling period, s.

    Returns
    -------
    array of shape (2, samples)
        Samples of a quintic, the first at q = 0, rad.

    Raises
    ------
    ValueError
        If `samples` is less than 1, `h` is not positive or the state is not finite.
    """
    if samples < 1:
        raise ValueError(f"samples: a lead-in needs at least one, got {samples}.")
    time = h * np.arange(samples, dtype=np.float64)
    return quintic(time, samples * h, np.zeros((3, 2)), np.stack([q, dq, ddq]))


def identification_program(
    duration: float = 3.0 * np.pi, h: float = 2.5e-3, margin: int = 40, lead_in_s: float = 0.75
) -> Program:
    """Lead-in, margin, trajectory of Eq. 10, margin.

    Parameters
    ----------
    duration : float
        Of the trajectory proper, s.
    h : float
        Sampling period, s.
    margin : int
        Samples of Eq. 10 before and after the trajectory proper.
    lead_in_s : float
        Time from rest to Eq. 10, s.

    Returns
    -------
    Program
        n1 and n2 enclose the trajectory proper.

    Raises
    ------
    InputError
        If it is longer than the board's memory.
    ValueError
        If an argument is not valid.
    """
    motion = identification_trajectory(duration, h, margin)
    if not np.isfinite(lead_in_s):
        raise ValueError(f"lead_in_s: must be finite, got {lead_in_s}.")
    lead = lead_in(motion.q[:, 0], motion.dq[:, 0], motion.ddq[:, 0], round(lead_in_s / h), h)
    n1 = lead.shape[1] + margin
    q = np.concatenate([lead, motion.q], axis=1)
    return Program("ID", q, n1, q.shape[1] - margin, h)


Make = Callable[[ProgramSettings, np.random.Generator], Motion]


@dataclass(frozen=True)
class Entry:
    """How a validation motion is made.

    Attributes
    ----------
    make : callable
        ``make(settings, rng)`` gives the motion.
    random : bool
        Whether it is drawn, and so may be drawn again.
    published : bool
        Whether the paper has it.
    """

    make: Make
    random: bool = False
    published: bool = True


#: Motions that only validate, in the order of tables and figures.
VALIDATION: dict[str, Entry] = {
    "T1": Entry(
        lambda s, rng: random_motion(rng, s.t1_bands, s.t1_limit, s.t1_range_of, s.validation_samples, s.h), random=True
    ),
    "T2": Entry(lambda s, _: circle_motion(s.geometry, samples=s.validation_samples, h=s.h)),
    "T3": Entry(lambda s, _: profile_motion(s.validation_samples, s.h)),
    "T4": Entry(lambda s, _: sinusoidal_motion(s.validation_samples, s.h)),
}
#: The motion of Eq. 10, which parameters are identified from, then those.
PROGRAMS = ("ID", *VALIDATION)
#: The validation motions in words.
SPAN = f"{PROGRAMS[1]} to {PROGRAMS[-1]}"


def program(name: str, settings: ProgramSettings, rng: np.random.Generator) -> Program:
    """Desired positions of one of the recordings.

    Parameters
    ----------
    name : str
        One of `PROGRAMS`.
    settings : ProgramSettings
        Lengths, filter and geometry.
    rng : numpy.random.Generator
        Source of random numbers of a motion that is drawn.

    Returns
    -------
    Program
        Ready for `repro.signals.limits.check_limits`.

    Raises
    ------
    InputError
        If it is longer than the board's memory.
    ValueError
        If the name is unknown or a setting is not valid.
    """
    s = settings
    if name not in PROGRAMS:
        raise ValueError(f"name: must be one of {PROGRAMS}, got {name!r}.")
    if name == "ID":
        return identification_program(s.duration, s.h, s.margin, s.lead_in)
    motion = VALIDATION[name].make(s, rng)
    return Program(name, motion.q, 0, motion.q.shape[1], s.h)
