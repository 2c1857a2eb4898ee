"""What a log contains, and what may be wrong with it: facts and warnings, before anything is identified."""

from collections.abc import Iterator
from dataclasses import dataclass
from operator import itemgetter
from typing import Final

import numpy as np
from scipy.ndimage import median_filter, uniform_filter1d

from repro.identification.armfile import Arm
from repro.identification.decimation import decimated
from repro.identification.log import (
    MAX_PERIOD_RATIO,
    MIN_RANGE_RAD,
    Log,
    half_window,
    missing_samples,
    period,
    speed,
    uniform,
)
from repro.logs.conventions import better_convention, late_torque, smoothed
from repro.logs.torque_limits import quantisation_step, saturated
from repro.model.parameters import Array

_TURN: Final = 2.0 * np.pi
MAX_REST_SPEED = 0.02  # speed below which a joint is at rest, rad/s
MAX_DOUBTFUL_RANGE_RAD = 0.06  # of the joint that moves more: 3.4 rad are so little if they are taken for degrees
#: Deviation of a torque from the median of five samples, in ranges that contain 90 % of them. The real arms reach 3.5.
MAX_TORQUE_DEVIATION = 5.0
#: Ratios of recorded velocity to differentiated position that have a known cause.
_RATIOS: Final = (
    (
        57.296,
        "velocity in deg/s, taken for rad/s (or position in rad, taken for deg): "
        "write into the arm file: units: {velocity: deg/s} (or units: {position: rad})",
    ),
    (
        1.0 / 57.296,
        "position in deg, taken for rad (or velocity in rad/s, taken for deg/s): "
        "write into the arm file: units: {position: deg} (or units: {velocity: rad/s})",
    ),
    (9.549, "velocity in rpm, taken for rad/s: write into the arm file: units: {velocity: rpm}"),
    (1000.0, "time in ms, taken for s: write into the arm file: units: {time: ms}"),
    (1e-3, "time in s, taken for ms: write into the arm file: units: {time: s}"),
)


def still_joint(log: Log) -> Iterator[str]:
    """Report the first joint that does not move."""
    still = [(joint, moved) for joint, moved in enumerate(np.ptp(log.q, axis=1), 1) if moved < MIN_RANGE_RAD]
    for joint, moved in still[:1]:
        found = f"joint {joint} does not move ({moved:.2g} rad)"
        yield f"{found}, so its friction and inertia are not excited: record a motion of both joints"


def small_range(log: Log) -> Iterator[str]:
    """Report a motion that is as small as one in rad that was taken for degrees."""
    moved = np.ptp(log.q, axis=1).max()
    if MIN_RANGE_RAD <= moved < MAX_DOUBTFUL_RANGE_RAD:
        found = f"no joint moves by more than {np.degrees(moved):.2g} degrees"
        yield f"{found}: if the positions are rad, write into the arm file: units: {{position: rad}}; else move further"


def large_range(log: Log) -> Iterator[str]:
    """Report positions of many turns."""
    joint, moved = max(enumerate(np.ptp(log.q, axis=1), 1), key=itemgetter(1))
    if moved > 4.0 * _TURN:
        lines = "units: {position: deg} or units: {position: counts}"
        found = f"joint {joint} moves by {moved:.4g} rad ({moved / _TURN:.3g} turns)"
        yield f"{found}: if these are degrees or counts, write into the arm file: {lines}"


def odd_speed(log: Log) -> Iterator[str]:
    """Report a speed that hardly any arm has, and a motion that is too fast for the rate."""
    top = float(np.percentile(np.abs(speed(log)), 99.9, axis=1).max())
    if top > 100.0:
        where = "units.position, units.time in the arm file"
        yield f"a joint turns at {top:.3g} rad/s: check the units of position and time ({where})"
    if top < 0.05:
        found = f"the fastest motion is {top:.2g} rad/s, too slow to show inertia"
        yield f"{found}: check the unit of time, or record a faster motion"
    step = float(np.percentile(np.abs(np.diff(log.q, axis=1)), 99.0, axis=1).max())
    if step > 0.3:
        found = f"joints turn by up to {step:.2g} rad from one sample to the next ({1.0 / period(log):.4g} Hz)"
        yield f"{found}: record at a higher rate"


