"""What trains or evaluates networks: those of the tables, of the interpretations and of the factorial."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from repro.cnn.network import load_network, on_this_processor, save_network
from repro.cnn.plain import PlainNetwork, load_posterior, read_torque, save_posterior, train_posterior
from repro.cnn.train import train
from repro.config.model import Configuration
from repro.config.sections import data_settings, of_network, search_settings
from repro.experiments.accepted import of_this_unit, read_accepted
from repro.experiments.arm import read_recordings, true_parameters
from repro.experiments.factorial import CELLS, COLUMNS, METRICS, configured
from repro.experiments.identifications import (
    CASE,
    identify_arms,
    identify_recording,
    least_squares_of,
    mean_training_torque,
    prepare_recording,
    read_mean_torque,
    score_estimates,
    score_runs,
)
from repro.experiments.interpretations import MEASURED, VARIANTS, configuration_of
from repro.experiments.monte_carlo import Scores
from repro.experiments.simulated_arms import training_motion
from repro.experiments.stored_networks import CONFIGURATION, configuration_digest, model_card, network_name, take_stored
from repro.files import write_csv, write_text
from repro.identification.algorithm1.preprocessing import PreparedSignals
from repro.identification.algorithm1.refinement import Algorithm1
from repro.identification.algorithm1.search import ResidualEstimator, SearchSettings, select
from repro.model.parameters import FEASIBILITY, Array
from repro.progress import Progress, over
from repro.signals.metric import TorqueScorer
from repro.streams import Stream, stream


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


def train_variant(
    trained: str, weights: Path, history: Path, tracked: Path, checkpoint: str, config: Configuration
) -> None:
    """Write weights and history of a network that no table has."""
    reading = VARIANTS[trained]
    label, c = f"{reading.question}: {reading.name}", configuration_of(config, reading)
    train_and_keep(label, weights, history, checkpoint, c, tracked)


def run_variant(reading: str, weights: Path, captures: Sequence[Path], config: Configuration) -> dict[str, float]:
    """Headline numbers under a reading: medians of the seeds, of which one is refined on the arm."""
    # Every reading is refined, whatever its network is used for elsewhere.
    c = configuration_of(config, VARIANTS[reading]).model_copy(update={"refinement": config.refinement})
    signals, metric, seeds = c.signals, c.metric, c.ablation.seeds
    tau_mean = mean_training_torque(signals, data_settings(c), c.training.seed)
    algorithm1 = algorithm1_of("published", weights, c, configuration_digest(c))
    totals = score_estimates([identify_arms(algorithm1.literal, c, tau_mean, seed) for seed in seeds], c, metric)
    cells = totals.groupby(["trajectory", "case", "joint"])["total"].median()

    refined, recordings, true = for_the_arm(algorithm1, c), read_recordings(captures, c), true_parameters(c)
    runs = [
        identify_recording(refined.literal if k else refined, recordings[0], tau_mean, signals, seed, true)
        for k, seed in enumerate(seeds)
    ]
    runs.append(least_squares_of(recordings[0], signals, true, seeds[0]))
    scores = score_runs(runs, recordings, signals, metric)
    by_seed = scores[scores["method"] == "algorithm1"].assign(on_id=scores["case"] == CASE)
    means = scores[scores["case"] != CASE].groupby("method")["total"].mean()
    medians = by_seed.groupby(["on_id", "seed"])["total"].mean().groupby("on_id").median()
    numeric = (cells["ID"].mean(), cells["ID"].min(), cells["validation"].mean())
    arm = (medians[True], medians[False], *means[["algorithm1+refinement", "least-squares", "true"]])
    return dict(zip(MEASURED, map(float, (*numeric, *arm)), strict=True))


def train_cell(
    cell: str, seed: int, weights: Path, checkpoint: str, config: Configuration, motions: Path | None = None
) -> None:
    """Train one network of the factorial."""
    c = configured(config, CELLS[cell], seed)
    if CELLS[cell].reader == "plain":
        motion, progress = training_motion(c, motions), Progress(f"training, {cell}")
        save_posterior(
            weights, train_posterior(PlainNetwork, motion, data_settings(c), c.factorial.plain, seed, progress)
        )
        return
    train_and_keep(f"{cell}, seed {seed}", weights, None, checkpoint, c, motions)


def search_under(
    reader: ResidualEstimator, prepared: PreparedSignals, settings: SearchSettings, rng: np.random.Generator
) -> tuple[dict[str, tuple[Array, int]], Array]:
    """`search` and `select` of Algorithm 1 under both metrics from one reading of all guesses, and the first estimates.

    An execution's guesses do not depend on the metric, only where it ends, so that the rest is left out afterwards.
    For each metric the parameters and the number of executions that met the threshold.
    """
    count, limit = settings.executions, settings.inner_limit
    guesses = np.stack([s.uniform(settings.guess_low, settings.guess_high, (limit, 9)) for s in rng.spawn(count)])
    beta = reader.estimate(guesses.reshape(-1, 9)).reshape(count, limit, 9)
    possible = FEASIBILITY[settings.feasibility](beta.reshape(-1, 9)).reshape(count, limit)
    results: dict[str, tuple[Array, int]] = {}
    for name, metric in METRICS.items():
        n_e = np.where(possible, TorqueScorer(prepared.alpha, prepared.y_sub, metric)(beta).total.mean(-1), 0.0)
        met = n_e >= settings.threshold
        until_met = np.equal(np.cumsum(met, axis=1), met)  # up to and with the first that meets the threshold
        selected = select(beta[possible & until_met], prepared, replace(settings, metric=metric))
        results[name] = (selected.beta, int(met.any(axis=1).sum()))
    return results, beta[:, 0]


def score_cell(
    cell: str,
    seed: int,
    search: int,
    weights: Path,
    experiments: Path,
    recordings: Path,
    mean_torque: Path,
    config: Configuration,
) -> pd.DataFrame:
    """Similarities of one network and one seed of guesses on every block; of a plain network, which has no guesses."""
    levels, rows = CELLS[cell], []
    c = configured(config, levels, seed)
    signals, f = c.signals, c.factorial
    tau_mean = read_mean_torque(mean_torque, signals)
    blocks = of_this_unit(read_accepted(experiments, recordings, c), c)
    if levels.reader == "plain":
        plain = load_posterior(weights, PlainNetwork(signals.image_samples, f.plain.width))
    else:
        of_cell = algorithm1_of(cell, weights, c, configuration_digest(c))
        algorithm1 = with_limit(for_the_arm(of_cell, c), f.inner_limit)
    common = {"reader": levels.reader, "training": levels.motions, "training_seed": seed, "search_seed": search}
    for block in over(blocks, f"{cell}, seed {seed}, guesses {search}"):
        scores = Scores(block.recordings, c)
        for image_motion in levels.image_motions or ("measured",):
            prepared = prepare_recording(block.recordings[0], tau_mean, signals, image_motion)
            if levels.reader == "plain":
                first = read_torque(plain, prepared.alpha)[0]
                found = dict.fromkeys(METRICS, (prepared.torque_scale * first, 0))
            else:
                reader = ResidualEstimator(algorithm1.network, algorithm1.image, prepared)
                rng = stream(search, Stream.FACTORIAL_SEARCH, block.number)
                found, first = search_under(reader, prepared, algorithm1.search, rng)
            error = float(np.sqrt(np.mean((first - block.true / prepared.torque_scale) ** 2)))
            own = {**common, "experiment": block.number, "error": error}
            own["image_motion"] = image_motion if levels.image_motions else ""
            rows += [{**own, "metric": m, **scores(x, METRICS[m]), "met": met} for m, (x, met) in found.items()]
    return pd.DataFrame(rows)[list(COLUMNS)]
