"""The claims ledger: each published number next to ours, with a tolerance stated in advance, and a verdict.

A number that depends on chance is compared with a prediction interval: for n seeds with standard deviation s, another
run lies within t s sqrt(1 + 1/n) of ours in 95 % of cases (Student's t, n - 1 degrees of freedom). The interval is a
comparison only if it is narrow: wider than the cap of its `Margin`, or so wide that the published value of another
case would pass as well, the verdict is *inconclusive*. Within the equivalence margin two numbers count as the same.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum

import pandas as pd
from scipy import stats

from repro.paper.published import PublishedValue

#: Verdicts, best first.
REPRODUCED, BETTER, DIFFERS = "reproduced", "better", "differs"
INCONCLUSIVE, NOT_COMPARABLE = "inconclusive", "not comparable"
CONTRADICTS, NOT_RUN, HARDWARE = "contradicts itself", "not run", "needs the hardware"
VERDICTS = (REPRODUCED, BETTER, DIFFERS, INCONCLUSIVE, NOT_COMPARABLE, CONTRADICTS, NOT_RUN, HARDWARE)
#: Published kind of the numbers that the authors chose and a reproduction adopts.
SETTING = "setting"


class Basis(StrEnum):
    """What a comparison rests on, and so what a match is worth."""

    NUMERIC = "numeric"  # computed independently on the paper's own arms N1 to N4
    ARM = "simulated arm"  # another arm than the paper's, which no longer exists
    CONSTRUCTION = "by construction"  # the simulated arm or its motions were chosen so that it comes out
    ARITHMETIC = "arithmetic"  # follows from other printed numbers or from a definition
    SETTING = "setting"  # adopted from the paper
    HARDWARE = "hardware"  # a property of the authors' arm, board or bench


#: Bases on which a match is evidence about a result of the paper.
EVIDENCE = (Basis.NUMERIC, Basis.ARM)
_OF_KIND = {SETTING: Basis.SETTING, "exact": Basis.ARITHMETIC, "deterministic": Basis.CONSTRUCTION}

COLUMNS = (
    "id", "place", "quantity", "unit", "kind", "basis", "published", "ours", "difference", "tolerance",
    "tolerance_from", "verdict", "must", "asserted", "cause", "target", "note",
)  # fmt: skip

#: Where a tolerance comes from.
PRINT = "print precision"
EQUIVALENCE = "equivalence margin"
PREDICTION = "95 % prediction interval"
NONE = "none: compared as it stands"
LEVEL = 0.95

#: Kind of the numbers that are left out: only the other work can tell.
LEFT_OUT = "other-work"
#: Stands between the id of a published number and the name of an extension of ours that is held against it too.
EXTENSION = "@"

#: How much of a number rounding in binary can blur.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Margin:
    """Differences that do not matter, and the widest interval that still compares: absolute, or shares of the value."""

    equivalent: float
    cap: float
    relative: bool = False

    def of(self, published: float) -> tuple[float, float]:
        """Both in the published unit."""
        scale = abs(published) if self.relative else 1.0
        return self.equivalent * scale, self.cap * scale


EXACT = Margin(0.0, math.inf)


@dataclass(frozen=True)
class OurValue:
    """Our side of one published number."""

    value: float | None  # in the published unit; None if only the hardware can tell
    target: str  # target of the workflow that makes it; empty without a value
    basis: Basis | None = None  # None: by the published kind, hardware without a value
    std: float = 0.0  # standard deviation over the seeds, in the published unit
    seeds: int = 1
    margin: Margin = EXACT
    better: Callable[[float, float], bool] | None = None  # of the published and our number, where one can be better
    strict: bool = False  # no tolerance: a setting can be adopted as printed, a limit can be met
    unused: bool = False  # a setting that the default run does not use
    asserted: str = ""  # verdict that the project asserts; a better number satisfies "reproduced"
    contradicts: str = ""  # why the paper contradicts itself here
    contradiction: float = math.inf  # by how much, in the published unit
    cause: str = ""  # why a number differs, where it does
    note: str = ""


def higher(published: float, ours: float) -> bool:
    """Whether ours is better where more is better."""
    return ours > published


def lower(published: float, ours: float) -> bool:
    """Whether ours is better where less is better."""
    return ours < published


def _interval(printed: PublishedValue, ours: OurValue) -> float:
    """Half width of the prediction interval of one further run, with the rounding of the print."""
    if ours.seeds < 2:
        return printed.half_step
    t = float(stats.t.ppf(0.5 + 0.5 * LEVEL, ours.seeds - 1))
    return printed.half_step + t * ours.std * math.sqrt(1.0 + 1.0 / ours.seeds)


def _tolerance(printed: PublishedValue, ours: OurValue) -> tuple[float, str]:
    if ours.strict:
        return 0.0, NONE
    interval = _interval(printed, ours)
    margin = printed.half_step + ours.margin.of(printed.value)[0]
    if margin > interval:
        return margin, EQUIVALENCE
    return interval, PREDICTION if interval > printed.half_step else PRINT


def _compared(printed: PublishedValue, ours: OurValue, value: float, tolerance: float, others: Iterable[float]) -> str:
    """Verdict on two numbers that can be compared."""
    slack = tolerance + _ROUNDING * abs(printed.value)
    wide = not ours.strict and _interval(printed, ours) - printed.half_step > ours.margin.of(printed.value)[1]
    difference = value - printed.value
    stated = {"above": difference > 0, "below": difference < 0}.get(printed.relation, False)
    if abs(difference) <= slack or stated:
        blind = any(min(abs(other - printed.value), abs(other - value)) <= slack for other in others)
        return INCONCLUSIVE if wide or blind else REPRODUCED
    if ours.better is not None and ours.better(printed.value, value):
        return INCONCLUSIVE if wide else BETTER
    return DIFFERS


def _verdict(
    printed: PublishedValue, ours: OurValue, basis: Basis, value: float, tolerance: float, others: Iterable[float]
) -> str:
    if ours.unused:
        return NOT_RUN
    difference = abs(value - printed.value)
    if ours.contradicts and difference <= ours.contradiction * (1.0 + _ROUNDING):
        return CONTRADICTS
    verdict = _compared(printed, ours, value, tolerance, others if basis in EVIDENCE else ())
    if verdict == BETTER and basis is not Basis.NUMERIC:
        return NOT_COMPARABLE  # an easier arm explains it as well as a better method
    return verdict


def basis_of(printed: PublishedValue, ours: OurValue) -> Basis:
    """What a comparison rests on."""
    return ours.basis or _OF_KIND.get(printed.kind, Basis.HARDWARE)


def judge(printed: PublishedValue, ours: OurValue, others: Iterable[float] = ()) -> dict[str, object]:
    """One row of the ledger; `others` are the published values of the same quantity for other cases."""
    basis = basis_of(printed, ours)
    row: dict[str, object] = {
        "id": printed.id, "place": printed.place, "quantity": printed.quantity, "unit": printed.unit,
        "kind": printed.kind, "basis": str(basis), "published": printed.printed,
        "must": ours.asserted == REPRODUCED, "asserted": ours.asserted,
        "cause": "", "target": ours.target, "note": "; ".join(part for part in (ours.contradicts, ours.note) if part),
    }  # fmt: skip
    if ours.value is None:
        verdict = CONTRADICTS if ours.contradicts else HARDWARE
        blank = {"ours": math.nan, "difference": math.nan, "tolerance": math.nan, "tolerance_from": ""}
        return {**row, **blank, "verdict": verdict}
    tolerance, tolerance_from = _tolerance(printed, ours)
    verdict = _verdict(printed, ours, basis, ours.value, tolerance, others)
    return {
        **row,
        "ours": ours.value,
        "difference": ours.value - printed.value,
        "tolerance": tolerance,
        "tolerance_from": tolerance_from,
        "verdict": verdict,
        "cause": ours.cause if verdict == DIFFERS else "",
    }


def _same_quantity(number: PublishedValue) -> tuple[object, ...]:
    return number.kind, number.quantity, number.method, number.joint, number.parameter


def other_cases(numbers: Iterable[PublishedValue]) -> dict[str, tuple[float, ...]]:
    """Published values of the same quantity for other cases, by the id of the number."""
    groups: dict[tuple[object, ...], list[PublishedValue]] = {}
    for number in numbers:
        if number.case and number.relation == "is":
            groups.setdefault(_same_quantity(number), []).append(number)
    return {
        number.id: tuple(other.value for other in group if other.case != number.case)
        for group in groups.values()
        for number in group
    }


def judge_all(numbers: Iterable[PublishedValue], ours: Mapping[str, OurValue]) -> pd.DataFrame:
    """Judge every number of the paper's own; one row for each of our values."""
    own = [number for number in numbers if number.kind != LEFT_OUT]
    sides: dict[str, list[tuple[str, OurValue]]] = {number.id: [] for number in own}
    for name, side in ours.items():
        base = name.partition(EXTENSION)[0]
        if base not in sides:
            raise ValueError(f"ledger: {name} has no published number.")
        sides[base].append((name, side))
    for base, compared in sides.items():
        if base not in {name for name, _ in compared}:
            raise ValueError(f"ledger: {base} has no counterpart of ours.")
    others = other_cases(own)
    rows = [
        {**judge(number, side, others.get(number.id, ())), "id": name}
        for number in own
        for name, side in sides[number.id]
    ]
    return pd.DataFrame(rows, columns=list(COLUMNS))


