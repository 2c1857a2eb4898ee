"""The arm file: conventions and limits of an arm that the header of a recording does not state."""

import re
from collections.abc import Callable, Mapping
from functools import wraps
from inspect import Signature, signature
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field, ValidationError
from pydantic.dataclasses import dataclass
from pydantic_core import PydanticCustomError
from typing_extensions import TypedDict

from repro.documents import STRICT, Loader, first_error, read_yaml, spelled
from repro.errors import InputError
from repro.model.dynamics import LAMBDA
from repro.model.parameters import STANDARD_GRAVITY

Signal = Literal["time", "q1", "q2", "dq1", "dq2", "tau1", "tau2"]
SignalKind = Literal["time", "position", "velocity", "torque"]

_MAX_NUMBER, _MIN_MAGNITUDE = 1e9, 1e-6  # largest number of an arm and smallest limit; their squares must not overflow


def _radians(most: float, expected: str) -> AfterValidator:
    """Allow a number that can be in radians; a larger one is in degrees."""

    def checked(value: float) -> float:
        if abs(value) > most:
            converted = f"if it is in degrees: {np.radians(value):.5g}"
            raise PydanticCustomError("radians", f"{expected}, whatever the unit of the log ({converted})")
        return value

    return AfterValidator(checked)


def _only(allowed: Callable[[Any], bool], expected: str) -> AfterValidator:
    """Allow some values only."""

    def checked(value: object) -> object:
        if not allowed(value):
            raise PydanticCustomError("value", expected)
        return value

    return AfterValidator(checked)


_AlsoList = Field(strict=False)  # a list, too
_Text = Annotated[str, Field(min_length=1)]
_Number = Annotated[float, Field(ge=-_MAX_NUMBER, le=_MAX_NUMBER)]
_Positive = Annotated[float, Field(ge=_MIN_MAGNITUDE, le=_MAX_NUMBER)]
_Sign = Annotated[_Number, _only(lambda value: abs(value) == 1.0, "two numbers, each 1 or -1")]
_NOT_ZERO = f"two numbers other than 0, with magnitudes of {_MIN_MAGNITUDE:g} and more"
_Constant = Annotated[_Number, _only(lambda value: abs(value) >= _MIN_MAGNITUDE, _NOT_ZERO)]
_Angle = Annotated[_Number, _radians(2.0 * np.pi, "radians within a turn")]
_rising = _only(lambda pair: pair[0] < pair[1], "the lower one first")
_apart = _only(lambda pair: pair[1] - pair[0] >= _MIN_MAGNITUDE, f"ends {_MIN_MAGNITUDE:g} and more apart")
_Range = Annotated[tuple[_Number, _Number], _AlsoList, _rising, _apart]
_TwoPositive = Annotated[tuple[_Positive, _Positive], _AlsoList]
_TwoSigns = Annotated[tuple[_Sign, _Sign], _AlsoList]
_TwoRanges = Annotated[tuple[_Range, _Range], _AlsoList]
_Reachable = Annotated[_Number, _radians(4.0 * np.pi, "radians within two turns")]
_Turn = Annotated[tuple[_Reachable, _Reachable], _AlsoList, _rising, _apart]
_Speed = Annotated[_Positive, _radians(20.0 * np.pi, "rad/s up to ten turns a second")]
_different = _only(lambda names: len(set(names.values())) == len(names), "a different column for each signal")
_Automatic = BeforeValidator(lambda value: None if value == "auto" else value)


class Units(TypedDict, total=False):
    """Unit of each kind of signal; it has priority over the header's."""

    __pydantic_config__ = STRICT  # type: ignore[misc]

    time: Literal["s", "ms", "us", "ns", "min", "days"]
    position: Literal["rad", "mrad", "deg", "counts", "turns"]
    velocity: Literal["rad/s", "deg/s", "rpm", "counts/s", "turns/s"]
    torque: Literal["N m", "mN m", "N cm", "kN m", "kgf cm", "lbf in", "lbf ft", "ozf in", "A", "mA", "counts"]


def _key(expected: str, meaning: str = "", absent: str = "none", **default: Any) -> Any:  # noqa: ANN401
    """Describe a key: what it should be and means, and what happens without it (which is None if not given)."""
    given = default or {"default": None}
    return Field(**given, description=meaning, json_schema_extra={"expected": expected, "absent": absent})


def _one_line(cls: type[Any]) -> type[Any]:
    """Let a class refuse wrong values in one line, and accept arrays."""
    init = cls.__init__

    @wraps(init)
    def checked(self: Any, /, *values: object, **given: object) -> None:  # noqa: ANN401
        try:
            init(self, *values, **{key: _plain(value) for key, value in given.items()})
        except ValidationError as invalid:
            place, found, expected = first_error(invalid, cls)
            raise InputError.at(f"{given.get('file', cls.file)}: {spelled(place)}", found, expected) from None

    cls.__init__ = checked
    bare = [one.replace(annotation=one.empty) for one in signature(cls).parameters.values()]
    cls.__signature__ = Signature(bare)  # what `help` shows; the annotations are those of the validation
    return cls


def _plain(value: object) -> object:
    """Give arrays, numbers of NumPy and mappings as lists, numbers and a dictionary of Python."""
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    return dict(value) if isinstance(value, Mapping) else value


