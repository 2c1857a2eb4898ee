"""What was recorded and with what, and the JSON file that states it: its keys, and how they must agree."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from functools import cached_property
from typing import Annotated, Any, Literal

from pydantic import Field

from repro.board.controller import ControlConstants
from repro.board.frames import SingleArray
from repro.board.messages import parse_program
from repro.board.parser import Count, Counts
from repro.documents import Section, spelled, violation
from repro.errors import InputError

#: Version of the layout of the sidecar.
FORMAT = 2

#: Why a recording ended before its last sample; empty if it did not.
EndReason = Literal["", "silent", "disconnected", "interrupted", "overrun"]


def _expected(text: str, **field: Any) -> Any:  # noqa: ANN401
    """Declare what a value of the file should be."""
    return Field(json_schema_extra={"expected": text}, **field)


_Digest = Annotated[str, _expected("a SHA-256 of 64 hexadecimal digits", pattern=r"^[0-9a-f]{64}\Z")]
_Size = Annotated[float, Field(gt=0, le=1e9)]
_Pair = Annotated[tuple[_Size, _Size], Field(strict=False)]
_Gains = Annotated[tuple[float, float], Field(strict=False)]  # follow from the rest
_Chunk = Annotated[tuple[int, float], Field(strict=False)]


class Host(Section):
    """The host's end of the link during a recording."""

    port: str  # name or URL that was opened
    baud: Count  # bits per second requested
    began: str  # when the arm was started, ISO 8601 with the offset from UTC
    # Bytes received so far and the time since the start (s), about every 50 ms
    chunks: Annotated[tuple[_Chunk, ...], Field(strict=False)]


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


class _Trajectory(Section):
    n1: Count
    n2: Count


class _Program(Section):
    bytes: Count
    sha256: _Digest
    recomputed: Literal[False]


class _Control(Section):
    kp: _Pair
    kv: _Pair
    pwm_hz: _Pair
    full_torque: _Pair
    kp_counts: _Gains
    kv_counts: _Gains


class Sidecar(Section):
    """Keys of ``NAME.json``."""

    format: int
    source: Literal["simulated", "serial"]
    board: dict[str, Any] | None
    motion: str = _expected("text without control characters", pattern=r"^[^\x00-\x1f\x7f-\x9f]*\Z")
    sampling_period_s: float = _expected("5e-05 to 0.2 s", ge=5e-5, le=0.2)
    samples_expected: Count
    trajectory: _Trajectory
    program: _Program
    control: _Control
    counts: Counts
    complete: bool
    reason: EndReason
    bytes: Count
    sha256: _Digest
    # Recordings of earlier versions have no sum, and those within a process no link.
    sidecar_sha256: _Digest = Field(default="")
    host: Host = _expected("the link that was recorded over", default=None)


def sidecar(metadata: CaptureMetadata, data: bytes, counts: Counts) -> dict[str, object]:
    """Build the content of the JSON file of a recording."""
    program, control = metadata.program, metadata.control
    content: dict[str, object] = {
        "format": FORMAT,
        "source": metadata.source,
        "board": metadata.board,
        "motion": metadata.motion,
        "sampling_period_s": metadata.h,
        "samples_expected": metadata.samples,
        "trajectory": {"n1": metadata.n1, "n2": metadata.n2},
        "program": {"bytes": len(program), "sha256": hashlib.sha256(program).hexdigest(), "recomputed": False},
        "control": asdict(control) | _gains(control),
        "counts": counts.model_dump(),
        "complete": metadata.end_reason == "",
        "reason": metadata.end_reason,
        "bytes": len(data),
        "sha256": hashlib.sha256(data).hexdigest(),
    }
    if metadata.host is not None:
        content["host"] = metadata.host.model_dump()
    return {**content, "sidecar_sha256": own_sum(content)}


def _gains(control: ControlConstants) -> dict[str, list[float]]:
    """Gains as sent to the board, which follow from the constants."""
    return {"kp_counts": control.kp_counts.tolist(), "kv_counts": control.kv_counts.tolist()}


def own_sum(content: Mapping[str, object]) -> str:
    """Compute the SHA-256 of a sidecar without this sum."""
    rest = {key: value for key, value in content.items() if key != "sidecar_sha256"}
    return hashlib.sha256(json.dumps(rest, sort_keys=True).encode()).hexdigest()


def check_sidecar(place: str, content: object) -> dict[str, Any]:
    """Refuse a sidecar of another version, with a wrong key or type, or whose values contradict each other."""
    if isinstance(content, dict) and content.get("format", FORMAT) != FORMAT:  # another version may have other keys
        raise InputError.at(f"{place}: format", repr(content["format"]), f"{FORMAT}")
    if wrong := violation(content, Sidecar):
        raise InputError.at(f"{place}: {spelled(wrong[0]) or 'content'}", *wrong[1:])
    assert isinstance(content, dict)  # checked above
    c: dict[str, Any] = content
    n1, n2, most = c["trajectory"]["n1"], c["trajectory"]["n2"], c["samples_expected"]
    board, size = c["board"], c["bytes"]
    received = [chunk[0] for chunk in c["host"]["chunks"]] if "host" in c else [size]
    rising = [0, *received] == sorted([0, *received]) and received[-1:] == [size]
    rules = [
        ("board", board, (board is None) == (c["source"] == "serial"), "an object if simulated, null if not"),
        # Earlier versions, which wrote no sum, recorded over a link alone.
        ("host", None, "host" in c or "sidecar_sha256" in c, "the link that was recorded over"),
        ("host.chunks", received[-3:], rising, f"numbers of bytes that rise to the {size} of bytes"),
        ("complete", c["complete"], c["complete"] == (c["reason"] == ""), "true if and only if there is no reason"),
        ("trajectory.n2", n2, n1 < n2 <= most, f"more than n1 ({n1}) and at most samples_expected ({most})"),
    ]
    for name, own in _gains(_control(c)).items():
        found = c["control"][name]
        rules.append((f"control.{name}", found, found == own, f"{own}, which follows from the rest"))
    for name, found, satisfied, expected in rules:
        if not satisfied:
            raise InputError.at(f"{place}: {name}", repr(found), expected)
    return c


def _control(c: Mapping[str, Any]) -> ControlConstants:
    return ControlConstants(**{f.name: tuple(c["control"][f.name]) for f in fields(ControlConstants)})


def metadata_from(content: Mapping[str, Any], program: bytes) -> CaptureMetadata:
    """Build the metadata from a checked sidecar; ValueError if it does not describe this program."""
    metadata = CaptureMetadata(
        motion=content["motion"],
        samples=content["samples_expected"],
        **content["trajectory"],
        h=content["sampling_period_s"],
        program=program,
        control=_control(content),
        board=content["board"],
        host=Host(**content["host"]) if "host" in content else None,
        end_reason=content["reason"],
    )
    gains, n = parse_program(program)[0], metadata.desired.shape[1]
    if n != metadata.samples:
        raise ValueError(f"program: has {n} samples, must have the {metadata.samples} of samples_expected.")
    sent, stated = (*gains.kp, *gains.kv), (*content["control"]["kp_counts"], *content["control"]["kv_counts"])
    if sent != stated:
        raise ValueError(f"program: sets the gains {sent}, must set those of control, {stated}.")
    return metadata
