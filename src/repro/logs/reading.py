"""From a file to a `Log`: columns, units, signs, zeros, and what cannot be worked on."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from repro.errors import InputError
from repro.fpga.capture import read_capture
from repro.fpga.recording import recording_of
from repro.logs.armfile import Arm
from repro.logs.bag import is_bag, read_bag
from repro.logs.checks import FEWEST, check_signals, check_time
from repro.logs.header import SIMULATED, find_columns
from repro.logs.log import Log
from repro.logs.table import in_words, read_table
from repro.logs.uniform import stretches
from repro.logs.units import KINDS, Signal, si_factor
from repro.model.parameters import Array

#: Steps within this of a full turn are the wrap of an angle, as a share of the turn.
_WRAP = 0.05


def read_log(path: Path, arm: Arm) -> Log:
    """Read a recording.

    Parameters
    ----------
    path : Path
        Capture ``NAME.bin`` with its sidecar, ROS 2 bag, or else a CSV table.
    arm : Arm
        What the recording means where it does not say so itself. Columns and units are not for captures.

    Returns
    -------
    Log
        SI, angles of Eq. 1.

    Raises
    ------
    InputError
        If the file cannot be read, a column or unit is missing or unclear, a cell is no number, time does not
        increase, the recording is too short, the arm does not move, a torque tells nothing, or gaps leave no
        stretch that is long enough.
    """
    if path.is_dir() and not is_bag(path):
        raise InputError.at(str(path), "a folder", "a CSV table, a capture NAME.bin, or a ROS 2 bag")
    raw = _from_capture(path, arm) if path.suffix == ".bin" else _from_table(path, arm)
    limit = raw.torque_limit if arm.torque_limit is None else np.array(arm.torque_limit)
    with np.errstate(over="ignore"):  # what is beyond double precision is refused below
        log = replace(_to_eq1(raw, arm), torque_limit=limit)
    check_signals(log, str(path))
    stretches(log)  # refuses a log that is all gaps
    return log


def _from_capture(path: Path, arm: Arm) -> Log:
    """Read a capture, which states its units itself."""
    capture = read_capture(path)
    metadata, recording = capture.metadata, recording_of(capture)
    t = np.asarray(metadata.h * np.arange(metadata.samples), dtype=np.float64)
    check_time(t, t, "s", str(path), range(1, metadata.samples + 1))
    notes = [f"capture of the motion {metadata.motion}"]
    if arm.columns or arm.units:
        notes.append(f"columns and units of {arm.file} are not used: a capture has its own")
    if recording.n_interpolated:
        notes.append(f"{recording.n_interpolated} lost samples are interpolated")
    simulated = metadata.source == "simulated"
    limit = np.array(metadata.control.full_torque)
    return Log(path.name, t, recording.q, recording.tau, None, tuple(notes), simulated, limit)


def _from_table(path: Path, arm: Arm) -> Log:
    """A table or bag in SI, signs and zeros as recorded."""
    table = read_bag(path, arm.topic) if is_bag(path) else read_table(path)
    columns, notes = find_columns(table.header, arm, table.file)
    values, lines, more = table.numbers([column.index for column in columns.values()])
    kept, told = _full_rows(table.file, lines, list(columns), values)
    notes = (*table.notes, *more, *notes, *told)
    recorded = {signal: row for signal, row in zip(columns, values[:, kept], strict=True) if not np.isnan(row).any()}
    factors = {signal: si_factor(signal, str(columns[signal].unit), arm, table.file) for signal in recorded}
    si = {signal: factors[signal] * values for signal, values in recorded.items()}
    time = si["time"]
    check_time(time, recorded["time"], str(columns["time"].unit), table.file, lines[kept])
    if time[0] != 0.0:
        notes = (*notes, f"time is counted from the first sample, at {time[0]:.10g} s in the file")
    pairs: Sequence[tuple[Signal, Signal]] = (("q1", "q2"), ("tau1", "tau2"), ("dq1", "dq2"))
    q, tau, dq = (np.stack([si[a], si[b]]) if a in si and b in si else None for a, b in pairs)
    assert q is not None
    assert tau is not None
    simulated = SIMULATED in table.header and bool(np.any(table.numbers([table.header.index(SIMULATED)])[0] != 0.0))
    return Log(path.name, time - time[0], q, tau, dq, notes, simulated)


def _full_rows(
    file: str, lines: NDArray[np.int64], signals: Sequence[Signal], values: Array
) -> tuple[NDArray[np.intp], list[str]]:
    """Rows without an empty cell that are no copy of the row before, and what is said of the others."""
    needed = [KINDS[signal] != "velocity" for signal in signals]
    empty = np.isnan(values[needed]).any(0)
    kept, notes = np.flatnonzero(~empty), []
    if kept.size < min(FEWEST, empty.size):
        found = f"an empty cell there and in {empty.sum() - 1} more of {empty.size} rows"
        row = int(np.argmax(empty))
        raise InputError.at(f"{file}: line {lines[row]}", found, f"at least {FEWEST} full rows")
    full = values[:, kept]
    with np.errstate(over="ignore"):  # the size of numbers is checked later
        copies = np.r_[False, ((full[:, 1:] == full[:, :-1]) | np.isnan(full[:, 1:] + full[:, :-1])).all(0)]
    for rows, words in ((np.flatnonzero(empty), "with empty cells"), (kept[copies], "equal to the one before")):
        if rows.size:
            plural, where = "s" * (rows.size > 1), in_words(lines[rows])
            notes.append(f"{rows.size} row{plural} {words} left out: {where}")
    if np.isnan(full).any():
        notes.append("velocity is ignored, because it has empty cells of its own")
    return kept[~copies], notes


def _to_eq1(log: Log, arm: Arm) -> Log:
    """Signs, zeros and wraps put right, joint 2 relative to link 1."""
    sign = np.array(arm.sign)[:, np.newaxis]
    q, wraps = _unwrapped(log.q)
    q = sign * (q - np.array(arm.zero)[:, np.newaxis])
    offset, scale = (np.array(pair)[:, np.newaxis] for pair in (arm.torque_offset, arm.torque_scale))
    tau = sign * np.array(arm.torque_sign)[:, np.newaxis] * (log.tau - offset) / scale
    dq = None if log.dq is None else sign * log.dq
    notes = list(log.notes)
    for joint, count in enumerate(wraps, 1):
        if count:
            notes.append(f"position of joint {joint} wraps by a full turn {count} times; unwrapped")
    if arm.second_joint_absolute:
        q = np.stack([q[0], q[1] - q[0]])
        dq = None if dq is None else np.stack([dq[0], dq[1] - dq[0]])
        notes.append("q2 was measured from the vertical; q1 is subtracted")
    return replace(log, q=q, tau=tau, dq=dq, notes=tuple(notes))


def _unwrapped(q: Array) -> tuple[Array, tuple[int, ...]]:
    """Positions without steps of a full turn between two samples, and how many there were on each joint."""
    turn = 2.0 * np.pi
    steps = np.diff(q, axis=1)
    turns = np.where(np.abs(np.abs(steps) - turn) < _WRAP * turn, np.sign(steps), 0.0)
    whole = np.concatenate([np.zeros((2, 1)), np.cumsum(turns, axis=1)], axis=1)
    return q - turn * whole, tuple(int(n) for n in np.count_nonzero(turns, axis=1))
