"""Beyond the paper: causes, intervals, the spread and its verdict, and other readings."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from repro.cnn.schedule import HISTORY_COLUMNS
from repro.errors import InputError
from repro.exhibits.inputs import Family, Inputs, Made
from repro.files import read_csv, read_json
from repro.identification.registry import OPPONENTS
from repro.model.parameters import Array
from repro.pipeline.readings import HEADLINES, ablation_figure, ablation_table
from repro.render import ablation, coverage, experiment_tables, spread, why
from repro.streams import Stream, stream

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
    histories = [read_csv(path, HISTORY_COLUMNS) for path in inputs["losses"]]
    return ablation_table([_numbers(path) for path in inputs["results"]], histories)


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
    ("table", "ablation"): Made(lambda i, _: _readings(i), ablation.table),
    ("figure", "ablation"): Made(
        lambda i, _: ablation_figure(read_csv(i["table"][0], ("question", "reading", *HEADLINES))), ablation.figure
    ),
}


def why_table(explained: pd.DataFrame) -> pd.DataFrame:
    """Medians over the seeds, and what each step costs."""
    groups = explained.groupby(["network", "step"], sort=False)
    table = groups[["total1", "total2", "error_uniform", "error_near"]].median()
    table[["spread1", "spread2"]] = groups[["total1", "total2"]].std(ddof=1).fillna(0.0).to_numpy()
    table["seeds"] = groups.size()
    mean = table[["total1", "total2"]].mean(axis=1)
    table["lost"] = mean.groupby("network", sort=False).transform(lambda totals: 0.0 - totals.diff().fillna(0.0))
    columns = ["network", "step", "seeds", "total1", "total2", "spread1", "spread2", "lost"]
    return table.reset_index()[[*columns, "error_uniform", "error_near"]]


#: Resamples of the bootstrap.
RESAMPLES = 9999


def verdict(scores: pd.DataFrame, methods: Sequence[str], opponents: Sequence[str]) -> pd.DataFrame:
    """Is a method better than an opponent: in how many runs, and by how much?

    From columns ``case, joint, method, duration, arm, seed, total``.
    """
    index = ["motion", "joint", "duration", "arm", "seed"]
    totals = scores.rename(columns={"case": "motion"}).pivot(index=index, columns="method", values="total")
    rows = []
    for method in methods:
        for opponent in opponents:
            difference = (totals[method] - totals[opponent]).rename("difference").reset_index()
            for k, (key, group) in enumerate(difference.groupby(["motion", "joint", "duration"], sort=True)):
                of_arms = [arm.to_numpy() for _, arm in group.groupby("arm")["difference"]]
                d = np.stack(of_arms)  # (arms, specimens)
                won = (int((d > 0).sum()), float((d > 0).mean()))
                rows.append((*list(key), method, opponent, len(d), d.size, *won, *_median(d, k)))
    columns = ["motion", "joint", "duration", "method", "opponent", "arms", "runs", "wins"]
    columns += ["win_share", "difference_median", "difference_low", "difference_high"]
    return pd.DataFrame(rows, columns=columns)


def _median(values: Array, index: int) -> tuple[float, float, float]:
    """Median with its 95 % bootstrap percentile interval; equal values are their own interval."""
    rng, (arms, specimens) = stream(0, Stream.BOOTSTRAP, index), values.shape
    arm = rng.integers(arms, size=(RESAMPLES, arms, 1))
    drawn = values[arm, rng.integers(specimens, size=(RESAMPLES, arms, specimens))]
    low, high = np.quantile(np.median(drawn.reshape(RESAMPLES, -1), axis=1), [0.025, 0.975])
    return float(np.median(values)), float(low), float(high)
