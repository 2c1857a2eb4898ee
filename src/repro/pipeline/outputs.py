"""Which function makes the numbers of which table and figure."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from repro.cnn.schedule import HISTORY_COLUMNS
from repro.cnn.weights import read_weights
from repro.errors import InputError
from repro.files import read_csv, read_json
from repro.pipeline import experiment_outputs as experiment
from repro.pipeline import figure_data as draw
from repro.pipeline import schematics_data as schematics
from repro.pipeline.description import architecture, network_features, parameter_description
from repro.pipeline.experiment_outputs import SCORES
from repro.pipeline.identified import read_identifications, read_scores
from repro.pipeline.named import Config
from repro.pipeline.numeric import motion_of
from repro.pipeline.readings import HEADLINES, ablation_figure, ablation_table
from repro.pipeline.summary import median_cells, median_seeds, parameter_table, similarity_table
from repro.settings import (
    data_settings,
    network_settings,
    numeric_settings,
    of_network,
    signal_settings,
    training_settings,
)
from repro.signals.trajectories import identification_trajectory

Inputs = Mapping[str, Sequence[Path]]


def _scores(inputs: Inputs) -> pd.DataFrame:
    return read_scores(inputs["scores"])


def _search_table(inputs: Inputs) -> pd.DataFrame:
    return read_csv(inputs["search"][0], ("factor", "candidate", "rms_log_error_best", "chosen"))


def _torques(
    inputs: Inputs, config: Config, trajectory: str, cases: Sequence[str], in_frequency: bool = False
) -> pd.DataFrame:
    return draw.torques(
        read_identifications(inputs["identifications"]),
        _scores(inputs),
        signal_settings(config),
        numeric_settings(config),
        trajectory,
        cases,
        in_frequency=in_frequency,
    )


def _validation_trajectory(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Figure 16 shows the trajectory of the seed that stands for N1."""
    seed = median_seeds(_scores(inputs))["N1", "algorithm1"]
    return draw.trajectory(motion_of("validation", signal_settings(config), numeric_settings(config), seed))


def _id_trajectory(config: Config) -> pd.DataFrame:
    s = signal_settings(config)
    return draw.trajectory(identification_trajectory(s.duration, s.h))


def _paper_losses(inputs: Inputs, config: Config) -> pd.DataFrame:
    names = {"algorithm1": "published", "algorithm1+paper-recipe": "paper-recipe"}
    histories = (read_csv(path, HISTORY_COLUMNS) for path in inputs["histories"])
    batches = {method: training_settings(of_network(config, name)).batch for method, name in names.items()}
    return draw.held_out_losses(dict(zip(names, histories, strict=True)), batches)


def _paper_recipe(inputs: Inputs) -> pd.DataFrame:
    """Literal Algorithm 1 with the paper's training and with ours, on N1 to N4 and on the arm."""
    numeric = _scores(inputs).query("trajectory == 'ID'")
    both = pd.concat([numeric, read_scores(inputs["experiment"], SCORES)], ignore_index=True)
    return median_cells(both.query("method in ('algorithm1', 'algorithm1+paper-recipe')"))


def _ablation(inputs: Inputs) -> pd.DataFrame:
    results, losses = ({path.stem: _numbers(path) for path in inputs[key]} for key in ("results", "losses"))
    return ablation_table(results, losses)


def _numbers(path: Path) -> dict[str, Any]:
    content = read_json(path)
    if not isinstance(content, dict):
        raise InputError.at(str(path), type(content).__name__, "numbers by name")
    return content


ALL = ("N1", "N2", "N3", "N4")

FIGURE_DATA: dict[str, Callable[[Inputs, Config], pd.DataFrame]] = {
    "fig01": lambda _, __: schematics.arm(),
    "fig02": lambda _, __: schematics.hardware(),
    "fig03": lambda _, __: schematics.control(),
    "fig04": lambda _, __: schematics.method(),
    "fig05": lambda _, c: draw.subsampling(signal_settings(c), numeric_settings(c).arms["N1"]),
    "fig06": lambda _, c: _id_trajectory(c),
    "fig07": lambda _, c: architecture(network_settings(c)),
    "fig08": lambda _, c: draw.example_images(signal_settings(c), data_settings(c), training_settings(c).seed),
    "fig09": lambda _, c: draw.torque_distribution(signal_settings(c), data_settings(c), training_settings(c).seed),
    "fig10": lambda i, _: draw.loss(read_csv(i["history"][0], HISTORY_COLUMNS)),
    "fig11": lambda i, c: draw.kernel_spectra(read_weights(i["weights"][0], network_settings(c))),
    "fig12": lambda i, c: _torques(i, c, "ID", ("N1", "N2")),
    "fig13": lambda i, c: _torques(i, c, "ID", ("N3", "N4")),
    "fig14": lambda i, c: _torques(i, c, "ID", ALL, in_frequency=True),
    "fig15": lambda i, c: _torques(i, c, "validation", ALL),
    "fig16": _validation_trajectory,
    "fig17": lambda i, c: _torques(i, c, "validation", ALL, in_frequency=True),
    "metric_search": lambda i, _: _search_table(i).rename(columns={"rms_log_error_best": "rms_log_error"})[
        ["factor", "candidate", "rms_log_error", "chosen"]
    ],
    "ablation": lambda i, _: ablation_figure(read_csv(i["table"][0], ("question", "reading", *HEADLINES))),
    "paper_recipe": _paper_losses,
    **experiment.FIGURE_DATA,
}

TABLE_DATA: dict[str, Callable[[Inputs, Config], pd.DataFrame]] = {
    "table01": lambda _, __: schematics.related_work(),
    "table02": lambda _, __: parameter_description(),
    "table03": lambda _, c: network_features(network_settings(c), training_settings(c)),
    "table04": lambda i, _: parameter_table(read_identifications(i["identifications"]), _scores(i), ("N1", "N2")),
    "table05": lambda i, _: parameter_table(read_identifications(i["identifications"]), _scores(i), ("N3", "N4")),
    "table06": lambda i, _: similarity_table(_scores(i), "ID"),
    "table07": lambda i, _: similarity_table(_scores(i), "validation"),
    "metric_search": lambda i, _: _search_table(i),
    "ablation": lambda i, _: _ablation(i),
    "paper_recipe": lambda i, _: _paper_recipe(i),
    **experiment.TABLE_DATA,
}
