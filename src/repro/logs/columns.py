"""Signals of a recording: the column of each, its unit, and the factor to SI, from the header and the arm file."""

import difflib
import json
import math
import re
from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from typing import Final

from repro.errors import InputError
from repro.identification.armfile import Arm, Signal, SignalKind

#: Signals of a log and what kind each is.
KINDS: Final[dict[Signal, SignalKind]] = {
    "time": "time",
    "q1": "position",
    "q2": "position",
    "dq1": "velocity",
    "dq2": "velocity",
    "tau1": "torque",
    "tau2": "torque",
}

_SECOND = ("/s", "s", "/sec", "persec", "ps", "pers", "/second", "s1", "s^1")
_TURNS = ("rev", "turn", "rot", "rotation", "revolution")

#: How headers spell each unit, after `squeeze`; the first unit of a kind is its SI unit.
SPELLINGS: Final[dict[SignalKind, dict[str, tuple[str, ...]]]] = {
    "time": {
        "s": ("s", "sec", "secs", "second", "seconds"),
        "ms": ("ms", "msec", "millis", "millisecond", "milliseconds"),
        "us": ("us", "usec", "micros", "microsecond", "microseconds"),
        "ns": ("ns", "nsec", "nanos", "nanosecond", "nanoseconds"),
        "min": ("min", "mins", "minute", "minutes"),
        "days": ("day", "days"),
    },
    "position": {
        "rad": ("rad", "rads", "radian", "radians"),
        "mrad": ("mrad", "milliradian", "milliradians"),
        "deg": ("deg", "degs", "degree", "degrees", "°"),
        "counts": ("counts", "count", "cts", "cnt", "ticks", "tick", "inc", "lsb"),
        "turns": tuple(f"{unit}{s}" for unit in _TURNS for s in ("", "s")),
    },
    "velocity": {
        "rad/s": tuple(f"{unit}{s}" for unit in ("rad", "radians") for s in _SECOND),
        "deg/s": tuple(f"{unit}{s}" for unit in ("deg", "degrees", "°") for s in _SECOND),
        "rpm": ("rpm", "r/min", "rev/min", "1/min"),
        "counts/s": tuple(f"{unit}{s}" for unit in ("counts", "count", "cts", "ticks") for s in _SECOND),
        "turns/s": tuple(f"{unit}{s}" for turn in _TURNS for unit in (turn, f"{turn}s") for s in _SECOND),
    },
    "torque": {
        "N m": ("nm", "newtonmeter", "newtonmetre", "newtonmeters", "newtonmetres"),
        "mN m": ("mnm", "nmm", "millinewtonmeter", "millinewtonmetre"),
        "N cm": ("ncm",),
        "kN m": ("knm",),
        "kgf cm": ("kgfcm", "kgcm"),
        "lbf in": ("lbfin", "lbin", "inlbf", "inlb"),
        "lbf ft": ("lbfft", "lbft", "ftlbf", "ftlb"),
        "ozf in": ("ozfin", "ozin", "inozf", "inoz"),
        "A": ("a", "amp", "amps", "ampere", "amperes"),
        "mA": ("ma", "milliamp", "milliamps"),
        "counts": ("counts", "count", "cts", "cnt", "pwm", "lsb", "ticks", "%", "percent", "‰"),
    },
}

