"""Findings of the audit. ``findings.csv`` has their texts, in the order of the table; `Check` computes a row of it.

The column ``numbers`` names the published numbers of a row (``name=id``). Its calculation is a function of
`repro.paper.audit`, `repro.paper.arithmetic_checks` or `repro.paper.appendix`.

Texts are templates of the row's numbers, ``found``, ``printed``, and names that a function passes. The
column ``verdict`` is that of a check that fails, or of a row without a calculation. If the place is empty, the
published number with the id of the row gives place and unit.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from repro.files import read_rows
from repro.paper.published import Published, PublishedValue

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


class Check:
    """One row of ``findings.csv`` with its published numbers, whose values are attributes by their names in the row."""

    def __init__(self, row: dict[str, str], published: Published) -> None:
        self.id = row["id"]
        self.published = published
        self._row = row
        names = [entry.partition("=") for entry in row["numbers"].split()]
        self.numbers: dict[str, PublishedValue] = {name: published[id_] for name, _, id_ in names}

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
        named = {"found": found, "printed": printed, **self.numbers, **texts}
        text = {name: self._row[name].format(**named) for name in TEXTS}
        if not text["place"]:
            subject = self.published[self.id]
            text |= {"place": subject.place, "unit": text["unit"] or subject.unit}
        text["note"] = text["note"].strip()
        text["verdict"] = CONSISTENT if consistent else verdict or text["verdict"]
        ids = tuple(number if isinstance(number, str) else number.id for number in (*self.numbers.values(), *uses))
        return Finding(**text, found=found, printed=printed, tolerance=tolerance, numbers=ids)

    def related(self, found: float, relation: Callable[[float, float], bool], printed: float, **texts: Any) -> Finding:  # noqa: ANN401
        """Report whether a calculated number is above, or below, a printed one."""
        return self.compares(found, printed, relation(found, printed), **texts)

    def in_words(self) -> Finding:
        """Report what is about words or symbols, with the verdict of the row."""
        return self.compares(math.nan, math.nan, False)


def read_checks(published: Published) -> list[Check]:
    """Read the rows of ``findings.csv``."""
    return [Check(row, published) for row in read_rows(FINDINGS_FILE)]
