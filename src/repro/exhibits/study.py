"""Beyond the paper: causes, intervals, the spread and its verdict, and other readings."""

from pathlib import Path
from typing import Any

import pandas as pd

from repro.errors import InputError
from repro.exhibits.inputs import Family, Inputs, Made
from repro.files import read_csv, read_json
from repro.identification.registry import OPPONENTS
from repro.pipeline.readings import HEADLINES, ablation_figure, ablation_table
from repro.pipeline.verdict import verdict
from repro.pipeline.why_table import why_table
from repro.render import ablation, coverage, experiment_tables, spread, why
from repro.render import ablation_table as ablation_layout

SPREAD = ("case", "joint", "method", "duration", "arm", "seed", "total")
EXPLAINED = ("network", "step", "seed", "total1", "total2", "error_uniform", "error_near")
RANKS = ("arms", "parameter", "bin", "number", "known", "raw", "calibrated")
COVERAGE = ("arms", "parameter", "level", "raw", "calibrated", "factor", "width", "warned")
INTERVALS = ("parameter", "true", "centre", "low", "high", "level", "warned")
#: Methods of the verdict, and what they are set against.
CONTENDERS = ("algorithm1", "algorithm1+tracked", "algorithm1+refinement", "algorithm1+local-search")
#: Methods drawn for the spread; the literal Algorithm 1 would leave the others on one line.
DRAWN = ("algorithm1+tracked", "algorithm1+refinement", "least-squares", "bounded", "true")


def _spread(inputs: Inputs) -> pd.DataFrame:
    return pd.concat([read_csv(path, SPREAD) for path in inputs["scores"]], ignore_index=True)


def _drawn_spread(inputs: Inputs) -> pd.DataFrame:
    """Runs that are drawn, with the median of each group of seeds beside them."""
    drawn = _spread(inputs).query("method in @DRAWN")[list(SPREAD)]
    median = drawn.groupby(["case", "joint", "method", "duration"])["total"].transform("median")
    return drawn.assign(median=median)


def _explained(inputs: Inputs) -> pd.DataFrame:
    return pd.concat([read_csv(path, EXPLAINED) for path in inputs["scores"]], ignore_index=True)


def _numbers(path: Path) -> dict[str, Any]:
    content = read_json(path)
    if not isinstance(content, dict):
        raise InputError.at(str(path), type(content).__name__, "numbers by name")
    return content


def _readings(inputs: Inputs) -> pd.DataFrame:
    results, losses = ({path.stem: _numbers(path) for path in inputs[key]} for key in ("results", "losses"))
    return ablation_table(results, losses)


MADE: Family = {
    ("table", "why"): Made(lambda i, _: why_table(_explained(i)), why.table),
    ("figure", "why"): Made(lambda i, _: _explained(i)[["network", "step", "seed", "total1", "total2"]], why.figure),
    ("table", "coverage"): Made(lambda i, _: read_csv(i["coverage"][0], COVERAGE), coverage.table),
    ("figure", "coverage"): Made(lambda i, _: read_csv(i["ranks"][0], RANKS), coverage.figure),
    ("table", "intervals"): Made(lambda i, _: read_csv(i["intervals"][0], INTERVALS), coverage.intervals),
    ("table", "verdict"): Made(
        lambda i, _: verdict(_spread(i), CONTENDERS, tuple(OPPONENTS)), experiment_tables.verdict
    ),
    ("figure", "spread"): Made(lambda i, _: _drawn_spread(i), spread.spread),
    ("table", "ablation"): Made(lambda i, _: _readings(i), ablation_layout.table),
    ("figure", "ablation"): Made(
        lambda i, _: ablation_figure(read_csv(i["table"][0], ("question", "reading", *HEADLINES))), ablation.figure
    ),
}
