"""Parameters and scores as tidy tables, one row for each number with what it belongs to."""

from collections.abc import Iterator

import pandas as pd

from repro.ownarm.result import HALVES, MethodResult, Result, Score

PARAMETER_COLUMNS = ("method", "parameter", "unit", "estimate", "standard_error", "low", "high", "verdict")
SCORE_COLUMNS = ("method", "log", "part", "joint", "relative_rms", "similarity", "position_rms")


def parameters_table(result: Result) -> pd.DataFrame:
    """Parameters of every method."""
    rows = [
        (
            method.method,
            parameter.name,
            parameter.unit,
            parameter.estimate,
            parameter.standard_error,
            parameter.low,
            parameter.high,
            parameter.verdict,
        )
        for method in result.methods
        for parameter in method.parameters
    ]
    numbers = dict.fromkeys(PARAMETER_COLUMNS[3:7], "float64")
    return pd.DataFrame(rows, columns=list(PARAMETER_COLUMNS)).astype(numbers)


def scores_table(result: Result) -> pd.DataFrame:
    """How well every method predicts every log."""
    rows = [
        (
            method.method,
            cell(score.log),
            part,
            joint + 1,
            score.relative_rms[joint],
            score.similarity[joint],
            score.position_rms[joint] if score.position_rms else None,
        )
        for method in result.methods
        for part, score in parts(method)
        for joint in range(2)
    ]
    numbers = dict.fromkeys(SCORE_COLUMNS[4:], "float64")
    return pd.DataFrame(rows, columns=list(SCORE_COLUMNS)).astype(numbers)


def cell(name: str) -> str:
    """Name of a log as text that no spreadsheet takes for a formula."""
    return f"'{name}" if name.startswith(("=", "+", "-", "@")) else name


def parts(method: MethodResult) -> Iterator[tuple[str, Score]]:
    """Every score of a method with the part it belongs to: ``fit``, ``half``, ``log`` or ``validation``."""
    yield "fit", method.fit
    for score in method.halves:
        yield "half" if score.log in HALVES else "log", score
    for score in method.validation:
        yield "validation", score
