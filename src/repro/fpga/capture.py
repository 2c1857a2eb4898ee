"""Capture files: the raw bytes of a recording, the bytes sent to the board, and a JSON sidecar with their checksums."""

import hashlib
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from repro.documents import read_bytes, read_json
from repro.errors import InputError
from repro.files import atomic_write, write_json
from repro.fpga.frames import RADIANS_PER_COUNT, Int16Array
from repro.fpga.parser import Counts, Gap, StreamParser
from repro.fpga.sidecar import CaptureMetadata, check_own_sum, check_sidecar, metadata_from, sidecar
from repro.model.parameters import Array

#: Suffix of the file with the bytes sent to the board.
PROGRAM = ".program"
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
    parts = (parser.feed(data), parser.finish())
    position = np.concatenate([part.position for part in parts], axis=1)
    pwm = np.concatenate([part.pwm for part in parts], axis=1)
    lost_before = np.zeros(position.shape[1] + 1, dtype=np.int64)
    for gap in parser.gaps:
        lost_before[gap.next_frame] += gap.lost
    index = np.arange(position.shape[1]) + np.cumsum(lost_before)[:-1]
    return Capture(place, metadata, data, position, pwm, index, tuple(parser.gaps), parser.counts)


def write_capture(path: Path, data: bytes, metadata: CaptureMetadata, overwrite: bool = False) -> Capture:
    """Write ``NAME.bin``, ``NAME.program`` and ``NAME.json``, all or none, and give the decoded capture."""
    check_target(path, overwrite)
    capture = decode_capture(data, metadata, str(path))
    _write_bytes(path, data)
    try:
        _write_bytes(path.with_suffix(PROGRAM), metadata.program)
        write_json(path.with_suffix(".json"), sidecar(metadata, data, capture.counts))
    except BaseException:
        for file in files_of(path):  # the rest of a capture that was to be replaced no longer fits
            if file.is_file():
                file.unlink()
        raise
    return capture


def files_of(path: Path) -> tuple[Path, Path, Path]:
    """Name the files of a capture: ``NAME.bin``, ``NAME.program`` and ``NAME.json``."""
    return path, path.with_suffix(PROGRAM), path.with_suffix(".json")


def _write_bytes(path: Path, data: bytes) -> None:
    """Write a file that is whole or absent, read-only afterwards."""
    atomic_write(path, lambda temporary: temporary.write_bytes(data))
    path.chmod(0o444)


def check_target(path: Path, overwrite: bool) -> None:
    """Refuse a name that is not ``NAME.bin``, is in a folder that cannot be written, or is in use."""
    _check_suffix(path)
    folder = next(parent for parent in path.absolute().parents if parent.exists())
    if not (folder.is_dir() and os.access(folder, os.W_OK)):
        raise InputError.at(str(path), f"{folder.name}, where nothing can be written", "a name in a folder of yours")
    for file in files_of(path):
        if file.exists() and not overwrite:
            raise InputError.at(str(file), "a file", "a new name, or --overwrite")


def _check_suffix(path: Path) -> None:
    if path.suffix != ".bin":
        raise InputError.at(str(path), f"the suffix {path.suffix!r}", "a capture NAME.bin")


def read_capture(path: Path) -> Capture:
    """Read a capture and check it against its sidecar.

    Parameters
    ----------
    path : Path
        ``NAME.bin``, with ``NAME.program`` and ``NAME.json`` next to it.

    Returns
    -------
    Capture
        Decoded, with positions (rad) and torques (N m).

    Raises
    ------
    InputError
        If a file is missing, or differs in size, checksum or content from what the sidecar states.
    """
    _check_suffix(path)
    _, program_file, sidecar_file = files_of(path)
    data = read_bytes(path, LARGEST, "a capture")
    content = check_sidecar(str(sidecar_file), read_json(sidecar_file))
    _check_bytes(path, data, content)
    program = read_bytes(program_file, LARGEST, "a capture")
    _check_bytes(program_file, program, content["program"])
    try:
        metadata = metadata_from(content, program)
    except ValueError as error:
        raise InputError.at(str(program_file), str(error), f"what {sidecar_file.name} says") from error
    capture = decode_capture(data, metadata, str(path))
    for name, count in asdict(capture.counts).items():
        if content["counts"][name] != count:
            expected = f"{count}, as in {path.name}"
            raise InputError.at(f"{sidecar_file}: counts.{name}", content["counts"][name], expected)
    check_own_sum(str(sidecar_file), content)
    return capture


def _check_bytes(path: Path, data: bytes, stated: Mapping[str, Any]) -> None:
    """Refuse bytes of another size or checksum than the sidecar states."""
    if len(data) != stated["bytes"]:
        raise InputError.at(f"{path}: size", f"{len(data)} bytes", f"the {stated['bytes']} of {path.stem}.json")
    digest = hashlib.sha256(data).hexdigest()
    if digest != stated["sha256"]:
        raise InputError.at(f"{path}: SHA-256", digest, f"the {stated['sha256']} of {path.stem}.json")
