"""Result of a check of the paper against itself, its verdicts, and builders of results."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import pandas as pd

from repro.paper.published import PublishedValue

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

    def __post_init__(self) -> None:
        if self.verdict not in VERDICTS:
            raise ValueError(f"verdict: must be one of {tuple(VERDICTS)}, got {self.verdict!r}.")


def agreement(found: float, printed: float, tolerance: float, otherwise: str = CONTRADICTS) -> str:
    """Verdict on two numbers that should be equal."""
    return CONSISTENT if abs(found - printed) <= tolerance * (1.0 + _ROUNDING) else otherwise


#: What a finding is about: a published number, or an id of its own and a place.
Subject = PublishedValue | tuple[str, str]
#: Published numbers that a check uses, or their ids.
Uses = Iterable[PublishedValue | str]


def equals(
    subject: Subject,
    what: str,
    arithmetic: str,
    found: float,
    *,
    printed: float | None = None,
    tolerance: float | None = None,
    unit: str | None = None,
    uses: Uses = (),
    note: str = "",
    otherwise: str = CONTRADICTS,
) -> Finding:
    """Compare a calculated number with a printed one, by default with the subject to its last printed digit."""
    if isinstance(subject, PublishedValue):
        printed = subject.value if printed is None else printed
        tolerance = subject.half_step if tolerance is None else tolerance
        unit = subject.unit if unit is None else unit
    if printed is None or tolerance is None or unit is None:
        raise ValueError(f"{subject}: printed, tolerance and unit are needed where no published number has them.")
    verdict = agreement(found, printed, tolerance, otherwise)
    return Finding(*_subject(subject), what, arithmetic, found, printed, tolerance, unit, verdict, note, _ids(uses))


def compares(
    subject: Subject,
    what: str,
    arithmetic: str,
    found: float,
    printed: float,
    verdict: str,
    *,
    unit: str,
    tolerance: float = math.nan,
    uses: Uses = (),
    note: str = "",
) -> Finding:
    """Report a calculated number next to a printed one, by default a limit, with the verdict of the check."""
    return Finding(*_subject(subject), what, arithmetic, found, printed, tolerance, unit, verdict, note, _ids(uses))


def remark(subject: Subject, what: str, arithmetic: str, verdict: str, note: str = "", uses: Uses = ()) -> Finding:
    """Report on words or symbols, which have no numbers to compare."""
    return compares(subject, what, arithmetic, math.nan, math.nan, verdict, unit="", uses=uses, note=note)


def _subject(subject: Subject) -> tuple[str, str]:
    return (subject.id, subject.place) if isinstance(subject, PublishedValue) else subject


def _ids(uses: Uses) -> tuple[str, ...]:
    return tuple(use if isinstance(use, str) else use.id for use in uses)


def findings_frame(findings: Iterable[Finding]) -> pd.DataFrame:
    """Tidy table of findings."""
    return pd.DataFrame(
        [{**vars(f), "numbers": " ".join(f.numbers)} for f in findings], columns=list(Finding.__dataclass_fields__)
    )
