"""The arm file: conventions and limits of an arm that the header of a recording does not state."""

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import wraps
from pathlib import Path
from typing import Any

import numpy as np

from repro.documents import Loader, read_yaml, spelled, violation
from repro.errors import InputError
from repro.model.dynamics import LAMBDA
from repro.model.parameters import STANDARD_GRAVITY

#: One value for each joint.
Pair = tuple[float, float]

#: Largest number of an arm and smallest limit; their squares must not overflow.
_LARGEST, _SMALLEST = 1e9, 1e-6
#: Keys whose numbers divide.
_POSITIVE = ("speed_limit", "torque_limit", "counts_per_turn", "torque_constant", "torque_scale")
_SCHEMA: dict[str, Any] = json.loads(Path(__file__).with_name("arm.schema.json").read_text(encoding="utf-8"))


def _names_unknown_keys(cls: type[Any]) -> type[Any]:
    """Let a dataclass refuse an unknown keyword as a file's unknown key."""
    init, known = cls.__init__, [each.name for each in fields(cls)]

    @wraps(init)
    def checked(self: Any, *values: object, **given: object) -> None:  # noqa: ANN401
        if unknown := [key for key in given if key not in known]:
            raise InputError.at(f"{cls.file}: {unknown[0]}", "an unknown key", f"one of {', '.join(known[:-1])}")
        init(self, *values, **given)

    cls.__init__ = checked
    return cls


@_names_unknown_keys
@dataclass(frozen=True)
class Arm:
    """How to read an arm's recordings, and what is known of the arm.

    Examples
    --------
    >>> arm = Arm(name="planar", zero=(1.571, 0.0), torque_limit=(8.0, 3.0))
    >>> arm.sign, arm.gravity
    ((1.0, 1.0), 9.80665)
    """

    name: str = "arm"
    columns: Mapping[str, str] = field(default_factory=dict)  # header of each signal: time, q1, q2, dq1, ..., tau2
    topic: str | None = None  # of the joint states in a bag; None for the only one
    # Unit of time, position, velocity or torque; it has priority over the header's.
    units: Mapping[str, str] = field(default_factory=dict)
    counts_per_turn: Pair | None = None  # encoder counts in a turn of each joint
    torque_constant: Pair | None = None  # torque at each joint, N m, for 1 A or for 1 count of PWM
    torque_offset: Pair = (0.0, 0.0)  # torque recorded where none acts, N m
    torque_scale: Pair = (1.0, 1.0)  # torque recorded, without the offset, over the one that acts
    sign: Pair = (1.0, 1.0)  # 1, or -1 where position, velocity and torque have the other sign than in Eq. 1
    torque_sign: Pair = (1.0, 1.0)  # 1, or -1 where the torque alone has the other sign, in addition to `sign`
    zero: Pair = (0.0, 0.0)  # position recorded, rad, where link 1 hangs down and link 2 is in line with it
    second_joint_absolute: bool = False  # whether ``q2`` was measured from the vertical instead of from link 1
    torque_limit: Pair | None = None  # largest torque of each joint, N m
    position_limit: tuple[Pair, Pair] | None = None  # lowest and highest angle of Eq. 1 of each joint, rad
    speed_limit: Pair | None = None  # largest speed of each joint, rad/s
    # Lowest and highest x, lowest and highest y of elbow and tip, m, as in `repro.model.dynamics`
    workspace: tuple[Pair, Pair] | None = None
    plane: str = "vertical"  # of the motion; in a "horizontal" one gravity turns no joint
    gravity: float = STANDARD_GRAVITY  # gravitational acceleration, m/s^2
    link_lengths: Pair | None = None  # lengths of the links, m
    friction_steepness: float | None = LAMBDA  # lambda of Eq. 1, s/rad; None: estimated from the data
    delay: float | None = None  # how much later than recorded the torque acts, s; None: estimated from the data
    file: str = "arm file"  # where this was read, for messages

    def __post_init__(self) -> None:
        """Check the values as those of a file, and store lists and arrays as tuples."""
        given = {}
        for each in fields(self):
            value = getattr(self, each.name)
            empty = (value is None and "None" in str(each.type)) or (isinstance(value, dict) and not value)
            if not (empty or value is each.default or each.name == "file"):
                given[each.name] = value
        try:
            content = json.loads(json.dumps(given, default=_plain))
        except (TypeError, ValueError) as error:
            raise InputError.at(self.file, f"a value of another type ({error})", "numbers, texts and pairs") from error
        _check(content, self.file)
        for key, value in content.items():
            object.__setattr__(self, key, _value(key, value))


