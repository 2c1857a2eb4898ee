"""The numbers the paper prints, as it prints them (``published.csv``), with typed access.

Nothing that computes our results may import this module: it serves comparisons, captions and audits only.

A row is one printed number: every claim, constant or result, once for each section, table, equation or figure that
states it. Comparisons of Section V-C in words are ratios above or below 1. Left out are the coefficients of a formula
(Eq. 1, 3, 5, 15, 17-22), the numbers of sections, equations, layers and references, the robots of other works in Table
1, and Table 8's PWM frequency of joint 2, unreadable in the text we have.

Percentages stay in percent, every number keeps its unit and its trailing zeros, which show how finely it is known:
``500e3`` is "500 thousand". Fields that do not apply are empty. Our values are those of `repro.paper.our_values`.
"""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, fields
from decimal import Decimal
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from repro.errors import InputError
from repro.files import read_rows
from repro.model.parameters import NAMES, Array

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
        return 0.5 * 10.0 ** int(Decimal(self.printed).as_tuple().exponent)


def parameter_id(case: str, method: str, name: str) -> str:
    """Id of a parameter of Table 4 or 5."""
    return f"{'table04' if case in NUMERIC_CASES[:2] else 'table05'}/{case}/{method}/{name}"


@dataclass(frozen=True)
class Published:
    """All published numbers of one file, in its order."""

    values: tuple[PublishedValue, ...]  # one entry a row; ids are unique
    source: str = PUBLISHED_FILE.name  # the file, for messages

    def __iter__(self) -> Iterator[PublishedValue]:
        """Over the numbers, in file order."""
        return iter(self.values)

    @cached_property
    def _by_id(self) -> dict[str, PublishedValue]:
        return {v.id: v for v in self.values}

    def __getitem__(self, id_: str) -> PublishedValue:
        """Number with a given id."""
        if id_ not in self._by_id:
            raise InputError.at(f"{self.source}: id", f"no row {id_!r}", "one row with this id")
        return self._by_id[id_]

    def parameter_sets(self, method: str) -> Array:
        """Parameter sets of the numeric tests (Tables 4 and 5)."""
        return np.array([[self[parameter_id(case, method, name)].value for name in NAMES] for case in NUMERIC_CASES])

    def similarities(self, quantity: str) -> Array:
        """Similarities of the numeric tests on the random trajectory (Table 7)."""
        rows = [[self[f"table07/{case}/{quantity}/joint{j}"].value for j in (1, 2)] for case in NUMERIC_CASES]
        return np.array(rows) / 100.0


def load_published(path: Path = PUBLISHED_FILE) -> Published:
    """Read the published numbers."""
    values: dict[str, PublishedValue] = {}
    columns = tuple(field.name.replace("printed", "value") for field in fields(PublishedValue))
    for number, row in enumerate(read_rows(path, columns), start=2):
        place = f"{path}: line {number}"
        for name, allowed in (("kind", KINDS), ("relation", RELATIONS), ("joint", ("", "1", "2"))):
            if row[name] not in allowed:
                raise InputError.at(f"{place}: {name}", repr(row[name]), f"one of {', '.join(map(repr, allowed))}")
        if not _NUMBER.fullmatch(row["value"]) or not math.isfinite(float(row["value"])):
            raise InputError.at(f"{place}: value", repr(row["value"]), "a finite decimal number")
        if row["id"] in values:
            raise InputError.at(f"{place}: id", f"{row['id']!r} a second time", "an id used once")
        joint, printed = int(row.pop("joint") or 0) or None, row.pop("value")
        values[row["id"]] = PublishedValue(joint=joint, printed=printed, **row)
    return Published(tuple(values.values()), path.name)


#: Columns that identify a cell of Tables 7 and 10.
CELL = ("place", "case", "method", "joint")


def similarity_cells(numbers: Published) -> pd.DataFrame:
    """Time, Freq. and Total of each cell of Tables 7 and 10, each with half a unit of its last digit."""
    rows = []
    for total in numbers:
        if total.quantity == "total" and total.place in ("Table 7", "Table 10"):
            row: dict[str, object] = {name: getattr(total, name) for name in ("id", *CELL)}
            for factor in ("time", "frequency", "total"):
                number = numbers[total.id.replace("/total/", f"/{factor}/")]
                row |= {factor: number.value, f"{factor}_step": number.half_step}
            rows.append(row)
    return pd.DataFrame(rows)
