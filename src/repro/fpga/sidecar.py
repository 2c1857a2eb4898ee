"""What was recorded and with what, and the JSON file that states it: its keys, and how they must agree."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from functools import cached_property
from typing import Annotated, Any, Literal

from pydantic import Field

from repro.documents import Section, spelled, violation
from repro.errors import InputError
from repro.fpga.controller import ControlConstants
from repro.fpga.frames import SingleArray
from repro.fpga.messages import parse_program
from repro.fpga.parser import Counts

#: Version of the layout of the sidecar.
FORMAT = 2

#: Why a recording ended before its last sample; empty if it did not.
EndReason = Literal["", "silent", "disconnected", "interrupted", "overrun"]


@dataclass(frozen=True)
class Host:
    """The host's end of the link during a recording."""

    port: str  # name or URL that was opened
    baud: int  # bits per second requested
    began: str  # when the arm was started, ISO 8601 with the offset from UTC
    chunks: tuple[tuple[int, float], ...]  # bytes received so far and the time since the start (s), about every 50 ms


@dataclass(frozen=True)
class CaptureMetadata:
    """What was recorded, and with what."""

    motion: str
    samples: int  # expected
    n1: int  # the trajectory proper is samples n1 to n2 - 1
    n2: int
    h: float  # sampling period, s
    program: bytes  # gains and desired positions as sent to the board
    control: ControlConstants
    board: Mapping[str, object] | None = None  # a simulated board's description of itself; None for real hardware
    host: Host | None = None  # None for a recording simulated in process
    end_reason: EndReason = ""

    @property
    def source(self) -> str:
        """``simulated`` or ``serial``."""
        return "serial" if self.board is None else "simulated"

    @cached_property
    def desired(self) -> SingleArray:
        """Desired positions (2, samples) as the board received them, rad."""
        return parse_program(self.program)[1]


# --- The JSON file ------------------------------------------------------------------------------------------------


def _expected(text: str, **field: Any) -> Any:  # noqa: ANN401
    """Declare what a value of the file should be."""
    return Field(json_schema_extra={"expected": text}, **field)


_Count = Annotated[int, Field(ge=0)]
_Digest = Annotated[str, _expected("a SHA-256 of 64 hexadecimal digits", pattern=r"^[0-9a-f]{64}\Z")]
_Size = Annotated[float, Field(ge=1e-6, le=1e9)]
_Pair = Annotated[tuple[_Size, _Size], Field(strict=False)]
_Chunk = Annotated[tuple[int, float], Field(strict=False)]


class _Trajectory(Section):
    n1: _Count
    n2: _Count


class _Program(Section):
    bytes: _Count
    sha256: _Digest
    recomputed: Literal[False]


class _Control(Section):
    kp: _Pair
    kv: _Pair
    pwm_hz: _Pair
    full_torque: _Pair
    kp_counts: _Pair
    kv_counts: _Pair


class _Counts(Section):
    received: _Count
    good: _Count
    skipped: _Count
    identifier: _Count
    zero_bits: _Count
    torque: _Count
    step: _Count
    unconfirmed: _Count
    incomplete: _Count
    gaps: _Count
    lost: _Count


class _Host(Section):
    port: str
    baud: _Count
    began: str
    chunks: list[_Chunk]


class Sidecar(Section):
    """Keys of ``NAME.json``."""

    format: int
    source: Literal["simulated", "serial"]
    board: dict[str, Any] | None
    motion: str = _expected("text without control characters", pattern=r"^[^\x00-\x1f\x7f-\x9f]*\Z")
    sampling_period_s: float = _expected("5e-05 to 0.2 s", ge=5e-5, le=0.2)
    samples_expected: _Count
    trajectory: _Trajectory
    program: _Program
    control: _Control
    counts: _Counts
    complete: bool
    reason: EndReason
    bytes: _Count
    sha256: _Digest
    # Recordings of earlier versions have no sum, and those within a process no link.
    sidecar_sha256: _Digest = Field(default="")
    host: _Host = _expected("the link that was recorded over", default=None)


