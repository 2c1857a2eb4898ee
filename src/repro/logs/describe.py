"""What a recording holds, told before anything is computed."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from repro.logs.armfile import Arm
from repro.logs.log import Log, period, speed
from repro.logs.saturation import quantisation_step, saturated_share
from repro.logs.suspicions import suspicions
from repro.logs.uniform import missing_samples
from repro.model.parameters import Array


@dataclass(frozen=True)
class Description:
    """What a log holds, told before anything is computed."""

    name: str  # file name
    # What was found and its value with unit: rate, length, motion range, gaps, saturation, quantisation
    facts: tuple[tuple[str, str], ...]
    notes: tuple[str, ...] = ()  # assumptions and conversions on reading
    warnings: tuple[str, ...] = ()  # what may spoil the result, one line each
    simulated: bool = False  # whether the simulated board made it


#: Speed below which a joint is at rest, rad/s.
AT_REST = 0.02


def describe(log: Log, arm: Arm) -> Description:
    """Say what a log holds and what may be wrong with it."""
    facts = (("arm", arm.name), *_timing(log), *_motion(log), *_torque(log))
    return Description(log.name, facts, log.notes, suspicions(log), log.simulated)


def _timing(log: Log) -> Iterator[tuple[str, str]]:
    """Samples, length, rate, gaps."""
    h = period(log)
    low, high = 1e3 * np.percentile(np.diff(log.t), (1.0, 99.0))
    missing = missing_samples(log)
    gaps = int(np.count_nonzero(missing))
    yield "samples", str(log.t.size)
    yield "length", f"{log.t[-1] - log.t[0]:.4g} s"
    yield "rate", f"{1.0 / h:.4g} Hz (98 % of the periods {low:.4g} to {high:.4g} ms)"
    worst = f", the longest {1e3 * float(np.diff(log.t).max()):.4g} ms" if gaps else ""
    yield "gaps", f"{gaps}, {missing.sum():.0f} samples missing{worst}" if gaps else "none"


def _motion(log: Log) -> Iterator[tuple[str, str]]:
    """Range, speed, rest and encoder steps of each joint."""
    moving = np.abs(speed(log))
    for joint, q in enumerate(log.q):
        low, high = float(q.min()), float(q.max())
        in_degrees = f"{np.rad2deg(low):.1f} to {np.rad2deg(high):.1f} deg"
        rest = float(np.mean(moving[joint] < AT_REST))
        yield f"position of joint {joint + 1}", f"{low:.3f} to {high:.3f} rad ({in_degrees})"
        yield f"top speed of joint {joint + 1}", f"{moving[joint].max():.3g} rad/s"
        yield f"at rest, joint {joint + 1}", f"{100.0 * rest:.1f} % of the time"
        yield f"step of position {joint + 1}", _step(q, "rad")
    yield "velocity", "none recorded" if log.dq is None else "recorded"


def _torque(log: Log) -> Iterator[tuple[str, str]]:
    """Range, step and saturation of each torque."""
    limit = log.torque_limit
    for joint, (tau, share) in enumerate(zip(log.tau, saturated_share(log), strict=True)):
        of = "" if limit is None else f" (limit {limit[joint]:.4g} N m)"
        rms = float(np.sqrt(np.mean(tau**2)))
        yield f"torque of joint {joint + 1}", f"{tau.min():.4g} to {tau.max():.4g} N m, RMS {rms:.4g} N m"
        yield f"step of torque {joint + 1}", _step(tau, "N m")
        yield f"saturation of torque {joint + 1}", f"{100.0 * share:.1f} % of the samples{of}"


def _step(x: Array, unit: str) -> str:
    """Quantisation in words."""
    step = quantisation_step(x)
    return "none seen" if step is None else f"{step:.3g} {unit}"
