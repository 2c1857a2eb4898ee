"""The claims ledger: each published number next to ours, with a tolerance stated in advance, a verdict, and its page.

A number that depends on chance is compared with a prediction interval: for n seeds with standard deviation s, another
run lies within t s sqrt(1 + 1/n) of ours in 95 % of cases (Student's t, n - 1 degrees of freedom). The interval is a
comparison only if it is narrow: wider than its cap, or so wide that the published value of another
case would pass as well, the verdict is *inconclusive*. Within the equivalence margin two numbers count as the same.
"""

import math
import operator
from collections.abc import Callable, Hashable, Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy import stats

from repro.files import read_rows
from repro.paper.published import PublishedValue

REPRODUCED, BETTER, DIFFERS = "reproduced", "better", "differs"
INCONCLUSIVE, NOT_COMPARABLE = "inconclusive", "not comparable"
CONTRADICTS, NOT_RUN, HARDWARE = "contradicts itself", "not run", "needs the hardware"
#: Verdicts, best first, and what each means.
VERDICTS = {
    REPRODUCED: "within a tolerance that was stated in advance and that the number of another case would fail",
    BETTER: "better by more than the tolerance, on the paper's own arms",
    DIFFERS: "different by more than the tolerance",
    INCONCLUSIVE: "decides nothing: our scatter or bounds are too wide, or another case would pass as well",
    NOT_COMPARABLE: "better, but on a simulated arm that may be an easier one",
    CONTRADICTS: "other numbers of the paper contradict it, by as much as ours differs",
    NOT_RUN: "a setting of the paper that the default run does not use",
    HARDWARE: "only a measurement on the real arm or board could decide",
}
#: What may be asserted of a number. Where it depends on chance, five runs may scatter too widely to call it reproduced.
NOT_REFUTED = f"{REPRODUCED} or {INCONCLUSIVE}"
ASSERTIONS = (REPRODUCED, DIFFERS, NOT_REFUTED)
#: Published kind of the numbers that the authors chose and a reproduction adopts.
SETTING = "setting"


class Basis(StrEnum):
    """What a comparison rests on, and so what a match is worth."""

    NUMERIC = (
        "numeric"  # computed on the paper's own arms N1 to N4; metric and validation motion fit Table 7 as a whole
    )
    ARM = "simulated arm"  # another arm than the paper's, which no longer exists
    CONSTRUCTION = "by construction"  # the simulated arm or its motions were chosen so that it comes out
    ARITHMETIC = "arithmetic"  # follows from other printed numbers or from a definition
    SETTING = "setting"  # adopted from the paper
    HARDWARE = "hardware"  # a property of the authors' arm, board or bench; at most next to a board of our design


#: Bases on which a match is evidence about a result of the paper.
EVIDENCE = (Basis.NUMERIC, Basis.ARM)
_OF_KIND = {SETTING: Basis.SETTING, "exact": Basis.ARITHMETIC, "deterministic": Basis.CONSTRUCTION}

#: Kind of the numbers that are left out: only the other work can tell.
LEFT_OUT = "other-work"
#: Stands between the id of a published number and the name of an extension of ours that is held against it too.
EXTENSION = "@"

#: Relations of a number that others are to be above or below of.
LIMITS = ("above", "below")
#: How much of a number rounding in binary can blur.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class OurValue:
    """Our side of one published number."""

    value: float  # in the published unit; NaN if only the hardware can tell
    target: str  # target of the workflow that makes it; empty without a value
    basis: Basis | None = None  # None: by the published kind
    std: float = 0.0  # standard deviation over the seeds, in the published unit
    seeds: int = 1
    equivalent: float = 0.0  # difference that does not matter, in the published unit
    cap: float = math.inf  # widest interval that still compares
    better: Callable[[float, float], bool] | None = None  # of the published and our number, where one can be better
    strict: bool = False  # no tolerance: a setting can be adopted as printed, a limit can be met
    unused: bool = False  # a setting that the default run does not use
    literal: bool = False  # written in the comparison itself, so that a match asserts nothing
    asserted: str = ""  # one of `ASSERTIONS`; a better number satisfies "reproduced"
    contradicts: str = ""  # why the paper contradicts itself here
    contradiction: float = math.inf  # by how much, in the published unit
    cause: str = ""  # why a number differs, where it does
    note: str = ""
    bounds: float = 0.0  # half the distance of the bounds whose middle ours is: they can refute a number, not match it


