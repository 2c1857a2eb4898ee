"""Training of one network of the workflow: its weights, its history and its model card."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import pandas as pd

from repro.cnn.checkpoint import save_network
from repro.cnn.factored import on_this_processor
from repro.cnn.schedule import HISTORY_COLUMNS
from repro.cnn.train import Trained, train
from repro.files import write_csv, write_text
from repro.pipeline.description import model_card
from repro.pipeline.job import Config
from repro.pipeline.stored_networks import CONFIGURATION, configuration_digest, take_stored
from repro.pipeline.tracked import describe_motions, training_motion
from repro.progress import Progress
from repro.settings import data_settings, network_settings, training_settings


def train_network(
    name: str, output: Mapping[str, str], checkpoint: str, config: Config, motions: str | None = None
) -> None:
    """Write ``weights``, ``history`` and ``card``, stored or trained; training continues from `checkpoint`."""
    out = {what: Path(file) for what, file in output.items()}
    if config["training"]["source"] == "stored" and name != "paper-recipe":
        take_stored(name, out, config)
        return
    trained = trained_as_configured(config, motions, checkpoint, name)
    history = pd.DataFrame(trained.history, columns=list(HISTORY_COLUMNS)).astype({"step": int})
    save_network(out["weights"], trained.network, {CONFIGURATION: configuration_digest(config)})
    write_csv(out["history"], history)
    network, data, training = network_settings(config), data_settings(config), training_settings(config)
    training = replace(training, precision=on_this_processor(training.precision))
    seconds, said = trained.seconds_at.tolist(), describe_motions(config)
    write_text(out["card"], model_card(out["weights"], history, network, data, training, seconds, said))
    Path(checkpoint).unlink(missing_ok=True)


def trained_as_configured(config: Config, motions: str | None, checkpoint: str, name: str) -> Trained:
    """Train a network, from its checkpoint on if there is one, and say how far it is."""
    progress = Progress(f"training, {name}")
    return train(
        training_motion(config, Path(motions) if motions else None),
        data_settings(config),
        network_settings(config),
        training_settings(config),
        Path(checkpoint),
        lambda done, total, loss: progress(done, total, f"loss {loss:.2e}"),
    )