def _plain(value: object) -> object:
    """Give a NumPy array or number, or a mapping, as JSON has it."""
    if isinstance(value, Mapping):
        return dict(value)
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    raise TypeError(type(value).__name__)


class _Loader(Loader):
    """YAML with numbers such as 1e-3, which YAML 1.1 takes for text, because it has no point."""


_EXPONENT = re.compile(r"[-+]?[0-9]+(\.[0-9]*)?[eE][-+]?[0-9]+\Z")
_Loader.add_implicit_resolver("tag:yaml.org,2002:float", _EXPONENT, list("-+0123456789"))


def read_arm(path: str | Path | None) -> Arm:
    """Read an arm file.

    Parameters
    ----------
    path : path or None
        YAML; None for an arm of which nothing is known.

    Returns
    -------
    Arm
        With defaults for what the file leaves out.

    Raises
    ------
    InputError
        If the file is missing, is not YAML, has an unknown key, or a value is not what it should be.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "arm.yaml"
    ...     _ = file.write_text("{units: {position: deg, torque: A}, torque_constant: [1.9, 0.7]}")
    ...     arm = read_arm(file)
    >>> arm.torque_constant, arm.units["position"], arm.zero
    ((1.9, 0.7), 'deg', (0.0, 0.0))
    """
    if path is None:
        return Arm()
    path = Path(path)
    content = read_yaml(path, "an arm file", _Loader)
    _check(content, str(path))
    return Arm(**content, file=str(path))


def _check(content: Mapping[str, Any], file: str) -> None:
    """Refuse what the schema or the meaning of a key forbids."""
    if content != {} and (wrong := violation(content, _SCHEMA)):
        place, found, expected = wrong
        raise InputError.at(f"{file}: {spelled(place)}", found, expected)
    for key, value in content.items():
        least = _SMALLEST if key in _POSITIVE else 0.0
        sizes = np.abs(np.ravel(value)) if isinstance(value, (list, int, float)) else np.empty(0)
        if np.any((sizes < least) | (sizes > _LARGEST)):
            expected = f"magnitudes of {f'{least:g} to' if least else 'at most'} {_LARGEST:g}"
            raise InputError.at(f"{file}: {key}", repr(value)[:60], expected)
    columns = content.get("columns", {})
    for signal, header in columns.items():
        twin = next(other for other in columns if columns[other] == header)
        if twin != signal:
            raise InputError.at(f"{file}: columns.{signal}", f"{header!r}, as for {twin}", "a column of its own")
    for key in ("position_limit", "workspace"):
        for row, (low, high) in enumerate(content.get(key, ())):
            if high - low < _SMALLEST:
                expected = f"ends {_SMALLEST:g} and more apart" if low < high else "the lower one first"
                raise InputError.at(f"{file}: {key}[{row}]", [low, high], expected)
    for joint, zero in enumerate(content.get("zero", ())):
        if abs(zero) > 2.0 * np.pi:
            converted = f"if it is in degrees: {np.radians(zero):.5g}"
            expected = f"radians within a turn, whatever the unit of the log ({converted})"
            raise InputError.at(f"{file}: zero.{joint}", zero, expected)


def _value(key: str, value: Any) -> Any:  # noqa: ANN401
    """A value of the file as an attribute of `Arm`."""
    if value == "auto" and key in ("friction_steepness", "delay"):
        return None
    if isinstance(value, list):
        return tuple(_value(key, item) for item in value)
    return float(value) if isinstance(value, int) and not isinstance(value, bool) else value
