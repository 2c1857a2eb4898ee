"""Two versions of a table, cell by cell."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from repro.comparison.classes import Kind, Spread, kind_of, rounding

Row = Mapping[str, str]


@dataclass(frozen=True)
class Difference:
    """A cell that is not the same text."""

    kind: Kind  # class of the cell
    place: str  # row and column
    a: str  # the two texts
    b: str
    size: float  # absolute difference; infinite if one is no number
    allowed: float  # how much its class allows; NaN if that was not measured

    @property
    def broken(self) -> bool:
        """Whether the class does not allow it."""
        return self.size > self.allowed

    @property
    def rank(self) -> float:
        """Size in units of what is allowed; small where nothing was measured."""
        return self.size / self.allowed if self.allowed > 0 else math.inf if self.broken else 0.0


def differences(table: str, a: Sequence[Row], b: Sequence[Row], spread: Spread) -> Iterator[Difference]:
    """Cells of two tables that are not the same text, and rows or columns that only one has."""
    if len(a) != len(b):
        yield Difference(Kind.EXACT, "number of rows", str(len(a)), str(len(b)), math.inf, 0.0)
        return
    for number, (x, y) in enumerate(zip(a, b, strict=True), start=2):
        if list(x) != list(y):
            yield Difference(Kind.EXACT, "header", ", ".join(x), ", ".join(y), math.inf, 0.0)
            return
        for column in x:
            if x[column] != y[column]:
                yield _difference(table, x, column, (x[column], y[column]), f"line {number}, {column}", spread)


def _difference(table: str, row: Row, column: str, texts: tuple[str, str], place: str, spread: Spread) -> Difference:
    kind = kind_of(table, row, column)
    try:
        a, b = map(float, texts)
    except ValueError:  # words that follow from trained numbers may differ with them
        allowed = math.nan if kind is Kind.TRAINED else 0.0
        return Difference(Kind.EXACT if kind is Kind.COMPUTED else kind, place, *texts, math.inf, allowed)
    size = 0.0 if math.isnan(a) and math.isnan(b) else abs(a - b)
    size = math.inf if math.isnan(size) else size
    allowed = rounding(a, b)
    if kind is Kind.TRAINED:
        measured = spread.allowed(table, row, column)
        allowed = measured if math.isnan(measured) else max(allowed, measured)
    return Difference(kind, place, *texts, size, allowed)
