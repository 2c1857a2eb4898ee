"""Tables over all seeds: the median seed with the spread over the seeds, and both time factors of the metric."""

from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any

import pandas as pd

from repro.config.model import Configuration
from repro.errors import InputError
from repro.experiments.arm import Recording
from repro.experiments.identifications import CASE, score_estimates, score_runs
from repro.identification.method import TABLE_METHODS
from repro.model.parameters import NAMES, UNITS
from repro.signals.metric import TIME_FORMULAS, MetricSettings


def median_seeds(scores: pd.DataFrame) -> dict[tuple[str, str], int]:
    """Seed that stands for a case and method: the one whose ID similarity is the median."""
    on_id = scores[scores["trajectory"] == "ID"]
    mean = on_id.groupby(["case", "method", "seed"])["total"].mean().reset_index()
    by_cell = mean.sort_values("total", kind="stable").groupby(["case", "method"])["seed"]
    return dict(by_cell.agg(lambda seeds: seeds.iloc[len(seeds) // 2]))


def _ordered(frame: pd.DataFrame) -> pd.DataFrame:
    unknown = set(frame["method"]) - set(TABLE_METHODS)
    if unknown:
        raise InputError.at("results: method", sorted(unknown)[0], f"one of {', '.join(TABLE_METHODS)}")
    method = pd.Categorical(frame["method"], list(TABLE_METHODS), ordered=True)
    return frame.assign(method=method).sort_values(["method", "case"], kind="stable").astype({"method": str})


def experiment_table(scores: pd.DataFrame) -> pd.DataFrame:
    """Table 10: `median_cells`, and for some methods one run, of the seed whose similarity on ID is the median."""
    cells = median_cells(scores)
    chosen = median_seeds(scores[scores["case"] == CASE].assign(trajectory="ID"))
    blocks = [cells]
    for (_, method), seed in chosen.items():
        if method in ("algorithm1", "algorithm1+tracked"):
            run = scores[(scores["method"] == method) & (scores["seed"] == seed)].sort_values("joint")
            blocks.append(run.assign(method=f"{method}/one-run", total_sd=0.0, seeds=1)[cells.columns])
    return _ordered(pd.concat(blocks, ignore_index=True))


def median_cells(scores: pd.DataFrame) -> pd.DataFrame:
    """Median seed of each case, method and joint, on one trajectory (Tables 6 and 7)."""
    rows = []
    for key, group in scores.groupby(["case", "method", "joint"], sort=True):
        row = group.sort_values(["total", "seed"], kind="stable").iloc[len(group) // 2]
        # Equal values have no spread; rounding of their mean would leave one.
        sd = float(group["total"].std(ddof=1)) if group["total"].nunique() > 1 else 0.0
        rows.append((*key, row["time"], row["frequency"], row["total"], sd, len(group)))
    columns = ["case", "method", "joint", "time", "frequency", "total", "total_sd", "seeds"]
    return _ordered(pd.DataFrame(rows, columns=columns))


def parameter_table(
    identifications: Sequence[Mapping[str, Any]], scores: pd.DataFrame, cases: Sequence[str]
) -> pd.DataFrame:
    """Table 4 or 5: true parameters, the median seed's estimates, and their standard deviation over the seeds."""
    chosen = median_seeds(scores)
    rows = []
    for case, method in product(cases, TABLE_METHODS):
        arms = {run["seed"]: run["arms"][case] for run in identifications if method in run["arms"][case]["methods"]}
        if arms:
            estimates = pd.DataFrame([arm["methods"][method]["beta"] for arm in arms.values()])
            sd = estimates.std(ddof=1).where(estimates.nunique() > 1, 0.0)
            shown = arms[chosen[case, method]]
            each = zip(NAMES, UNITS, shown["true"], shown["methods"][method]["beta"], sd, strict=True)
            rows += [(case, method, *parameter) for parameter in each]
    columns = ["case", "method", "parameter", "unit", "true", "estimate", "estimate_sd"]
    return _ordered(pd.DataFrame(rows, columns=columns))


BOTH_METRICS = (
    "method", "formula", "numeric_id", "numeric_validation", "id1", "id2", "validation", "frequency_id",
    "frequency_validation",
)  # fmt: skip


def both_metrics(
    numeric: Sequence[Mapping[str, Any]],
    arm: Sequence[Mapping[str, Any]],
    recordings: Sequence[Recording],
    config: Configuration,
) -> pd.DataFrame:
    """Means of the median cells under each formula; the estimates were searched for with the configured one."""
    signals, rows, cell = config.signals, [], ["method", "case", "joint"]
    for formula in TIME_FORMULAS:
        metric = MetricSettings(formula, config.metric.exponent)
        of_arm = score_runs(arm, recordings, signals, metric)
        of_arm = of_arm.groupby(cell)[["frequency", "total"]].median().reset_index()
        of_numbers = score_estimates(numeric, config, metric)
        of_numbers = of_numbers.groupby(["trajectory", *cell])["total"].median().reset_index()
        means = of_numbers.groupby(["method", "trajectory"])["total"].mean()
        for method, own in of_arm.groupby("method"):
            on_id, others = own[own["case"] == CASE].set_index("joint"), own[own["case"] != CASE]
            numeric_means = [means.get((method, trajectory)) for trajectory in ("ID", "validation")]
            joints = [on_id.loc[joint, "total"] for joint in (1, 2)]
            frequencies = [cells["frequency"].mean() for cells in (on_id, others)]
            rows.append((method, formula, *numeric_means, *joints, others["total"].mean(), *frequencies))
    return pd.DataFrame(rows, columns=list(BOTH_METRICS)).sort_values(["method", "formula"], ignore_index=True)
