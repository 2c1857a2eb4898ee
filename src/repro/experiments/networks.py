"""Identify the numeric arms, the arm and the accepted experiments with networks."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd

from repro.cnn.network import load_network
from repro.config.model import Configuration
from repro.config.sections import of_network, search_settings
from repro.experiments.accepted import of_this_unit, read_accepted
from repro.experiments.arm import read_recordings, true_parameters
from repro.experiments.identifications import (
    identify_arms,
    identify_recording,
    least_squares_of,
    read_mean_torque,
    score_runs,
)
from repro.experiments.stored_networks import network_name
from repro.identification.algorithm1.refinement import Algorithm1
from repro.progress import over


def algorithm1_of(variant: str, weights: Path, config: Configuration, digest: str | None = None) -> Algorithm1:
    """Algorithm 1 with a trained network, whose weights must state the configuration `digest` if there is one."""
    network = load_network(weights, config.network, digest, config.training.precision)
    return Algorithm1(variant, network, config.image, search_settings(config), config.refinement)


def for_the_arm(algorithm1: Algorithm1, config: Configuration) -> Algorithm1:
    """The same with the threshold of the experiment."""
    return replace(algorithm1, search=replace(algorithm1.search, threshold=config.experiment.threshold))


def with_limit(algorithm1: Algorithm1, inner_limit: int) -> Algorithm1:
    """The same with another number of guesses in an execution."""
    return replace(algorithm1, search=replace(algorithm1.search, inner_limit=inner_limit))


def identify_numeric(
    suffix: str, weights: Path, mean_torque: Path, seeds: Sequence[int], trained_as: str, config: Configuration
) -> list[dict[str, Any]]:
    """All numeric arms for one network and every seed."""
    tau_mean = read_mean_torque(mean_torque, config.signals)
    algorithm1 = algorithm1_of(network_name(suffix), weights, config, trained_as)
    return [identify_arms(algorithm1, config, tau_mean, seed) for seed in seeds]


def identify_experiment(
    suffix: str,
    captures: Sequence[Path],
    weights: Path,
    mean_torque: Path,
    seeds: Sequence[int],
    trained_as: str,
    config: Configuration,
) -> list[dict[str, Any]]:
    """The arm's parameters by Algorithm 1 and its refinement, one network and every seed."""
    signals, true = config.signals, true_parameters(config)
    tau_mean = read_mean_torque(mean_torque, signals)
    (recording,) = read_recordings(captures, config)
    algorithm1 = for_the_arm(algorithm1_of(network_name(suffix), weights, config, trained_as), config)
    return [identify_recording(algorithm1, recording, tau_mean, signals, seed, true) for seed in seeds]


def score_spread(
    experiments: Path,
    recordings: Path,
    weights: Sequence[Path],
    mean_torque: Path,
    trained_as: Mapping[str, str],
    config: Configuration,
) -> pd.DataFrame:
    """Similarity of every method on every motion of every accepted experiment with this unit of omega."""
    signals, limit = config.signals, config.spread.inner_limit
    tau_mean, chosen = read_mean_torque(mean_torque, signals), read_accepted(experiments, recordings, config)
    networks = [
        with_limit(for_the_arm(algorithm1_of(name, file, of_network(config, name), digest), config), limit)
        for file, (name, digest) in zip(weights, trained_as.items(), strict=True)
    ]
    frames = []
    for one in over(of_this_unit(chosen, config), "methods on accepted experiments"):
        recorded = one.recordings[0]
        runs = [identify_recording(each, recorded, tau_mean, signals, one.number, one.true) for each in networks]
        runs.append(least_squares_of(recorded, signals, one.true, one.number))
        scores = score_runs(runs, one.recordings, signals, config.metric)
        frames.append(scores.assign(experiment=one.number))
    table = pd.concat(frames, ignore_index=True)
    return table[["case", "joint", "method", "experiment", "time", "frequency", "total"]]
