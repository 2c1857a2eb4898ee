"""What a recording must be to be worked on at all; each check raises one line."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from repro.errors import InputError
from repro.logs.armfile import Arm
from repro.logs.log import Log
from repro.logs.saturation import saturated_share
from repro.logs.units import SPELLINGS, si_factor
from repro.model.parameters import Array

#: Shortest recording, s, and fewest samples.
SHORTEST, FEWEST = 2.0, 200
#: Rates that an arm is recorded at, Hz.
SLOWEST, FASTEST = 5.0, 20e3
#: Those that most are, Hz.
_LIKELY = (20.0, 10e3)
#: Range of positions below which a joint does not move, rad.
STILL = 0.02
#: Largest magnitudes of a time (in the file), a position (rad), a velocity (rad/s) and a torque (N m).
_LARGEST_TIME, _LARGEST = 1e30, (("position", 1e6, "rad"), ("velocity", 1e9, "rad/s"), ("torque", 1e9, "N m"))
#: Smallest of the largest torques of a joint, N m: the square of a smaller one is nothing in double precision.
_SMALLEST = 1e-12
#: Share of samples at the torque limit above which nothing else is left.
_ALL = 0.9


def check_time(time: Array, recorded: Array, unit: str, file: str, lines: Sequence[int] | NDArray[np.int64]) -> None:
    """Check the time column."""
    if time.size < FEWEST:
        raise InputError.at(file, f"{time.size} samples", f"at least {FEWEST}")
    if np.abs(recorded).max() > _LARGEST_TIME:
        raise InputError.at(f"{file}: time", f"{np.abs(recorded).max():.3g} {unit}", f"at most {_LARGEST_TIME:g}")
    steps = np.diff(recorded)
    wrong = np.flatnonzero(steps <= 0.0)
    if wrong.size:
        k = int(wrong[0])
        now, before = (f"{value:.10g} {unit}" for value in (recorded[k + 1], recorded[k]))
        digits = " (too few digits?)" if np.all(steps[wrong] == 0.0) and wrong.size > 0.05 * steps.size else ""
        found = f"{now} twice{digits}" if steps[k] == 0.0 else f"{now} after {before}"
        raise InputError.at(f"{file}: line {lines[k + 1]}, time", found, "time that increases")
    rate = 1.0 / float(np.median(np.diff(time)))
    if not SLOWEST <= rate <= FASTEST:
        period = float(np.median(steps))
        found = f"a period of {period:.4g} {unit}, so a rate of {rate:.4g} Hz"
        rates = {other: 1.0 / (period * si_factor("time", other, Arm())) for other in SPELLINGS["time"]}
        likely = [f"{other} ({hz:.4g} Hz)" for other, hz in rates.items() if _LIKELY[0] <= hz <= _LIKELY[1]]
        unless = f"unless time is in {' or '.join(likely)}: then give" if likely else "or another unit of time:"
        expected = f"{SLOWEST:g} to {FASTEST:g} Hz, {unless} units.time in the arm file"
        raise InputError.at(f"{file}: time", found, expected)
    if time[-1] - time[0] < SHORTEST:
        raise InputError.at(file, f"{time[-1] - time[0]:.3g} s", f"at least {SHORTEST:g} s")


def check_signals(log: Log, file: str) -> None:
    """Check that the arm moves and is driven."""
    for signal, (kind, most, unit) in zip((log.q, log.dq, log.tau), _LARGEST, strict=True):
        if signal is not None and np.abs(signal).max() > most:
            raise InputError.at(f"{file}: {kind}", f"{np.abs(signal).max():.3g} {unit}", f"at most {most:g} {unit}")
    moved = np.ptp(log.q, axis=1)
    if moved.max() < STILL:
        found = f"an arm that does not move ({moved[0]:.2g} and {moved[1]:.2g} rad)"
        raise InputError.at(f"{file}: position", found, f"joints that move by {STILL:g} rad and more")
    for joint, tau in enumerate(log.tau, 1):
        if np.ptp(tau) == 0.0:
            found = "zero throughout" if tau[0] == 0.0 else f"{tau[0]:.6g} N m throughout"
            raise InputError.at(f"{file}: torque of joint {joint}", found, "a torque that changes")
        if np.abs(tau).max() < _SMALLEST:
            found = f"{np.abs(tau).max():.3g} N m at most"
            raise InputError.at(f"{file}: torque of joint {joint}", found, f"a torque of {_SMALLEST:g} N m and more")
    for joint, share in enumerate(saturated_share(log), 1):
        if share > _ALL:
            found = f"saturated throughout ({100.0 * share:.0f} % of the samples at the limit)"
            raise InputError.at(f"{file}: torque of joint {joint}", found, "a torque below the drive's limit")
