"""Capture files: the raw bytes of a recording, the bytes sent to the board, and a JSON sidecar with their checksums."""

import hashlib
import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from repro.board.controller import PDController
from repro.board.frames import RADIANS_PER_COUNT, Int16Array
from repro.board.parser import Counts, Gap, StreamParser
from repro.board.sidecar import CaptureMetadata, check_sidecar, metadata_from, own_sum, sidecar
from repro.documents import read_bytes, read_json
from repro.errors import InputError
from repro.files import atomic_write, write_json
from repro.model.parameters import Array

#: Largest file of a capture, bytes: the board's memory contains a motion of 64 KiB.
LARGEST = 4 << 20


@dataclass(frozen=True)
class Capture:
    """The bytes of a recording, decoded, and its metadata."""

    place: str  # name of the file, for messages
    metadata: CaptureMetadata
    data: bytes  # as received
    position: Int16Array  # (2, n), encoder counts of the frames that arrived
    pwm: Int16Array  # (2, n), PWM counts
    index: NDArray[np.int64]  # (n,), sample that each frame is; a gap counts with its estimate of the frames lost
    gaps: tuple[Gap, ...]
    counts: Counts

    @property
    def complete(self) -> bool:
        """Whether the recording reached the end of the motion."""
        return self.metadata.end_reason == ""

    @cached_property
    def time(self) -> Array:
        """Sampling instants (n,), s."""
        return np.asarray(self.index * self.metadata.h)

    @cached_property
    def q(self) -> Array:
        """Joint positions (2, n), rad."""
        return np.asarray(self.position * np.float64(RADIANS_PER_COUNT))

    @cached_property
    def tau(self) -> Array:
        """Joint torques (2, n), N m."""
        return np.asarray(self.pwm * self.metadata.control.torque_per_count[:, np.newaxis])


def decode_capture(data: bytes, metadata: CaptureMetadata, place: str = "recording") -> Capture:
    """Decode the bytes of a recording; `place` names it in messages."""
    parser = StreamParser()
    first, rest = parser.feed(data), parser.finish()
    position, pwm = np.hstack([first.position, rest.position]), np.hstack([first.pwm, rest.pwm])
    lost_before = np.zeros(position.shape[1] + 1, dtype=np.int64)
    for gap in parser.gaps:
        lost_before[gap.next_frame] += gap.lost
    index = np.arange(position.shape[1]) + np.cumsum(lost_before)[:-1]
    return Capture(place, metadata, data, position, pwm, index, tuple(parser.gaps), parser.counts)


def write_capture(path: Path, data: bytes, metadata: CaptureMetadata, overwrite: bool = False) -> Capture:
    """Write ``NAME.bin``, ``NAME.program`` and ``NAME.json``, all or none, and give the decoded capture."""
    check_target(path, overwrite)
    capture = decode_capture(data, metadata, str(path))
    _, program_file, sidecar_file = files_of(path)

    def write(file: Path, content: bytes) -> None:
        atomic_write(file, lambda temporary: temporary.write_bytes(content))
        file.chmod(0o444)

    write(path, data)
    try:
        write(program_file, metadata.program)
        write_json(sidecar_file, sidecar(metadata, data, capture.counts))
    except BaseException:
        for file in files_of(path):  # the rest of a capture that was to be replaced no longer fits
            if file.is_file():
                file.unlink()
        raise
    return capture


def files_of(path: Path) -> tuple[Path, Path, Path]:
    """Name the files of a capture: ``NAME.bin``, ``NAME.program`` and ``NAME.json``."""
    return path, path.with_suffix(".program"), path.with_suffix(".json")


def check_target(path: Path, overwrite: bool) -> None:
    """Refuse a name that is not ``NAME.bin``, is in a folder that cannot be written, or is in use."""
    _check_suffix(path)
    folder = next(parent for parent in path.absolute().parents if os.path.lexists(parent))
    if not (folder.is_dir() and os.access(folder, os.W_OK)):
        raise InputError.at(str(path), f"{folder.name}, where nothing can be written", "a name in a folder of yours")
    for file in files_of(path):
        if os.path.lexists(file) and not overwrite:
            raise InputError.at(str(file), "a file", "a new name, or --overwrite")


def _check_suffix(path: Path) -> None:
    if path.suffix != ".bin":
        raise InputError.at(str(path), f"the suffix {path.suffix!r}", "a capture NAME.bin")


