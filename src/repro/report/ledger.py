"""The claims ledger as the page shows it: rows with units, counts, and what differs in plain words."""

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from repro.errors import InputError
from repro.exhibits.markup import unit as unit_text
from repro.files import read_rows
from repro.paper.claims import (
    BETTER,
    CAUSES,
    CONTRADICTS,
    DIFFERS,
    EXTENSION,
    EXTENSIONS,
    HARDWARE,
    INCONCLUSIVE,
    NOT_COMPARABLE,
    NOT_RUN,
    REPRODUCED,
    VERDICTS,
    Basis,
    Cause,
)

COLUMNS = (
    "id", "place", "quantity", "unit", "basis", "published", "ours", "difference", "tolerance", "verdict", "asserted",
    "cause", "target", "note",
)  # fmt: skip

#: What each verdict means, for a reader who has not seen the paper.
MEANINGS = {
    REPRODUCED: "within a tolerance that was stated in advance and that the number of another case would fail",
    BETTER: "better by more than the tolerance, on the paper's own arms",
    DIFFERS: "different by more than the tolerance",
    INCONCLUSIVE: "compatible, but the scatter over the seeds is too wide, or another case would pass as well",
    NOT_COMPARABLE: "better, but on a simulated arm that may be an easier one",
    CONTRADICTS: "other numbers of the paper contradict it, by as much as ours differs",
    NOT_RUN: "a setting of the paper that the default run does not use",
    HARDWARE: "only a measurement on the real arm or board could tell",
}

_ID = re.compile(r"[\w./+:,()@-]+")
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
_NO_UNIT = ("", "1", "-", "not printed")
_SUPERSCRIPTS = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
_MINUS = "\N{MINUS SIGN}"


@dataclass(frozen=True)
class Cell:
    """A cell of the ledger: what it shows, and what it is sorted by (empty if by what it shows)."""

    text: str
    value: str = ""


@dataclass(frozen=True)
class Claim:
    """One row of the ledger; fields as in ``claims.csv``.

    Numbers are cells with their unit; a difference and a tolerance have the unit of what is published.
    """

    id: str
    place: str
    quantity: str
    basis: str
    published: Cell
    ours: Cell
    difference: Cell
    tolerance: Cell
    verdict: str
    asserted: str
    cause: str
    target: str
    note: str

    @property
    def extension(self) -> bool:
        """Whether it holds an extension of ours against a published number."""
        return EXTENSION in self.id

    @property
    def satisfied(self) -> bool:
        """Whether the verdict is the asserted one, or better than it."""
        return self.verdict == self.asserted or (self.asserted, self.verdict) == (REPRODUCED, BETTER)


def read_claims(path: Path) -> list[Claim]:
    """Read the ledger."""
    claims: list[Claim] = []
    seen: set[str] = set()
    for number, row in enumerate(read_rows(path, COLUMNS), start=1):
        place = f"{path}: row {number}"
        for name in ("place", "quantity"):
            if not row[name].strip():
                raise InputError.at(f"{place}: {name}", "nothing", "text")
        if not _ID.fullmatch(row["id"]) or row["id"] in seen:
            raise InputError.at(f"{place}: id", repr(row["id"]), "an id without blanks, used once")
        if row["verdict"] not in VERDICTS:
            raise InputError.at(f"{place}: verdict", repr(row["verdict"]), f"one of {', '.join(VERDICTS)}")
        words = {"basis": [str(basis) for basis in Basis], "asserted": ["", *VERDICTS], "cause": ["", *CAUSES]}
        for name, allowed in words.items():
            if row[name] not in allowed:
                raise InputError.at(f"{place}: {name}", repr(row[name]), f"one of {', '.join(map(repr, allowed))}")
        seen.add(row["id"])
        claims.append(_claim(row))
    return claims


