"""One function for each workflow script: read inputs, call the room that does the work, write outputs whole."""

import logging
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import torch

from repro.cnn.checkpoint import load_network, save_network
from repro.cnn.dataset import sample_motion
from repro.cnn.train import HISTORY_COLUMNS, train
from repro.errors import InputError
from repro.files import read_csv, write_csv, write_json, write_text
from repro.model.parameters import Array
from repro.pipeline.description import model_card
from repro.pipeline.identified import read_identifications
from repro.pipeline.numeric import Experiment, identify_arms, mean_training_torque, score_estimates
from repro.pipeline.outputs import FIGURE_DATA, TABLE_DATA
from repro.progress import Progress
from repro.render.figures import draw
from repro.render.tables import lay_out
from repro.settings import (
    data_settings,
    metric_settings,
    network_settings,
    numeric_settings,
    refinement_settings,
    search_settings,
    signal_settings,
    training_settings,
)
from repro.signals.trajectories import identification_trajectory, sample_times

_LOG = logging.getLogger(__name__)

Config = Mapping[str, Any]
Named = Iterable[tuple[str, str | Sequence[str]]]


def paths(named: Named) -> dict[str, list[Path]]:
    """Named inputs or outputs of a rule as lists of paths."""
    return {name: [Path(value)] if isinstance(value, str) else [Path(v) for v in value] for name, value in named}


def mean_torque(output: str, config: Config) -> None:
    """Stage data: mean training torque, which fit2trt needs."""
    signals = signal_settings(config)
    tau = mean_training_torque(signals, data_settings(config, "published"), training_settings(config, "published").seed)
    time = identification_trajectory(signals.duration, signals.h).time
    write_csv(Path(output), pd.DataFrame({"time": time, "joint1": tau[0], "joint2": tau[1]}))


def train_network(variant: str, named_outputs: Named, checkpoint: str, config: Config) -> None:
    """Stage train: weights, history and model card; continues from `checkpoint` if it is there."""
    out = {name: files[0] for name, files in paths(named_outputs).items()}
    signals, network = signal_settings(config), network_settings(config)
    data, training = data_settings(config, variant), training_settings(config, variant)
    motion = sample_motion(identification_trajectory(signals.duration, signals.h), signals)
    able = torch.cpu.get_capabilities()
    if training.precision == "bfloat16" and not any(able.get(name) for name in ("avx512_bf16", "amx_bf16", "bf16")):
        _LOG.warning("this processor has no bfloat16 arithmetic: training.precision: float32 is faster here")
    progress = Progress(f"training, {variant}")
    trained = train(
        motion,
        data,
        network,
        training,
        Path(checkpoint),
        lambda done, total, loss: progress(done, total, f"loss {loss:.2e}"),
    )
    history = pd.DataFrame(trained.history, columns=list(HISTORY_COLUMNS)).astype({"step": int})
    save_network(out["weights"], trained.network, {"variant": variant})
    write_csv(out["history"], history)
    card = model_card(out["weights"], history, network, data, training, trained.seconds_at.tolist())
    write_text(out["card"], card)
    Path(checkpoint).unlink(missing_ok=True)


def read_mean_torque(path: Path, samples: int) -> Array:
    """Mean training torque, an array of shape (2, N) with N = `samples`.

    Raises
    ------
    InputError
        If the file is missing, lacks a column, has another length, or holds a value that is not finite.
    """
    columns = ("joint1", "joint2")
    table = read_csv(path, columns)[list(columns)].apply(pd.to_numeric, errors="coerce")
    if len(table) != samples:
        raise InputError.at(f"{path}: rows", len(table), f"{samples}, one for each sample of the trajectory")
    wrong = ~np.isfinite(table.to_numpy())
    if wrong.any():
        line, column = np.argwhere(wrong)[0]
        raise InputError.at(f"{path}: line {line + 2}: {columns[column]}", "no finite number", "a torque in N m")
    tau: Array = table.to_numpy(dtype=np.float64).T
    return tau


def identify_numeric(variant: str, seed: int, named_inputs: Named, output: str, config: Config) -> None:
    """Stage identify: all arms for one seed."""
    inputs = paths(named_inputs)
    network = load_network(inputs["weights"][0], network_settings(config))
    signals = signal_settings(config)
    experiment = Experiment(
        variant,
        signals,
        data_settings(config, variant),
        search_settings(config),
        refinement_settings(config),
        numeric_settings(config),
        read_mean_torque(inputs["mean_torque"][0], sample_times(signals.duration, signals.h).size),
    )
    write_json(Path(output), identify_arms(network, experiment, seed))


def score_numeric(identifications: Sequence[str], output: str, config: Config) -> None:
    """Stage validate: similarity on the identification and validation trajectories."""
    runs = read_identifications([Path(p) for p in identifications])
    scores = score_estimates(runs, signal_settings(config), numeric_settings(config), metric_settings(config))
    write_csv(Path(output), scores)


def make_figure(name: str, named_inputs: Named, named_outputs: Named, config: Config) -> None:
    """Stage render: numbers of a figure, then the figure drawn from them."""
    out = {key: files[0] for key, files in paths(named_outputs).items()}
    write_csv(out["csv"], FIGURE_DATA[name](paths(named_inputs), config))
    draw(name, out["csv"], out["pdf"], out["png"])


def make_table(name: str, named_inputs: Named, named_outputs: Named, config: Config) -> None:
    """Stage render: a tidy table, then its TeX and Markdown layouts."""
    out = {key: files[0] for key, files in paths(named_outputs).items()}
    write_csv(out["csv"], TABLE_DATA[name](paths(named_inputs), config))
    lay_out(name, out["csv"], out["tex"], out["md"])