def broken(claims: pd.DataFrame) -> pd.DataFrame:
    """Claims whose verdict is not the asserted one; better than reproduced satisfies too."""
    satisfied = (claims["asserted"] == claims["verdict"]) | (
        (claims["asserted"] == REPRODUCED) & (claims["verdict"] == BETTER)
    )
    return claims[(claims["asserted"] != "") & ~satisfied]


def specificity(claims: pd.DataFrame, numbers: Iterable[PublishedValue]) -> pd.DataFrame:
    """How often the published value of another case fails where ours was called reproduced, by basis and unit group.

    Columns ``basis, what, rows, pairs, refused``: the share ``refused / pairs`` is the specificity of the verdict.
    """
    others = other_cases(number for number in numbers if number.kind != LEFT_OUT)
    called = claims[(claims["verdict"] == REPRODUCED) & claims["basis"].isin([str(basis) for basis in EVIDENCE])]
    counted: dict[tuple[str, str], list[int]] = {}
    for row in called.to_dict("records"):
        values = others.get(str(row["id"]).partition(EXTENSION)[0], ())
        if values:
            what = "similarities" if row["unit"] == "%" else "parameters"
            count = counted.setdefault((str(row["basis"]), what), [0, 0, 0])
            refused = sum(abs(value - row["ours"]) > row["tolerance"] for value in values)
            for k, number in enumerate((1, len(values), refused)):
                count[k] += number
    rows = [(*key, *count) for key, count in sorted(counted.items())]
    return pd.DataFrame(rows, columns=["basis", "what", "rows", "pairs", "refused"])
