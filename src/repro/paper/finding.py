"""Findings of the audit. ``findings.csv`` has their texts, in the order of the table; `Check` computes a row of it.

The columns ``found``, ``relation`` and ``printed`` are a calculation on the row's published numbers, which the column
``numbers`` names (``name=id``). ``=`` compares to the last digit of the published number with the id of the row, ``==``
exactly. Other calculations are functions of `repro.paper.audit`.

Texts are templates of the row's numbers, ``found``, ``printed``, names that a function passes, and expressions. The
column ``verdict`` is that of a check that fails, or of a row without a calculation. If the place is empty, the
published number with the id of the row gives place and unit.
"""

import math
import operator
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from string import Formatter
from typing import Any

from repro.files import read_rows
from repro.paper.published import Published, PublishedValue, evaluate

#: Columns with texts.
TEXTS = ("id", "place", "what", "arithmetic", "unit", "verdict", "note")
FINDINGS_FILE = Path(__file__).with_name("findings.csv")

#: Outcomes of a check.
CONSISTENT = "consistent"
CONTRADICTS = "contradicts itself"
NOT_POSSIBLE = "not possible"
QUESTIONABLE = "questionable"

VERDICTS = {
    CONSISTENT: "the printed numbers agree",
    CONTRADICTS: "two statements of the paper exclude each other",
    NOT_POSSIBLE: "no arm, or no signal, can have the printed value",
    "outside its own range": "the value lies outside the range that the paper gives for it",
    "holds in part": "true for some of the cases it is said of",
    "misprint": "a symbol, unit or reference that the rest of the paper corrects",
    QUESTIONABLE: "no contradiction, but a reader should know",
    "cannot be decided": "the part of the paper that would decide it is lost or was not printed",
}

#: Relations of two numbers that a row can state, besides their equality.
RELATIONS = {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge}

#: Rounding of binary numbers, relative to the tolerance.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Finding:
    """Result of one check."""

    id: str  # stable name, for example ``composition/table10``
    place: str  # where the statement is printed
    what: str  # what is checked, in words
    arithmetic: str  # the calculation, with its numbers
    found: float  # what the calculation gives, in `unit`; nan where there is no number
    printed: float  # what it is compared with, in `unit`
    tolerance: float  # by how much rounding lets them differ; nan where they are not compared as values
    unit: str  # unit of `found` and `printed`
    verdict: str  # one of `VERDICTS`
    note: str = ""  # what a reader should know; says so where the extraction of the text may be at fault
    numbers: tuple[str, ...] = ()  # ids of the published numbers that the check uses


#: Published numbers, or their ids, that a check uses besides those of its row.
Uses = Iterable[PublishedValue | str]


class _Texts(Formatter):
    """Templates whose fields are names, or arithmetic on the values of numbers."""

    def get_field(self, field_name: str, args: Sequence[Any], kwargs: Mapping[str, Any]) -> Any:  # noqa: ANN401
        """Look a field up, or else evaluate it."""
        try:
            return super().get_field(field_name, args, kwargs)
        except LookupError:
            return evaluate(field_name, kwargs["values"]), field_name


class Check:
    """One row of ``findings.csv`` with its published numbers, whose values are attributes by their names in the row."""

    def __init__(self, row: dict[str, str], published: Published) -> None:
        self.id = row["id"]
        self.published = published
        self._row = row
        names = [entry.partition("=") for entry in row["numbers"].split()]
        self.numbers: dict[str, PublishedValue] = {name: published[id_] for name, _, id_ in names}
        self._values = {"pi": math.pi, **{name: number.value for name, number in self.numbers.items()}}

    def __getattr__(self, name: str) -> float:
        """Value of a published number of the row."""
        if name not in self.__dict__.get("numbers", {}):
            raise AttributeError(name)
        return self.numbers[name].value

    def equals(
        self,
        found: float,
        printed: float | None = None,
        tolerance: float | None = None,
        uses: Uses = (),
        **texts: Any,  # noqa: ANN401
    ) -> Finding:
        """Compare a calculated number with a printed one, by default the published number of this id as printed."""
        if printed is None:
            printed = self.published[self.id].value
        if tolerance is None:
            tolerance = self.published[self.id].half_step
        same = abs(found - printed) <= tolerance * (1.0 + _ROUNDING)
        return self.compares(found, printed, same, tolerance=tolerance, uses=uses, **texts)

    def compares(
        self, found: float, printed: float, consistent: bool, *,
        tolerance: float = math.nan, verdict: str = "", uses: Uses = (), **texts: Any,  # noqa: ANN401
    ) -> Finding:  # fmt: skip
        """Report a calculated number next to a printed one, for example a limit, with the outcome of the check."""
        named = {"found": found, "printed": printed, "values": self._values, **self.numbers, **texts}
        text = {name: _Texts().vformat(self._row[name], (), named) for name in TEXTS}
        if not text["place"]:
            subject = self.published[self.id]
            text |= {"place": subject.place, "unit": text["unit"] or subject.unit}
        text["note"] = text["note"].strip()
        text["verdict"] = CONSISTENT if consistent else verdict or text["verdict"]
        ids = tuple(number if isinstance(number, str) else number.id for number in (*self.numbers.values(), *uses))
        return Finding(**text, found=found, printed=printed, tolerance=tolerance, numbers=ids)

    def calculated(self) -> Finding:
        """Evaluate the expressions of the row; one without them is about words or symbols."""
        sides = (self._row["found"], self._row["printed"])
        found, printed = (float(evaluate(side, self._values)) if side else math.nan for side in sides)
        relation = self._row["relation"]
        if relation in ("=", "=="):
            return self.equals(found, printed, 0.0 if relation == "==" else None)
        return self.compares(found, printed, relation != "" and RELATIONS[relation](found, printed))


def read_checks(published: Published) -> list[Check]:
    """Read the rows of ``findings.csv``."""
    return [Check(row, published) for row in read_rows(FINDINGS_FILE)]
