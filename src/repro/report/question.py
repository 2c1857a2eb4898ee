"""The paper's central comparison, answered from the table ``verdict``: does Algorithm 1 beat least squares?"""

from collections.abc import Sequence
from dataclasses import dataclass

import pandas as pd

from repro.errors import InputError
from repro.files import read_csv
from repro.identify.registry import METHODS
from repro.render.contract import check_table
from repro.report.inputs import ReportInputs

MOTIONS = ("T1", "T2", "T3", "T4")

_PUBLISHED = "algorithm1"


@dataclass(frozen=True)
class Tally:
    """Comparisons of one method with least squares, by motion and joint, after an identification of `duration` s.

    A method is better where the whole confidence interval of the difference of the totals lies above 0, worse
    where it lies below; the rest is open.
    """

    method: str
    duration: str
    better: int
    worse: int
    open: int


@dataclass(frozen=True)
class Answer:
    """The answer in one sentence, and what it counts."""

    words: str
    tallies: tuple[Tally, ...]


def answer(inputs: ReportInputs) -> Answer | None:
    """Count the comparisons on T1 to T4.

    Parameters
    ----------
    inputs : ReportInputs
        Its ``results`` folder holds ``tables/verdict.csv``.

    Returns
    -------
    Answer or None
        None if the file is missing and the report may be partial.

    Raises
    ------
    InputError
        If the file is missing in a whole report or not the table it must be.
    """
    path = inputs.results / "tables" / "verdict.csv"
    if inputs.partial and not path.exists():
        return None
    frame = read_csv(path)
    named = frame if "method" in frame.columns else frame.assign(method=_PUBLISHED)
    try:
        table = check_table(named, ("motion", "method"), ("duration", "difference_low", "difference_high"))
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    table = table[table["motion"].isin(MOTIONS)]
    if _PUBLISHED not in set(table["method"]):
        raise InputError.at(f"{path}: method", f"no {_PUBLISHED!r} on T1 to T4", f"rows of {_PUBLISHED}")
    known = [name for name in METHODS if name in set(table["method"])]
    others = [name for name in dict.fromkeys(table["method"]) if name not in METHODS]
    tallies = {
        method: [
            _tally(METHODS[method].title if method in METHODS else method, duration, table[(table["method"] == method)])
            for duration in sorted(set(table.loc[table["method"] == method, "duration"]))
        ]
        for method in (*known, *others)
    }
    words = _sentence(tallies[_PUBLISHED])
    return Answer(words, tuple(tally for group in tallies.values() for tally in group))


def _tally(method: str, duration: float, table: pd.DataFrame) -> Tally:
    rows = table[table["duration"] == duration]
    better, worse = int((rows["difference_low"] > 0).sum()), int((rows["difference_high"] < 0).sum())
    return Tally(method, f"{duration:.4g}", better, worse, len(rows) - better - worse)


def _sentence(tallies: Sequence[Tally]) -> str:
    better, worse = sum(t.better for t in tallies), sum(t.worse for t in tallies)
    total = better + worse + sum(t.open for t in tallies)
    yes = {total: "Yes", 0: "No"}.get(better, "Not throughout")
    if better == worse == 0:
        yes = "Undecided"
    return (
        f"{yes}: as published, Algorithm 1 rebuilds the torque better than least squares in {better} of {total} "
        f"comparisons and worse in {worse}; {total - better - worse} are open. A comparison is one joint on one motion "
        "after one identification, over many simulated arms."
    )
