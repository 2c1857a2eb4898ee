"""The claims ledger as the page shows it: rows with units, counts, and what differs in plain words."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

from repro.errors import InputError
from repro.paper.claims import (
    BETTER,
    CONTRADICTS,
    DIFFERS,
    EXTENSION,
    HARDWARE,
    NOT_RUN,
    REPRODUCED,
    SETTING,
    VERDICTS,
)
from repro.render.markup import unit as unit_text
from repro.report.inputs import ReportInputs, read_rows

COLUMNS = (
    "id", "place", "quantity", "unit", "kind", "published", "ours", "difference", "tolerance", "verdict", "must",
    "target", "note",
)  # fmt: skip

#: What each verdict means, for a reader who has not seen the paper.
MEANINGS = {
    REPRODUCED: "our number is the published one, within the tolerance given beside it",
    BETTER: "our number is better than the published one",
    DIFFERS: "our number is another one, by more than the tolerance",
    CONTRADICTS: "other numbers of the paper say otherwise, whatever ours is",
    NOT_RUN: "a setting of the paper that the default run does not use",
    HARDWARE: "only a measurement on the real arm or board could tell",
}

_ID = re.compile(r"[\w./+:,()@-]+")
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
_NO_UNIT = ("", "1", "-", "not printed")
_TRUTH = {"true": True, "false": False, "1": True, "0": False}
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
    kind: str
    published: Cell
    ours: Cell
    difference: Cell
    tolerance: Cell
    verdict: str
    must: bool
    target: str
    note: str

    @property
    def setting(self) -> bool:
        """Whether it is a number that the authors chose, which we adopt."""
        return self.kind == SETTING

    @property
    def extension(self) -> bool:
        """Whether it holds an extension of ours against a published number."""
        return EXTENSION in self.id

    @property
    def holds(self) -> bool:
        """Whether the claim is reproduced, or better."""
        return self.verdict in (REPRODUCED, BETTER)


def read_claims(inputs: ReportInputs) -> list[Claim]:
    """Read the ledger."""
    path = inputs.results / "claims.csv"
    if inputs.partial and not path.exists():
        return []
    _, rows = read_rows(path, COLUMNS)
    claims: list[Claim] = []
    seen: set[str] = set()
    for number, row in enumerate(rows, start=1):
        place = f"{path}: row {number}"
        for name in ("place", "quantity", "kind"):
            if not row[name].strip():
                raise InputError.at(f"{place}: {name}", "nothing", "text")
        if not _ID.fullmatch(row["id"]) or row["id"] in seen:
            raise InputError.at(f"{place}: id", repr(row["id"]), "an id without blanks, used once")
        if row["verdict"] not in VERDICTS:
            raise InputError.at(f"{place}: verdict", repr(row["verdict"]), f"one of {', '.join(VERDICTS)}")
        if row["must"].strip().lower() not in _TRUTH:
            raise InputError.at(f"{place}: must", repr(row["must"]), "true or false")
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
        kind=row["kind"],
        published=_cell(published, None, shown),
        ours=_cell(row["ours"], decimals, shown),
        difference=_cell(row["difference"], decimals, signed=True),
        tolerance=_cell(row["tolerance"], decimals),
        verdict=row["verdict"],
        must=_TRUTH[row["must"].strip().lower()],
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
    """Claims of one place that share a verdict and a note."""

    place: str
    note: str
    claims: tuple[Claim, ...]


def differences(claims: Sequence[Claim], verdict: str) -> list[Difference]:
    """Claims with a verdict, those of one place and with one note together."""
    groups: dict[tuple[str, str], list[Claim]] = {}
    for claim in claims:
        if claim.verdict == verdict:
            groups.setdefault((claim.place, claim.note), []).append(claim)
    return [Difference(place, note, tuple(group)) for (place, note), group in groups.items()]


def counts(claims: Sequence[Claim]) -> list[tuple[str, int, str]]:
    """How many claims have each verdict that occurs, with what it means; best verdict first."""
    found = [(verdict, sum(claim.verdict == verdict for claim in claims)) for verdict in VERDICTS]
    return [(verdict, number, MEANINGS[verdict]) for verdict, number in found if number]
