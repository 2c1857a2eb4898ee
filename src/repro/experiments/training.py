"""Train each network of the workflow, or take one that comes with the project."""

from pathlib import Path

import pandas as pd

from repro.cnn.network import on_this_processor, save_network
from repro.cnn.train import train
from repro.config.model import Configuration
from repro.config.sections import data_settings
from repro.experiments.simulated_arms import training_motion
from repro.experiments.stored_networks import CONFIGURATION, configuration_digest, model_card, network_name, take_stored
from repro.files import write_csv, write_text
from repro.progress import Progress


def train_network(
    suffix: str,
    weights: Path,
    history: Path,
    card: Path,
    checkpoint: str,
    trained_as: str,
    config: Configuration,
    motions: Path | None = None,
) -> None:
    """Write weights, history and card, stored or trained; training continues from `checkpoint`."""
    name = network_name(suffix)
    if config.training.source == "stored":
        take_stored(
            suffix, {"weights": weights, "history": history, "card": card}, config.training.networks, trained_as
        )
        return
    table = train_and_keep(name, weights, history, checkpoint, config, motions)
    precision = on_this_processor(config.training.precision)
    write_text(card, model_card(weights, table, precision, config))


def train_and_keep(
    name: str, weights: Path, history: Path | None, checkpoint: str, config: Configuration, motions: Path | None
) -> pd.DataFrame:
    """Train a network and log the progress; write its weights and, to a file, its history; return this with seconds."""
    motion, progress = training_motion(config, motions), Progress(f"training, {name}")
    data = data_settings(config)
    network, table = train(motion, data, config.network, config.training, Path(checkpoint), progress)
    save_network(weights, network, {CONFIGURATION: configuration_digest(config)})
    if history:
        write_csv(history, table.drop(columns="seconds"))
    Path(checkpoint).unlink(missing_ok=True)
    return table