def sidecar(metadata: CaptureMetadata, data: bytes, counts: Counts) -> dict[str, object]:
    """Build the content of the JSON file of a recording."""
    control = metadata.control
    content: dict[str, object] = {
        "format": FORMAT,
        "source": metadata.source,
        "board": None if metadata.board is None else dict(metadata.board),
        "motion": metadata.motion,
        "sampling_period_s": metadata.h,
        "samples_expected": metadata.samples,
        "trajectory": {"n1": metadata.n1, "n2": metadata.n2},
        "program": {
            "bytes": len(metadata.program),
            "sha256": hashlib.sha256(metadata.program).hexdigest(),
            "recomputed": False,
        },
        "control": {
            **{name: list(value) for name, value in asdict(control).items()},
            "kp_counts": control.kp_counts.tolist(),
            "kv_counts": control.kv_counts.tolist(),
        },
        "counts": asdict(counts),
        "complete": metadata.end_reason == "",
        "reason": metadata.end_reason,
        "bytes": len(data),
        "sha256": hashlib.sha256(data).hexdigest(),
    }
    if metadata.host is not None:
        content["host"] = {**asdict(metadata.host), "chunks": [list(chunk) for chunk in metadata.host.chunks]}
    return {**content, "sidecar_sha256": own_sum(content)}


def own_sum(content: Mapping[str, object]) -> str:
    """Compute the SHA-256 of a sidecar without this sum."""
    rest = {key: value for key, value in content.items() if key != "sidecar_sha256"}
    return hashlib.sha256(json.dumps(rest, sort_keys=True).encode()).hexdigest()


def check_sidecar(place: str, content: object) -> dict[str, Any]:
    """Refuse a sidecar of another version, with a wrong key or type, or whose values contradict each other."""
    if isinstance(content, dict) and content.get("format", FORMAT) != FORMAT:  # another version may have other keys
        raise InputError.at(f"{place}: format", repr(content["format"]), f"{FORMAT}")
    if wrong := violation(content, Sidecar):
        where, found, expected = wrong
        raise InputError.at(f"{place}: {spelled(where) or 'content'}", found, expected)
    assert isinstance(content, dict)  # checked above
    c: dict[str, Any] = content
    control, trajectory, board = _control(c), c["trajectory"], c["board"]
    received = [chunk[0] for chunk in c["host"]["chunks"]] if "host" in c else [c["bytes"]]
    kp, kv = c["control"]["kp_counts"], c["control"]["kv_counts"]
    own_kp, own_kv = control.kp_counts.tolist(), control.kv_counts.tolist()
    rules = (
        ("board", board, (board is None) == (c["source"] == "serial"), "an object if simulated, null if not"),
        # Earlier versions, which wrote no sum, recorded over a link alone.
        ("host", None, "host" in c or "sidecar_sha256" in c, "the link that was recorded over"),
        (
            "host.chunks",
            received[-3:],
            [0, *received] == sorted([0, *received]) and received[-1:] == [c["bytes"]],
            f"numbers of bytes that rise to the {c['bytes']} of bytes",
        ),
        ("complete", c["complete"], c["complete"] == (c["reason"] == ""), "true if and only if there is no reason"),
        (
            "trajectory.n2",
            trajectory["n2"],
            trajectory["n1"] < trajectory["n2"] <= c["samples_expected"],
            f"more than n1 ({trajectory['n1']}) and at most samples_expected ({c['samples_expected']})",
        ),
        ("control.kp_counts", kp, kp == own_kp, f"{own_kp}, which follows from the rest"),
        ("control.kv_counts", kv, kv == own_kv, f"{own_kv}, which follows from the rest"),
    )
    for name, found, satisfied, expected in rules:
        if not satisfied:
            raise InputError.at(f"{place}: {name}", repr(found), expected)
    return c


def _control(c: Mapping[str, Any]) -> ControlConstants:
    return ControlConstants(**{f.name: tuple(c["control"][f.name]) for f in fields(ControlConstants)})


def metadata_from(content: Mapping[str, Any], program: bytes) -> CaptureMetadata:
    """Build the metadata from a checked sidecar; ValueError if it does not describe this program."""
    host, control = content.get("host"), _control(content)
    metadata = CaptureMetadata(
        motion=content["motion"],
        samples=content["samples_expected"],
        n1=content["trajectory"]["n1"],
        n2=content["trajectory"]["n2"],
        h=content["sampling_period_s"],
        program=program,
        control=control,
        board=content["board"],
        host=host and Host(**{**host, "chunks": tuple((int(b), float(t)) for b, t in host["chunks"])}),
        end_reason=content["reason"],
    )
    gains, n = parse_program(program)[0], metadata.desired.shape[1]
    if n != metadata.samples:
        raise ValueError(f"program: has {n} samples, must have the {metadata.samples} of samples_expected.")
    sent, stated = (*gains.kp, *gains.kv), (*control.kp_counts.tolist(), *control.kv_counts.tolist())
    if sent != stated:
        raise ValueError(f"program: sets the gains {sent}, must set those of control, {stated}.")
    return metadata