#: Whether ours is better than the published number, where more or where less is better.
higher, lower = operator.lt, operator.gt


def _scatter(ours: OurValue) -> float:
    """Half width of the 95 % prediction interval of one further run, or of the bounds."""
    if ours.seeds < 2:
        return ours.bounds
    return float(stats.t.ppf(0.975, ours.seeds - 1)) * ours.std * math.sqrt(1.0 + 1.0 / ours.seeds)


def _tolerance(printed: PublishedValue, ours: OurValue) -> tuple[float, str]:
    """Tolerance of a difference, and where it comes from."""
    if ours.strict:
        return 0.0, "none: compared as it stands"
    step = printed.half_step if printed.relation not in LIMITS else 0.0  # a limit is exact
    interval, margin = step + _scatter(ours), step + ours.equivalent
    if ours.bounds:
        return interval, "bounds of ours"
    if margin > interval:
        return margin, "equivalence margin"
    return interval, "95 % prediction interval" if interval > step else "print precision"


#: Why a number is inconclusive: the note of its row.
_BOUNDS_ONLY, _SCATTER_TOO_WIDE = "of ours only bounds are known", "our runs scatter too widely"
_BETTER_BUT_WIDE, _OTHERS_MATCH = "outside but better, and our runs scatter too widely", "another case would match too"


def _verdict(
    printed: PublishedValue, ours: OurValue, basis: Basis, tolerance: float, others: Iterable[float]
) -> tuple[str, str]:
    """Verdict, and why it is inconclusive."""
    difference = ours.value - printed.value
    if ours.unused:
        return NOT_RUN, ""
    if ours.contradicts and abs(difference) <= ours.contradiction * (1.0 + _ROUNDING):
        return CONTRADICTS, ""
    slack = tolerance + _ROUNDING * abs(printed.value)
    wide = ours.bounds > 0.0 or (not ours.strict and _scatter(ours) > ours.cap)
    stated = {"above": difference > 0, "below": difference < 0}.get(printed.relation, False)
    compatible = abs(difference) <= slack or stated
    if not compatible and (ours.better is None or not ours.better(printed.value, ours.value)):
        return DIFFERS, ""
    if wide:
        return INCONCLUSIVE, _BOUNDS_ONLY if ours.bounds else _SCATTER_TOO_WIDE if compatible else _BETTER_BUT_WIDE
    if not compatible:  # on another arm an easier one explains it as well as a better method
        return BETTER if basis is Basis.NUMERIC else NOT_COMPARABLE, ""
    blind = any(min(abs(other - printed.value), abs(other - ours.value)) <= slack for other in others)
    return (INCONCLUSIVE, _OTHERS_MATCH) if blind and basis in EVIDENCE else (REPRODUCED, "")


def judge(printed: PublishedValue, ours: OurValue, others: Iterable[float] = ()) -> dict[str, object]:
    """One row of the ledger; `others` are the published values of the same quantity for other cases."""
    basis = ours.basis or _OF_KIND.get(printed.kind, Basis.HARDWARE)
    (tolerance, tolerance_from), verdict, why = (math.nan, ""), CONTRADICTS if ours.contradicts else HARDWARE, ""
    if not math.isnan(ours.value):
        tolerance, tolerance_from = _tolerance(printed, ours)
        verdict, why = _verdict(printed, ours, basis, tolerance, others)
    return {
        "id": printed.id, "place": printed.place, "quantity": printed.quantity, "unit": printed.unit,
        "kind": printed.kind, "basis": str(basis), "published": printed.printed,
        "ours": ours.value, "difference": ours.value - printed.value,
        "tolerance": tolerance, "tolerance_from": tolerance_from, "verdict": verdict,
        "must": ours.asserted in (REPRODUCED, NOT_REFUTED), "asserted": ours.asserted,
        "cause": ours.cause if verdict == DIFFERS else "", "target": ours.target,
        "note": "; ".join(part for part in (why, ours.contradicts, ours.note) if part),
    }  # fmt: skip