def read_capture(path: str | Path) -> Capture:
    """Read a capture and check it against its sidecar.

    Parameters
    ----------
    path : path
        ``NAME.bin``, with ``NAME.program`` and ``NAME.json`` next to it.

    Returns
    -------
    Capture
        Decoded: ``time`` (n,), s; ``q`` (2, n), rad; ``tau`` (2, n), N m; ``complete``; ``metadata`` with the sampling
        period ``h`` and the samples ``n1`` to ``n2`` of the motion.

    Raises
    ------
    InputError
        If a file is missing, or differs in size, checksum or content from what the sidecar states.

    Examples
    --------
    >>> capture = repro.read_capture("data/captures/T3.bin")
    >>> capture.metadata.motion, capture.metadata.source, capture.metadata.h
    ('T3', 'simulated', 0.0025)
    """
    path = Path(path)
    _check_suffix(path)
    _, program_file, sidecar_file = files_of(path)
    data = read_bytes(path, LARGEST, "a capture")
    if not os.path.lexists(sidecar_file):
        expected = f"a capture with its {sidecar_file.name}; a table has another suffix, such as .csv"
        raise InputError.at(str(path), f"no {sidecar_file.name} next to it", expected)
    content = check_sidecar(str(sidecar_file), read_json(sidecar_file))
    _check_bytes(path, data, content)
    program = read_bytes(program_file, LARGEST, "a capture")
    _check_bytes(program_file, program, content["program"])
    try:
        metadata = metadata_from(content, program)
    except ValueError as error:
        found = str(error).removeprefix("program: ").rstrip(".")
        raise InputError.at(f"{program_file}: program", found, f"what {sidecar_file.name} says") from error
    capture = decode_capture(data, metadata, str(path))
    for name, count in capture.counts:
        if content["counts"][name] != count:
            expected = f"{count}, as in {path.name}"
            raise InputError.at(f"{sidecar_file}: counts.{name}", content["counts"][name], expected)
    own = own_sum(content)
    if content.get("sidecar_sha256", own) != own:  # recordings of earlier versions have no sum
        found = content["sidecar_sha256"]
        raise InputError.at(f"{sidecar_file}: sidecar_sha256", found, f"{own}, the sum of the other keys")
    return capture


def _check_bytes(path: Path, data: bytes, stated: Mapping[str, Any]) -> None:
    """Refuse bytes of another size or checksum than the sidecar states."""
    if len(data) != stated["bytes"]:
        raise InputError.at(f"{path}: size", f"{len(data)} bytes", f"the {stated['bytes']} of {path.stem}.json")
    digest = hashlib.sha256(data).hexdigest()
    if digest != stated["sha256"]:
        raise InputError.at(f"{path}: SHA-256", digest, f"the {stated['sha256']} of {path.stem}.json")


#: Most samples in a row that are interpolated.
LONGEST_GAP = 4


def recording_of(capture: Capture) -> tuple[Array, Array]:
    """Give positions (rad) and torques (N m), each (2, N), of a complete capture; short gaps are interpolated."""
    n, good, lost = capture.metadata.samples, len(capture.index), capture.counts.lost
    if not capture.complete:
        raise InputError.at(capture.place, f"an incomplete recording ({capture.metadata.end_reason})", "a complete one")
    for gap in capture.gaps:
        where = f"{capture.place}: byte {gap.offset}"
        if gap.lost > LONGEST_GAP:
            raise InputError.at(where, f"a gap of about {gap.lost} samples", f"at most {LONGEST_GAP}")
        if gap.lost and gap.next_frame in (0, good):
            raise InputError.at(where, f"a gap of about {gap.lost} samples", "gaps between samples only")
    if good + lost != n:
        raise InputError.at(f"{capture.place}: samples", f"{good} and about {lost} lost", f"{n} together")
    q1, q2, tau1, tau2 = (np.interp(np.arange(n), capture.index, joint) for joint in (*capture.q, *capture.tau))
    return np.stack([q1, q2]), np.stack([tau1, tau2])


def verify_control(capture: Capture) -> tuple[int, NDArray[np.int64]]:
    """Recompute the torque of each frame from the positions, bit by bit as the board does (Eq. 2).

    Gives the number of frames checked, all but those right after a gap, and the indices of those that differ. A
    flipped bit that the parser cannot see is found here, in its own frame or in the one after it.
    """
    index, constants, position = capture.index, capture.metadata.control, capture.position.astype(np.int32)
    checked = np.flatnonzero((np.diff(index, prepend=-1) == 1) & (index < capture.metadata.desired.shape[1]))
    q_d = capture.metadata.desired[:, index[checked]]
    control = PDController(constants.kp_counts, constants.kv_counts)
    # Each frame is one arm of the batch: one call with the position before, one with the position.
    control(q_d, position[:, np.maximum(checked - 1, 0)])
    pwm = control(q_d, position[:, checked])
    return checked.size, checked[(pwm != capture.pwm[:, checked]).any(axis=0)]


def to_table(capture: Capture) -> pd.DataFrame:
    """Tabulate the frames that arrived; `gap` is 1 where samples are missing before the frame."""
    gaps = np.zeros(len(capture.index) + 1, dtype=np.int64)
    gaps[[gap.next_frame for gap in capture.gaps if gap.lost]] = 1
    names = ("time_s", "q1_rad", "q2_rad", "tau1_Nm", "tau2_Nm", "q1_counts", "q2_counts", "pwm1", "pwm2", "gap")
    columns = (capture.time, *capture.q, *capture.tau, *capture.position, *capture.pwm, gaps[:-1])
    table = pd.DataFrame(dict(zip(names, columns, strict=True)))
    return table.assign(simulated=int(capture.metadata.source == "simulated"))
