"""Networks of the workflow: training of one, with its history and model card, and Algorithm 1 with a trained one."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import pandas as pd

from repro.cnn.architecture import HISTORY_COLUMNS
from repro.cnn.network import load_network, on_this_processor, save_network
from repro.cnn.train import train
from repro.files import write_csv, write_text
from repro.identification.algorithm1.refinement import Algorithm1
from repro.pipeline.job import Config
from repro.pipeline.model_card import model_card
from repro.pipeline.stored_networks import CONFIGURATION, configuration_digest, take_stored
from repro.pipeline.tracked import describe_motions, training_motion
from repro.progress import Progress
from repro.settings import data_settings, network_settings, refinement_settings, search_settings, training_settings


def algorithm1_of(variant: str, weights: str, config: Config, digest: str) -> Algorithm1:
    """Algorithm 1 with a trained network, whose weights must state the configuration `digest`."""
    network = load_network(Path(weights), network_settings(config), digest, training_settings(config).precision)
    image, search = data_settings(config).image, search_settings(config)
    return Algorithm1(variant, network, image, search, refinement_settings(config))


def for_the_arm(algorithm1: Algorithm1, config: Config) -> Algorithm1:
    """The same with the threshold of the experiment."""
    return replace(algorithm1, search=replace(algorithm1.search, threshold=config["experiment"]["threshold"]))


def train_network(
    name: str, output: Mapping[str, str], checkpoint: str, config: Config, motions: str | None = None
) -> None:
    """Write ``weights``, ``history`` and ``card``, stored or trained; training continues from `checkpoint`."""
    out = {what: Path(file) for what, file in output.items()}
    if config["training"]["source"] == "stored" and not name.startswith("paper-recipe"):
        take_stored(name, out, config)
        return
    history, seconds = train_and_keep(name, out["weights"], out["history"], checkpoint, config, motions)
    network, data, training = network_settings(config), data_settings(config), training_settings(config)
    training = replace(training, precision=on_this_processor(training.precision))
    card = model_card(out["weights"], history, network, data, training, seconds, describe_motions(config))
    write_text(out["card"], card)
    Path(checkpoint).unlink(missing_ok=True)


def train_and_keep(
    name: str, weights: Path, history: Path, checkpoint: str, config: Config, motions: str | None
) -> tuple[pd.DataFrame, list[float]]:
    """Train a network, saying how far it is; write its weights and its history, and return this with its seconds."""
    progress = Progress(f"training, {name}")
    trained = train(
        training_motion(config, Path(motions) if motions else None),
        data_settings(config),
        network_settings(config),
        training_settings(config),
        Path(checkpoint),
        lambda done, total, loss: progress(done, total, f"loss {loss:.2e}"),
    )
    table = pd.DataFrame(trained.history, columns=list(HISTORY_COLUMNS)).astype({"step": int})
    save_network(weights, trained.network, {CONFIGURATION: configuration_digest(config)})
    write_csv(history, table)
    return table, trained.seconds_at.tolist()