def position_jump(log: Log) -> Iterator[str]:
    """Report a position that jumps, other than by a full turn."""
    dt = np.diff(log.t)
    for joint, q in enumerate(log.q, 1):
        steps = np.where(dt < MAX_PERIOD_RATIO * period(log), np.abs(np.diff(q)), 0.0)
        usual = median_filter(steps, 11, mode="nearest")
        if (jumps := np.flatnonzero((steps > 0.1) & (steps > 8.0 * usual))).size:
            k = int(jumps[0])
            found = f"the position of joint {joint} jumps by {steps[k]:.3g} rad at {log.t[k + 1]:.4g} s"
            yield f"{found} ({jumps.size} such): check the encoder, or cut the log there"
            return


def torque_spikes(log: Log) -> Iterator[str]:
    """Report samples whose torque is far from the median of their neighbours: by several times its usual range."""
    far = np.abs(log.tau - median_filter(log.tau, (1, 5), mode="nearest"))
    low, high = np.percentile(log.tau, (5.0, 95.0), axis=1)
    for joint, (apart, usual) in enumerate(zip(far, high - low, strict=True), 1):
        if usual > 0.0 and (spikes := np.flatnonzero(apart > MAX_TORQUE_DEVIATION * usual)).size:
            at = ", ".join(f"{log.t[k]:.4g}" for k in spikes[:5]) + " ..." * (spikes.size > 5)
            found = f"the torque of joint {joint} has spikes at {at} s ({spikes.size} such)"
            yield f"{found}: check sensor and bus, and delete these rows of the log"


def velocity_disagrees(log: Log) -> Iterator[str]:
    """Report velocities that are not the derivative of the positions."""
    if log.dq is None:
        return
    w, derived = half_window(log), speed(log)
    recorded = uniform_filter1d(log.dq, 2 * w + 1, axis=1)[:, w:-w]
    with np.errstate(invalid="ignore"):  # a constant has no correlation: it counts as none
        match = np.nan_to_num(np.corrcoef(recorded, derived)[:2, 2:])
    if min(match[0, 1], match[1, 0]) > 0.9 > max(match[0, 0], match[1, 1]):
        yield (
            "the velocity columns of joints 1 and 2 are swapped (each is the derivative of the other position): "
            "write into the arm file: columns: {dq1: dq2, dq2: dq1} (with the headers of this log)"
        )
        return
    problems = map(_velocity_problem, np.diagonal(match), recorded, derived)
    yield from [f"velocity of joint {joint}: {problem}" for joint, problem in enumerate(problems, 1) if problem][:1]


def _velocity_problem(match: float, recorded: Array, derived: Array) -> str:
    """Compare the velocity of one joint with its differentiated position; empty if they agree."""
    if match < -0.8:
        return "the opposite sign of the differentiated position: check the signs of both columns"
    if match < 0.8:
        found = f"it is not the derivative of the position (correlation {match:.2f})"
        return f"{found}: check which columns they are, and the unit of time"
    ratio = float(recorded @ derived / (derived @ derived))
    if 0.8 < ratio < 1.25:
        return ""
    causes = [f", as with {cause}" for known, cause in _RATIOS if 0.9 < ratio / known < 1.1]
    cause = causes[0] if causes else ": check the units of position, velocity and time"
    return f"{ratio:.3g} times the differentiated position{cause}"


def odd_torque(log: Log) -> Iterator[str]:
    """Report a torque that looks like counts or mN m, and one at the drive's limit."""
    for joint, tau in enumerate(log.tau, 1):
        largest = float(np.abs(tau).max())
        if largest > 100.0 and np.array_equal(tau, np.rint(tau)):
            found = f"the torque of joint {joint} is whole numbers up to {largest:.0f}, taken for N m"
            yield f"{found}: if these are counts, give units.torque: counts and torque_constant in the arm file"
            break
        if largest > 1000.0:
            found = f"the torque of joint {joint} is up to {largest:.4g} N m"
            yield f"{found}: if this is mN m, give units.torque: mN m in the arm file"
            break
    joint, fraction = max(enumerate(saturated(log).mean(axis=1), 1), key=itemgetter(1))
    if fraction > 0.05:
        found = f"the torque of joint {joint} is saturated in {100.0 * fraction:.0f} % of the samples"
        yield f"{found}, where the recorded torque may not be the one that acted: record a slower motion"