def other_cases(numbers: Iterable[PublishedValue]) -> dict[str, tuple[float, ...]]:
    """Published values of the same quantity for other cases, by the id of the number; for a limit, of both joints."""
    compared = [n for n in numbers if n.case and n.kind != LEFT_OUT and n.relation in ("is", *LIMITS)]
    groups: dict[tuple[object, ...], list[PublishedValue]] = {}
    for number in compared:
        if number.relation == "is":
            groups.setdefault(_quantity(number), []).append(number)
    others = {}
    for number in compared:
        group = [n for n in groups.get(_quantity(number), ()) if number.relation in LIMITS or n.joint == number.joint]
        if any(other.case == number.case for other in group):
            others[number.id] = tuple(other.value for other in group if other.case != number.case)
    return others


def _quantity(number: PublishedValue) -> tuple[object, ...]:
    """What numbers of several cases and joints have in common."""
    return number.kind, number.quantity, number.method, number.parameter


def judge_all(numbers: Iterable[PublishedValue], ours: Mapping[str, OurValue]) -> pd.DataFrame:
    """Judge each of our values against the published number that its id begins with."""
    by_id = {number.id: number for number in numbers}
    others = other_cases(by_id.values())
    rows = []
    for name, side in ours.items():
        number = by_id[name.partition(EXTENSION)[0]]
        rows.append({**judge(number, side, others.get(number.id, ())), "id": name})
    return pd.DataFrame(rows)


def broken(claims: pd.DataFrame) -> pd.DataFrame:
    """Claims whose verdict is not the asserted one; better than reproduced satisfies too."""
    asserted = claims["asserted"].str.split(" or ")
    verdict = claims["verdict"].replace(BETTER, REPRODUCED)
    satisfied = [one in accepted for one, accepted in zip(verdict, asserted, strict=True)]
    return claims[(claims["asserted"] != "") & ~np.array(satisfied, bool)]


def specificity(claims: pd.DataFrame, numbers: Iterable[PublishedValue]) -> pd.DataFrame:
    """How often the value of another case fails (``refused / pairs``) where ours was called reproduced, by basis."""
    others = other_cases(numbers)
    called = claims[(claims["verdict"] == REPRODUCED) & claims["basis"].isin(EVIDENCE)]
    rows = []
    for row in called.to_dict("records"):
        if values := others.get(str(row["id"]).partition(EXTENSION)[0], ()):
            what = "similarities" if row["unit"] == "%" else "parameters"
            refused = sum(abs(value - row["ours"]) > row["tolerance"] for value in values)
            rows.append((str(row["basis"]), what, 1, len(values), refused))
    table = pd.DataFrame(rows, columns=["basis", "what", "rows", "pairs", "refused"])
    return table.groupby(["basis", "what"], as_index=False).sum()


_COLUMNS = ["id", "quantity", "published", "ours", "tolerance", "verdict", "asserted", "target", "note"]


def causes() -> dict[str, dict[str, str]]:
    """Causes of differences by their names: title, why, and as evidence a page of docs/ with its anchor."""
    return {row["name"]: row for row in read_rows(Path(__file__).with_name("causes.csv"))}


def _number(value: object) -> str:
    return "" if pd.isna(value) else f"{value:.6g}"  # type: ignore[call-overload]


def _published(row: Mapping[Hashable, Any]) -> str:
    return f"{row['published']} {row['unit']}".removesuffix(" 1").removesuffix(" not printed")


