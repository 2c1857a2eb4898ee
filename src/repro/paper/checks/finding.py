"""What a check of the paper against itself returns, and the words for its outcome."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import pandas as pd

#: Outcomes of a check.
CONSISTENT = "consistent"
CONTRADICTS = "contradicts itself"
NOT_POSSIBLE = "not possible"
OUTSIDE = "outside its own range"
IN_PART = "holds in part"
MISPRINT = "misprint"
QUESTIONABLE = "questionable"
OPEN = "cannot be decided"

VERDICTS = {
    CONSISTENT: "the printed numbers agree",
    CONTRADICTS: "two statements of the paper exclude each other",
    NOT_POSSIBLE: "no arm, or no signal, can have the printed value",
    OUTSIDE: "the value lies outside the range that the paper gives for it",
    IN_PART: "true for some of the cases it is said of",
    MISPRINT: "a symbol, unit or reference that the rest of the paper corrects",
    QUESTIONABLE: "no contradiction, but a reader should know",
    OPEN: "the part of the paper that would decide it is lost or was not printed",
}

#: Rounding of binary numbers, relative to the tolerance.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Finding:
    """Result of one check."""

    id: str  # stable name, for example ``composition/table10``
    place: str  # where the statement stands
    what: str  # what is checked, in words
    arithmetic: str  # the calculation, with its numbers
    found: float  # what the calculation gives and what it is held against, in `unit`; nan where there is no number
    printed: float
    tolerance: float  # by how much rounding lets them differ; nan where they are not compared as values
    unit: str  # unit of `found` and `printed`
    verdict: str  # one of `VERDICTS`
    note: str = ""  # what a reader should know; says so where the extraction of the text may be at fault
    numbers: tuple[str, ...] = ()  # ids of the published numbers that the check uses

    def __post_init__(self) -> None:
        if self.verdict not in VERDICTS:
            raise ValueError(f"verdict: must be one of {tuple(VERDICTS)}, got {self.verdict!r}.")


def agreement(found: float, printed: float, tolerance: float, otherwise: str = CONTRADICTS) -> str:
    """Verdict on two numbers that should be equal."""
    return CONSISTENT if abs(found - printed) <= tolerance * (1.0 + _ROUNDING) else otherwise


def remark(
    id_: str, place: str, what: str, arithmetic: str, verdict: str, note: str = "", numbers: tuple[str, ...] = ()
) -> Finding:
    """Finding about words or symbols, which has no numbers to compare."""
    return Finding(id_, place, what, arithmetic, math.nan, math.nan, math.nan, "", verdict, note, numbers)


def findings_frame(findings: Iterable[Finding]) -> pd.DataFrame:
    """Tidy table of findings."""
    return pd.DataFrame(
        [{**vars(f), "numbers": " ".join(f.numbers)} for f in findings], columns=list(Finding.__dataclass_fields__)
    )
