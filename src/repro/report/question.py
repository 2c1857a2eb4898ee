"""The paper's central comparison, answered from the table ``verdict``: does Algorithm 1 beat least squares?"""

from collections.abc import Sequence
from dataclasses import dataclass

import pandas as pd

from repro.errors import InputError
from repro.files import read_csv
from repro.identification.registry import METHODS
from repro.report.inputs import ReportInputs
from repro.signals.programs import SPAN, VALIDATION

#: The paper's method as listed, and the opponent that the paper chose.
_PUBLISHED, _OPPONENT = "algorithm1", "least-squares"

#: What the sentence says of each method that it names; of others the table tells.
_CLAUSES = {
    "algorithm1+tracked": "trained on closed-loop motions with line 18 on the desired motion, in",
    "algorithm1+refinement": "with our refinement, in",
    "algorithm1+local-search": "and by that refinement's selection without the network, in",
}


@dataclass(frozen=True)
class Tally:
    """Comparisons of one method with one opponent, by motion and joint, after an identification of `duration` s.

    A method is better where the whole confidence interval of the difference of the totals lies above 0, worse
    where it lies below; the rest is open.
    """

    method: str
    opponent: str
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
    """Count the comparisons on T1 to T4; None if the table is missing and the report may be partial."""
    path = inputs.results / "tables" / "verdict.csv"
    if inputs.partial and not path.exists():
        return None
    columns = ("motion", "method", "opponent", "duration", "arms", "runs", "difference_low", "difference_high")
    table = read_csv(path, columns)
    table = table[table["motion"].isin(list(VALIDATION))]
    if not ((table["method"] == _PUBLISHED) & (table["opponent"] == _OPPONENT)).any():
        found = f"no {_PUBLISHED!r} against {_OPPONENT!r} on {SPAN}"
        raise InputError.at(f"{path}: method", found, f"rows of {_PUBLISHED}")
    known = [name for name in METHODS if name in set(table["method"])]
    others = [name for name in dict.fromkeys(table["method"]) if name not in METHODS]
    keys = [
        (method, opponent, duration)
        for opponent in dict.fromkeys(table["opponent"])
        for method in (*known, *others)
        for duration in sorted(set(table.loc[table["method"] == method, "duration"]))
    ]
    tallies = {key: _tally(table, *key) for key in keys}
    return Answer(_sentence(tallies, int(table["runs"].max()), int(table["arms"].max())), tuple(tallies.values()))


def _tally(table: pd.DataFrame, method: str, opponent: str, duration: float) -> Tally:
    chosen = (table["method"] == method) & (table["opponent"] == opponent) & (table["duration"] == duration)
    rows = table[chosen]
    better, worse = int((rows["difference_low"] > 0).sum()), int((rows["difference_high"] < 0).sum())
    first, second = (METHODS[name].title if name in METHODS else name for name in (method, opponent))
    return Tally(first, second, f"{duration:.4g}", better, worse, len(rows) - better - worse)


def _counts(tallies: Sequence[Tally]) -> tuple[int, int, int]:
    """Better, worse, and all comparisons."""
    better, worse = sum(t.better for t in tallies), sum(t.worse for t in tallies)
    return better, worse, better + worse + sum(t.open for t in tallies)


def _sentence(tallies: dict[tuple[str, str, float], Tally], runs: int, arms: int) -> str:
    def of(method: str, opponent: str) -> tuple[int, int, int]:
        return _counts([t for (m, o, _), t in tallies.items() if (m, o) == (method, opponent)])

    better, worse, total = of(_PUBLISHED, _OPPONENT)
    yes = {total: "Yes", 0: "No"}.get(better, "Not throughout")
    if better == worse == 0:
        yes = "Undecided"
    words = (
        f"{yes}: over {runs} specimens of {arms} simulated arms, Algorithm 1 as listed, trained on Eq. 10's motion, "
        f"rebuilds the torque better than least squares in {better} of {total} comparisons and worse in {worse}"
    )
    methods = {method for method, _, _ in tallies}
    for method, clause in _CLAUSES.items():
        if method in methods:
            words += f"; {clause} {of(method, _OPPONENT)[0]} (worse in {of(method, _OPPONENT)[1]})"
    words += ". "
    fair = [o for o in dict.fromkeys(opponent for _, opponent, _ in tallies) if o != _OPPONENT]
    best = max((of(method, opponent)[0] for method in methods for opponent in fair), default=0)
    if fair:
        names = " or ".join(METHODS[o].title[0].lower() + METHODS[o].title[1:] if o in METHODS else o for o in fair)
        most = f"more than {best} of {total}" if best else f"any of {total}"
        words += f"Against {names}, no variant is better in {most}. "
    return words + "A comparison is one joint on one motion after one identification."
