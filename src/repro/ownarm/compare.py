"""Methods side by side: what stands in each cell, and which cell is the best of its column."""

from collections.abc import Sequence
from dataclasses import dataclass

from repro.ownarm.numbers import percent, printed, significant
from repro.ownarm.result import MethodResult, Result, Score
from repro.ownarm.tables import parts

#: What stands where there is no number.
NOTHING = "\N{EN DASH}"

#: What a block of scores is called.
_HEADINGS = {
    "fit": "Fitted: {}",
    "half": "Half on half: the {}, predicted from the other half",
    "log": "Left out: {}, predicted from the other logs",
    "validation": "Validation: {}, not used for the fit",
}


@dataclass(frozen=True)
class Cell:
    """A number in print, and whether it is the best of its column in its block."""

    text: str
    best: bool = False


@dataclass(frozen=True)
class Block:
    """Scores of all methods on one log.

    Attributes
    ----------
    heading : str
        Which log and what it was used for.
    rows : list of (MethodResult, list of Cell)
        Methods that have this score: relative RMS, similarity and position error, joint 1 and joint 2 of each.
    """

    heading: str
    rows: list[tuple[MethodResult, list[Cell]]]


def predictions(method: MethodResult) -> list[tuple[str, list[str]]]:
    """How one method predicts each log, what it has not seen first."""
    order = {"validation": 0, "half": 1, "log": 1, "fit": 2}
    ordered = sorted(parts(method), key=lambda item: order[item[0]])
    return [
        (_HEADINGS[part].format(score.log), [_text(place, number) for place, number in enumerate(_numbers(score))])
        for part, score in ordered
    ]


def method_columns(result: Result) -> list[tuple[str, str, str, list[str]]]:
    """Parameters side by side."""
    rows = zip(*(method.parameters for method in result.methods), strict=True)
    return [
        (row[0].name, row[0].unit, row[0].description, [printed(parameter).both for parameter in row]) for row in rows
    ]


def blocks(result: Result) -> list[Block]:
    """Scores side by side, a block for each log.

    The best of a column is marked where methods are compared by what they predict, not by what they were fitted to, and
    only if they differ in print.
    """
    scores: dict[tuple[int, int], tuple[str, list[tuple[MethodResult, Score]]]] = {}
    order = list(_HEADINGS)
    for method in result.methods:
        count = dict.fromkeys(order, 0)
        for part, score in parts(method):  # by number, because two logs may have one name
            heading = _HEADINGS[part].format(score.log)
            scores.setdefault((order.index(part), count[part]), (heading, []))[1].append((method, score))
            count[part] += 1
    made = []
    for (part_number, _), (heading, found) in sorted(scores.items()):
        marked = order[part_number] != "fit"
        columns = [_column(place, [_numbers(score)[place] for _, score in found], marked) for place in range(6)]
        rows = [(method, list(row)) for (method, _), row in zip(found, zip(*columns, strict=True), strict=True)]
        made.append(Block(heading, rows))
    return made


def _numbers(score: Score) -> list[float | None]:
    return [*score.relative_rms, *score.similarity, *(score.position_rms or (None, None))]


def _text(place: int, number: float | None) -> str:
    """The number of one of the six columns in print: four in percent, two in rad."""
    if number is None:
        return NOTHING
    return percent(number) if place < 4 else significant(number)


def _column(place: int, numbers: Sequence[float | None], marked: bool) -> list[Cell]:
    """Cells of one column; of similarity more is better, of errors less."""
    texts = [_text(place, number) for number in numbers]
    known = [number for number in numbers if number is not None]
    if not marked or not known or len(set(texts)) == 1:
        return [Cell(text) for text in texts]
    best = _text(place, max(known) if place in (2, 3) else min(known))
    return [Cell(text, text == best) for text in texts]