def _claim(row: dict[str, str]) -> Claim:
    unit = row["unit"].strip()
    shown = "" if unit in _NO_UNIT else f"\N{NO-BREAK SPACE}{unit_text(unit).md}"
    published = row["published"].strip()
    decimals = _decimals(published)
    return Claim(
        id=row["id"],
        place=row["place"],
        quantity=row["quantity"],
        basis=row["basis"],
        published=_cell(published, None, shown),
        ours=_cell(row["ours"], decimals, shown),
        difference=_cell(row["difference"], decimals, signed=True),
        tolerance=_cell(row["tolerance"], decimals),
        verdict=row["verdict"],
        asserted=row["asserted"],
        cause=row["cause"],
        target=row["target"].strip(),
        note=row["note"].strip(),
    )


def _decimals(published: str) -> int | None:
    """Decimals to show ours with: one more than published; None if the number is not a plain decimal."""
    whole, _, part = published.partition(".")
    return len(part) + 1 if _NUMBER.fullmatch(published) and (whole + part).lstrip("+-").isdigit() else None


def _cell(text: str, decimals: int | None, unit: str = "", signed: bool = False) -> Cell:
    """A number as it is written, or with `decimals` where it has more; text as it is."""
    text = text.strip()
    if not _NUMBER.fullmatch(text):
        return Cell("" if text.lower() in ("nan", "") else text)
    value, shown = float(text), text
    written = len(text.partition(".")[2])
    if decimals is not None and written > decimals and "e" not in text.lower():
        shown = f"{value:.{decimals}f}"
    if float(shown) == 0.0 != value or len(shown) > 10:
        shown = f"{value:.3g}"
    if signed and value > 0:
        shown = f"+{shown.lstrip('+')}"
    digits, e, power = shown.lower().partition("e")
    if e:
        shown = f"{digits}×10{str(int(power)).translate(_SUPERSCRIPTS)}"  # noqa: RUF001
    return Cell(shown.replace("-", _MINUS) + unit, repr(value))


@dataclass(frozen=True)
class Difference:
    """Claims that differ for one cause."""

    cause: Cause
    claims: tuple[Claim, ...]


def differences(claims: Sequence[Claim]) -> list[Difference]:
    """Group the claims that differ by their cause."""
    differing = [claim for claim in claims if claim.verdict == DIFFERS]
    groups = {name: tuple(claim for claim in differing if claim.cause == name) for name in CAUSES}
    return [Difference(CAUSES[name], group) for name, group in groups.items() if group]


@dataclass(frozen=True)
class Tally:
    """How many of the paper's own numbers on one basis agree with ours."""

    agree: int  # reproduced or better
    differ: int
    open: int  # inconclusive, not comparable, or contradicted by other numbers of the paper


def tally(claims: Sequence[Claim], basis: Basis) -> Tally:
    """Count the numbers on a basis that is evidence, without extensions of ours."""
    verdicts = [claim.verdict for claim in claims if claim.basis == basis and not claim.extension]
    agree, differ = (sum(verdict in some for verdict in verdicts) for some in ((REPRODUCED, BETTER), (DIFFERS,)))
    return Tally(agree, differ, len(verdicts) - agree - differ)


@dataclass(frozen=True)
class Counts:
    """How many claims have each verdict, by what their comparison rests on."""

    groups: tuple[str, ...]
    rows: tuple[tuple[str, str, tuple[int, ...]], ...]  # verdict, meaning, number in each group; verdicts that occur


def count(claims: Sequence[Claim]) -> Counts:
    """Count the verdicts by basis; extensions of ours are a group of their own."""
    groups = (*(str(basis) for basis in Basis), EXTENSIONS)
    counted = Counter((claim.verdict, EXTENSIONS if claim.extension else claim.basis) for claim in claims)
    rows = [(verdict, MEANINGS[verdict], tuple(counted[verdict, group] for group in groups)) for verdict in VERDICTS]
    return Counts(groups, tuple(row for row in rows if any(row[2])))
