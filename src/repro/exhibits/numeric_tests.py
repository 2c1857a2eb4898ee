"""The numeric tests N1 to N4: Tables 2 and 4 to 7, Figures 5, 6 and 12 to 17, and the paper's own training."""

from collections.abc import Sequence

import pandas as pd

from repro.cnn.schedule import HISTORY_COLUMNS
from repro.exhibits.declare import ABLATION, MODEL, NUMERIC, SIGNALS, VALIDATION, Inputs, figure, table
from repro.exhibits.markup import Table, formula, plain, unit
from repro.files import read_csv
from repro.model.parameters import DESCRIPTIONS, EXPRESSIONS, NAMES, UNITS
from repro.pipeline import figure_data
from repro.pipeline.identified import every_seed, read_identifications, read_scores
from repro.pipeline.job import Config
from repro.pipeline.numeric import motion_of
from repro.pipeline.summary import SCORES, median_cells, median_seeds, parameter_table, similarity_table
from repro.render import lines, result_tables, torques
from repro.settings import numeric_settings, of_network, signal_settings, training_settings
from repro.signals.trajectories import identification_trajectory

_NUMERIC = ("signals", "numeric")
_ALL = ("N1", "N2", "N3", "N4")


def _scores(inputs: Inputs) -> pd.DataFrame:
    return read_scores(inputs["scores"])


def _parameters(inputs: Inputs, cases: Sequence[str]) -> pd.DataFrame:
    return parameter_table(every_seed(read_identifications(inputs["identifications"])), _scores(inputs), cases)


def _torques(
    inputs: Inputs, config: Config, trajectory: str, cases: Sequence[str], in_frequency: bool = False
) -> pd.DataFrame:
    return figure_data.torques(
        read_identifications(inputs["identifications"]),
        _scores(inputs),
        signal_settings(config),
        numeric_settings(config),
        trajectory,
        cases,
        in_frequency=in_frequency,
    )


def description(frame: pd.DataFrame) -> Table:
    """Dynamic parameters (Table 2)."""
    columns = ["parameter", "description", "expression", "unit"]
    rows = [
        (formula(name), plain(description), formula(expression), unit(si))
        for name, description, expression, si in frame[columns].itertuples(index=False)
    ]
    header = tuple(plain(name) for name in ("Parameter", "Description", "Expression", "Unit"))
    return Table("Table 2", "tab:table02", plain("Dynamic parameters of the arm."), "llll", header, [(None, rows)])


@table(2, "Dynamic parameters", MODEL, description)
def table02(_: Inputs, __: Config) -> pd.DataFrame:
    """The nine dynamic parameters, rebuilt from Eq. 1 (the paper's Table 2 is an image)."""
    return pd.DataFrame({"parameter": NAMES, "description": DESCRIPTIONS, "expression": EXPRESSIONS, "unit": UNITS})


@figure(5, "Subsampling technique", SIGNALS, lines.subsampling, sections=_NUMERIC)
def fig05(_: Inputs, config: Config) -> pd.DataFrame:
    """Subsampling with the DCT-II: the torque of joint 1 of arm N1 on the identification trajectory, its spectrum cut
    to 100 bands, and the subsampled torque (Fig. 5 of the paper).
    """
    return figure_data.subsampling(signal_settings(config), numeric_settings(config).arms["N1"])


@figure(6, "Identification trajectory", SIGNALS, lines.motion, sections=("signals",))
def fig06(_: Inputs, config: Config) -> pd.DataFrame:
    """Identification trajectory of Eq. 10 with its exact derivatives (Fig. 6)."""
    signals = signal_settings(config)
    return figure_data.trajectory(identification_trajectory(signals.duration, signals.h))


@table(4, "Parameters of N1 and N2", NUMERIC, result_tables.parameters_12, inputs=("networks",), trained="claims")
def table04(inputs: Inputs, _: Config) -> pd.DataFrame:
    """True and identified parameters of N1 and N2: median seed and spread over the seeds."""
    return _parameters(inputs, ("N1", "N2"))


@table(5, "Parameters of N3 and N4", NUMERIC, result_tables.parameters_34, inputs=("networks",), trained="claims")
def table05(inputs: Inputs, _: Config) -> pd.DataFrame:
    """True and identified parameters of N3 and N4: median seed and spread over the seeds."""
    return _parameters(inputs, ("N3", "N4"))


