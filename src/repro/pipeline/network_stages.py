"""The stages that run a network, each for one workflow script: the only ones that load torch."""

import logging
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from repro.cnn.checkpoint import load_network, save_network
from repro.cnn.factored import FactoredCNN
from repro.cnn.schedule import HISTORY_COLUMNS
from repro.cnn.train import on_this_processor, train
from repro.errors import InputError
from repro.files import read_csv, write_csv, write_json, write_text
from repro.model.parameters import Array
from repro.pipeline.coverage import coverage
from repro.pipeline.description import model_card
from repro.pipeline.experiment import true_parameters
from repro.pipeline.experiment_runs import identify_recording, least_squares_of, score_runs
from repro.pipeline.methods import Identifier
from repro.pipeline.named import Config, Named, paths
from repro.pipeline.numeric_identification import Experiment, identify_arms
from repro.pipeline.recordings import read_recording
from repro.pipeline.spread import read_spread
from repro.pipeline.stored_networks import CONFIGURATION, configuration_digest, take_stored
from repro.pipeline.tracked import describe_motions, training_motion
from repro.pipeline.why import explain
from repro.progress import Progress
from repro.settings import (
    data_settings,
    metric_settings,
    network_settings,
    numeric_settings,
    of_network,
    refinement_settings,
    search_settings,
    signal_settings,
    training_settings,
)
from repro.signals.trajectories import sample_times

_LOG = logging.getLogger(__name__)


def train_network(name: str, named_inputs: Named, named_outputs: Named, checkpoint: str, config: Config) -> None:
    """Stage train: weights, history and model card, stored or trained; training continues from `checkpoint`."""
    out = {name: files[0] for name, files in paths(named_outputs).items()}
    if config["training"]["source"] == "stored" and name != "paper-recipe":
        take_stored(name, out, config)
        return
    network = network_settings(config)
    data, training = data_settings(config), on_this_processor(training_settings(config))
    motion = training_motion(config, *paths(named_inputs).get("motions", []))
    progress = Progress(f"training, {name}")
    trained = train(
        motion,
        data,
        network,
        training,
        Path(checkpoint),
        lambda done, total, loss: progress(done, total, f"loss {loss:.2e}"),
    )
    history = pd.DataFrame(trained.history, columns=list(HISTORY_COLUMNS)).astype({"step": int})
    save_network(out["weights"], trained.network, {CONFIGURATION: configuration_digest(config)})
    write_csv(out["history"], history)
    motions = describe_motions(config)
    card = model_card(out["weights"], history, network, data, training, trained.seconds_at.tolist(), motions)
    write_text(out["card"], card)
    Path(checkpoint).unlink(missing_ok=True)


def read_mean_torque(path: Path, samples: int) -> Array:
    """Mean training torque, an array of shape (2, N) with N = `samples`."""
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


def identify_numeric(
    variant: str, seeds: Sequence[int], named_inputs: Named, outputs: Sequence[str], config: Config
) -> None:
    """Stage identify: all arms, one output for each seed."""
    inputs = paths(named_inputs)
    network = load_network(inputs["weights"][0], network_settings(config))
    signals = signal_settings(config)
    experiment = Experiment(
        variant,
        signals,
        data_settings(config),
        search_settings(config),
        refinement_settings(config),
        numeric_settings(config),
        read_mean_torque(inputs["mean_torque"][0], sample_times(signals.duration, signals.h).size),
    )
    for seed, output in zip(seeds, outputs, strict=True):
        write_json(Path(output), identify_arms(network, experiment, seed))


def identifier_of(variant: str, network: FactoredCNN, config: Config) -> Identifier:
    """A trained network with the experiment's settings."""
    return Identifier(
        variant,
        network,
        data_settings(config).image,
        replace(search_settings(config), threshold=config["experiment"]["threshold"]),
        refinement_settings(config),
    )


def identify_experiment(
    variant: str, seeds: Sequence[int], named_inputs: Named, outputs: Sequence[str], config: Config
) -> None:
    """Stage identify: all methods on the recording of the identification trajectory, one output for each seed."""
    inputs = paths(named_inputs)
    signals = signal_settings(config)
    tau_mean = read_mean_torque(inputs["mean_torque"][0], sample_times(signals.duration, signals.h).size)
    recording = read_recording(inputs["captures"][0], config)
    identifier = identifier_of(variant, load_network(inputs["weights"][0], network_settings(config)), config)
    for seed, output in zip(seeds, outputs, strict=True):
        run = identify_recording(identifier, recording, tau_mean, signals, seed, true_parameters(config))
        write_json(Path(output), run)


def explain_network(variant: str, named_inputs: Named, output: str, config: Config) -> None:
    """Stage identify: the search of one network on every step from the ideal case to the recording."""
    inputs = paths(named_inputs)
    signals = signal_settings(config)
    tau_mean = read_mean_torque(inputs["mean_torque"][0], sample_times(signals.duration, signals.h).size)
    identifier = identifier_of(variant, load_network(inputs["weights"][0], network_settings(config)), config)
    write_csv(Path(output), explain(identifier, tau_mean, config["why"]["seeds"], config))


def check_coverage(named_inputs: Named, named_outputs: Named, config: Config) -> None:
    """Stage validate: whether the intervals of the network of tracked motions cover."""
    inputs = paths(named_inputs)
    signals = signal_settings(config)
    tau_mean = read_mean_torque(inputs["mean_torque"][0], sample_times(signals.duration, signals.h).size)
    identifier = identifier_of("tracked", load_network(inputs["weights"][0], network_settings(config)), config)
    recording = read_recording(inputs["captures"][0], config)
    tables = coverage(identifier, inputs["motions"][0], recording, tau_mean, config)
    for name, files in paths(named_outputs).items():
        write_csv(files[0], tables[name])


def score_specimens(index: int, named_inputs: Named, output: str, config: Config) -> None:
    """Stages identify and validate for every specimen of the spread and one identification duration."""
    inputs = paths(named_inputs)
    signals = signal_settings(config)
    tau_mean = read_mean_torque(inputs["mean_torque"][0], sample_times(signals.duration, signals.h).size)
    names = dict(zip(("published", "tracked"), inputs["weights"], strict=True))
    identifiers = [
        identifier_of(name, load_network(weights, network_settings(config)), of_network(config, name))
        for name, weights in names.items()
    ]
    duration = config["spread"]["durations_s"][index]
    specimens = read_spread(inputs["recordings"][0], config, index)
    progress = Progress(f"spread, identification of {duration:.4g} s")
    frames = []
    for k, one in enumerate(specimens):
        recorded = one.recordings["ID"]
        runs = [identify_recording(each, recorded, tau_mean, signals, one.seed, one.true) for each in identifiers]
        runs.append({**least_squares_of(recorded, signals, one.true), "seed": one.seed})
        scores = score_runs(runs, list(one.recordings.values()), signals, metric_settings(config))
        frames.append(scores.assign(duration=duration, arm=one.arm))
        progress(k + 1, len(specimens))
    table = pd.concat(frames, ignore_index=True)
    write_csv(Path(output), table[["case", "joint", "method", "duration", "arm", "seed", "time", "frequency", "total"]])