_FACTORS: Final = {
    **{"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "days": 86400.0},
    **{"rad": 1.0, "deg": math.pi / 180.0, "rad/s": 1.0, "deg/s": math.pi / 180.0, "rpm": math.pi / 30.0},
    **{"turns": 2.0 * math.pi, "turns/s": 2.0 * math.pi},
    **{"mrad": 1e-3, "N m": 1.0, "mN m": 1e-3, "N cm": 1e-2, "kN m": 1e3, "kgf cm": 9.80665e-2},
    **{"lbf in": 0.1129848290276167, "lbf ft": 1.3558179483314004, "ozf in": 0.1129848290276167 / 16.0},
}

#: Names of a signal without its joint, and the unit that they imply.
_WORDS: Final[tuple[tuple[str, tuple[str, ...], str | None], ...]] = (
    ("q", ("q", "pos", "position", "theta", "angle"), None),
    ("dq", ("dq", "qd", "qdot", "dotq", "vel", "velocity", "dtheta", "thetadot", "omega", "speed"), None),
    ("tau", ("tau", "torque", "effort", "trq", "u"), None),
    ("tau", ("current", "cur"), "A"),
    ("tau", ("pwm",), "counts"),
)
_MAX_PROPOSED_LENGTH = 80  # longest header that a message proposes as a column

SIMULATED: Final = "simulated"  # column of `repro decode` that states whether the simulated board made a recording

_JOINT_0 = re.compile(r"(?<=\D)0(?=\D|$)")
_BRACKETS = re.compile(r"(.+?)\s*[\[({]\s*([^\d\s].*?)\s*[\])}]\Z")


@dataclass(frozen=True)
class Column:
    """Where a signal is."""

    index: int  # column of the table
    header: str
    unit: str | None  # one of `SPELLINGS`; None if nothing states it
    assumed: bool = False  # whether the unit is the SI unit because nothing states another


def _names() -> dict[str, tuple[Signal, str | None]]:
    """List the squeezed names of columns, each with its signal and the unit that the name implies."""
    times = ("time", "t", "timestamp", "timestamps")
    names: dict[str, tuple[Signal, str | None]] = dict.fromkeys(times, ("time", None))
    names |= {"millis": ("time", "ms"), "micros": ("time", "us")}
    for joint, part in ((1, "shoulder"), (2, "elbow")):
        for signal, words, unit in _WORDS:
            for word in words:
                for name in (f"{word}{joint}", f"joint{joint}{word}", f"{word}joint{joint}", part + word, word + part):
                    for spelt in (name, f"{name}meas", f"{name}measured", name.replace(word, f"{word}meas")):
                        names[spelt] = (f"{signal}{joint}", unit)  # type: ignore[assignment]
        for name in (f"q{joint}dot", f"theta{joint}dot"):
            names[name] = (f"dq{joint}", None)  # type: ignore[assignment]
    return names


_NAMES: Final = _names()


def find_columns(header: Sequence[str], arm: Arm, file: str) -> tuple[dict[Signal, Column], tuple[str, ...]]:
    """Find the column of each signal, by the arm file before the header, and note what was assumed and ignored."""
    notes: list[str] = []
    chosen = _mapped(header, arm, file)
    mapped = {column.index for column in chosen.values()}
    candidates: dict[Signal, list[Column]] = {}
    for index, name in enumerate(header):
        match = _match(name)
        if match and match[0] not in chosen and index not in mapped:
            candidates.setdefault(match[0], []).append(Column(index, name, _unit(name, *match, arm, file)))
    zero = [name for name in header if _JOINT_0.search(name) and _match(_JOINT_0.sub("1", name))]
    if zero and candidates.keys() - {"time"}:  # joints 1 and 2 may be the second and third of 0, 1 and 2
        guessed = {} if candidates.keys() & {"q2", "tau2"} else _alike(header)
        guessed |= {signal: columns[0].header for signal, columns in candidates.items() if signal == "time"}
        expected = f"joints 1 and 2; for arm.yaml, to correct: {_paste(KINDS.keys() - {'dq1', 'dq2'}, guessed)}"
        raise InputError.at(f"{file}: header", f"columns of a joint 0: {_listed(zero)}", expected)
    for signal, columns in candidates.items():
        chosen[signal] = _choose(signal, columns, file, notes)
    if arm.passive_joint is not None and (torque := chosen.pop("tau1" if arm.passive_joint == 1 else "tau2", None)):
        notes.append(f"{torque.header} is not used: passive_joint of {arm.file} is {arm.passive_joint}")
    if arm.sampling_rate is not None and (time := chosen.pop("time", None)):
        notes.append(f"{time.header} is not used: sampling_rate of {arm.file} is {arm.sampling_rate:g} Hz")
    optional = ("dq1", "dq2", f"tau{arm.passive_joint}", *(("time",) if arm.sampling_rate is not None else ()))
    if missing := [signal for signal in KINDS if signal not in chosen and signal not in optional]:
        raise _missing(missing, header, chosen, file)
    for signal, other in (("dq1", "dq2"), ("dq2", "dq1")):
        if signal in chosen and other not in chosen:
            notes.append(f"{chosen.pop(signal).header} is ignored, because the other joint has no velocity column")
    used = {column.index for column in chosen.values()}
    if ignored := [name for k, name in enumerate(header) if name and k not in used and name != SIMULATED]:
        notes.append(f"columns ignored: {_listed(ignored)}")
    return _with_units(chosen, file, notes), tuple(notes)


def _mapped(header: Sequence[str], arm: Arm, file: str) -> dict[Signal, Column]:
    """Find the columns that the arm file names."""
    chosen: dict[Signal, Column] = {}
    for signal, kind in ((signal, kind) for signal, kind in KINDS.items() if signal in arm.columns):
        name = arm.columns[signal].strip()
        if name not in header:
            near = difflib.get_close_matches(name, header, 1)
            expected = f"a header of {file}: {_listed(header)}" + (f" (perhaps {near[0]!r})" if near else "")
            raise InputError.at(f"{arm.file}: columns.{signal}", repr(name), expected)
        match = _match(name)
        if match and KINDS[match[0]] == kind:
            spelling = match[1]
        else:  # of a header of any name; brackets enclose a unit, known or not
            units = [unit for _, unit in _split(name) if unit_named(unit, kind)]
            brackets = _BRACKETS.match(name)
            spelling = units[0] if units else brackets[2] if brackets else ""
        chosen[signal] = Column(header.index(name), name, _unit(name, signal, spelling, arm, file))
    return chosen


def _split(header: str) -> Iterator[tuple[str, str]]:
    """Split a header into name and unit in every way: without unit, in brackets, behind a slash, as a suffix."""
    yield header, ""
    brackets = _BRACKETS.match(header)
    if brackets:
        yield brackets[1], brackets[2]
    name, slash, unit = header.partition("/")
    if slash and name and not brackets:
        yield name, unit.strip("() ")
    for place in re.finditer(r"[_\s.-]", header):
        yield header[: place.start()], header[place.end() :]


def _match(header: str) -> tuple[Signal, str] | None:
    """Give signal and spelling of the unit, empty if there is none; None for a header that names no signal."""
    unknown: tuple[Signal, str] | None = None
    for name, unit in _split(header):
        signal, implied = _NAMES.get(squeeze(name), (None, None))
        if signal is None:
            continue
        if not unit or unit_named(unit, KINDS[signal]):
            return signal, unit or implied or ""
        # A suffix may be any word, but brackets and slashes enclose a unit.
        if unknown is None and re.search(r"[\[({/]", header):
            unknown = signal, unit
    return unknown


def _unit(header: str, signal: Signal, spelling: str, arm: Arm, file: str) -> str | None:
    """Give the unit of a column; None if neither the header nor the arm file states it."""
    kind = KINDS[signal]
    if kind in arm.units:
        return arm.units[kind]
    unit = unit_named(spelling, kind)
    if spelling and unit is None:
        expected = f"a unit of {kind}: {', '.join(SPELLINGS[kind])}; or units.{kind} in the arm file"
        raise InputError.at(f"{file}: header, column {header}", f"the unit {spelling!r}", expected)
    return unit


def _choose(signal: Signal, columns: list[Column], file: str, notes: list[str]) -> Column:
    """Choose the column of a signal; one in an SI unit has priority over raw counts and currents."""
    if len(columns) == 1:
        return columns[0]
    si = [column for column in columns if column.unit == si_unit(KINDS[signal])]
    raw = [column for column in columns if column.unit in ("counts", "counts/s", "A", "mA")]
    names = ", ".join(column.header for column in columns)
    if len(si) == 1 and len(si) + len(raw) == len(columns):
        notes.append(f"{signal} is read from {si[0].header}, in {si[0].unit}, of {names}")
        return si[0]
    found = f"{len(columns)} columns for {signal}: {names}"
    raise InputError.at(f"{file}: header", found, f"one, or the one to use as columns.{signal} in the arm file")


def _missing(missing: Sequence[Signal], header: Sequence[str], found: dict[Signal, Column], file: str) -> InputError:
    """Report signals without a column, with columns of the file to correct and paste into the arm file."""
    used = {column.header for column in found.values()}
    free = [name for name in header if name and name not in used and len(name) <= _MAX_PROPOSED_LENGTH]
    known = {signal: column.header for signal, column in found.items()}
    if known.keys() <= {"time", "q2", "dq2", "tau2"}:  # the two joints may be the second and third of a larger arm
        free += [known.pop(signal) for signal in known.keys() - {"time"}]
    likely = _misspelt(free) | _alike(free) | known
    near = [f"{likely[signal]!r} for {signal}" for signal in missing if signal in likely]
    hint = f" (perhaps {', '.join(near)})" if near else ""
    without = ", or sampling_rate: HZ if it has none" if "time" in missing else ""
    if missing in (["tau1"], ["tau2"]):
        without = f", or passive_joint: {missing[0][-1]} if it has no drive"
    if missing in (["tau1", "tau2"], ["q1", "q2"]) and "time" in known:
        without = f", joined by time if they are in another file: pandas.merge_asof(frame, other, on={known['time']!r})"
    if joint := next((name for name in header if squeeze(name) in ("joint", "jointname", "name", "motor", "id")), None):
        pivot = f"frame.pivot(index={known.get('time', 'TIME')!r}, columns={joint!r})"
        renamed = "frame.columns = ['.'.join(map(str, pair[::-1])) for pair in frame.columns]"
        without += f"; of a row for each joint, make columns in Python: frame = {pivot}; {renamed}"
    paste = _paste({*found, *missing}, likely)
    expected = f"a column for {', '.join(missing)}{hint}{without}; for arm.yaml, to correct: {paste}"
    return InputError.at(f"{file}: header", f"the columns {_listed(header)}", expected)


def _paste(signals: Set[Signal], columns: Mapping[Signal, str]) -> str:
    """Write the columns of these signals as a line of the arm file."""
    names = {signal: columns.get(signal, "HEADER") for signal in KINDS if signal in signals}
    return f"columns: {{{', '.join(f'{key}: {json.dumps(name, ensure_ascii=False)}' for key, name in names.items())}}}"


#: Words of a header by what they say of it; what was asked for, or worked on later, is not what was measured.
_KIND_WORDS: Final[dict[str, tuple[str, ...]]] = {
    "time": ("time", "t", "timestamp", "stamp", "times", "timestamps", "zeit"),
    "q": ("q", "pos", "position", "positions", "theta", "angle", "angles", "encoder", "enc", "winkel"),
    "tau": ("tau", "torque", "torques", "effort", "efforts", "trq", "current", "currents", "cur", "m", "moment"),
}
_NOT_MEASURED: Final = re.compile(
    r"cmd|command|target|desired|des|ref|setpoint|goal|demand|filt|smooth|lowpass|error|err|residual|vel|speed|dot|acc"
)


def _misspelt(header: Sequence[str]) -> dict[Signal, str]:
    """Guess columns whose names nearly are those of a signal, with its joint."""
    guessed: dict[Signal, str] = {}
    words = {word for _, of_kind, _ in _WORDS for word in of_kind}  # of neither joint
    for known, (signal, _) in _NAMES.items():
        measured = {
            squeeze(name): name
            for name in header
            if not _NOT_MEASURED.search(name.lower()) and squeeze(name) not in words
        }
        same_joint = [plain for plain in measured if re.findall(r"\d", plain) == re.findall(r"\d", known)]
        if near := difflib.get_close_matches(known, same_joint, 1, 0.75):
            guessed.setdefault(signal, measured[near[0]])
    return guessed


def _alike(header: Sequence[str]) -> dict[Signal, str]:
    """Guess columns by their words: of the kind that is missing, measured, and the first two joints of a numbering."""
    by_stem: dict[tuple[str, str], dict[int, str]] = {}
    guessed: dict[Signal, str] = {}
    for name in header:
        numbered = re.sub("shoulder|hip", "1", re.sub("elbow|knee", "2", name, flags=re.I), flags=re.I)
        words = [word.lower() for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+|\d+", numbered)]
        letters = [word for word in words if word.isalpha()]
        if any(_NOT_MEASURED.search(word) for word in letters):
            continue
        kinds = [kind for kind, known in _KIND_WORDS.items() if set(known) & set(letters)]
        numbers = [int(word) for word in words if word.isdigit()]
        if kinds == ["time"] and not numbers:
            guessed.setdefault("time", name)
        elif len(kinds) == len(numbers) == 1 and kinds != ["time"]:
            by_stem.setdefault((kinds[0], re.sub(r"\d+", "#", numbered)), {})[numbers[0]] = name
    for kind in ("q", "tau"):
        joints = [joint for (of, _), joint in by_stem.items() if of == kind and len(joint) > 1]
        if len(joints) == 1:
            first, second = sorted(joints[0])[:2]
            if second == first + 1:
                signals: tuple[Signal, Signal] = ("q1", "q2") if kind == "q" else ("tau1", "tau2")
                guessed |= {signals[0]: joints[0][first], signals[1]: joints[0][second]}
    return guessed


def _listed(names: Sequence[str]) -> str:
    """Join the first few names."""
    few = [name[:40] for name in names[:10]]
    return ", ".join(few) + (f" and {len(names) - len(few)} more" if len(names) > len(few) else "")


def _with_units(found: dict[Signal, Column], file: str, notes: list[str]) -> dict[Signal, Column]:
    """Complete the units: SI where neither joint states one. Columns come in the order of `KINDS`."""
    complete = {signal: found[signal] for signal in KINDS if signal in found}
    assumed: dict[str, list[str]] = {}
    for signal, column in complete.items():
        kind = KINDS[signal]
        if column.unit is None:
            for twin in (twin for name, twin in found.items() if KINDS[name] == kind and twin.unit):
                expected = f"its unit, as {twin.header} is in {twin.unit}; or units.{kind} in the arm file"
                raise InputError.at(f"{file}: header, column {column.header}", "no unit", expected)
            assumed.setdefault(si_unit(kind), []).append(column.header)
            complete[signal] = replace(column, unit=si_unit(kind), assumed=True)
    if units := "; ".join(f"{', '.join(names)} in {unit}" for unit, names in assumed.items()):
        notes.append(f"the header states no unit for some columns; assumed: {units}")
    if converted := [f"{c.header} from {c.unit}" for s, c in complete.items() if c.unit != si_unit(KINDS[s])]:
        notes.append(f"converted to SI: {', '.join(converted)}")
    return complete


def squeeze(text: str) -> str:
    """Remove case, spaces, dots and dashes from a name or unit."""
    return re.sub(r"[\s_.·⋅*-]", "", text).lower().replace("µ", "u").replace("μ", "u")


def unit_named(text: str, kind: SignalKind) -> str | None:
    """Give the unit of a spelling; None if this kind is not measured in it."""
    plain = squeeze(text)
    return next((unit for unit, spellings in SPELLINGS[kind].items() if plain in spellings), None)


def si_unit(kind: SignalKind) -> str:
    """Give the SI unit of a kind of signal."""
    return next(iter(SPELLINGS[kind]))


def unused_constants(columns: dict[Signal, Column], arm: Arm, file: str) -> Iterator[str]:
    """Note a constant of the arm file that no column needs; refuse one where nothing states the unit of the columns."""
    for key, kinds, raw in (
        ("torque_constant", ("torque",), "torque: A"),
        ("counts_per_turn", ("position", "velocity"), "position: counts"),
    ):
        first, *rest = [column for signal, column in columns.items() if KINDS[signal] in kinds]
        if getattr(arm, key) is None or any(column.unit not in _FACTORS for column in (first, *rest)):
            continue
        if first.assumed:
            expected = f"units: {{{raw}}} in the arm file, or '{first.header} [{first.unit}]' as header"
            raise InputError.at(f"{file}: header, column {first.header}", f"no unit, but {key} in {arm.file}", expected)
        yield f"{key} of {arm.file} is not used: {first.header} is in {first.unit}"


def si_factor(signal: Signal, unit: str, arm: Arm, log: str = "the log") -> float:
    """Give the SI value of one `unit` of a signal; InputError if it needs a constant that the arm file lacks."""
    if unit in _FACTORS:
        return _FACTORS[unit]
    key = "torque_constant" if KINDS[signal] == "torque" else "counts_per_turn"
    if getattr(arm, key) is None:
        meaning = "N m at the joint for 1 A or 1 count" if key == "torque_constant" else "counts in a turn of the joint"
        expected = f"two numbers, {meaning}, because {signal} of {log} is in {unit}"
        raise InputError.at(f"{arm.file}: {key}", "nothing", expected)
    value: float = getattr(arm, key)[int(signal[-1]) - 1]
    return 2.0 * math.pi / value if key == "counts_per_turn" else value * (1e-3 if unit == "mA" else 1.0)
