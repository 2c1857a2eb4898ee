"""The experiment on the simulated arm: Tables 8 to 10, Figures 19 to 24, and the conditions of the appendix."""

from typing import Any

import pandas as pd

from repro.exhibits.declare import ARM, EXPERIMENT, Inputs, figure, table
from repro.pipeline import experiment_data
from repro.pipeline.experiment import control_constants, mechanical_parameters, program_settings
from repro.pipeline.experiment_runs import CASE, tracking
from repro.pipeline.identified import every_seed, read_identifications, read_scores
from repro.pipeline.job import Config
from repro.pipeline.recordings import Recording, read_recordings
from repro.pipeline.summary import SCORES, experiment_table, parameter_table
from repro.render import experiment, experiment_tables, result_tables
from repro.settings import metric_settings, signal_settings
from repro.signals.programs import SPAN


def _recordings(inputs: Inputs, config: Config) -> list[Recording]:
    return read_recordings(inputs["captures"], config)


def _runs(inputs: Inputs) -> list[dict[str, Any]]:
    return every_seed(read_identifications(inputs["identifications"]))


def _scores(inputs: Inputs) -> pd.DataFrame:
    return read_scores(inputs["scores"], SCORES)


def _estimates(inputs: Inputs) -> dict[str, Any]:
    return experiment_data.shown_estimates(_runs(inputs), _scores(inputs))


def _identification(inputs: Inputs, config: Config, in_frequency: bool) -> pd.DataFrame:
    (recording,) = _recordings(inputs, config)
    estimates = _estimates(inputs)
    return experiment_data.identification_figure(recording, signal_settings(config), estimates, in_frequency)


def _validation(inputs: Inputs, config: Config, in_frequency: bool) -> pd.DataFrame:
    recordings, estimates = _recordings(inputs, config), _estimates(inputs)
    return experiment_data.validation_figure(recordings, signal_settings(config), estimates, in_frequency)


@table(
    8, "Position control of the board", EXPERIMENT, experiment_tables.control, inputs=("ID",), sections=(*ARM, "metric")
)
def table08(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Constants of the simulated board and similarity of the desired and the simulated position on the identification
    trajectory (Table 8).
    """
    (recording,) = _recordings(inputs, config)
    tracked = tracking(recording, metric_settings(config))
    return experiment_data.control_table(tracked, control_constants(config), config["signals"]["filter_coefficient"])


@table(9, "Parameters of the arm", EXPERIMENT, experiment_tables.parameters, inputs=("arm",), trained="claims")
def table09(inputs: Inputs, _: Config) -> pd.DataFrame:
    """True parameters of the simulated arm and the parameters identified by each method, median seed (the paper's Table
    9 is an image).
    """
    on_id = _scores(inputs).query("case == @CASE").assign(trajectory="ID")
    table = parameter_table(_runs(inputs), on_id, (CASE,))
    return table[table["method"] != "true"].reset_index(drop=True)


@table(
    10,
    f"Similarity on the identification run and on {SPAN}",
    EXPERIMENT,
    result_tables.experiment,
    inputs=("arm",),
    trained="claims",
)
def table10(inputs: Inputs, _: Config) -> pd.DataFrame:
    """Similarity of the torques measured in the simulated experiment and rebuilt from the parameters of each method, on
    the identification trajectory and on the validation motions: the median of the seeds and the spread over the seeds
    (Table 10). The true parameters' own score is the ceiling; refinement is an extension of ours.
    """
    return experiment_table(_scores(inputs), CASE)


@table(
    "stability",
    "Conditions of the appendix",
    EXPERIMENT,
    experiment_tables.stability,
    target="stability",
    inputs=("arm",),
    sections=("arm",),
)
def stability(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Conditions of the appendix for input-to-state stability with the parameters that each method identified on the
    simulated arm.
    """
    estimates = {**_estimates(inputs), "appendix": mechanical_parameters(config)}
    return experiment_data.stability_table(estimates, ("algorithm1", *experiment_data.SHOWN, "true", "appendix"))


@figure(
    19,
    "Torques and motion of the identification run",
    EXPERIMENT,
    experiment.identification,
    inputs=(
        "ID",
        "arm",
    ),
    sections=ARM,
)
def fig19(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Simulated experiment on the identification trajectory: the torque measured and the torques rebuilt from the
    parameters of each method, with the position, velocity and acceleration of the joints (Fig. 19).
    """
    return _identification(inputs, config, in_frequency=False)


@figure(
    20,
    "Spectra of the identification run's torques",
    EXPERIMENT,
    experiment.identification_spectra,
    inputs=(
        "ID",
        "arm",
    ),
    sections=ARM,
)
def fig20(inputs: Inputs, config: Config) -> pd.DataFrame:
    """DCT-II spectra of the torques of Fig. 19, simulated experiment (Fig. 20)."""
    return _identification(inputs, config, in_frequency=True)


@figure(21, f"Paths of the tip in {SPAN}", EXPERIMENT, experiment.paths, inputs=("validation",), sections=ARM)
def fig21(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Desired and actual path of the tip on the validation motions of the simulated arm (Fig. 21)."""
    return experiment_data.paths_figure(_recordings(inputs, config), program_settings(config).geometry)


@figure(22, f"Motions of {SPAN}", EXPERIMENT, experiment.validation_motion, inputs=("validation",), sections=ARM)
def fig22(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Position, velocity and acceleration on the validation motions of the simulated arm (Fig. 22)."""
    return experiment_data.motions_figure(_recordings(inputs, config), signal_settings(config))


@figure(
    23,
    f"Torques of {SPAN}",
    EXPERIMENT,
    experiment.validation_torques,
    inputs=(
        "validation",
        "arm",
    ),
    sections=ARM,
)
def fig23(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Torques measured on the validation motions of the simulated arm and rebuilt from the parameters of each method
    (Fig. 23).
    """
    return _validation(inputs, config, in_frequency=False)


@figure(
    24,
    f"Spectra of the torques of {SPAN}",
    EXPERIMENT,
    experiment.validation_spectra,
    inputs=(
        "validation",
        "arm",
    ),
    sections=ARM,
)
def fig24(inputs: Inputs, config: Config) -> pd.DataFrame:
    """DCT-II spectra of the torques of Fig. 23, simulated experiment; each row ends with the last band that matters in
    it (Fig. 24).
    """
    return _validation(inputs, config, in_frequency=True)
