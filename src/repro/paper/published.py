"""The numbers the paper prints, as it prints them (``published.csv``), with typed access.

Nothing that computes our results may import this module: it serves comparisons, captions and audits only.

A row of the file is one printed number: every number that is a claim, a constant or a result, once for each section,
table, equation or figure that states it. Section V-C compares parameters of Table 9 in words; these comparisons are
ratios above or below 1. Left out are the coefficients of a formula (Eq. 1, 3, 5, 15, 17-22), the numbers of sections,
equations, layers and references, and the degrees of freedom of the robots of other works, which Table 1 lists; so is
Table 8's PWM frequency of joint 2, unreadable in the text we have.

Percentages stay in percent (unit ``%``), every number keeps the unit printed with it, and trailing zeros stay,
because the number of digits shows how finely a value is known: ``500e3`` stands for "500 thousand". Fields that do not
apply are empty. The columns ``ours`` and ``note`` declare where our value comes from (`repro.paper.our_values`).
"""

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from repro.errors import InputError
from repro.files import read_rows
from repro.model.parameters import NAMES, Array

COLUMNS = (
    "id", "place", "quantity", "case", "method", "joint", "parameter", "unit", "relation", "value", "text", "kind",
    "ours", "note",
)  # fmt: skip
REQUIRED = ("id", "place", "quantity", "unit", "relation", "value", "kind")
PUBLISHED_FILE = Path(__file__).with_name("published.csv")
#: The four numeric test arms of Tables 4 and 5.
NUMERIC_CASES = ("N1", "N2", "N3", "N4")

#: How a number is meant, and what a comparison with ours can therefore be.
KINDS = {
    "exact": "arithmetic on other printed numbers",
    "deterministic": "computed without chance from an arm that is lost",
    "stochastic": "depends on random numbers: training, guesses, random trajectories",
    "hardware-only": "measured on, or a property of, the real arm and its board",
    "setting": "chosen by the authors; a configuration can adopt it",
    "other-work": "a result of another work, as this paper quotes it",
}
#: What the print says of the number: the quantity is this, lies above or below it, reaches up to it, or is about it.
RELATIONS = ("is", "above", "below", "up to", "about")

_NUMBER = re.compile(r"[+-]?\d+(\.\d*)?([eE][+-]?\d+)?")
_NUMBERED = re.compile(r"(Table|Fig\.|Eq\.) (\d+)")
_SECTION = re.compile(r"Section (I|II|III|IV|V|VI|VII)(?:-([A-C]))?")
_ROMAN = {numeral: k for k, numeral in enumerate(("I", "II", "III", "IV", "V", "VI", "VII"), start=1)}
_PLAIN = {"Abstract": "abstract", "Algorithm 1": "algorithm1", "Appendix A": "appendix"}


@dataclass(frozen=True)
class PublishedValue:
    """One number of the paper."""

    id: str  # stable name, for example ``table07/N1/total/joint1``; it begins with the place
    place: str  # where it is printed: ``Table 7``, ``Abstract``, ``Section IV-A``, ``Eq. 10``
    quantity: str  # what it is: ``parameter``, ``time``, ``frequency``, ``total``, or some words
    case: str  # like method and parameter empty where it does not apply
    method: str
    joint: int | None  # 1 or 2; None where it does not apply
    parameter: str
    unit: str  # unit as printed
    relation: str  # one of `RELATIONS`
    printed: str  # the number, with the digits printed
    text: str  # the print itself where it is not that number: ``half-million``, ``three``; else empty
    kind: str  # one of `KINDS`
    ours: str = ""  # where our value comes from (`repro.paper.our_values`)
    note: str = ""  # what a reader of the comparison should know

    def __str__(self) -> str:
        """The number as it is printed."""
        return self.printed

    @property
    def value(self) -> float:
        """The number, in `unit`."""
        return float(self.printed)

    @property
    def half_step(self) -> float:
        """Half a unit of the last printed digit, in `unit`: the value is known no better."""
        mantissa, _, exponent = self.printed.lower().partition("e")
        decimals = len(mantissa.partition(".")[2])
        return 0.5 * 10.0 ** (int(exponent or 0) - decimals)


