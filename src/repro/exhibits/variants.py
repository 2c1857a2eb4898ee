"""The headline numbers under other readings of the paper: both time factors, and the ablation."""

from pathlib import Path
from typing import Any

import pandas as pd

from repro.cnn.schedule import HISTORY_COLUMNS
from repro.documents import read_json
from repro.errors import InputError
from repro.exhibits.declare import ABLATION, ARM, EXPERIMENT, Inputs, figure, table
from repro.files import read_csv
from repro.pipeline.identified import read_identifications
from repro.pipeline.job import Config
from repro.pipeline.readings import HEADLINES, ablation_figure, ablation_table
from repro.pipeline.recordings import read_recordings
from repro.pipeline.summary import both_metrics
from repro.render import ablation, experiment_tables


def _numbers(path: Path) -> dict[str, Any]:
    content = read_json(path)
    if not isinstance(content, dict):
        raise InputError.at(str(path), type(content).__name__, "numbers by name")
    return content


@table(
    "both_metrics",
    "Headline rows under both time factors",
    EXPERIMENT,
    experiment_tables.both_metrics,
    target="both_metrics",
    inputs=("headline",),
    sections=(*ARM, "metric", "numeric"),
)
def both_metrics_table(inputs: Inputs, config: Config) -> pd.DataFrame:
    """The headline rows of the numeric tests and of the simulated arm under both time factors of metr2ev, from the same
    estimates.
    """
    numeric, arm = (read_identifications(inputs[name]) for name in ("numeric", "arm"))
    return both_metrics(numeric, arm, read_recordings(inputs["captures"], config), config)


@table(
    "ablation",
    "Headline numbers under other readings",
    ABLATION,
    ablation.table,
    inputs=("readings",),
    trained="all",
    optional=True,
)
def readings_table(inputs: Inputs, _: Config) -> pd.DataFrame:
    """Headline numbers under each reading of what the paper leaves open: the literal Algorithm 1 on N1 to N4 and on the
    simulated arm (medians of the seeds), and the mean over T1 to T4 of the simulated arm for the refined Algorithm 1,
    least squares and the true parameters. Losses under different labels or images do not compare with each other.
    """
    histories = [read_csv(path, HISTORY_COLUMNS) for path in inputs["losses"]]
    return ablation_table([_numbers(path) for path in inputs["results"]], histories)


@figure(
    "ablation",
    "Headline numbers by reading",
    ABLATION,
    ablation.figure,
    inputs=("ablation",),
    trained="all",
    optional=True,
)
def readings_figure(inputs: Inputs, _: Config) -> pd.DataFrame:
    """Mean total similarity under each reading of what the paper leaves open: the literal Algorithm 1 on N1 to N4
    (left), on the simulated arm's identification run and on the validation motions (middle), and on the validation
    motions the refined Algorithm 1, least squares and the true parameters (right). Vertical lines are the default
    reading. Values far below it stand as numbers in the grey strip.
    """
    return ablation_figure(read_csv(inputs["table"][0], ("question", "reading", *HEADLINES)))
