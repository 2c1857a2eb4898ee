"""The headline rows under both time factors of the metric, from the same estimates."""

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from repro.pipeline.experiment_runs import CASE, score_runs
from repro.pipeline.identified import every_seed
from repro.pipeline.job import Config
from repro.pipeline.numeric import score_estimates
from repro.pipeline.recordings import Recording
from repro.settings import numeric_settings, signal_settings
from repro.signals.metric import TIME_FORMULAS, MetricSettings

COLUMNS = (
    "method", "formula", "numeric_id", "numeric_validation", "id1", "id2", "validation", "frequency_id",
    "frequency_validation",
)  # fmt: skip


def both_metrics(
    numeric: Sequence[Mapping[str, Any]],
    arm: Sequence[Mapping[str, Any]],
    recordings: Sequence[Recording],
    config: Config,
) -> pd.DataFrame:
    """Means of the median cells under each formula; the estimates were searched for with the configured one.

    Columns `COLUMNS`: totals of N1 to N4 on both trajectories, of the arm on ID (each joint) and over T1 to T4, and the
    frequency factor of the arm, which both formulas share.
    """
    signals, settings = signal_settings(config), numeric_settings(config)
    rows = []
    for formula in TIME_FORMULAS:
        metric = MetricSettings(formula, config["metric"]["exponent"])
        cells = ["method", "case", "joint"]
        of_arm = score_runs(every_seed(arm), recordings, signals, metric)
        of_arm = of_arm.groupby(cells)[["frequency", "total"]].median().reset_index()
        of_numbers = score_estimates(every_seed(numeric), signals, settings, metric)
        of_numbers = of_numbers.groupby(["trajectory", *cells])["total"].median().reset_index()
        means = of_numbers.groupby(["method", "trajectory"])["total"].mean()
        for method, own in of_arm.groupby("method"):
            on_id, others = own[own["case"] == CASE].set_index("joint"), own[own["case"] != CASE]
            rows.append(
                {
                    "method": method,
                    "formula": formula,
                    "numeric_id": means.get((method, "ID")),
                    "numeric_validation": means.get((method, "validation")),
                    "id1": on_id.loc[1, "total"],
                    "id2": on_id.loc[2, "total"],
                    "validation": others["total"].mean(),
                    "frequency_id": on_id["frequency"].mean(),
                    "frequency_validation": others["frequency"].mean(),
                }
            )
    return pd.DataFrame(rows, columns=list(COLUMNS)).sort_values(["method", "formula"], ignore_index=True)
