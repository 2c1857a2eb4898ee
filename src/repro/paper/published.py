"""The numbers the paper prints, as it prints them (``published.csv``), with typed access.

Nothing that makes our results may import this module: it serves comparisons, captions and audits only.

A row of the file is one printed number (`repro.paper.published_value`): every number that is a claim, a constant or a
result, once for each section, table, equation or figure that states it. Section V-C compares parameters of Table 9 in
words; these comparisons are ratios above or below 1. Left out are the coefficients of a formula
(Eq. 1, 3, 5, 15, 17-22), the numbers of sections, equations, layers and references, and the degrees of freedom of the
robots of other works, which Table 1 lists; so is Table 8's PWM frequency of joint 2, unreadable in the text we have.
"""

import csv
from collections.abc import Iterator
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
import pandas as pd

from repro.errors import InputError
from repro.model.parameters import NAMES, Array
from repro.paper.published_value import COLUMNS, PublishedValue, parse_row

__all__ = ["COLUMNS", "NUMERIC_CASES", "PUBLISHED_FILE", "Published", "PublishedValue", "load_published"]

PUBLISHED_FILE = Path(__file__).with_name("published.csv")

#: The four numeric test arms of Tables 4 and 5.
NUMERIC_CASES = ("N1", "N2", "N3", "N4")


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
        unknown = set(wanted) - {f.name for f in fields(PublishedValue)}
        if unknown:
            raise ValueError(f"select: no field {', '.join(sorted(unknown))} in a published value.")
        return tuple(v for v in self.values if all(getattr(v, name) == w for name, w in wanted.items()))

    def parameter_sets(self, method: str) -> Array:
        """Parameter sets of the numeric tests (Tables 4 and 5)."""
        return np.array([[self[_parameter_id(case, method, name)].value for name in NAMES] for case in NUMERIC_CASES])

    def similarities(self, quantity: str) -> Array:
        """Similarities of the numeric tests on the random trajectory (Table 7)."""
        rows = [[self[f"table07/{case}/{quantity}/joint{j}"].value for j in (1, 2)] for case in NUMERIC_CASES]
        return np.array(rows) / 100.0

    def frame(self) -> pd.DataFrame:
        """Table with the columns of the file (values as floats) and ``half_step``."""
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
    """Read and check the published numbers."""
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
    values = tuple(parse_row(row, f"{path}: line {number}") for number, row in enumerate(rows[1:], start=2))
    seen: set[str] = set()
    for number, v in enumerate(values, start=2):
        if v.id in seen:
            raise InputError.at(f"{path}: line {number}: id", f"{v.id!r} a second time", "an id used once")
        seen.add(v.id)
    return Published(values, path.name)
