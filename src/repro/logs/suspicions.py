"""What may be wrong with a recording that can be read: each function tells one thing in one line, or nothing."""

from collections.abc import Callable
from typing import Final

import numpy as np
from scipy.ndimage import median_filter, uniform_filter1d

from repro.logs.checks import STILL
from repro.logs.log import Log, period, spanned, speed
from repro.logs.readings import late_torque, other_reading
from repro.logs.saturation import saturated_share
from repro.logs.uniform import GAP
from repro.model.parameters import Array

_TURN: Final = 2.0 * np.pi
#: Ratios of recorded velocity to differentiated position that have a name, and what it is.
_RATIOS: Final = (
    (
        57.296,
        "velocity in deg/s, taken for rad/s (or position in rad, taken for deg): "
        "give units.velocity or units.position in the arm file",
    ),
    (
        1.0 / 57.296,
        "position in deg, taken for rad (or velocity in rad/s, taken for deg/s): "
        "give units.position or units.velocity in the arm file",
    ),
    (9.549, "velocity in rpm, taken for rad/s: give units.velocity: rpm in the arm file"),
    (1000.0, "time in ms, taken for s: give units.time: ms in the arm file"),
    (1e-3, "time in s, taken for ms: give units.time: s in the arm file"),
    (1.0 / 60.0, "time in s, taken for min: give units.time: s in the arm file"),
    (60.0, "time in min, taken for s: give units.time: min in the arm file"),
)


def still_joint(log: Log) -> str | None:
    """One joint that does not move."""
    for joint, moved in enumerate(np.ptp(log.q, axis=1), 1):
        if moved < STILL:
            return (
                f"joint {joint} does not move ({moved:.2g} rad), so its friction and inertia are not excited: "
                "record a motion of both joints"
            )
    return None


def large_range(log: Log) -> str | None:
    """Positions of many turns."""
    joint = int(np.argmax(np.ptp(log.q, axis=1)))
    moved = float(np.ptp(log.q[joint]))
    if moved <= 4.0 * _TURN:
        return None
    return (
        f"joint {joint + 1} moves by {moved:.4g} rad ({moved / _TURN:.3g} turns): if these are degrees or counts, "
        "give units.position in the arm file"
    )


def odd_speed(log: Log) -> str | None:
    """A speed that no arm has, or hardly any."""
    top = float(np.percentile(np.abs(speed(log)), 99.9, axis=1).max())
    if top > 100.0:
        return (
            f"a joint turns at {top:.3g} rad/s: check the units of position and time (units.position, units.time "
            "in the arm file)"
        )
    if top < 0.05:
        return (
            f"the fastest motion is {top:.2g} rad/s, too slow to show inertia: check the unit of time, or record a "
            "faster motion"
        )
    return None


def slow_sampling(log: Log) -> str | None:
    """Motion that is too fast for the rate."""
    step = float(np.percentile(np.abs(np.diff(log.q, axis=1)), 99.0, axis=1).max())
    if step <= 0.3:
        return None
    return (
        f"joints turn by up to {step:.2g} rad from one sample to the next ({1.0 / period(log):.4g} Hz): "
        "record at a higher rate"
    )


def position_jump(log: Log) -> str | None:
    """A position that jumps, other than by a full turn."""
    dt = np.diff(log.t)
    for joint, q in enumerate(log.q, 1):
        steps = np.where(dt < GAP * period(log), np.abs(np.diff(q)), 0.0)
        usual = median_filter(steps, 11, mode="nearest")
        jumps = np.flatnonzero((steps > 0.1) & (steps > 8.0 * usual))
        if jumps.size:
            k = int(jumps[0])
            return (
                f"the position of joint {joint} jumps by {steps[k]:.3g} rad at {log.t[k + 1]:.4g} s "
                f"({jumps.size} such): check the encoder, or cut the log there"
            )
    return None


def velocity_disagrees(log: Log) -> str | None:
    """Recorded velocities that are not the derivative of the positions."""
    if log.dq is None:
        return None
    w = spanned(log)
    derived = speed(log)
    recorded = uniform_filter1d(log.dq, 2 * w + 1, axis=1)[:, w:-w]
    match = np.array([[_correlation(r, d) for d in derived] for r in recorded])
    if min(match[0, 1], match[1, 0]) > 0.9 > max(match[0, 0], match[1, 1]):
        return (
            "the velocity columns of joints 1 and 2 are swapped (each is the derivative of the other position): "
            "give columns.dq1 and columns.dq2 in the arm file"
        )
    for joint in range(2):
        told = _one_velocity(match[joint, joint], recorded[joint], derived[joint])
        if told:
            return f"velocity of joint {joint + 1}: {told}"
    return None


def _one_velocity(match: float, recorded: Array, derived: Array) -> str | None:
    """What is wrong with the velocity of one joint."""
    if match < -0.8:
        return "the opposite sign of the differentiated position: check the signs of both columns"
    if match < 0.8:
        return (
            f"it is not the derivative of the position (correlation {match:.2f}): check which columns they are, and "
            "the unit of time"
        )
    ratio = float(recorded @ derived / (derived @ derived))
    if 0.8 < ratio < 1.25:
        return None
    for known, words in _RATIOS:
        if 0.9 < ratio / known < 1.1:
            return f"{ratio:.3g} times the differentiated position, as with {words}"
    return f"{ratio:.3g} times the differentiated position: check the units of position, velocity and time"


def _correlation(a: Array, b: Array) -> float:
    """Correlation coefficient, zero for a constant."""
    a, b = a - a.mean(), b - b.mean()
    size = float(np.linalg.norm(a) * np.linalg.norm(b))
    return float(a @ b) / size if size > 0.0 else 0.0


def torque_in_counts(log: Log) -> str | None:
    """Torques that look like counts or mN m."""
    for joint, tau in enumerate(log.tau, 1):
        largest = float(np.abs(tau).max())
        if largest > 100.0 and np.array_equal(tau, np.rint(tau)):
            return (
                f"the torque of joint {joint} is whole numbers up to {largest:.0f}, taken for N m: if these are "
                "counts, give units.torque: counts and torque_constant in the arm file"
            )
        if largest > 1000.0:
            return (
                f"the torque of joint {joint} is up to {largest:.4g} N m: if this is mN m, give units.torque: mN m in "
                "the arm file"
            )
    return None


def saturated(log: Log) -> str | None:
    """Torques at the drive's limit."""
    shares = saturated_share(log)
    joint = int(np.argmax(shares))
    if shares[joint] <= 0.05:
        return None
    return (
        f"the torque of joint {joint + 1} is saturated in {100.0 * shares[joint]:.0f} % of the samples, where the "
        "recorded torque may not be the one that acted: record a slower motion"
    )


#: What shows in single signals, in the order it is told.
IN_SIGNALS: Final[tuple[Callable[[Log], str | None], ...]] = (
    still_joint,
    large_range,
    odd_speed,
    slow_sampling,
    position_jump,
    torque_in_counts,
    saturated,
)
#: What shows in signals held against each other, which a jump or a joint at rest would mislead.
IN_TOGETHER: Final[tuple[Callable[[Log], str | None], ...]] = (velocity_disagrees, other_reading, late_torque)


def suspicions(log: Log) -> tuple[str, ...]:
    """Everything that may be wrong with a log."""
    jumps = position_jump(log) is not None and large_range(log) is None  # degrees seem to jump, too
    misled = jumps or still_joint(log) is not None
    told = (suspicion(log) for suspicion in (IN_SIGNALS if misled else IN_SIGNALS + IN_TOGETHER))
    return tuple(each for each in told if each is not None)
