"""What a capture file says about itself: the JSON file beside the raw bytes, checked against its schema."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

from repro.errors import InputError
from repro.fpga.about import About, Host, Reason
from repro.fpga.controller import ControlConstants
from repro.fpga.downlink import parse_program
from repro.fpga.stream import Counts
from repro.schema import spelled, violation

#: Version of the layout of the sidecar.
FORMAT = 2


def sidecar(about: About, data: bytes, counts: Counts, reason: Reason) -> dict[str, object]:
    """Content of the JSON file."""
    control = about.control
    content: dict[str, object] = {
        "format": FORMAT,
        "source": about.source,
        "board": None if about.board is None else dict(about.board),
        "motion": about.motion,
        "sampling_period_s": about.h,
        "samples_expected": about.samples,
        "trajectory": {"n1": about.n1, "n2": about.n2},
        "program": {
            "bytes": len(about.program),
            "sha256": hashlib.sha256(about.program).hexdigest(),
            "recomputed": False,
        },
        "control": {
            **{name: list(value) for name, value in asdict(control).items()},
            "kp_counts": control.kp_counts.tolist(),
            "kv_counts": control.kv_counts.tolist(),
        },
        "counts": asdict(counts),
        "complete": reason == "",
        "reason": reason,
        "bytes": len(data),
        "sha256": hashlib.sha256(data).hexdigest(),
    }
    if about.host is not None:
        content["host"] = {**asdict(about.host), "chunks": [list(chunk) for chunk in about.host.chunks]}
    return {**content, "sidecar_sha256": _own_sum(content)}


def _own_sum(content: Mapping[str, object]) -> str:
    """SHA-256 of a sidecar without this sum."""
    rest = {key: value for key, value in content.items() if key != "sidecar_sha256"}
    return hashlib.sha256(json.dumps(rest, sort_keys=True).encode()).hexdigest()


def check_sidecar(place: str, content: object) -> dict[str, Any]:
    """Check what was read from a JSON file."""
    # Another version may have other keys.
    schema = json.loads(Path(__file__).with_name("sidecar.schema.json").read_text(encoding="utf-8"))
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
    agreements = (
        ("board", board, (board is None) == (c["source"] == "serial"), "an object if simulated, null if not"),
        ("complete", c["complete"], c["complete"] == (c["reason"] == ""), "true if and only if there is no reason"),
        (
            "trajectory.n2",
            trajectory["n2"],
            trajectory["n1"] < trajectory["n2"] <= c["samples_expected"],
            f"more than n1 ({trajectory['n1']}) and at most samples_expected ({c['samples_expected']})",
        ),
        *(
            (f"control.{name}", given, given == follows, f"{follows}, which follows from the rest")
            for name, given, follows in (
                ("kp_counts", c["control"]["kp_counts"], control.kp_counts.tolist()),
                ("kv_counts", c["control"]["kv_counts"], control.kv_counts.tolist()),
            )
        ),
    )
    for name, found, agrees, expected in agreements:
        if not agrees:
            raise InputError.at(f"{place}: {name}", repr(found), expected)
    return c


def check_sum(place: str, content: Mapping[str, object]) -> None:
    """Refuse a sidecar that was changed; recordings of earlier versions have no sum."""
    own = _own_sum(content)
    if content.get("sidecar_sha256", own) != own:
        raise InputError.at(f"{place}: sidecar_sha256", content["sidecar_sha256"], f"{own}, the sum of the other keys")


def _control(c: Mapping[str, Any]) -> ControlConstants:
    return ControlConstants(**{f.name: tuple(c["control"][f.name]) for f in fields(ControlConstants)})


def about_of(content: Mapping[str, Any], program: bytes) -> About:
    """What was recorded, from a checked sidecar and what the board was sent."""
    host, control = content.get("host"), _control(content)
    about = About(
        motion=content["motion"],
        samples=content["samples_expected"],
        n1=content["trajectory"]["n1"],
        n2=content["trajectory"]["n2"],
        h=content["sampling_period_s"],
        program=program,
        control=control,
        board=content["board"],
        host=host and Host(**{**host, "chunks": tuple((int(b), float(t)) for b, t in host["chunks"])}),
    )
    gains, n = parse_program(program)[0], about.desired.shape[1]
    if n != about.samples:
        raise ValueError(f"program: has {n} samples, must have the {about.samples} of samples_expected.")
    wanted = (*control.kp_counts.tolist(), *control.kv_counts.tolist())
    if (*gains.kp, *gains.kv) != wanted:
        raise ValueError(f"program: sets the gains {(*gains.kp, *gains.kv)}, must set those of control, {wanted}.")
    return about
