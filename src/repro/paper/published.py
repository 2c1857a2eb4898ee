"""The numbers the paper prints, as it prints them (``published.csv``), with typed access.

Nothing that makes our results may import this module: it serves comparisons, captions and audits only.

A row of the file is one printed number. Percentages stay in percent (unit ``%``), parameters keep the unit
their table prints, and trailing zeros stay, because the number of decimals says how finely a value is known.
Fields that do not apply are empty. A new table of the paper is a matter of new rows.
"""

import csv
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
import pandas as pd

from repro.errors import InputError
from repro.model.parameters import NAMES, Array

COLUMNS = ("id", "place", "quantity", "case", "method", "joint", "parameter", "unit", "value")
REQUIRED = ("id", "place", "quantity", "unit", "value")
PUBLISHED_FILE = Path(__file__).with_name("published.csv")

#: The four numeric test arms of Tables 4 and 5.
NUMERIC_CASES = ("N1", "N2", "N3", "N4")

_NUMBER = re.compile(r"[+-]?\d+(\.\d*)?([eE][+-]?\d+)?")


@dataclass(frozen=True)
class PublishedValue:
    """One number of the paper.

    Attributes
    ----------
    id : str
        Stable name, for example ``table07/N1/total/joint1``.
    place : str
        Where it is printed: ``Table 7``, ``Abstract``.
    quantity : str
        What it is: ``parameter``, ``time``, ``frequency``, ``total``, or ``total exceeds`` for a lower bound.
    case, method, parameter : str
        Test case, method and dynamic parameter; empty where they do not apply.
    joint : int or None
        1 or 2; None where it does not apply.
    unit : str
        Unit as printed.
    printed : str
        The number as printed.
    """

    id: str
    place: str
    quantity: str
    case: str
    method: str
    joint: int | None
    parameter: str
    unit: str
    printed: str

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


@dataclass(frozen=True)
class Published:
    """All published numbers of one file, in its order.

    Attributes
    ----------
    values : tuple of PublishedValue
        One entry a row; ids are unique.
    source : str
        The file, for messages.
    """

    values: tuple[PublishedValue, ...]
    source: str = PUBLISHED_FILE.name

    def __len__(self) -> int:
        """How many numbers there are."""
        return len(self.values)

    def __iter__(self) -> Iterator[PublishedValue]:
        """Over the numbers, in file order."""
        return iter(self.values)

    def __getitem__(self, id_: str) -> PublishedValue:
        """Number with a given id.

        Raises
        ------
        InputError
            If there is none.
        """
        for v in self.values:
            if v.id == id_:
                return v
        raise InputError.at(f"{self.source}: id", f"no row {id_!r}", "one row with this id")

    def select(self, **wanted: str | int) -> tuple[PublishedValue, ...]:
        """Select the numbers that match every field given, in file order.

        Parameters
        ----------
        **wanted
            Field names of `PublishedValue` and their values, for example ``place="Table 7", joint=1``.

        Returns
        -------
        tuple of PublishedValue
            Possibly empty.

        Raises
        ------
        ValueError
            If a field does not exist.
        """
        unknown = set(wanted) - {f.name for f in fields(PublishedValue)}
        if unknown:
            raise ValueError(f"select: no field {', '.join(sorted(unknown))} in a published value.")
        return tuple(v for v in self.values if all(getattr(v, name) == w for name, w in wanted.items()))

    def parameter_sets(self, method: str) -> Array:
        """Parameter sets of the numeric tests (Tables 4 and 5).

        Parameters
        ----------
        method : {"true", "algorithm1"}
            The true sets or the published estimates.

        Returns
        -------
        array of shape (4, 9)
            One row for each of N1 ... N4, SI units.

        Raises
        ------
        InputError
            If a number is missing.
        """
        return np.array([[self[_parameter_id(case, method, name)].value for name in NAMES] for case in NUMERIC_CASES])

    def similarities(self, quantity: str) -> Array:
        """Similarities of the numeric tests on the random trajectory (Table 7).

        Parameters
        ----------
        quantity : {"time", "frequency", "total"}
            Which rows.

        Returns
        -------
        array of shape (4, 2)
            Fractions of 1: a row for each of N1 ... N4, a column for each joint.

        Raises
        ------
        InputError
            If a number is missing.
        """
        rows = [[self[f"table07/{case}/{quantity}/joint{j}"].value for j in (1, 2)] for case in NUMERIC_CASES]
        return np.array(rows) / 100.0

    def frame(self) -> pd.DataFrame:
        """Table with the columns of the file (values as floats) and ``half_step``.

        Returns
        -------
        DataFrame
            One row a number; `joint` is empty (``<NA>``) where it does not apply.
        """
        plain = [c for c in COLUMNS if c not in ("joint", "value")]
        columns: dict[str, object] = {c: [getattr(v, c) for v in self.values] for c in plain}
        columns["joint"] = pd.array([v.joint for v in self.values], dtype="Int64")
        columns["value"] = [v.value for v in self.values]
        columns["half_step"] = [v.half_step for v in self.values]
        return pd.DataFrame(columns)[[*COLUMNS, "half_step"]]


def _parameter_id(case: str, method: str, name: str) -> str:
    table = "table04" if case in NUMERIC_CASES[:2] else "table05"
    return f"{table}/{case}/{method}/{name}"


def load_published(path: Path = PUBLISHED_FILE) -> Published:
    """Read and check the published numbers.

    Parameters
    ----------
    path : Path
        CSV file with the columns `COLUMNS`.

    Returns
    -------
    Published
        The numbers.

    Raises
    ------
    InputError
        If the file is missing, or a header, field, joint, number or id is not what it must be.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except OSError as error:
        raise InputError.at(str(path), error.strerror or "an unreadable file", "a CSV table") from error
    except UnicodeDecodeError as error:
        raise InputError.at(str(path), f"bytes that are not UTF-8 (at {error.start})", "a CSV table") from error
    try:
        rows = list(csv.reader(lines))
    except csv.Error as error:
        raise InputError.at(str(path), f"text that is not a table ({error})", "a CSV table") from error
    if not rows or tuple(rows[0]) != COLUMNS:
        raise InputError.at(f"{path}: header", ",".join(rows[0]) if rows else "nothing", ",".join(COLUMNS))
    if len(rows) == 1:
        raise InputError.at(str(path), "no row below the header", "one row a published number")
    values = tuple(_parse(row, f"{path}: line {number}") for number, row in enumerate(rows[1:], start=2))
    seen: set[str] = set()
    for number, v in enumerate(values, start=2):
        if v.id in seen:
            raise InputError.at(f"{path}: line {number}: id", f"{v.id!r} a second time", "an id used once")
        seen.add(v.id)
    return Published(values, path.name)


def _parse(row: list[str], place: str) -> PublishedValue:
    """Check one row of the file."""
    if len(row) != len(COLUMNS):
        raise InputError.at(place, f"{len(row)} fields", f"{len(COLUMNS)} fields")
    entry = dict(zip(COLUMNS, row, strict=True))
    for name in REQUIRED:
        if not entry[name].strip():
            raise InputError.at(f"{place}: {name}", "nothing", "text")
    joint, printed = entry.pop("joint"), entry.pop("value")
    if joint not in ("", "1", "2"):
        raise InputError.at(f"{place}: joint", repr(joint), "1, 2 or nothing")
    if not _NUMBER.fullmatch(printed) or not math.isfinite(float(printed)):
        raise InputError.at(f"{place}: value", repr(printed), "a finite decimal number")
    return PublishedValue(joint=int(joint) if joint else None, printed=printed, **entry)
