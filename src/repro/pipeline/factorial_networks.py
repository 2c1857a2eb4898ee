"""Networks of the factorial: training, and the search with each of them on every block.

What decides how similar Algorithm 1's torques are? `repro.pipeline.factorial` has the factors and the blocks.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from repro.cnn.network import load_network
from repro.cnn.plain import PlainSettings, load_plain, read_torque, save_plain, train_plain
from repro.identification.algorithm1.preprocessing import PreparedSignals
from repro.identification.algorithm1.search import ResidualEstimator, SearchSettings, select
from repro.model.parameters import FEASIBILITY, Array
from repro.pipeline.experiment_runs import prepare_recording
from repro.pipeline.factorial import CELLS, COLUMNS, METRICS, Scorers, configured, read_blocks
from repro.pipeline.job import Config
from repro.pipeline.networks import train_and_keep
from repro.pipeline.stored_networks import configuration_digest
from repro.pipeline.tracked import training_motion
from repro.progress import Progress
from repro.settings import data_settings, network_settings, search_settings, signal_settings
from repro.signals.metric import TorqueScorer
from repro.streams import Stream, stream


def _plain_settings(config: Config) -> PlainSettings:
    p = config["factorial"]["plain"]
    return PlainSettings(p["width"], p["steps"], p["batch"], p["learning_rate"])


def train_cell(name: str, seed: int, weights: Path, checkpoint: str, motions: str | None, config: Config) -> None:
    """Train one network of the factorial."""
    cell = CELLS[name]
    c = configured(config, cell, seed)
    if cell.reader == "plain":
        progress = Progress(f"training, {name}")
        network = train_plain(
            training_motion(c, Path(motions) if motions else None), data_settings(c), _plain_settings(c), seed, progress
        )
        save_plain(weights, network)
        return
    train_and_keep(f"{name}, seed {seed}", weights, weights.with_suffix(".csv"), checkpoint, c, motions)
    Path(checkpoint).unlink(missing_ok=True)


def search_under(
    reader: ResidualEstimator, prepared: PreparedSignals, settings: SearchSettings, rng: np.random.Generator
) -> tuple[dict[str, tuple[Array, int]], Array]:
    """`search` and `select` of Algorithm 1 under both metrics from one reading of all guesses.

    An execution's guesses do not depend on the metric, only where it ends, so that the rest is left out afterwards.
    Returns for each metric the parameters and how many executions met the threshold, and each execution's first
    estimate.
    """
    count, limit = settings.executions, settings.inner_limit
    guesses = np.stack([s.uniform(settings.low, settings.high, (limit, 9)) for s in rng.spawn(count)])
    beta = reader.estimate(guesses.reshape(-1, 9)).reshape(count, limit, 9)
    possible = FEASIBILITY[settings.feasibility](beta.reshape(-1, 9)).reshape(count, limit)
    results: dict[str, tuple[Array, int]] = {}
    for name, metric in METRICS.items():
        n_e = np.where(possible, TorqueScorer(prepared.alpha, prepared.y_sub, metric)(beta).total.mean(-1), 0.0)
        met = n_e >= settings.threshold
        before: NDArray[np.bool_] = (
            np.cumsum(met, axis=1) - met == 0
        )  # up to and with the first that meets the threshold
        selected = select(beta[possible & before], prepared, replace(settings, metric=metric))
        results[name] = (selected.beta, int(met.any(axis=1).sum()))
    return results, beta[:, 0]


def score_cell(
    name: str, training_seed: int, search_seed: int, weights: Path, recordings: Path, tau_mean: Array, config: Config
) -> pd.DataFrame:
    """Similarities of one network and one seed of guesses on every block; of a plain network, which has no guesses."""
    cell = CELLS[name]
    c = configured(config, cell, training_seed)
    signals, blocks = signal_settings(c), read_blocks(recordings, c)
    settings = replace(search_settings(c), threshold=c["experiment"]["threshold"])
    progress, rows = Progress(f"{name}, seed {training_seed}, guesses {search_seed}"), []
    common = {"reader": cell.reader, "training": cell.motions, "omega": cell.omega, "training_seed": training_seed}
    plain = load_plain(weights, signals.samples, _plain_settings(c)) if cell.reader == "plain" else None
    network = None
    if plain is None:
        network = load_network(weights, network_settings(c), configuration_digest(c), c["training"]["precision"])
    for k, block in enumerate(blocks):
        scorers, right = Scorers.of(block, c), block.true
        own = {**common, "block": block.name, "arm": block.arm, "back_emf": block.back_emf, "search_seed": search_seed}
        for image_motion in cell.image_motions or ("measured",):
            prepared = prepare_recording(block.recordings["ID"], tau_mean, signals, image_motion)
            if network is not None:
                reader = ResidualEstimator(network, data_settings(c).image, prepared)
                rng = stream(search_seed, Stream.FACTORIAL_SEARCH, k)
                found, first = search_under(reader, prepared, settings, rng)
            else:
                assert plain is not None
                first = read_torque(plain, prepared.alpha)[np.newaxis]
                found = dict.fromkeys(METRICS, (prepared.torque_scale * first[0], 0))
            error = float(np.sqrt(np.mean((first - right / prepared.torque_scale) ** 2)))
            shown = image_motion if cell.image_motions else ""
            rows += [
                {**own, "image_motion": shown, "metric": m, **scorers.row(m, beta), "error": error, "met": met}
                for m, (beta, met) in found.items()
            ]
        progress(k + 1, len(blocks))
    return pd.DataFrame(rows)[list(COLUMNS)]
