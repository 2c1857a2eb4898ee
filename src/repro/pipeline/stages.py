"""Stages of the numeric experiment that run no network, each for one workflow script."""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from repro.files import write_csv
from repro.pipeline.identified import read_identifications
from repro.pipeline.named import Config
from repro.pipeline.numeric import mean_training_torque, score_estimates
from repro.settings import data_settings, metric_settings, numeric_settings, signal_settings, training_settings
from repro.signals.trajectories import identification_trajectory


def mean_torque(output: str, config: Config) -> None:
    """Stage data: mean training torque, which fit2trt needs."""
    signals = signal_settings(config)
    tau = mean_training_torque(signals, data_settings(config), training_settings(config).seed)
    time = identification_trajectory(signals.duration, signals.h).time
    write_csv(Path(output), pd.DataFrame({"time": time, "joint1": tau[0], "joint2": tau[1]}))


def score_numeric(identifications: Sequence[str], output: str, config: Config) -> None:
    """Stage validate: similarity on the identification and validation trajectories."""
    runs = read_identifications([Path(p) for p in identifications])
    scores = score_estimates(runs, signal_settings(config), numeric_settings(config), metric_settings(config))
    write_csv(Path(output), scores)
