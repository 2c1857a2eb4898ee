"""Capture files: the raw bytes of a recording, what the board was sent, and a JSON sidecar that vouches for both."""

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
from repro.files import write_json, write_whole
from repro.fpga.about import About, Reason
from repro.fpga.frames import RADIANS_PER_COUNT, Int16Array
from repro.fpga.parser import StreamParser
from repro.fpga.sidecar import about_of, check_sidecar, check_sum, sidecar
from repro.fpga.stream import Counts, Gap
from repro.model.parameters import Array

#: Suffix of the file that holds what the board was sent.
PROGRAM = ".program"
#: Largest file of a capture, bytes: the board's memory holds a motion of 64 KiB.
LARGEST = 4 << 20


@dataclass(frozen=True)
class Capture:
    """A recording and what its bytes decode to."""

    place: str  # name of the file, for messages
    about: About  # what was recorded, and with what
    data: bytes  # as received
    position: Int16Array  # (2, n), encoder and PWM counts of the frames that arrived
    pwm: Int16Array
    index: NDArray[np.int64]  # (n,), sample that each frame is; a gap counts with its estimate of the frames lost
    gaps: tuple[Gap, ...]  # interruptions
    counts: Counts  # what became of every byte
    reason: Reason  # why the recording ended early

    @property
    def complete(self) -> bool:
        """Whether the recording reached the end of the motion."""
        return self.reason == ""

    @cached_property
    def time(self) -> Array:
        """Sampling instants, s, shape (n,)."""
        return np.asarray(self.index * self.about.h)

    @cached_property
    def q(self) -> Array:
        """Joint positions, rad, shape (2, n)."""
        return np.asarray(self.position * np.float64(RADIANS_PER_COUNT))

    @cached_property
    def tau(self) -> Array:
        """Joint torques, N m, shape (2, n)."""
        return np.asarray(self.pwm * self.about.control.torque_per_count[:, np.newaxis])


def decode_capture(data: bytes, about: About, reason: Reason = "", place: str = "recording") -> Capture:
    """Read the bytes of a recording."""
    parser = StreamParser()
    parts = (parser.feed(data), parser.finish())
    position = np.concatenate([part.position for part in parts], axis=1)
    pwm = np.concatenate([part.pwm for part in parts], axis=1)
    lost_before = np.zeros(position.shape[1] + 1, dtype=np.int64)
    for gap in parser.gaps:
        lost_before[gap.next_frame] += gap.lost
    index = np.arange(position.shape[1]) + np.cumsum(lost_before)[:-1]
    return Capture(place, about, data, position, pwm, index, tuple(parser.gaps), parser.counts, reason)


def write_capture(path: Path, data: bytes, about: About, reason: Reason = "", overwrite: bool = False) -> Capture:
    """Write a recording, what was sent and the sidecar; all are there afterwards, or none."""
    check_target(path, overwrite)
    capture = decode_capture(data, about, reason, str(path))
    write_bytes(path, data)
    try:
        write_bytes(path.with_suffix(PROGRAM), about.program)
        write_json(path.with_suffix(".json"), sidecar(about, data, capture.counts, reason))
    except BaseException:
        for each in files_of(path):  # what is left of the capture that was to be replaced fits no longer
            if each.is_file():
                each.unlink()
        raise
    return capture


def files_of(path: Path) -> tuple[Path, Path, Path]:
    """The files of a capture ``NAME.bin``: as received, what was sent, and the sidecar."""
    return path, path.with_suffix(PROGRAM), path.with_suffix(".json")


def write_bytes(path: Path, data: bytes) -> None:
    """Write a file that is whole or absent, read-only afterwards."""

    def fill(temporary: Path) -> None:
        temporary.write_bytes(data)

    write_whole(path, fill)
    path.chmod(0o444)


def check_target(path: Path, overwrite: bool) -> None:
    """Refuse a name that a capture cannot be written to."""
    if path.suffix != ".bin":
        raise InputError.at(str(path), f"the suffix {path.suffix!r}", "a capture NAME.bin")
    folder = next(parent for parent in path.absolute().parents if parent.exists())
    if not (folder.is_dir() and os.access(folder, os.W_OK)):
        raise InputError.at(str(path), f"{folder.name}, where nothing can be written", "a name in a folder of yours")
    for each in files_of(path):
        if each.exists() and not overwrite:
            raise InputError.at(str(each), "a file", "a new name, or --overwrite")


def read_capture(path: Path) -> Capture:
    """Read a capture and check it against its sidecar.

    Parameters
    ----------
    path : Path
        ``NAME.bin``.

    Returns
    -------
    Capture
        Decoded.

    Raises
    ------
    InputError
        If a file is missing, the sidecar is not what it should be, or the bytes are not those it vouches for.
    """
    if path.suffix != ".bin":
        raise InputError.at(str(path), f"the suffix {path.suffix!r}", "a capture NAME.bin")
    _, sent, beside = files_of(path)
    data = read_bytes(path, LARGEST, "a capture")
    content = check_sidecar(str(beside), read_json(beside))
    check_bytes(path, data, content)
    program = read_bytes(sent, LARGEST, "a capture")
    check_bytes(sent, program, content["program"])
    try:
        about = about_of(content, program)
    except ValueError as error:
        raise InputError.at(str(sent), str(error), f"what {beside.name} says") from error
    capture = decode_capture(data, about, content["reason"], str(path))
    for name, counted in asdict(capture.counts).items():
        if content["counts"][name] != counted:
            raise InputError.at(f"{beside}: counts.{name}", content["counts"][name], f"{counted}, as in {path.name}")
    check_sum(str(beside), content)
    return capture


def check_bytes(path: Path, data: bytes, vouched: Mapping[str, Any]) -> None:
    """Refuse bytes that are not those a sidecar vouches for."""
    if len(data) != vouched["bytes"]:
        raise InputError.at(f"{path}: size", f"{len(data)} bytes", f"the {vouched['bytes']} of {path.stem}.json")
    digest = hashlib.sha256(data).hexdigest()
    if digest != vouched["sha256"]:
        raise InputError.at(f"{path}: SHA-256", digest, f"the {vouched['sha256']} of {path.stem}.json")
