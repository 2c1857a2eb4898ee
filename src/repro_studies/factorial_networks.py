"""Train the networks of the factorial, and search with them on the accepted experiments."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from repro.config.model import Configuration
from repro.config.sections import data_settings
from repro.experiments.accepted import of_this_unit, read_accepted
from repro.experiments.identifications import (
    prepare_recording,
    read_mean_torque,
)
from repro.experiments.monte_carlo import ArmScores
from repro.experiments.networks import algorithm1_of, for_the_arm, with_limit
from repro.experiments.simulated_arms import training_motion
from repro.experiments.stored_networks import configuration_digest
from repro.experiments.training import train_and_keep
from repro.identification.algorithm1.preprocessing import PreparedSignals
from repro.identification.algorithm1.search import ResidualEstimator, SearchSettings, select
from repro.model.parameters import FEASIBILITY, Array
from repro.progress import Progress, over
from repro.signals.metric import TorqueScorer
from repro.streams import Stream, stream
from repro_studies.factorial import CELLS, COLUMNS, METRICS, configured
from repro_studies.plain import PlainNetwork, load_posterior, read_torque, save_posterior, train_posterior


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
    estimator: ResidualEstimator, prepared: PreparedSignals, settings: SearchSettings, rng: np.random.Generator
) -> tuple[dict[str, tuple[Array, int]], Array]:
    """`search` and `select` of Algorithm 1 under both metrics from one evaluation of all guesses, and first estimates.

    An execution's guesses do not depend on the metric, only where it ends, so that the rest is left out afterwards.
    For each metric the parameters and the number of executions that met the threshold.
    """
    count, limit = settings.executions, settings.inner_limit
    guesses = np.stack([s.uniform(settings.guess_low, settings.guess_high, (limit, 9)) for s in rng.spawn(count)])
    beta = estimator.estimate(guesses.reshape(-1, 9)).reshape(count, limit, 9)
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
        scores = ArmScores(block.recordings, c)
        for image_motion in levels.image_motions or ("measured",):
            prepared = prepare_recording(block.recordings[0], tau_mean, signals, image_motion)
            if levels.reader == "plain":
                first = read_torque(plain, prepared.alpha)[0]
                found = dict.fromkeys(METRICS, (prepared.torque_scale * first, 0))
            else:
                estimator = ResidualEstimator(algorithm1.network, algorithm1.image, prepared)
                rng = stream(search, Stream.FACTORIAL_SEARCH, block.number)
                found, first = search_under(estimator, prepared, algorithm1.search, rng)
            error = float(np.sqrt(np.mean((first - block.true / prepared.torque_scale) ** 2)))
            own = {**common, "experiment": block.number, "error": error}
            own["image_motion"] = image_motion if levels.image_motions else ""
            rows += [{**own, "metric": m, **scores(x, METRICS[m]), "met": met} for m, (x, met) in found.items()]
    return pd.DataFrame(rows)[list(COLUMNS)]
