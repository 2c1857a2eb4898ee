"""Stages of the experiment that run no network, each for one workflow script."""

from collections.abc import Sequence
from pathlib import Path

from repro.files import write_csv, write_json
from repro.pipeline.acquire import acquire
from repro.pipeline.experiment import true_parameters
from repro.pipeline.experiment_runs import every_seed, least_squares_of, score_runs
from repro.pipeline.identified import read_identifications
from repro.pipeline.named import Config, Named, paths
from repro.pipeline.recordings import read_recording
from repro.pipeline.spread import simulate_spread
from repro.settings import metric_settings, signal_settings


def acquire_capture(motion: str, outputs: Sequence[str], config: Config) -> None:
    """Stage acquire: the capture of one motion and its sidecar."""
    acquire(motion, Path(outputs[0]), config)


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
