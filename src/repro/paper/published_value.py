"""One printed number: what a row of ``published.csv`` holds, and the check that a row is sound.

Percentages stay in percent (unit ``%``), every number keeps the unit printed with it, and trailing zeros stay,
because the number of digits says how finely a value is known: ``500e3`` stands for "500 thousand". Fields that
do not apply are empty.
"""

import math
import re
from dataclasses import dataclass

from repro.errors import InputError

COLUMNS = (
    "id",
    "place",
    "quantity",
    "case",
    "method",
    "joint",
    "parameter",
    "unit",
    "relation",
    "value",
    "text",
    "kind",
)
REQUIRED = ("id", "place", "quantity", "unit", "relation", "value", "kind")

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


def parse_row(row: list[str], place: str) -> PublishedValue:
    """Check one row of the file."""
    if len(row) != len(COLUMNS):
        raise InputError.at(place, f"{len(row)} fields", f"{len(COLUMNS)} fields")
    entry = dict(zip(COLUMNS, row, strict=True))
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
    joint, printed = entry.pop("joint"), entry.pop("value")
    if not _NUMBER.fullmatch(printed) or not math.isfinite(float(printed)):
        raise InputError.at(f"{place}: value", repr(printed), "a finite decimal number")
    return PublishedValue(joint=int(joint) if joint else None, printed=printed, **entry)