@_one_line
@dataclass(frozen=True, config=STRICT)
class Arm:
    """How to read an arm's recordings, and what is known of the arm.

    Its arguments are the keys of an arm file.

    Examples
    --------
    >>> arm = repro.Arm(name="planar", zero=(1.571, 0.0), torque_limit=(8.0, 3.0))
    >>> arm.sign, arm.gravity
    ((1.0, 1.0), 9.80665)
    """

    name: Annotated[_Text, _only(lambda name: str(name).isprintable(), "text on one line")] = _key(
        "text on one line", "shown in the report and the exports", default="arm"
    )
    columns: Annotated[dict[Signal, _Text], _different] = _key(
        "headers of the log by signal, such as 'q1: shoulder angle'",
        "signals are `time`, `q1`, `q2`, `dq1`, `dq2`, `tau1`, `tau2`",
        "found by name",
        default_factory=dict,
    )
    topic: _Text | None = _key("the name of a topic, as text", "of a bag, with the joint states", "the only one")
    units: Units = _key(
        "units by kind of signal, such as 'position: deg'",
        "of all columns of a kind (`time`, `position`, `velocity`, `torque`), whatever the header states",
        "from the header, else SI",
        default_factory=Units,
    )
    passive_joint: Literal[1, 2] | None = _key(
        "1 or 2", "of a joint without a drive: its torque is zero and needs no column", "none"
    )
    sampling_rate: _Positive | None = _key(
        "a positive number, Hz",
        "of evenly spaced samples: for a log without times, or whose times are those of a PC that read in bursts",
        "from the times",
    )
    counts_per_turn: _TwoPositive | None = _key(
        "two numbers above 0, the counts in a turn of joint 1 and of joint 2",
        "a turn of the **joint**: counts per motor turn times the gear ratio",
    )
    torque_constant: Annotated[tuple[_Constant, _Constant], _AlsoList] | None = _key(
        "two numbers other than 0, N m at the joint for 1 A or for 1 count, joint 1 and joint 2",
        "gear included; a count is one of PWM",
    )
    torque_offset: Annotated[tuple[_Number, _Number], _AlsoList] = _key(
        "two numbers, the torque recorded where none acts, N m", default=(0.0, 0.0)
    )
    torque_scale: _TwoPositive = _key(
        "two numbers above 0, the torque recorded over the one that acts",
        "the offset is subtracted first",
        default=(1.0, 1.0),
    )
    sign: _TwoSigns = _key(
        "two numbers, each 1 or -1",
        "-1 where position, velocity and torque of a joint count in the opposite direction",
        default=(1.0, 1.0),
    )
    torque_sign: _TwoSigns = _key(
        "two numbers, each 1 or -1", "-1 where only the torque does, in addition to `sign`", default=(1.0, 1.0)
    )
    zero: Annotated[tuple[_Angle, _Angle], _AlsoList] = _key(
        "two numbers, the position recorded where the angle of Eq. 1 is 0, rad",
        "in rad whatever the unit of the log, within a turn",
        default=(0.0, 0.0),
    )
    second_joint_absolute: bool = _key(
        "true or false", "whether `q2` was measured from the vertical and not from link 1", default=False
    )
    torque_limit: _TwoPositive | None = _key(
        "two numbers above 0, the largest torque of joint 1 and of joint 2, N m",
        "of the torque that acts, so after `torque_offset` and `torque_scale`; without it a largest value that occurs "
        "repeatedly counts as one",
    )
    position_limit: Annotated[tuple[_Turn, _Turn], _AlsoList] | None = _key(
        "two ranges, lowest and highest angle of Eq. 1 of joint 1 and of joint 2, rad",
        "for `repro excite`, within two turns; joint 2 relative to link 1, whatever `zero` and `sign` state",
    )
    speed_limit: Annotated[tuple[_Speed, _Speed], _AlsoList] | None = _key(
        "two numbers above 0, the largest speed of joint 1 and of joint 2, rad/s",
        "for `repro excite`, up to ten turns a second",
    )
    workspace: _TwoRanges | None = _key(
        "two ranges, of x and of y of elbow and tip from joint 1, m",
        "for `repro excite`, with `link_lengths`: x to the right, y up, joint 1 at 0, 0",
    )
    plane: Literal["vertical", "horizontal"] = _key(
        "vertical or horizontal", "in a horizontal plane g1 and g2 are zero and not estimated", default="vertical"
    )
    gravity: _Positive = _key(
        "a number above 0, m/s^2", "for the exports, and with `link_lengths` for the fit", default=STANDARD_GRAVITY
    )
    link_lengths: _TwoPositive | None = _key(
        "two numbers above 0, the lengths of link 1 and link 2, m",
        "between the axes, and to the tool: l1 enters the fit (I2 = 2 l1 g2 / g), l2 `workspace` and the exports",
    )
    link_length_sd: _Positive = _key(
        "a number above 0, m",
        "standard deviation of l1 as measured; a large one leaves l1 out of the fit",
        default=1e-3,
    )
    friction_steepness: Annotated[_Positive | None, _Automatic] = _key(
        "a number above 0, s/rad, or auto",
        "lambda of Eq. 1; `auto` chooses the best of 5, 10, 20, 50, 100, 200",
        default=LAMBDA,
    )
    delay: Annotated[Annotated[float, Field(ge=-1, le=1)] | None, _Automatic] = _key(
        "a number from -1 to 1, s, or auto", "how much later than recorded the torque acts", "`auto`"
    )
    file: str = Field(default="arm file", exclude=True)  # where this was read, for messages


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
    ...     arm = repro.read_arm(file)
    >>> arm.torque_constant, arm.units["position"], arm.zero
    ((1.9, 0.7), 'deg', (0.0, 0.0))
    """
    if path is None:
        return Arm()
    content = read_yaml(Path(path), "an arm file", _Loader)
    for key in content:
        if key == "file" or content[key] is None:
            raise InputError.at(f"{path}: {key}", repr(content[key]), "a key of an arm, with a value")
    return Arm(**content, file=str(path))
