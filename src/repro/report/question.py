"""The paper's central comparison, answered from the table ``verdict``: does Algorithm 1 beat least squares?"""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import Any

from repro.errors import InputError
from repro.exhibits.style import METHODS
from repro.files import read_csv
from repro.pipeline.monte_carlo import ALL, BETTER, COMPARISON_COLUMNS, OPEN, SAME, WORSE
from repro.report.inputs import ReportInputs
from repro.signals.programs import SPAN

#: The paper's method as listed, and the opponent that the paper chose.
_PUBLISHED, _OPPONENT = "algorithm1", "least-squares"
_WORDS = {BETTER: "Yes", WORSE: "No", SAME: "Neither", OPEN: "Undecided"}


@dataclass(frozen=True)
class Pair:
    """One method against one opponent on all arms, after an identification of `duration` s."""

    method: str
    opponent: str
    duration: str
    difference: str  # points of a percent, with the simultaneous interval
    conclusion: str


@dataclass(frozen=True)
class Answer:
    """The answer in one sentence, and what it rests on."""

    words: str
    pairs: tuple[Pair, ...]


def answer(inputs: ReportInputs) -> Answer | None:
    """Read the comparisons; None if the table is missing and the report may be partial."""
    path = inputs.results / "tables" / "verdict.csv"
    if inputs.partial and not path.exists():
        return None
    table = read_csv(path, COMPARISON_COLUMNS)
    table = table[table["set"] == ALL]
    asked = table[(table["method"] == _PUBLISHED) & (table["opponent"] == _OPPONENT)]
    if asked.empty:
        found = f"no {_PUBLISHED!r} against {_OPPONENT!r} on {SPAN}"
        raise InputError.at(f"{path}: method", found, f"rows of {_PUBLISHED}")
    conclusions = set(asked["conclusion"])
    yes = _WORDS[conclusions.pop()] if len(conclusions) == 1 else "Not throughout"
    parts = [f"{_points(row)} after {row['duration']:.4g} s" for row in asked.to_dict("records")]
    words = (
        f"{yes}: over {int(table['arms'].max())} simulated arms, Algorithm 1 as listed differs from least squares by "
        f"{' and '.join(parts)}."
    )
    return Answer(words, tuple(_pair(row) for row in table.to_dict("records")))


def _points(row: Mapping[Hashable, Any]) -> str:
    difference, low, high = (100.0 * float(row[name]) for name in ("difference", "low", "high"))
    return f"{difference:+.2f} points ({low:+.2f} to {high:+.2f})".replace("-", "\N{MINUS SIGN}")


def _pair(row: Mapping[Hashable, Any]) -> Pair:
    first, second = (
        METHODS[name].title if name in METHODS else name for name in (str(row["method"]), str(row["opponent"]))
    )
    return Pair(first, second, f"{row['duration']:.4g}", _points(row), str(row["conclusion"]))
