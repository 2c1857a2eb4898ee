"""Which column holds which signal, and in what unit, from the header and the arm file."""

import difflib
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from repro.errors import InputError
from repro.logs.armfile import Arm
from repro.logs.units import KINDS, SPELLINGS, Kind, Signal, si_unit, squeeze, unit_named

_POSITION = ("q", "pos", "position", "theta", "angle")
_VELOCITY = ("dq", "qd", "qdot", "dotq", "vel", "velocity", "dtheta", "thetadot", "omega", "speed")
_TORQUE = ("tau", "torque", "effort", "trq", "u")
_CURRENT = ("current", "cur")
_PWM = ("pwm",)
_JOINT_NAMES = ("shoulder", "elbow")

#: Column of `repro decode` that says whether the simulated board made a recording.
SIMULATED: Final = "simulated"

_BRACKETS = re.compile(r"(.+?)\s*[\[({]\s*([^\d\s].*?)\s*[\])}]\Z")


@dataclass(frozen=True)
class Column:
    """Where a signal is."""

    index: int  # column of the table
    header: str  # its header
    unit: str | None  # one of `repro.logs.units.SPELLINGS`; None if nothing says


def _names() -> dict[str, tuple[Signal, str | None]]:
    """Squeezed names of columns, each with its signal and the unit that the name implies."""
    names: dict[str, tuple[Signal, str | None]] = dict.fromkeys(
        ("time", "t", "timestamp", "timestamps"), ("time", None)
    )
    for signals, words, unit in (
        (("q1", "q2"), _POSITION, None),
        (("dq1", "dq2"), _VELOCITY, None),
        (("tau1", "tau2"), _TORQUE, None),
        (("tau1", "tau2"), _CURRENT, "A"),
        (("tau1", "tau2"), _PWM, "counts"),
    ):
        for joint, signal in enumerate(signals, 1):
            own = _JOINT_NAMES[joint - 1]
            for word in words:
                for name in (f"{word}{joint}", f"joint{joint}{word}", f"{word}joint{joint}", own + word, word + own):
                    for spelt in (name, f"{name}meas", f"{name}measured", name.replace(word, f"{word}meas")):
                        names[spelt] = (signal, unit)  # type: ignore[assignment]
    for joint, signal in ((1, "dq1"), (2, "dq2")):
        for name in (f"q{joint}dot", f"theta{joint}dot"):
            names[name] = (signal, None)  # type: ignore[assignment]
    return names


_NAMES: Final = _names()


def find_columns(header: Sequence[str], arm: Arm, file: str) -> tuple[dict[Signal, Column], tuple[str, ...]]:
    """Find the columns of a log."""
    notes: list[str] = []
    found = _mapped(header, arm, file)
    candidates: dict[Signal, list[Column]] = {}
    for index, name in enumerate(header):
        match = _match(name)
        if match and match[0] not in found and index not in {column.index for column in found.values()}:
            candidates.setdefault(match[0], []).append(Column(index, name, _unit(name, match, arm, file)))
    for signal, columns in candidates.items():
        found[signal] = _one(signal, columns, file, notes)
    missing = [signal for signal in KINDS if signal not in found and KINDS[signal] != "velocity"]
    if missing:
        raise _missing(missing, header, found, file)
    for signal, other in (("dq1", "dq2"), ("dq2", "dq1")):
        if signal in found and other not in found:
            notes.append(f"{found.pop(signal).header} is ignored, because the other joint has no velocity column")
    used = {column.index for column in found.values()}
    ignored = [name for index, name in enumerate(header) if name and index not in used and name != SIMULATED]
    if ignored:
        notes.append(f"columns ignored: {_listed(ignored)}")
    return _with_units(found, file, notes), tuple(notes)


def _mapped(header: Sequence[str], arm: Arm, file: str) -> dict[Signal, Column]:
    """Columns that the arm file names."""
    found: dict[Signal, Column] = {}
    for signal, kind in KINDS.items():
        if signal not in arm.columns:
            continue
        name = arm.columns[signal].strip()
        if name not in header:
            near = difflib.get_close_matches(name, header, 1)
            expected = f"a header of {file}: {_listed(header)}" + (f" (perhaps {near[0]!r})" if near else "")
            raise InputError.at(f"{arm.file}: columns.{signal}", repr(name), expected)
        match = _match(name)
        implied = match if match and KINDS[match[0]] == kind else (signal, *_any_unit(name, kind))
        found[signal] = Column(header.index(name), name, _unit(name, (signal, *implied[1:]), arm, file))
    return found


def _split(header: str) -> Iterator[tuple[str, str]]:
    """Ways to take a header for a name and a unit: without one, in brackets, behind a slash, as a suffix."""
    yield header, ""
    brackets = _BRACKETS.match(header)
    if brackets:
        yield brackets[1], brackets[2]
    name, slash, unit = header.partition("/")
    if slash and name and not brackets:
        yield name, unit.strip("() ")
    for place in re.finditer(r"[_\s.-]", header):
        yield header[: place.start()], header[place.end() :]