def left_out_torque(log: Log) -> Iterator[str]:
    """Report samples of a uniformly sampled log whose torque is left out of fits."""
    for joint, wrong in enumerate(log.left_out if log.left_out is not None else (), 1):
        if n := np.count_nonzero(wrong):
            found = f"at a limit or stuck in {n} samples ({100.0 * n / wrong.size:.2g} %)"
            yield f"the torque of joint {joint} is {found}, and the motion contradicts it: the fit leaves them out"


def diagnose(log: Log, arm: Arm) -> tuple[str, ...]:
    """List what may be wrong with a log as read, one line each; InputError if gaps leave no segment long enough."""
    checks = (still_joint, small_range, large_range, position_jump, torque_spikes)
    still, small, turns, jumps, spikes = (list(check(log)) for check in checks)
    warnings = [*still, *small, *turns, *odd_speed(log), *jumps, *spikes, *odd_torque(log)]
    # A joint at rest, a jump or a spike misleads checks of signals against each other; degrees seem to jump, too.
    if not (still or spikes) and (turns or not jumps):
        smooth = smoothed(decimated(uniform(log)))
        warnings += [*velocity_disagrees(log), *better_convention(log, smooth, arm)]
        warnings += late_torque(smooth, arm.delay or 0.0)
    return tuple(warnings)


@dataclass(frozen=True)
class Description:
    """Facts about a log, and warnings."""

    name: str  # file name
    # What was found and its value with unit: rate, length, motion range, gaps, saturation, quantisation
    facts: tuple[tuple[str, str], ...]
    notes: tuple[str, ...] = ()  # assumptions and conversions on reading
    warnings: tuple[str, ...] = ()  # what may spoil the result, one line each
    simulated: bool = False  # whether the simulated board made it


def describe(log: Log, arm: Arm) -> Description:
    """Describe a log as read, before resampling."""
    facts = (("arm", arm.name), *_timing(log), *_motion(log), *_torque(log))
    return Description(log.name, facts, log.notes, diagnose(log, arm), log.simulated)


def _timing(log: Log) -> Iterator[tuple[str, str]]:
    h = period(log)
    low, high, longest = 1e3 * np.percentile(np.diff(log.t), (1.0, 99.0, 100.0))
    missing = missing_samples(log)
    gaps = np.count_nonzero(missing)
    yield "samples", str(log.t.size)
    yield "length", f"{log.t[-1] - log.t[0]:.4g} s"
    yield "rate", f"{1.0 / h:.4g} Hz (98 % of the periods {low:.4g} to {high:.4g} ms)"
    yield "gaps", f"{gaps}, {missing.sum():.0f} samples missing, the longest {longest:.4g} ms" if gaps else "none"


def _motion(log: Log) -> Iterator[tuple[str, str]]:
    speeds = np.abs(speed(log))
    for joint, q in enumerate(log.q):
        low, high = q.min(), q.max()
        in_degrees = f"{np.rad2deg(low):.1f} to {np.rad2deg(high):.1f} deg"
        yield f"position of joint {joint + 1}", f"{low:.3f} to {high:.3f} rad ({in_degrees})"
        yield f"top speed of joint {joint + 1}", f"{speeds[joint].max():.3g} rad/s"
        yield f"at rest, joint {joint + 1}", f"{100.0 * np.mean(speeds[joint] < MAX_REST_SPEED):.1f} % of the time"
        yield f"step of position {joint + 1}", _step(q, "rad")
    yield "velocity", "none recorded" if log.dq is None else "recorded"


def _torque(log: Log) -> Iterator[tuple[str, str]]:
    limit = log.torque_limit
    for joint, (tau, fraction) in enumerate(zip(log.tau, saturated(log).mean(axis=1), strict=True)):
        of = "" if limit is None else f" (limit {limit[joint]:.4g} N m)"
        rms = np.sqrt(np.mean(tau**2))
        yield f"torque of joint {joint + 1}", f"{tau.min():.4g} to {tau.max():.4g} N m, RMS {rms:.4g} N m"
        yield f"step of torque {joint + 1}", _step(tau, "N m")
        yield f"saturation of torque {joint + 1}", f"{100.0 * fraction:.1f} % of the samples{of}"


def _step(x: Array, unit: str) -> str:
    step = quantisation_step(x)
    return "none seen" if step is None else f"{step:.3g} {unit}"
