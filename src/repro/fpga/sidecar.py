"""The sidecar of a capture: what was recorded, with what and over which link, as JSON checked against its schema."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

from repro.errors import InputError
from repro.fpga.controller import ControlConstants
from repro.fpga.messages import SingleArray, parse_program
from repro.fpga.parser import Counts
from repro.schema import spelled, violation

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
    return {**content, "sidecar_sha256": _own_sum(content)}


def _own_sum(content: Mapping[str, object]) -> str:
    """Compute the SHA-256 of a sidecar without this sum."""
    rest = {key: value for key, value in content.items() if key != "sidecar_sha256"}
    return hashlib.sha256(json.dumps(rest, sort_keys=True).encode()).hexdigest()


def check_sidecar(place: str, content: object) -> dict[str, Any]:
    """Refuse a sidecar of another version, with a wrong key or type, or whose values contradict each other."""
    schema = json.loads(Path(__file__).with_name("sidecar.schema.json").read_text(encoding="utf-8"))
    # First the version by itself: another one may have other keys.
    of_format = {"format": content["format"]} if isinstance(content, dict) and "format" in content else {}
    wrong = violation(of_format, {"properties": {"format": schema["properties"]["format"]}}) or violation(
        content, schema
    )
    if wrong:
        where, found, expected = wrong
        raise InputError.at(f"{place}: {spelled(where) or 'content'}", found, expected)
    assert isinstance(content, dict)  # checked above
    c: dict[str, Any] = content
    control, trajectory, board = _control(c), c["trajectory"], c["board"]
    kp, kv = c["control"]["kp_counts"], c["control"]["kv_counts"]
    own_kp, own_kv = control.kp_counts.tolist(), control.kv_counts.tolist()
    rules = (
        ("board", board, (board is None) == (c["source"] == "serial"), "an object if simulated, null if not"),
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


def check_own_sum(place: str, content: Mapping[str, object]) -> None:
    """Refuse a sidecar that was changed; recordings of earlier versions have no sum."""
    own = _own_sum(content)
    if content.get("sidecar_sha256", own) != own:
        raise InputError.at(f"{place}: sidecar_sha256", content["sidecar_sha256"], f"{own}, the sum of the other keys")


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
