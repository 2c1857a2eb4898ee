"""Beyond the paper: causes, intervals, the spread and its verdict, and other readings."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from repro.cnn.schedule import HISTORY_COLUMNS
from repro.documents import read_json
from repro.errors import InputError
from repro.exhibits.inputs import Family, Inputs, Made, arm_scores
from repro.files import read_csv
from repro.identification.method import BASELINES
from repro.pipeline.both_metrics import both_metrics
from repro.pipeline.effects import cell_means, effects
from repro.pipeline.experiment_runs import CASE
from repro.pipeline.factorial_design import COLUMNS
from repro.pipeline.identified import read_identifications
from repro.pipeline.job import Config
from repro.pipeline.paired import comparisons
from repro.pipeline.readings import HEADLINES, ablation_figure, ablation_table
from repro.pipeline.recordings import read_recordings
from repro.render import ablation, coverage, experiment_tables, factorial, spread, why

SPREAD = ("case", "joint", "method", "duration", "arm", "chatter", "seed", "total")
RANKS = ("arms", "parameter", "level", "number", "known", "raw", "calibrated")
COVERAGE = ("arms", "parameter", "level", "raw", "calibrated", "factor", "width", "contraction", "warned")
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


def _both_metrics(inputs: Inputs, config: Config) -> pd.DataFrame:
    numeric, arm = (read_identifications(inputs[name]) for name in ("numeric", "arm"))
    return both_metrics(numeric, arm, read_recordings(inputs["captures"], config), config)


def _factorial(inputs: Inputs) -> pd.DataFrame:
    return pd.concat([read_csv(path, COLUMNS) for path in inputs["scores"]], ignore_index=True)


def _numbers(path: Path) -> dict[str, Any]:
    content = read_json(path)
    if not isinstance(content, dict):
        raise InputError.at(str(path), type(content).__name__, "numbers by name")
    return content


def _readings(inputs: Inputs) -> pd.DataFrame:
    histories = [read_csv(path, HISTORY_COLUMNS) for path in inputs["losses"]]
    return ablation_table([_numbers(path) for path in inputs["results"]], histories)


MADE: Family = {
    ("table", "why"): Made(lambda i, _: why_table(crossed(arm_scores(i))), why.table),
    ("figure", "why"): Made(lambda i, _: crossed(arm_scores(i)), why.figure),
    ("table", "coverage"): Made(lambda i, _: read_csv(i["coverage"][0], COVERAGE), coverage.table),
    ("figure", "coverage"): Made(lambda i, _: read_csv(i["ranks"][0], RANKS), coverage.figure),
    ("table", "intervals"): Made(lambda i, _: read_csv(i["intervals"][0], INTERVALS), coverage.intervals),
    ("table", "verdict"): Made(
        lambda i, _: comparisons(_spread(i), CONTENDERS, tuple(BASELINES)), experiment_tables.verdict
    ),
    ("figure", "spread"): Made(lambda i, _: _drawn_spread(i), spread.spread),
    ("table", "both_metrics"): Made(_both_metrics, experiment_tables.both_metrics),
    ("table", "factorial"): Made(lambda i, _: effects(_factorial(i)), factorial.effects_table),
    ("figure", "factorial"): Made(lambda i, _: effects(_factorial(i)), factorial.figure),
    ("table", "factorial_cells"): Made(
        lambda i, _: cell_means(_factorial(i), read_csv(i["references"][0])), factorial.cells_table
    ),
    ("table", "ablation"): Made(lambda i, _: _readings(i), ablation.table),
    ("figure", "ablation"): Made(
        lambda i, _: ablation_figure(read_csv(i["table"][0], ("question", "reading", *HEADLINES))), ablation.figure
    ),
}


#: Variants of Algorithm 1 by the motions of their training and the motion of line 18.
CAUSES = {
    "algorithm1": ("ideal", "measured"),
    "algorithm1+desired": ("ideal", "desired"),
    "algorithm1+tracked-measured": ("tracked", "measured"),
    "algorithm1+tracked": ("tracked", "desired"),
}
#: Weights of the four cells, in this order, in each effect.
EFFECTS = {
    "image_motion": (-0.5, 0.5, -0.5, 0.5),
    "training": (-0.5, -0.5, 0.5, 0.5),
    "both": (0.5, -0.5, -0.5, 0.5),
}


def crossed(scores: pd.DataFrame) -> pd.DataFrame:
    """Mean total of each seed in the four cells.

    Columns ``training, image_motion, seed, response, value``, the response being ``id`` or ``validation``.
    """
    of_causes = scores[scores["method"].isin(CAUSES)]
    on_id = of_causes["case"].eq(CASE).map({True: "id", False: "validation"}).rename("response")
    means = of_causes.groupby(["method", "seed", on_id])["total"].mean().rename("value").reset_index()
    levels = pd.DataFrame(means["method"].map(CAUSES).tolist(), columns=["training", "image_motion"], index=means.index)
    return pd.concat([levels, means[["seed", "response", "value"]]], axis=1)


def why_table(cells: pd.DataFrame) -> pd.DataFrame:
    """Mean and spread over the seeds of the four cells and of the effects, from `crossed`.

    Columns ``row, training, image_motion, response, value, spread, seeds``; an effect has its name under ``training``.
    """
    values = cells.pivot(index=["response", "seed"], columns=["training", "image_motion"], values="value")
    values = values[list(CAUSES.values())]
    effects = pd.DataFrame({name: values @ np.array(weights) for name, weights in EFFECTS.items()})
    rows: list[tuple[object, ...]] = []
    for kind, frame in (("cell", values), ("effect", effects)):
        for name in frame.columns:
            for response, of_seeds in frame[name].groupby("response"):
                where = name if kind == "cell" else (name, "")
                rows.append((kind, *where, response, of_seeds.mean(), of_seeds.std(ddof=1), len(of_seeds)))
    columns = ["row", "training", "image_motion", "response", "value", "spread", "seeds"]
    return pd.DataFrame(rows, columns=columns).fillna({"spread": 0.0})