def _table(frame: pd.DataFrame) -> str:
    lines = [f"| {' | '.join(frame.columns)} |", f"|{'---|' * frame.shape[1]}"]
    cells = ([str(cell).replace("|", r"\|") for cell in row] for row in frame.itertuples(index=False))
    return "\n".join([*lines, *(f"| {' | '.join(row)} |" for row in cells)])


def _table_of_claims(claims: pd.DataFrame) -> str:
    numbers = {name: claims[name].map(_number) for name in ("ours", "tolerance")}
    shown = claims.assign(published=[_published(row) for row in claims.to_dict("records")], **numbers)
    return _table(shown[_COLUMNS].rename(columns={"target": "made by"}))


def by_basis(claims: pd.DataFrame) -> pd.DataFrame:
    """Count the verdicts (rows) by what the comparison rests on (columns); extensions of ours are counted apart."""
    extension = claims["id"].str.contains(EXTENSION, regex=False)
    groups = {str(basis): ~extension & (claims["basis"] == basis) for basis in Basis} | {"extensions": extension}
    counts = {name: claims.loc[chosen, "verdict"].value_counts() for name, chosen in groups.items()}
    return pd.DataFrame(counts).reindex(list(VERDICTS)).fillna(0).astype(int)


def _asserted(claims: pd.DataFrame) -> tuple[int, int]:
    """How many claims are asserted, and how many of them have the asserted verdict."""
    asserted = int((claims["asserted"] != "").sum())
    return asserted, asserted - len(broken(claims))


def summary(claims: pd.DataFrame) -> list[str]:
    """How many claims have each verdict, by what the comparison rests on, and every asserted claim that fails."""
    counted, lines = by_basis(claims), []
    width = max(map(len, counted.columns))
    for name, column in counted.items():
        listed = ", ".join(f"{number} {verdict}" for verdict, number in column.items() if number)
        lines.append(f"{name!s:<{width}}  {column.sum():4d}  {listed}")
    asserted, satisfied = _asserted(claims)
    lines.append(f"{satisfied} of {asserted} asserted claims are as asserted")
    for row in broken(claims).to_dict("records"):
        numbers = f"published {_published(row)}, ours {_number(row['ours'])}"
        lines.append(f"not as asserted: {row['id']}: {row['verdict']} instead of {row['asserted']}, {numbers}")
    return lines


def markdown(claims: pd.DataFrame, specific: pd.DataFrame) -> str:
    """The ledger as a page."""
    asserted, satisfied = _asserted(claims)
    of_results = (claims["asserted"] != "") & claims["basis"].isin(EVIDENCE)
    failing = claims.index.isin(broken(claims).index)
    blocks = [
        "# Claims",
        "Every number that the paper prints as its own, next to ours.",
        "A match is evidence only in the columns *numeric* (the paper's own arms N1 to N4) and *simulated arm* "
        "(another arm than the paper's). The other columns are adopted, follow from other numbers, or are about the "
        f"board, whose design is ours.\nAn id with `{EXTENSION}` compares an extension of ours with the same number.",
        _table(by_basis(claims).reset_index(names="verdict")),
        "## Specificity",
        "Of the numbers that are called reproduced: how often the published value of another case lies outside the "
        "tolerance.",
        _table(specific.set_axis(["basis", "of", "numbers", "pairs", "outside"], axis=1)),
        "## Asserted claims",
        f"{satisfied} of {asserted} have the asserted verdict. Those about results, and those that fail:",
        _table_of_claims(claims[of_results | failing]),
        "## What differs, by cause",
    ]
    differing = claims[claims["verdict"] == DIFFERS]
    for name, cause in causes().items():
        if len(own := differing[differing["cause"] == name]):
            why = f"{cause['why']} Evidence: docs/{cause['evidence']}."
            blocks += [f"### {cause['title']}", why, _table_of_claims(own)]
    blocks.append("## Every number")
    for place in dict.fromkeys(claims["place"]):
        blocks += [f"### {place}", _table_of_claims(claims[claims["place"] == place])]
    return "\n\n".join(blocks) + "\n"
