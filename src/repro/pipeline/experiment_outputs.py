"""Which function makes the numbers of the experiment's tables and figures."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from repro.files import read_csv
from repro.pipeline import experiment_data as draw
from repro.pipeline.experiment import control_constants, program_settings
from repro.pipeline.experiment_runs import CASE, every_seed, tracking
from repro.pipeline.identified import read_identifications, read_scores
from repro.pipeline.named import Config
from repro.pipeline.recordings import Recording, read_recording
from repro.pipeline.summary import median_cells, parameter_table
from repro.pipeline.verdict import verdict
from repro.pipeline.why_table import why_table
from repro.settings import metric_settings, signal_settings

Inputs = Mapping[str, Sequence[Path]]

#: Columns of the scores of the experiment, and of the spread.
SCORES = ("case", "method", "seed", "joint", "time", "frequency", "total")
SPREAD = ("case", "joint", "method", "duration", "arm", "seed", "total")
EXPLAINED = ("network", "step", "seed", "total1", "total2", "error_uniform", "error_near")
RANKS = ("arms", "parameter", "bin", "number", "known", "raw", "calibrated")
COVERAGE = ("arms", "parameter", "level", "raw", "calibrated", "factor", "width", "warned")
INTERVALS = ("parameter", "true", "centre", "low", "high", "level", "warned")
#: Methods of the verdict, and what they are set against.
CONTENDERS = ("algorithm1", "algorithm1+tracked", "algorithm1+refinement", "algorithm1+local-search")
OPPONENTS = ("least-squares", "bounded", "consistent")
#: Methods drawn for the spread; the literal Algorithm 1 would leave the others on one line.
DRAWN = ("algorithm1+tracked", "algorithm1+refinement", "least-squares", "bounded", "true")


def _recordings(inputs: Inputs, config: Config) -> list[Recording]:
    return [read_recording(path, config) for path in inputs["captures"] if path.suffix == ".bin"]


def _runs(inputs: Inputs) -> list[dict[str, Any]]:
    return every_seed(read_identifications(inputs["identifications"]))


def _scores(inputs: Inputs) -> pd.DataFrame:
    return read_scores(inputs["scores"], SCORES)


def _estimates(inputs: Inputs) -> dict[str, Any]:
    return draw.shown_estimates(_runs(inputs), _scores(inputs))


def _identification(inputs: Inputs, config: Config, in_frequency: bool) -> pd.DataFrame:
    (recording,) = _recordings(inputs, config)
    return draw.identification_figure(recording, signal_settings(config), _estimates(inputs), in_frequency)


def _validation(inputs: Inputs, config: Config, in_frequency: bool) -> pd.DataFrame:
    recordings = _recordings(inputs, config)
    return draw.validation_figure(recordings, signal_settings(config), _estimates(inputs), in_frequency)


def _setup(config: Config) -> pd.DataFrame:
    settings = program_settings(config)
    return draw.setup_figure(control_constants(config), settings.geometry, settings.h)


def _control(inputs: Inputs, config: Config) -> pd.DataFrame:
    (recording,) = _recordings(inputs, config)
    tracked = tracking(recording, metric_settings(config))
    return draw.control_table(tracked, control_constants(config), config["signals"]["filter_coefficient"])


def _parameters(inputs: Inputs) -> pd.DataFrame:
    on_id = _scores(inputs).query("case == @CASE").assign(trajectory="ID")
    table = parameter_table(_runs(inputs), on_id, (CASE,))
    return table[table["method"] != "true"].reset_index(drop=True)


def _spread(inputs: Inputs) -> pd.DataFrame:
    return pd.concat([read_csv(path, SPREAD) for path in inputs["scores"]], ignore_index=True)


def _drawn_spread(inputs: Inputs) -> pd.DataFrame:
    """Runs that are drawn, with the median of each group of seeds beside them."""
    drawn = _spread(inputs).query("method in @DRAWN")[list(SPREAD)]
    median = drawn.groupby(["case", "joint", "method", "duration"])["total"].transform("median")
    return drawn.assign(median=median)


def _explained(inputs: Inputs) -> pd.DataFrame:
    return pd.concat([read_csv(path, EXPLAINED) for path in inputs["scores"]], ignore_index=True)


FIGURE_DATA: dict[str, Callable[[Inputs, Config], pd.DataFrame]] = {
    "fig18": lambda _, c: _setup(c),
    "fig19": lambda i, c: _identification(i, c, in_frequency=False),
    "fig20": lambda i, c: _identification(i, c, in_frequency=True),
    "fig21": lambda i, c: draw.paths_figure(_recordings(i, c), program_settings(c).geometry),
    "fig22": lambda i, c: draw.motions_figure(_recordings(i, c), signal_settings(c)),
    "fig23": lambda i, c: _validation(i, c, in_frequency=False),
    "fig24": lambda i, c: _validation(i, c, in_frequency=True),
    "spread": lambda i, _: _drawn_spread(i),
    "why": lambda i, _: _explained(i)[["network", "step", "seed", "total1", "total2"]],
    "coverage": lambda i, _: read_csv(i["ranks"][0], RANKS),
}

TABLE_DATA: dict[str, Callable[[Inputs, Config], pd.DataFrame]] = {
    "table08": _control,
    "table09": lambda i, _: _parameters(i),
    "table10": lambda i, _: median_cells(_scores(i)),
    "stability": lambda i, _: draw.stability_table(_estimates(i), ("algorithm1", *draw.SHOWN, "true")),
    "verdict": lambda i, _: verdict(_spread(i), CONTENDERS, OPPONENTS),
    "why": lambda i, _: why_table(_explained(i)),
    "coverage": lambda i, _: read_csv(i["coverage"][0], COVERAGE),
    "intervals": lambda i, _: read_csv(i["intervals"][0], INTERVALS),
}
