"""Signals of a recording, the units they come in, and what these are in SI."""

import math
import re
from typing import Final, Literal

from repro.errors import InputError
from repro.logs.armfile import Arm, Pair

Signal = Literal["time", "q1", "q2", "dq1", "dq2", "tau1", "tau2"]
Kind = Literal["time", "position", "velocity", "torque"]

#: Signals of a log and what kind each is.
KINDS: Final[dict[Signal, Kind]] = {
    "time": "time",
    "q1": "position",
    "q2": "position",
    "dq1": "velocity",
    "dq2": "velocity",
    "tau1": "torque",
    "tau2": "torque",
}

_SECOND = ("/s", "s", "/sec", "persec", "ps", "pers", "/second", "s1", "s^1")

#: How headers spell each unit, after `squeeze`; the first unit of a kind is its SI unit.
SPELLINGS: Final[dict[Kind, dict[str, tuple[str, ...]]]] = {
    "time": {
        "s": ("s", "sec", "secs", "second", "seconds"),
        "ms": ("ms", "msec", "millis", "millisecond", "milliseconds"),
        "us": ("us", "usec", "micros", "microsecond", "microseconds"),
        "ns": ("ns", "nsec", "nanos", "nanosecond", "nanoseconds"),
        "min": ("min", "mins", "minute", "minutes"),
    },
    "position": {
        "rad": ("rad", "rads", "radian", "radians"),
        "deg": ("deg", "degs", "degree", "degrees", "°"),
        "counts": ("counts", "count", "cts", "cnt", "ticks", "tick", "inc", "lsb"),
    },
    "velocity": {
        "rad/s": tuple(f"{unit}{s}" for unit in ("rad", "radians") for s in _SECOND),
        "deg/s": tuple(f"{unit}{s}" for unit in ("deg", "degrees", "°") for s in _SECOND),
        "rpm": ("rpm", "r/min", "rev/min", "1/min"),
        "counts/s": tuple(f"{unit}{s}" for unit in ("counts", "count", "cts", "ticks") for s in _SECOND),
    },
    "torque": {
        "N m": ("nm", "newtonmeter", "newtonmetre", "newtonmeters", "newtonmetres"),
        "mN m": ("mnm", "millinewtonmeter", "millinewtonmetre"),
        "A": ("a", "amp", "amps", "ampere", "amperes"),
        "mA": ("ma", "milliamp", "milliamps"),
        "counts": ("counts", "count", "cts", "cnt", "pwm", "lsb", "ticks"),
    },
}

_FACTORS: Final = {
    **{"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0},
    **{"rad": 1.0, "deg": math.pi / 180.0, "rad/s": 1.0, "deg/s": math.pi / 180.0, "rpm": math.pi / 30.0},
    **{"N m": 1.0, "mN m": 1e-3},
}


def squeeze(text: str) -> str:
    """Spelling of a name or unit without case, spaces, dots and dashes."""
    return re.sub(r"[\s_.·⋅*-]", "", text).lower().replace("µ", "u").replace("μ", "u")


def unit_named(text: str, kind: Kind) -> str | None:
    """Unit that a spelling stands for."""
    plain = squeeze(text)
    return next((unit for unit, spellings in SPELLINGS[kind].items() if plain in spellings), None)


def si_unit(kind: Kind) -> str:
    """SI unit of a kind of signal."""
    return next(iter(SPELLINGS[kind]))


def si_factor(signal: Signal, unit: str, arm: Arm, log: str = "the log") -> float:
    """What a recorded number is multiplied by to be in SI."""
    if unit in _FACTORS:
        return _FACTORS[unit]
    joint = int(signal[-1]) - 1
    if KINDS[signal] == "torque":
        constant = _needed(arm, "torque_constant", arm.torque_constant, f"{signal} of {log} is in {unit}")
        return constant[joint] * (1e-3 if unit == "mA" else 1.0)
    return (
        2.0 * math.pi / _needed(arm, "counts_per_turn", arm.counts_per_turn, f"{signal} of {log} is in {unit}")[joint]
    )


def _needed(arm: Arm, key: str, value: Pair | None, reason: str) -> Pair:
    """A value of the arm file that a unit cannot do without."""
    if value is None:
        raise InputError.at(f"{arm.file}: {key}", "nothing", f"two numbers, because {reason}")
    return value