@table(
    6,
    "Similarity on the identification trajectory",
    NUMERIC,
    result_tables.similarity,
    inputs=("networks",),
    trained="claims",
)
def table06(inputs: Inputs, _: Config) -> pd.DataFrame:
    """Similarity of the numeric torques and their rebuilding on the identification trajectory: the median of the seeds
    in each cell and the spread over the seeds. The refinement is an extension of ours; the local search is its control.
    """
    return similarity_table(_scores(inputs), "ID")


@table(
    7,
    "Similarity on the validation trajectory",
    VALIDATION,
    result_tables.validation,
    inputs=("networks",),
    trained="claims",
)
def table07(inputs: Inputs, _: Config) -> pd.DataFrame:
    """Similarity on the random validation trajectory: the median of the seeds in each cell and the spread over the
    seeds. The refinement is an extension of ours; the local search is its control.
    """
    return similarity_table(_scores(inputs), "validation")


@figure(12, "Torques of N1 and N2", NUMERIC, torques.torques_12, inputs=("published",), sections=_NUMERIC)
def fig12(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Torques of N1 and N2 and their rebuilding from the parameters that Algorithm 1 identified,
    median seed (Fig. 12).
    """
    return _torques(inputs, config, "ID", ("N1", "N2"))


@figure(13, "Torques of N3 and N4", NUMERIC, torques.torques_34, inputs=("published",), sections=_NUMERIC)
def fig13(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Torques of N3 and N4 and their rebuilding from the parameters that Algorithm 1 identified,
    median seed (Fig. 13).
    """
    return _torques(inputs, config, "ID", ("N3", "N4"))


@figure(
    14,
    "Spectra of the numeric torques",
    NUMERIC,
    torques.spectra_all,
    inputs=("published",),
    sections=_NUMERIC,
    trained="all",
)
def fig14(inputs: Inputs, config: Config) -> pd.DataFrame:
    """DCT-II spectra of the torques of Fig. 12 and 13 (Fig. 14)."""
    return _torques(inputs, config, "ID", _ALL, in_frequency=True)


@figure(
    15, "Validation torques", VALIDATION, torques.torques_all, inputs=("published",), sections=_NUMERIC, trained="all"
)
def fig15(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Torques on the random validation trajectory and their rebuilding, median seed (Fig. 15)."""
    return _torques(inputs, config, "validation", _ALL)


@figure(
    16,
    "Validation trajectory",
    VALIDATION,
    lines.random_motion,
    inputs=("published",),
    sections=_NUMERIC,
    trained="all",
)
def fig16(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Random validation trajectory of the seed that stands for N1 (Fig. 16)."""
    seed = median_seeds(_scores(inputs))["N1", "algorithm1"]
    return figure_data.trajectory(motion_of("validation", signal_settings(config), numeric_settings(config), seed))


@figure(
    17,
    "Spectra of the validation torques",
    VALIDATION,
    torques.spectra_all,
    inputs=("published",),
    sections=_NUMERIC,
    trained="all",
)
def fig17(inputs: Inputs, config: Config) -> pd.DataFrame:
    """DCT-II spectra of the validation torques (Fig. 17)."""
    return _torques(inputs, config, "validation", _ALL, in_frequency=True)


@table(
    "paper_recipe",
    "Literal Algorithm 1 with it",
    ABLATION,
    result_tables.paper_recipe,
    label="The paper's training",
    inputs=("paper_recipe",),
    optional=True,
)
def paper_recipe_table(inputs: Inputs, _: Config) -> pd.DataFrame:
    """Similarity of the literal Algorithm 1 on N1 to N4 (identification trajectory) and on the simulated arm with a
    network trained by the paper's own schedule, 500,000 iterations of one image each, and with ours.
    """
    numeric = _scores(inputs).query("trajectory == 'ID'")
    both = pd.concat([numeric, read_scores(inputs["experiment"], SCORES)], ignore_index=True)
    return median_cells(both.query("method in ('algorithm1', 'algorithm1+paper-recipe')"))


@figure(
    "paper_recipe",
    "Loss beside ours",
    ABLATION,
    lines.held_out_losses,
    label="The paper's training",
    inputs=("losses",),
    sections=("training", "networks"),
    trained="all",
    optional=True,
)
def paper_recipe_figure(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Loss on held-out images over the number of images trained on: the paper's own schedule, iterated in full, beside
    ours.
    """
    names = {"algorithm1": "published", "algorithm1+paper-recipe": "paper-recipe"}
    histories = (read_csv(path, HISTORY_COLUMNS) for path in inputs["histories"])
    batches = {method: training_settings(of_network(config, name)).batch for method, name in names.items()}
    return figure_data.held_out_losses(dict(zip(names, histories, strict=True)), batches)
