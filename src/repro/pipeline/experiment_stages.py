"""One function for each workflow script of the experiment."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd

from repro.cnn.checkpoint import load_network
from repro.files import write_csv, write_json
from repro.pipeline.acquire import acquire, read_recording
from repro.pipeline.experiment import true_parameters
from repro.pipeline.experiment_runs import (
    every_seed,
    identify_recording,
    least_squares_of,
    score_runs,
)
from repro.pipeline.identified import read_identifications
from repro.pipeline.methods import Identifier
from repro.pipeline.spread import read_spread, simulate_spread
from repro.pipeline.stages import Named, paths, read_mean_torque
from repro.progress import Progress
from repro.settings import (
    data_settings,
    metric_settings,
    network_settings,
    refinement_settings,
    search_settings,
    signal_settings,
)
from repro.signals.trajectories import sample_times

Config = Mapping[str, Any]


def acquire_capture(motion: str, outputs: Sequence[str], config: Config) -> None:
    """Stage acquire: the capture of one motion and its sidecar."""
    acquire(motion, Path(outputs[0]), config)


def _identifier(variant: str, weights: Path, config: Config) -> Identifier:
    return Identifier(
        variant,
        load_network(weights, network_settings(config)),
        data_settings(config, variant).image,
        replace(search_settings(config), threshold=config["experiment"]["threshold"]),
        refinement_settings(config),
    )


def identify_experiment(variant: str, seed: int, named_inputs: Named, output: str, config: Config) -> None:
    """Stage identify: Algorithm 1 and its refinement on the recording of the identification trajectory."""
    inputs = paths(named_inputs)
    signals = signal_settings(config)
    tau_mean = read_mean_torque(inputs["mean_torque"][0], sample_times(signals.duration, signals.h).size)
    recording = read_recording(inputs["captures"][0], config)
    identifier = _identifier(variant, inputs["weights"][0], config)
    run = identify_recording(identifier, recording, tau_mean, signals, seed, true_parameters(config))
    write_json(Path(output), run)


def identify_least_squares(named_inputs: Named, output: str, config: Config) -> None:
    """Stage identify: least squares on the same signals."""
    recording = read_recording(paths(named_inputs)["captures"][0], config)
    write_json(Path(output), least_squares_of(recording, signal_settings(config), true_parameters(config)))


def score_experiment(named_inputs: Named, output: str, config: Config) -> None:
    """Stage validate: similarity of every run on all five motions."""
    inputs = paths(named_inputs)
    runs = every_seed(read_identifications(inputs["identifications"]))
    recordings = [read_recording(path, config) for path in inputs["captures"] if path.suffix == ".bin"]
    write_csv(Path(output), score_runs(runs, recordings, signal_settings(config), metric_settings(config)))


def simulate_specimens(output: str, config: Config) -> None:
    """Stage acquire: recordings of every specimen of the spread."""
    simulate_spread(config, Path(output))


def score_specimens(index: int, named_inputs: Named, output: str, config: Config) -> None:
    """Stages identify and validate for every specimen of the spread and one identification duration."""
    inputs = paths(named_inputs)
    signals = signal_settings(config)
    tau_mean = read_mean_torque(inputs["mean_torque"][0], sample_times(signals.duration, signals.h).size)
    identifier = _identifier("published", inputs["weights"][0], config)
    duration, true = config["spread"]["durations_s"][index], true_parameters(config)
    specimens = read_spread(inputs["recordings"][0], config, index)
    progress = Progress(f"spread, identification of {duration:.4g} s")
    frames = []
    for k, (seed, recordings) in enumerate(specimens):
        runs = [
            identify_recording(identifier, recordings["ID"], tau_mean, signals, seed, true),
            {**least_squares_of(recordings["ID"], signals, true), "seed": seed},
        ]
        scores = score_runs(runs, list(recordings.values()), signals, metric_settings(config))
        frames.append(scores.assign(duration=duration))
        progress(k + 1, len(specimens))
    table = pd.concat(frames, ignore_index=True)
    write_csv(Path(output), table[["case", "joint", "method", "duration", "seed", "time", "frequency", "total"]])