def place_head(place: str) -> str:
    """First part of the ids of a place: ``table07`` for ``Table 7``, ``section4a`` for ``Section IV-A``."""
    if match := _NUMBERED.fullmatch(place):
        return f"{match[1].rstrip('.').lower()}{int(match[2]):02d}"
    if match := _SECTION.fullmatch(place):
        return f"section{_ROMAN[match[1]]}{(match[2] or '').lower()}"
    return _PLAIN.get(place, "")


def parse_row(entry: Mapping[str, str], place: str) -> PublishedValue:
    """Check one row of the file."""
    for name in REQUIRED:
        if not entry[name].strip():
            raise InputError.at(f"{place}: {name}", "nothing", "text")
    head = place_head(entry["place"])
    if not head:
        raise InputError.at(f"{place}: place", repr(entry["place"]), "a table, figure, equation or section")
    if entry["id"].split("/")[0] != head:
        raise InputError.at(f"{place}: id", repr(entry["id"]), f"an id that begins with {head!r}")
    for name, allowed in (("kind", KINDS), ("relation", RELATIONS), ("joint", ("", "1", "2"))):
        if entry[name] not in allowed:
            raise InputError.at(f"{place}: {name}", repr(entry[name]), f"one of {', '.join(map(repr, allowed))}")
    printed = entry["value"]
    if not _NUMBER.fullmatch(printed) or not math.isfinite(float(printed)):
        raise InputError.at(f"{place}: value", repr(printed), "a finite decimal number")
    others = {name: text for name, text in entry.items() if name not in ("joint", "value")}
    return PublishedValue(joint=int(entry["joint"]) if entry["joint"] else None, printed=printed, **others)


def parameter_id(case: str, method: str, name: str) -> str:
    """Id of a parameter of Table 4 or 5."""
    return f"{'table04' if case in NUMERIC_CASES[:2] else 'table05'}/{case}/{method}/{name}"


@dataclass(frozen=True)
class Published:
    """All published numbers of one file, in its order."""

    values: tuple[PublishedValue, ...]  # one entry a row; ids are unique
    source: str = PUBLISHED_FILE.name  # the file, for messages

    def __len__(self) -> int:
        """How many numbers there are."""
        return len(self.values)

    def __iter__(self) -> Iterator[PublishedValue]:
        """Over the numbers, in file order."""
        return iter(self.values)

    def __getitem__(self, id_: str) -> PublishedValue:
        """Number with a given id."""
        for v in self.values:
            if v.id == id_:
                return v
        raise InputError.at(f"{self.source}: id", f"no row {id_!r}", "one row with this id")

    def select(self, **wanted: str | int) -> tuple[PublishedValue, ...]:
        """Select the numbers that match every field given, in file order."""
        return tuple(v for v in self.values if all(getattr(v, name) == w for name, w in wanted.items()))

    def parameter_sets(self, method: str) -> Array:
        """Parameter sets of the numeric tests (Tables 4 and 5)."""
        return np.array([[self[parameter_id(case, method, name)].value for name in NAMES] for case in NUMERIC_CASES])

    def similarities(self, quantity: str) -> Array:
        """Similarities of the numeric tests on the random trajectory (Table 7)."""
        rows = [[self[f"table07/{case}/{quantity}/joint{j}"].value for j in (1, 2)] for case in NUMERIC_CASES]
        return np.array(rows) / 100.0


def load_published(path: Path = PUBLISHED_FILE) -> Published:
    """Read and check the published numbers."""
    rows = read_rows(path)
    if not rows:
        raise InputError.at(str(path), "no row below the header", "one row a published number")
    if tuple(rows[0]) != COLUMNS:
        raise InputError.at(f"{path}: header", ",".join(rows[0]), ",".join(COLUMNS))
    values = tuple(parse_row(row, f"{path}: line {number}") for number, row in enumerate(rows, start=2))
    seen: set[str] = set()
    for number, v in enumerate(values, start=2):
        if v.id in seen:
            raise InputError.at(f"{path}: line {number}: id", f"{v.id!r} a second time", "an id used once")
        seen.add(v.id)
    return Published(values, path.name)
