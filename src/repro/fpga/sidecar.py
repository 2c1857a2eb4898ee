"""What a capture file says about itself: the JSON file beside the raw bytes, checked key by key."""

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from repro.errors import InputError
from repro.fpga.about import REASONS, About, Host, Reason
from repro.fpga.controller import ControlConstants
from repro.fpga.downlink import parse_program
from repro.fpga.stream import Counts

#: Version of the layout of the sidecar, and the one before, which held a hash of the desired positions alone.
FORMAT, WITHOUT_PROGRAM = 2, 1


def sidecar(about: About, data: bytes, counts: Counts, reason: Reason) -> dict[str, object]:
    """Content of the JSON file.

    Parameters
    ----------
    about : About
        What was recorded.
    data : bytes
        The recording.
    counts : Counts
        What the parser made of it.
    reason : {"", "silent", "disconnected", "interrupted"}
        Why it ended early.

    Returns
    -------
    dict
        Ready for JSON.
    """
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
    return content


@dataclass(frozen=True)
class _Rule:
    expected: str
    holds: Callable[[Any], bool]


def _is_integer(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and bool(np.isfinite(value))


def _is_pair(value: object) -> bool:
    return isinstance(value, list) and len(value) == 2 and all(_is_number(x) and x > 0 for x in value)


def _is_digest(value: object) -> bool:
    return isinstance(value, str) and len(value) == 64 and set(value) <= set("0123456789abcdef")


def _is_chunk(value: object) -> bool:
    return isinstance(value, list) and len(value) == 2 and _is_integer(value[0]) and _is_number(value[1])


_TEXT = _Rule("text", lambda value: isinstance(value, str))
_COUNT = _Rule("an integer, 0 or more", lambda value: _is_integer(value) and value >= 0)
_PAIR = _Rule("two positive numbers", _is_pair)
_DIGEST = _Rule("a SHA-256 of 64 hexadecimal digits", _is_digest)
_HOST = {
    "port": _TEXT,
    "baud": _COUNT,
    "began": _TEXT,
    "chunks": _Rule("pairs of bytes and seconds", lambda value: isinstance(value, list) and all(map(_is_chunk, value))),
}
_CONTROL = (*(field.name for field in fields(ControlConstants)), "kp_counts", "kv_counts")
_SIDECAR: dict[str, Any] = {
    "format": _Rule(str(FORMAT), lambda value: _is_integer(value) and value == FORMAT),
    "source": _Rule("simulated or serial", lambda value: value in ("simulated", "serial")),
    "board": _Rule("an object or null", lambda value: value is None or isinstance(value, dict)),
    "motion": _TEXT,
    "sampling_period_s": _Rule("a positive number", lambda value: _is_number(value) and value > 0),
    "samples_expected": _COUNT,
    "trajectory": {"n1": _COUNT, "n2": _COUNT},
    "program": {
        "bytes": _COUNT,
        "sha256": _DIGEST,
        "recomputed": _Rule("true or false", lambda value: isinstance(value, bool)),
    },
    "control": dict.fromkeys(_CONTROL, _PAIR),
    "counts": {field.name: _COUNT for field in fields(Counts)},
    "complete": _Rule("true or false", lambda value: isinstance(value, bool)),
    "reason": _Rule(f"one of {', '.join(map(repr, REASONS))}", lambda value: value in REASONS),
    "bytes": _COUNT,
    "sha256": _DIGEST,
}


def _check(place: str, content: object, rules: Mapping[str, Any], prefix: str = "") -> None:
    """Check keys and values of one object, and of the objects in it."""
    if not isinstance(content, dict):
        raise InputError.at(f"{place}: {prefix.rstrip('.') or 'content'}", repr(content), "an object")
    for key, rule in rules.items():
        name = prefix + key
        if key not in content:
            raise InputError.at(f"{place}: {name}", "nothing", "a value")
        if isinstance(rule, _Rule):
            if not rule.holds(content[key]):
                raise InputError.at(f"{place}: {name}", repr(content[key]), rule.expected)
        else:
            _check(place, content[key], rule, f"{name}.")
    for key in content:
        if key not in rules:
            raise InputError.at(f"{place}: {prefix}{key}", "an unknown key", f"one of {', '.join(rules)}")


def check_sidecar(place: str, content: object) -> dict[str, Any]:
    """Check what was read from a JSON file.

    Parameters
    ----------
    place : str
        Name of the file, for messages.
    content : object
        What it holds.

    Returns
    -------
    dict
        The same content, checked.

    Raises
    ------
    InputError
        If the version is another, a key is missing or unknown, or a value is of the wrong type or contradicts
        another.
    """
    if isinstance(content, dict) and "format" in content:  # another version may have other keys
        if _is_integer(content["format"]) and content["format"] == WITHOUT_PROGRAM:
            raise InputError.at(
                f"{place}: format",
                "1, a recording without what the board was sent",
                f"{FORMAT}; `repro upgrade {Path(place).with_suffix('.bin')}` adds it",
            )
        _check(place, {"format": content["format"]}, {"format": _SIDECAR["format"]})
    with_host = isinstance(content, dict) and "host" in content
    _check(place, content, _SIDECAR | ({"host": _HOST} if with_host else {}))
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


def _control(c: Mapping[str, Any]) -> ControlConstants:
    return ControlConstants(**{f.name: tuple(c["control"][f.name]) for f in fields(ControlConstants)})


def about_of(content: Mapping[str, Any], program: bytes) -> About:
    """What was recorded, from a checked sidecar and what the board was sent.

    Raises
    ------
    ValueError
        If `program` is not one, has another number of samples, or sets other gains than the sidecar says.
    """
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
