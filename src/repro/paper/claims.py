"""The claims ledger: each published number beside ours, with a tolerance, where it comes from, and a verdict."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import pandas as pd

from repro.paper.published_value import PublishedValue

#: Verdicts, best first.
REPRODUCED, BETTER, DIFFERS = "reproduced", "better", "differs"
CONTRADICTS, NOT_RUN, HARDWARE = "contradicts itself", "not run", "needs the hardware"
VERDICTS = (REPRODUCED, BETTER, DIFFERS, CONTRADICTS, NOT_RUN, HARDWARE)
#: Kind of the numbers that the authors chose and a reproduction adopts: they cannot come out otherwise.
SETTING = "setting"

COLUMNS = (
    "id", "place", "quantity", "unit", "kind", "published", "ours", "difference", "tolerance", "tolerance_from",
    "verdict", "must", "target", "note",
)  # fmt: skip

#: Where a tolerance comes from.
PRINT = "print precision"
SEEDS = "print precision and twice the spread over seeds"
CAPPED = "print precision and the widest spread over seeds that is allowed"
NONE = "none: compared as it stands"

#: Kind of the numbers that are left out: only the other work can tell.
LEFT_OUT = "other-work"
#: Stands between the id of a published number and the name of an extension of ours that is held against it too.
EXTENSION = "@"

#: How much of a number rounding in binary can blur.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Ours:
    """What our results say about one published number.

    Attributes
    ----------
    value : float or None
        Our number in the published unit; None if only the hardware can tell.
    target : str
        Target of the workflow, file or module that makes it.
    spread : float
        Standard deviation over seeds, in the published unit; 0 if there is none.
    better : callable or None
        Tells from the published and our number whether ours is better, where one can be.
    widest : float
        Largest part of the tolerance that the spread may give: what scatters by more reproduces nothing.
    strict : bool
        Compare without a tolerance: a choice can be adopted as printed, a limit can be kept.
    unused : bool
        A setting that the default run does not use: a key of the configuration reproduces nothing.
    must : bool
        The project promises that it holds.
    contradicts : str
        Why the paper contradicts itself here; empty if it does not.
    note : str
        What a reader should know.
    """

    value: float | None
    target: str
    spread: float = 0.0
    better: Callable[[float, float], bool] | None = None
    widest: float = math.inf
    strict: bool = False
    unused: bool = False
    must: bool = False
    contradicts: str = ""
    note: str = ""


def higher(published: float, ours: float) -> bool:
    """Whether ours is better where more is better."""
    return ours > published


def lower(published: float, ours: float) -> bool:
    """Whether ours is better where less is better."""
    return ours < published


def _tolerance(printed: PublishedValue, ours: Ours) -> tuple[float, str]:
    if ours.strict:
        return 0.0, NONE
    if 2.0 * ours.spread > ours.widest:
        return printed.half_step + ours.widest, CAPPED
    return printed.half_step + 2.0 * ours.spread, SEEDS if ours.spread > 0 else PRINT


def _verdict(printed: PublishedValue, ours: Ours, value: float, tolerance: float) -> str:
    difference = value - printed.value
    if ours.contradicts:
        return CONTRADICTS
    if ours.unused:
        return NOT_RUN
    if abs(difference) <= tolerance + _ROUNDING * abs(printed.value):
        return REPRODUCED
    if ours.better is not None and ours.better(printed.value, value):
        return BETTER
    if {"above": difference > 0, "below": difference < 0}.get(printed.relation, False):
        return REPRODUCED
    return DIFFERS


def judge(printed: PublishedValue, ours: Ours) -> dict[str, object]:
    """One row of the ledger."""
    row: dict[str, object] = {
        "id": printed.id, "place": printed.place, "quantity": printed.quantity, "unit": printed.unit,
        "kind": printed.kind, "published": printed.printed, "must": ours.must, "target": ours.target,
        "note": "; ".join(part for part in (ours.contradicts, ours.note) if part),
    }  # fmt: skip
    if ours.value is None:
        verdict = CONTRADICTS if ours.contradicts else HARDWARE
        blank = {"ours": math.nan, "difference": math.nan, "tolerance": math.nan, "tolerance_from": ""}
        return {**row, **blank, "verdict": verdict}
    tolerance, tolerance_from = _tolerance(printed, ours)
    return {
        **row,
        "ours": ours.value,
        "difference": ours.value - printed.value,
        "tolerance": tolerance,
        "tolerance_from": tolerance_from,
        "verdict": _verdict(printed, ours, ours.value, tolerance),
    }


def ledger(numbers: Iterable[PublishedValue], ours: Mapping[str, Ours]) -> pd.DataFrame:
    """The whole ledger."""
    own = [number for number in numbers if number.kind != LEFT_OUT]
    sides: dict[str, list[tuple[str, Ours]]] = {number.id: [] for number in own}
    for name, side in ours.items():
        base = name.partition(EXTENSION)[0]
        if base not in sides:
            raise ValueError(f"ledger: {name} has no published number.")
        sides[base].append((name, side))
    for base, held in sides.items():
        if base not in {name for name, _ in held}:
            raise ValueError(f"ledger: {base} has no counterpart of ours.")
    rows = [{**judge(number, side), "id": name} for number in own for name, side in sides[number.id]]
    return pd.DataFrame(rows, columns=list(COLUMNS))


def broken(claims: pd.DataFrame) -> pd.DataFrame:
    """Claims that the project promises and that do not hold."""
    return claims[claims["must"] & ~claims["verdict"].isin([REPRODUCED, BETTER])]
