"""The numeric tests N1 to N4: Tables 4 to 7, Figures 12 to 17, and the paper's own training."""

from collections.abc import Sequence

import pandas as pd

from repro.cnn.schedule import HISTORY_COLUMNS
from repro.exhibits.inputs import SCORES, Family, Inputs, Made
from repro.files import read_csv
from repro.pipeline import figure_data as data
from repro.pipeline.identified import every_seed, read_identifications, read_scores
from repro.pipeline.job import Config
from repro.pipeline.numeric import motion_of
from repro.pipeline.summary import median_cells, median_seeds, parameter_table, similarity_table
from repro.render import lines, result_tables, torques
from repro.settings import numeric_settings, of_network, signal_settings, training_settings

ALL = ("N1", "N2", "N3", "N4")


def _scores(inputs: Inputs) -> pd.DataFrame:
    return read_scores(inputs["scores"])


def _parameters(inputs: Inputs, cases: Sequence[str]) -> pd.DataFrame:
    return parameter_table(every_seed(read_identifications(inputs["identifications"])), _scores(inputs), cases)


def _torques(
    inputs: Inputs, config: Config, trajectory: str, cases: Sequence[str], in_frequency: bool = False
) -> pd.DataFrame:
    return data.torques(
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
    return data.trajectory(motion_of("validation", signal_settings(config), numeric_settings(config), seed))


def _paper_losses(inputs: Inputs, config: Config) -> pd.DataFrame:
    names = {"algorithm1": "published", "algorithm1+paper-recipe": "paper-recipe"}
    histories = (read_csv(path, HISTORY_COLUMNS) for path in inputs["histories"])
    batches = {method: training_settings(of_network(config, name)).batch for method, name in names.items()}
    return data.held_out_losses(dict(zip(names, histories, strict=True)), batches)


def _paper_recipe(inputs: Inputs) -> pd.DataFrame:
    """Literal Algorithm 1 with the paper's training and with ours, on N1 to N4 and on the arm."""
    numeric = _scores(inputs).query("trajectory == 'ID'")
    both = pd.concat([numeric, read_scores(inputs["experiment"], SCORES)], ignore_index=True)
    return median_cells(both.query("method in ('algorithm1', 'algorithm1+paper-recipe')"))


MADE: Family = {
    ("table", "table04"): Made(lambda i, _: _parameters(i, ("N1", "N2")), result_tables.parameters_12),
    ("table", "table05"): Made(lambda i, _: _parameters(i, ("N3", "N4")), result_tables.parameters_34),
    ("table", "table06"): Made(lambda i, _: similarity_table(_scores(i), "ID"), result_tables.similarity),
    ("table", "table07"): Made(lambda i, _: similarity_table(_scores(i), "validation"), result_tables.validation),
    ("figure", "fig12"): Made(lambda i, c: _torques(i, c, "ID", ("N1", "N2")), torques.torques_12),
    ("figure", "fig13"): Made(lambda i, c: _torques(i, c, "ID", ("N3", "N4")), torques.torques_34),
    ("figure", "fig14"): Made(lambda i, c: _torques(i, c, "ID", ALL, in_frequency=True), torques.spectra_all),
    ("figure", "fig15"): Made(lambda i, c: _torques(i, c, "validation", ALL), torques.torques_all),
    ("figure", "fig16"): Made(_validation_trajectory, lines.random_motion),
    ("figure", "fig17"): Made(lambda i, c: _torques(i, c, "validation", ALL, in_frequency=True), torques.spectra_all),
    ("table", "paper_recipe"): Made(lambda i, _: _paper_recipe(i), result_tables.paper_recipe),
    ("figure", "paper_recipe"): Made(_paper_losses, lines.held_out_losses),
}
