"""Read a recording as a `Log`: columns, units, signs and zeros; refuse what cannot be identified from."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from repro.board.capture import read_capture, recording_of
from repro.errors import InputError, shown
from repro.identification.armfile import Arm, Signal, read_arm
from repro.identification.log import MIN_LENGTH_S, MIN_RANGE_RAD, MIN_SAMPLES, Log, segments
from repro.logs.bag import is_bag, read_bag
from repro.logs.columns import KINDS, SIMULATED, SPELLINGS, find_columns, si_factor, unused_constants
from repro.logs.instants import continued, merged, unwrapped
from repro.logs.table import Table, list_lines, read_table, table_of
from repro.logs.torque_limits import saturated
from repro.model.parameters import Array

_MIN_RATE_HZ, _MAX_RATE_HZ = 5.0, 20e3  # rates that an arm is recorded at
_LIKELY_RATES_HZ = (20.0, 10e3)  # rates that most arms are recorded at
#: Largest magnitudes of a time (in the file), a position (rad), a velocity (rad/s) and a torque (N m).
_MAX_TIME, _MAX_MAGNITUDES = 1e30, (("position", 1e6, "rad"), ("velocity", 1e9, "rad/s"), ("torque", 1e9, "N m"))
_MAX_RATE_ERROR = 1e-3  # relative difference from a whole number of Hz up to which a rate is that number
_MIN_TORQUE_NM = 1e-12  # largest torque of a joint that is large enough: the square of a smaller one underflows
_MAX_SATURATED = 0.9  # fraction of samples at the torque limit, above which a log is refused
_TURN = 2.0 * np.pi
_MAX_RANGE_WITHOUT_UNIT = 2.0 * _TURN  # range of a position, rad, beyond which its unit must be stated
#: What a recording is read from.
Source = Path | pd.DataFrame | Log
_MAX_WRAP_ERROR = 0.05  # difference of a step from a full turn, in turns, below which it is the wrap of an angle


def read_log(source: str | Source, arm: str | Path | Arm | None = None) -> Log:
    """Read a recording as SI and angles of Eq. 1.

    Parameters
    ----------
    source : path, DataFrame or Log
        Capture ``NAME.bin`` with its sidecar, ROS 2 bag, or else a CSV table; a DataFrame has the columns of a table;
        arrays of a `Log` are SI.
    arm : path or Arm, optional
        Conventions that the recording does not state itself. Columns and units are for tables alone;
        units are refused for a `Log`.

    Returns
    -------
    Log
        Times, positions and torques; velocities if they were recorded.

    Raises
    ------
    InputError
        If the file cannot be read, a column or unit is missing or unclear, a cell is no number, time does not increase,
        the recording is too short, the arm does not move, a torque is constant, or gaps leave no stretch that is long
        enough.

    Examples
    --------
    >>> run = repro.read_log("data/captures/ID.bin")
    >>> run.q.shape, run.simulated
    ((2, 4694), True)
    """
    arm = arm if isinstance(arm, Arm) else read_arm(arm)
    source = Path(source) if isinstance(source, str) else source
    if isinstance(source, Log):
        place, raw = source.name, _from_arrays(source, arm)
    elif isinstance(source, pd.DataFrame):
        place, raw = "data frame", _from_table(table_of(source, "data frame"), "data frame", arm)
    elif not isinstance(source, Path):
        raise InputError.at("source", type(source).__name__, "a path, a DataFrame or a Log")
    elif source.is_dir() and not is_bag(source):
        raise InputError.at(str(source), "a folder", "a CSV table, a capture NAME.bin, or a ROS 2 bag")
    elif source.suffix == ".bin":
        place, raw = str(source), _from_capture(source, arm)
    else:
        table = read_bag(source, arm.topic) if is_bag(source) else read_table(source)
        place, raw = str(source), _from_table(table, shown(source.name), arm)
    if arm.topic and not (isinstance(source, Path) and is_bag(source)):
        raw = replace(raw, notes=(*raw.notes, f"topic of {arm.file} is not used: {raw.name} is no bag"))
    with np.errstate(over="ignore"):  # numbers beyond double precision are refused below
        log = to_eq1(raw, arm)
    log = log if arm.torque_limit is None else replace(log, torque_limit=np.array(arm.torque_limit))
    passive = [joint for joint, tau in enumerate(log.tau, 1) if not tau.any()]
    said = (f"the torque of joint {joint} is zero throughout: read as a joint without a drive" for joint in passive)
    log = replace(log, notes=(*log.notes, *said))
    _check_signals(log, place)
    segments(log)  # refuses a log that is all gaps
    return log


def _from_arrays(log: Log, arm: Arm) -> Log:
    """Check the times of arrays; refuse units, which would have no effect."""
    for key in ("units", "counts_per_turn", "torque_constant"):
        if given := getattr(arm, key):
            expected = f"none, because the arrays of a Log are SI: convert those of {log.name}"
            raise InputError.at(f"{arm.file}: {key}", given, expected)
    _check_time(log.t, log.t, "s", log.name, range(1, log.t.size + 1))
    unused = (f"columns of {arm.file} are not used: a Log has none",) if arm.columns else ()
    return replace(log, t=log.t - log.t[0], breaks=(), left_out=None, notes=(*log.notes, *unused))


def _from_capture(path: Path, arm: Arm) -> Log:
    """Read a capture, which states its units itself."""
    capture = read_capture(path)
    metadata, (q, tau) = capture.metadata, recording_of(capture)
    t = np.asarray(metadata.h * np.arange(metadata.samples), dtype=np.float64)
    _check_time(t, t, "s", str(path), range(1, metadata.samples + 1))
    notes = [f"capture of the motion {metadata.motion}"]
    if arm.columns or arm.units or arm.counts_per_turn or arm.torque_constant:
        notes.append(f"columns, units and constants of {arm.file} are not used: a capture has its own")
    if lost := metadata.samples - capture.counts.good:
        notes.append(f"{lost} lost samples are interpolated")
    simulated, limit = metadata.source == "simulated", np.array(metadata.control.full_torque)
    return Log(name=shown(path.name), t=t, q=q, tau=tau, notes=tuple(notes), simulated=simulated, torque_limit=limit)


def _from_table(table: Table, name: str, arm: Arm) -> Log:
    """Read a table or bag in SI, signs and zeros as recorded."""
    columns, notes = find_columns(table.header, arm, table.file)
    notes = (*notes, *unused_constants(columns, arm, table.file))
    place = list(columns).index("time") if "time" in columns else None
    values, lines, more = table.numbers([column.index for column in columns.values()], place)
    if place is not None:
        needed = np.array([KINDS[signal] != "velocity" for signal in columns])
        values[place], wraps = continued(values[place])
        values, whole, joined = merged(values, needed, place)
        lines = lines[whole]
        more = (*more, *filter(None, (wraps and f"time is {wraps} that begins again; it is continued", joined)))
    rows, left_out = _full_rows(table.file, lines, list(columns), values)
    notes = (*table.notes, *more, *notes, *left_out)
    recorded = {signal: x for signal, x in zip(columns, values[:, rows], strict=True) if not np.isnan(x).any()}
    positions: tuple[Signal, Signal] = ("q1", "q2")
    for position in positions:
        if columns[position].unit == "counts":
            recorded[position], modulus = unwrapped(recorded[position])
            if modulus:
                angle = modulus * si_factor(position, "counts", arm, table.file)
                full_turns = (
                    abs(angle / _TURN - round(angle / _TURN)) < _MAX_WRAP_ERROR
                )  # full turns do not change the zero
                known = (
                    "" if full_turns else f": its zero in the arm file is known but for multiples of {angle:.5g} rad"
                )
                notes = (*notes, f"{position} wraps at {modulus} counts; unwrapped{known}")
    si = {signal: si_factor(signal, str(columns[signal].unit), arm, table.file) * x for signal, x in recorded.items()}
    if arm.sampling_rate is not None:
        si["time"], recorded["time"] = (np.arange(values.shape[1], dtype=np.float64)[rows] / arm.sampling_rate,) * 2
    for joint in positions:
        if columns[joint].assumed and np.ptp(si[joint]) > _MAX_RANGE_WITHOUT_UNIT:
            turned = float(np.ptp(si[joint]))
            found, degrees = f"no unit, and {turned / _TURN:.3g} turns if it is rad", f"{np.radians(turned):.3g} rad"
            expected = f"in the arm file units: {{position: deg}}, which makes it {degrees}, or counts, or rad"
            raise InputError.at(f"{table.file}: {columns[joint].header}", found, expected)
    time = si["time"]
    unit = "s" if arm.sampling_rate is not None else str(columns["time"].unit)
    _check_time(time, recorded["time"], unit, table.file, lines[rows])
    if time[0] != 0.0:
        notes = (*notes, f"time is counted from the first sample, at {time[0]:.10g} s in the file")
    if arm.passive_joint is not None:
        torque: Signal = "tau1" if arm.passive_joint == 1 else "tau2"
        si[torque] = np.zeros_like(time)
    q, tau = np.stack([si["q1"], si["q2"]]), np.stack([si["tau1"], si["tau2"]])
    dq = np.stack([si["dq1"], si["dq2"]]) if "dq1" in si and "dq2" in si else None
    simulated = SIMULATED in table.header and bool(np.any(table.numbers([table.header.index(SIMULATED)])[0] != 0.0))
    return Log(name=name, t=time - time[0], q=q, tau=tau, dq=dq, notes=notes, simulated=simulated)


def _full_rows(
    file: str, lines: NDArray[np.int64], signals: Sequence[Signal], values: Array
) -> tuple[NDArray[np.intp], list[str]]:
    """Select rows without an empty cell that are no copy of the row before, with notes on the others."""
    needed = [KINDS[signal] != "velocity" for signal in signals]
    empty = np.isnan(values[needed]).any(0)
    full_rows, notes = np.flatnonzero(~empty), []
    if full_rows.size < min(MIN_SAMPLES, empty.size):
        worst = signals[int(np.argmax(np.isnan(values).sum(1) * needed))]
        found = f"an empty cell there and in {empty.sum() - 1} more of {empty.size} rows, most of {worst}"
        row = int(np.argmax(empty))
        expected = f"at least {MIN_SAMPLES} full rows"
        if KINDS[worst] == "torque" and np.isnan(values[signals.index(worst)]).all():
            expected += f", or in the arm file passive_joint: {worst[-1]} if joint {worst[-1]} has no drive"
        raise InputError.at(f"{file}: line {lines[row]}", found, expected)
    full = values[:, full_rows]
    with np.errstate(over="ignore"):  # the size of numbers is checked later
        copies = np.r_[False, ((full[:, 1:] == full[:, :-1]) | np.isnan(full[:, 1:] + full[:, :-1])).all(0)]
    copies &= "time" in signals  # evenly spaced samples may be equal
    for rows, reason in ((np.flatnonzero(empty), "with empty cells"), (full_rows[copies], "equal to the one before")):
        if rows.size:
            plural, where = "s" * (rows.size > 1), list_lines(lines[rows])
            notes.append(f"{rows.size} row{plural} {reason} left out: {where}")
    if np.isnan(full).any():
        notes.append("velocity is ignored, because it has empty cells of its own")
    return full_rows[~copies], notes


def to_eq1(log: Log, arm: Arm) -> Log:
    """Correct signs, zeros and wraps, and make joint 2 relative to link 1."""
    pairs = (arm.sign, arm.zero, arm.torque_offset, arm.torque_scale, arm.torque_sign)
    sign, zero, offset, scale, torque_sign = (np.array(pair)[:, np.newaxis] for pair in pairs)
    steps = np.diff(log.q, axis=1, prepend=log.q[:, :1])
    turns = np.where(np.abs(np.abs(steps) - _TURN) < _MAX_WRAP_ERROR * _TURN, np.sign(steps), 0.0)
    q = sign * (log.q - _TURN * np.cumsum(turns, axis=1) - zero)
    tau = sign * torque_sign * (log.tau - offset) / scale
    limit = None if log.torque_limit is None else (log.torque_limit - np.abs(offset[:, 0])) / scale[:, 0]
    dq = None if log.dq is None else sign * log.dq
    wraps = [(joint, count) for joint, count in enumerate(np.count_nonzero(turns, axis=1), 1) if count]
    notes = [f"position of joint {joint} wraps by a full turn {count} times; unwrapped" for joint, count in wraps]
    if arm.second_joint_absolute:
        q = np.stack([q[0], q[1] - q[0]])
        dq = None if dq is None else np.stack([dq[0], dq[1] - dq[0]])
        notes.append("q2 was measured from the vertical; q1 is subtracted")
    return replace(log, q=q, tau=tau, dq=dq, torque_limit=limit, notes=(*log.notes, *notes))


def _check_time(time: Array, recorded: Array, unit: str, file: str, lines: Sequence[int] | NDArray[np.int64]) -> None:
    """Refuse too few samples, times that do not increase, and rates that no arm is recorded at."""
    if time.size < MIN_SAMPLES:
        raise InputError.at(file, f"{time.size} samples", f"at least {MIN_SAMPLES}")
    if np.abs(recorded).max() > _MAX_TIME:
        raise InputError.at(f"{file}: time", f"{np.abs(recorded).max():.3g} {unit}", f"at most {_MAX_TIME:g}")
    steps = np.diff(recorded)
    if (wrong := np.flatnonzero(steps <= 0.0)).size:
        k = int(wrong[0])
        now, before = (f"{value:.10g} {unit}" for value in (recorded[k + 1], recorded[k]))
        found = f"{now} twice" if steps[k] == 0.0 else f"{now} after {before}"
        expected = "time that increases; of two runs in one file, a file for each"
        if np.all(steps[wrong] == 0.0) and wrong.size > 0.05 * steps.size:
            found, expected = f"{found} (too few digits?)", "time that increases"
            ticks = np.flatnonzero(steps)
            if ticks.size > 1:
                rate = (ticks[-1] - ticks[0]) / (time[ticks[-1]] - time[ticks[0]])
                rate = round(rate) if abs(rate - round(rate)) < _MAX_RATE_ERROR * rate else rate
                expected += f"; if the samples are evenly spaced, write into the arm file: sampling_rate: {rate:.4g}"
        raise InputError.at(f"{file}: line {lines[k + 1]}, time", found, expected)
    rate = 1.0 / float(np.median(np.diff(time)))
    if not _MIN_RATE_HZ <= rate <= _MAX_RATE_HZ:
        period = float(np.median(steps))
        found = f"a period of {period:.4g} {unit}, so a rate of {rate:.4g} Hz"
        rates = {name: 1.0 / (period * si_factor("time", name, Arm())) for name in SPELLINGS["time"]}
        low, high = _LIKELY_RATES_HZ
        likely = [f"{name} ({hz:.4g} Hz)" for name, hz in rates.items() if low <= hz <= high]
        unless = f"unless time is in {' or '.join(likely)}: then" if likely else "or another unit of time:"
        named = likely[0].split()[0] if len(likely) == 1 else "UNIT"
        expected = (
            f"{_MIN_RATE_HZ:g} to {_MAX_RATE_HZ:g} Hz, {unless} write into the arm file: units: {{time: {named}}}"
        )
        raise InputError.at(f"{file}: time", found, expected)
    if time[-1] - time[0] < MIN_LENGTH_S:
        raise InputError.at(file, f"{time[-1] - time[0]:.3g} s", f"at least {MIN_LENGTH_S:g} s")


def _check_signals(log: Log, file: str) -> None:
    """Refuse absurd magnitudes, an arm that does not move, and torques that are constant or always at the limit."""
    for signal, (kind, most, unit) in zip((log.q, log.dq, log.tau), _MAX_MAGNITUDES, strict=True):
        if signal is not None and np.abs(signal).max() > most:
            raise InputError.at(f"{file}: {kind}", f"{np.abs(signal).max():.3g} {unit}", f"at most {most:g} {unit}")
    moved = np.ptp(log.q, axis=1)
    if moved.max() < MIN_RANGE_RAD:
        found = f"an arm that does not move ({moved[0]:.2g} and {moved[1]:.2g} rad)"
        raise InputError.at(f"{file}: position", found, f"joints that move by {MIN_RANGE_RAD:g} rad and more")
    for joint, tau in enumerate(log.tau, 1):
        place, most = f"{file}: torque of joint {joint}", np.abs(tau).max()
        if not tau.any() and moved[joint - 1] >= MIN_RANGE_RAD and np.ptp(log.tau) > 0.0:
            continue  # a joint without a drive
        if np.ptp(tau) == 0.0:
            found = "zero throughout" if tau[0] == 0.0 else f"{tau[0]:.6g} N m throughout"
            without = f", or in the arm file passive_joint: {joint} if the joint has no drive"
            alone = moved[joint - 1] >= MIN_RANGE_RAD and np.ptp(log.tau[2 - joint]) > 0.0  # the other joint is driven
            raise InputError.at(place, found, f"a torque that changes{without if alone else ''}")
        if most < _MIN_TORQUE_NM:
            raise InputError.at(place, f"{most:.3g} N m at most", f"a torque of {_MIN_TORQUE_NM:g} N m and more")
    for joint, fraction in enumerate(saturated(log).mean(axis=1), 1):
        if fraction > _MAX_SATURATED:
            found = f"saturated throughout ({100.0 * fraction:.0f} % of the samples at the limit)"
            raise InputError.at(
                f"{file}: torque of joint {joint}",
                found,
                "a torque below the drive's limit; torque_limit in the arm file if this is not it",
            )
