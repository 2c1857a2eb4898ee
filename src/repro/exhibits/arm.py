"""The simulated arm: Tables 8 to 10, Figures 18 to 24, and the conditions of the appendix."""

from typing import Any

import pandas as pd

from repro.exhibits.inputs import Family, Inputs, Made, arm_scores
from repro.pipeline import experiment_data as data
from repro.pipeline.experiment import control_constants, mechanical_parameters, program_settings
from repro.pipeline.experiment_runs import CASE, tracking
from repro.pipeline.identified import every_seed, read_identifications
from repro.pipeline.job import Config
from repro.pipeline.recordings import Recording, read_recordings
from repro.pipeline.summary import experiment_table, parameter_table
from repro.render import experiment, experiment_setup, experiment_tables, result_tables
from repro.settings import metric_settings, signal_settings


def _recordings(inputs: Inputs, config: Config) -> list[Recording]:
    return read_recordings(inputs["captures"], config)


def _runs(inputs: Inputs) -> list[dict[str, Any]]:
    return every_seed(read_identifications(inputs["identifications"]))


def _estimates(inputs: Inputs) -> dict[str, Any]:
    return data.shown_estimates(_runs(inputs), arm_scores(inputs))


def _identification(inputs: Inputs, config: Config, in_frequency: bool) -> pd.DataFrame:
    (recording,) = _recordings(inputs, config)
    return data.identification_figure(recording, signal_settings(config), _estimates(inputs), in_frequency)


def _validation(inputs: Inputs, config: Config, in_frequency: bool) -> pd.DataFrame:
    return data.validation_figure(
        _recordings(inputs, config), signal_settings(config), _estimates(inputs), in_frequency
    )


def _setup(config: Config) -> pd.DataFrame:
    settings = program_settings(config)
    return data.setup_figure(control_constants(config), settings.geometry, settings.h)


def _control(inputs: Inputs, config: Config) -> pd.DataFrame:
    (recording,) = _recordings(inputs, config)
    tracked = tracking(recording, metric_settings(config))
    return data.control_table(tracked, control_constants(config), config["signals"]["filter_coefficient"])


def _parameters(inputs: Inputs) -> pd.DataFrame:
    on_id = arm_scores(inputs).query("case == @CASE").assign(trajectory="ID")
    table = parameter_table(_runs(inputs), on_id, (CASE,))
    return table[table["method"] != "true"].reset_index(drop=True)


MADE: Family = {
    ("table", "table08"): Made(_control, experiment_tables.control),
    ("table", "table09"): Made(lambda i, _: _parameters(i), experiment_tables.parameters),
    ("table", "table10"): Made(lambda i, _: experiment_table(arm_scores(i), CASE), result_tables.experiment),
    ("table", "stability"): Made(
        lambda i, c: data.stability_table(
            {**_estimates(i), "appendix": mechanical_parameters(c)},
            ("algorithm1", *data.SHOWN, "true", "appendix"),
        ),
        experiment_tables.stability,
    ),
    ("figure", "fig18"): Made(lambda _, c: _setup(c), experiment_setup.setup),
    ("figure", "fig19"): Made(lambda i, c: _identification(i, c, in_frequency=False), experiment.identification),
    ("figure", "fig20"): Made(lambda i, c: _identification(i, c, in_frequency=True), experiment.identification_spectra),
    ("figure", "fig21"): Made(
        lambda i, c: data.paths_figure(_recordings(i, c), program_settings(c).geometry),
        experiment.paths,
    ),
    ("figure", "fig22"): Made(
        lambda i, c: data.motions_figure(_recordings(i, c), signal_settings(c)),
        experiment.validation_motion,
    ),
    ("figure", "fig23"): Made(lambda i, c: _validation(i, c, in_frequency=False), experiment.validation_torques),
    ("figure", "fig24"): Made(lambda i, c: _validation(i, c, in_frequency=True), experiment.validation_spectra),
}