def _match(header: str) -> tuple[Signal, str, bool] | None:
    """Signal, spelling of its unit, and whether the unit is known; None for a header that names no signal."""
    unknown: tuple[Signal, str, bool] | None = None
    for name, unit in _split(header):
        signal, implied = _NAMES.get(squeeze(name), (None, None))
        if signal is None:
            continue
        if not unit:
            return signal, implied or "", True
        if unit_named(unit, KINDS[signal]):
            return signal, unit, True
        if unknown is None and re.search(r"[\[({/]", header):  # a suffix may be any word; what is set apart is a unit
            unknown = (signal, unit, False)
    return unknown


def _any_unit(header: str, kind: Kind) -> tuple[str, bool]:
    """Unit in a header of any name."""
    units = [unit for _, unit in _split(header) if unit and unit_named(unit, kind)]
    return (units[0], True) if units else ("", True)


def _unit(header: str, match: tuple[Signal, str, bool], arm: Arm, file: str) -> str | None:
    """Unit of a column; None if neither the header nor the arm file says."""
    signal, spelling, known = match
    kind = KINDS[signal]
    if kind in arm.units:
        return arm.units[kind]
    if not known:
        expected = f"a unit of {kind}: {', '.join(SPELLINGS[kind])}; or units.{kind} in the arm file"
        raise InputError.at(f"{file}: header, column {header}", f"the unit {spelling!r}", expected)
    return unit_named(spelling, kind) if spelling else None


def _one(signal: Signal, columns: list[Column], file: str, notes: list[str]) -> Column:
    """The one column of a signal; one in an SI unit stands before raw counts and currents of the same."""
    if len(columns) == 1:
        return columns[0]
    si = [column for column in columns if column.unit == si_unit(KINDS[signal])]
    raw = [column for column in columns if column.unit in ("counts", "counts/s", "A", "mA")]
    names = [column.header for column in columns]
    if len(si) == 1 and len(si) + len(raw) == len(columns):
        notes.append(f"{signal} is read from {si[0].header}, in {si[0].unit}, of {', '.join(names)}")
        return si[0]
    found = f"{len(columns)} columns for {signal}: {', '.join(names)}"
    raise InputError.at(f"{file}: header", found, f"one, or the one to use as columns.{signal} in the arm file")


def _missing(missing: Sequence[Signal], header: Sequence[str], found: dict[Signal, Column], file: str) -> InputError:
    """What to say of signals without a column."""
    used = {column.header for column in found.values()}
    free = {squeeze(name): name for name in header if name and name not in used}
    near = []
    for signal in missing:
        spellings = [name for name, (known, _) in _NAMES.items() if known == signal]
        close = [name for plain, name in free.items() if difflib.get_close_matches(plain, spellings, 1, 0.75)]
        near += [f"{name!r} for {signal}" for name in close[:1]]
    hint = f" (perhaps {', '.join(near)})" if near else ""
    if any(re.search(r"(q|pos|position|tau|theta|torque|effort|joint)\W?0", plain) for plain in free):
        hint = " (joints counted from 0?)"
    expected = f"a column for {', '.join(missing)}{hint}; name it there or as columns.{missing[0]} in the arm file"
    return InputError.at(f"{file}: header", f"the columns {_listed(header)}", expected)


def _listed(names: Sequence[str]) -> str:
    """Names in a row, the first few of many."""
    few = [name[:40] for name in names[:10]]
    return ", ".join(few) + (f" and {len(names) - len(few)} more" if len(names) > len(few) else "")


def _with_units(found: dict[Signal, Column], file: str, notes: list[str]) -> dict[Signal, Column]:
    """Columns in the order of `KINDS`, each with a unit: its own, or SI if neither joint states one."""
    complete: dict[Signal, Column] = {}
    assumed: dict[str, list[str]] = {}
    for signal, kind in KINDS.items():
        if signal not in found:
            continue
        column, unit = found[signal], found[signal].unit
        if unit is None:
            unit = si_unit(kind)
            for twin in (twin for name, twin in found.items() if KINDS[name] == kind and twin.unit):
                expected = f"its unit, as {twin.header} is in {twin.unit}; or units.{kind} in the arm file"
                raise InputError.at(f"{file}: header, column {column.header}", "no unit", expected)
            assumed.setdefault(unit, []).append(column.header)
        complete[signal] = Column(column.index, column.header, unit)
    told = [f"{', '.join(names)} in {unit}" for unit, names in assumed.items()]
    if told:
        notes.append(f"the header states no unit for some columns; assumed: {'; '.join(told)}")
    converted = [f"{c.header} from {c.unit}" for s, c in complete.items() if c.unit != si_unit(KINDS[s])]
    if converted:
        notes.append(f"converted to SI: {', '.join(converted)}")
    return complete
