"""Parameters and scores as tables: tidy for the CSV files, rounded and side by side for the report."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from operator import attrgetter

import pandas as pd

from repro.drawing.markup import SUPERSCRIPTS, TIMES
from repro.fitting.result import Curves, MethodResult, Parameter, Result, Score
from repro.fitting.text import NOTHING

PARAMETER_COLUMNS = ["method", "parameter", "unit", "estimate", "standard_error", "low", "high", "verdict"]
#: The same of a parameter, without the method.
_row = attrgetter("name", *PARAMETER_COLUMNS[2:])
SCORE_COLUMNS = ["method", "log", "part", "joint", "relative_rms", "similarity", "position_rms"]

#: Headings of the scores by their kind.
_HEADINGS = {
    "fit": "Fitted: {}",
    "half": "Half on half: the {}, predicted from the other half",
    "log": "Left out: {}, predicted from the other logs",
    "validation": "Validation: {}, not used for the fit",
}
_MIN_POWER, _MAX_POWER = -4, 5  # powers of ten outside this range are written as such


def parameters_table(result: Result) -> pd.DataFrame:
    """Tabulate the parameters of every method, one a row."""
    rows = [(method.method, *_row(parameter)) for method in result.methods for parameter in method.parameters]
    return pd.DataFrame(rows, columns=PARAMETER_COLUMNS).astype(dict.fromkeys(PARAMETER_COLUMNS[3:7], "float64"))


def runs_table(result: Result) -> pd.DataFrame:
    """Tabulate the parameters from each log alone, a row each, with their range and agreement over the logs."""
    pairs = [(run, k, spread) for k, spread in enumerate(result.spread) for run in result.runs]
    rows = [(escape_formula(run.log), *_row(run.parameters[k]), row.range, row.agree) for run, k, row in pairs]
    return pd.DataFrame(rows, columns=["log", *PARAMETER_COLUMNS[1:], "range", "agree"])


def scores_table(result: Result) -> pd.DataFrame:
    """Tabulate the scores of every method on every log, one joint a row."""
    rows = [
        (method.method, escape_formula(score.log), part, joint, *numbers)
        for method in result.methods
        for part, score in method.scores
        for joint, numbers in enumerate(zip(*_numbers(score), strict=True), 1)
    ]
    return pd.DataFrame(rows, columns=SCORE_COLUMNS).astype(dict.fromkeys(SCORE_COLUMNS[4:], "float64"))


def residuals_table(result: Result, curves: Curves) -> pd.DataFrame:
    """Tabulate measured and rebuilt torque of the recommended method, log by log."""
    frames = []
    for signals in curves.signals:
        for joint in range(2):
            tau, rebuilt = signals.tau[joint], signals.rebuilt[result.recommended][joint]
            columns = {"log": escape_formula(signals.name), "time_s": signals.t, "joint": joint + 1}
            columns |= {"torque_nm": tau, "rebuilt_nm": rebuilt, "residual_nm": tau - rebuilt}
            frames.append(pd.DataFrame(columns))
    return pd.concat(frames, ignore_index=True)


def escape_formula(name: str) -> str:
    """Quote the name of a log that a spreadsheet would take for a formula."""
    return f"'{name}" if name.startswith(("=", "+", "-", "@")) else name


#: A rounded number, and whether it is the best of its column in its block.
ScoreCell = tuple[str, bool]
#: A heading that names a log and its use, and the methods that have scores on it: each with the cells of relative RMS,
#: similarity and position error, joint 1 and 2 of each.
Block = tuple[str, list[tuple[MethodResult, tuple[ScoreCell, ...]]]]


def predictions(method: MethodResult) -> list[tuple[str, list[str]]]:
    """Give the scores of one method on each log, unseen logs first."""
    ordered = sorted(method.scores, key=lambda item: -list(_HEADINGS).index(item[0]))
    return [(_HEADINGS[part].format(score.log), _texts(score)) for part, score in ordered]


def blocks(result: Result) -> list[Block]:
    """Give the scores side by side, a block for each log; the best is marked, except of the fit and of equals."""
    filled = []
    for kind, heading in _HEADINGS.items():
        scores = [[(method, score) for part, score in method.scores if part == kind] for method in result.methods]
        for row in zip_longest(*scores):  # by number, because two logs may have one name
            pairs = [pair for pair in row if pair is not None]
            columns = [_column(place, [score for _, score in pairs], kind != "fit") for place in range(6)]
            cells = zip((method for method, _ in pairs), zip(*columns, strict=True), strict=True)
            filled.append((heading.format(pairs[0][1].log), list(cells)))
    return filled


def _numbers(score: Score) -> tuple[tuple[float | None, float | None], ...]:
    return score.relative_rms, score.similarity, score.position_rms or (None, None)


def _texts(score: Score) -> list[str]:
    """Round the six numbers: relative RMS and similarity in percent, position error in rad."""
    forms: tuple[Callable[[float], str], ...] = (percent, percent, significant)
    pairs = zip(_numbers(score), forms, strict=True)
    return [NOTHING if number is None else form(number) for pair, form in pairs for number in pair]


def _column(place: int, scores: Sequence[Score], marked: bool) -> list[ScoreCell]:
    """Fill one column; a larger similarity is better, a smaller error is."""
    pairs = [(_numbers(score)[place // 2][place % 2], _texts(score)[place]) for score in scores]
    known = [(number, text) for number, text in pairs if number is not None]
    best = None
    if marked and known and len({text for _, text in pairs}) > 1:
        _, best = max(known) if place in (2, 3) else min(known)
    return [(text, text == best) for _, text in pairs]


@dataclass(frozen=True)
class Rounded:
    """A rounded estimate; all but `estimate` are empty where the method claims no interval."""

    estimate: str
    error: str  # standard error
    low: str  # ends of the interval
    high: str
    power: str  # power of ten that multiplies all four, such as ``×10⁻⁷``; mostly empty

    @property
    def with_error(self) -> str:
        """Estimate and standard error in one text."""
        text = f"{self.estimate} ± {self.error}" if self.error else self.estimate
        return f"({text}){self.power}" if self.error and self.power else text + self.power

    @property
    def interval(self) -> str:
        """Both ends; empty if there are none."""
        return f"{self.low} to {self.high}{self.power}" if self.low else ""


def rounded(parameter: Parameter) -> Rounded:
    """Round an estimate to two digits of its standard error, or to four digits without one."""
    estimate, error = parameter.estimate, parameter.standard_error
    values = (estimate, error, parameter.low, parameter.high)
    if not all(value is None or math.isfinite(value) for value in values):
        shown, spread, low, high = ("" if value is None else significant(value) for value in values)
        return Rounded(shown, spread, low, high, "")
    largest = max(abs(estimate), error or 0.0)
    last = _power(error) - 1 if error else (_power(estimate) - 3 if estimate else 0)
    (shown, spread, low, high), times = _print(values, _power(largest) if largest > 0.0 else 0, last)
    return Rounded(shown, "0" if error == 0.0 else spread, low, high, times)


def significant(value: float, digits: int = 3) -> str:
    """Round to significant digits; a power of ten is written only far from 1."""
    if value == 0.0 or not math.isfinite(value):
        return f"{value + 0.0:g}"  # no negative zero
    power = _power(float(f"{value:.{digits - 1}e}"))
    (text,), times = _print([value], power, power - digits + 1)
    return text + times


def percent(fraction: float) -> str:
    """Write a fraction of 1 in percent."""
    return f"{100.0 * fraction:.1f}" if abs(fraction) < 10.0 else significant(100.0 * fraction)


def _power(value: float) -> int:
    return math.floor(math.log10(abs(value)))


def _print(values: Sequence[float | None], power: int, last: int) -> tuple[list[str], str]:
    """Print numbers (None is empty) to the digit of a power of ten, over `power` if far from 1, and that power."""
    scaled = not _MIN_POWER <= power <= _MAX_POWER
    scale, decimals = 10.0**power if scaled else 1.0, min(max(0, (power if scaled else 0) - last), 12)
    # + 0.0: no negative zero
    texts = ["" if value is None else f"{round(value / scale, decimals) + 0.0:.{decimals}f}" for value in values]
    return texts, f"{TIMES}10{str(power).translate(SUPERSCRIPTS)}" if scaled else ""
