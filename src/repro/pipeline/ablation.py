"""What each reading of the paper does to the headline numbers."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from repro.files import write_json
from repro.identification.algorithm1.refinement import Algorithm1
from repro.model.parameters import Array
from repro.pipeline.experiment import Recording, read_recordings, true_parameters
from repro.pipeline.experiment_runs import CASE, identify_recording, least_squares_of, score_runs
from repro.pipeline.interpretations import VARIANTS, configuration_of
from repro.pipeline.job import Config
from repro.pipeline.networks import algorithm1_of, for_the_arm, train_and_keep
from repro.pipeline.numeric import identify_arms, mean_training_torque, score_estimates
from repro.pipeline.stored_networks import configuration_digest
from repro.settings import data_settings, metric_settings, numeric_settings, signal_settings


def train_variant(name: str, weights: str, history: str, tracked: str, checkpoint: str, config: Config) -> None:
    """Write weights and history of a network that no table has."""
    reading = VARIANTS[name]
    label, c = f"{reading.question}: {reading.name}", configuration_of(config, reading)
    train_and_keep(label, Path(weights), Path(history), checkpoint, c, tracked)
    Path(checkpoint).unlink(missing_ok=True)


def run_variant(name: str, weights: str, captures: Sequence[str], out: str, config: Config) -> None:
    """Headline numbers under a reading."""
    reading = VARIANTS[name]
    # Every reading is refined, whatever its network is used for elsewhere.
    c = {**configuration_of(config, reading), "refinement": config["refinement"]}
    signals, metric = signal_settings(c), metric_settings(c)
    tau_mean = mean_training_torque(signals, data_settings(c), c["training"]["seed"])
    arms, algorithm1 = numeric_settings(c), algorithm1_of("published", weights, c, configuration_digest(c))
    runs = [identify_arms(algorithm1.literal, signals, arms, tau_mean, seed) for seed in c["ablation"]["seeds"]]
    numeric = score_estimates(runs, signals, arms, metric)
    cells = numeric.groupby(["trajectory", "case", "joint"])["total"].median()
    arm = _arm_scores(for_the_arm(algorithm1, c), read_recordings(captures, c), tau_mean, c)
    result: dict[str, Any] = {
        "id_mean": float(cells["ID"].mean()),
        "id_lowest": float(cells["ID"].min()),
        "validation_mean": float(cells["validation"].mean()),
        **{f"arm_{method}": value for method, value in arm.items()},
    }
    write_json(Path(out), result)


def _arm_scores(
    refined: Algorithm1, recordings: Sequence[Recording], tau_mean: Array, c: Config
) -> Mapping[str, float]:
    """Mean total similarity of the literal search on ID and on T1 to T4, and on these of what it is held against.

    The literal search is the median of the seeds; one of them is refined.
    """
    signals, true, seeds = signal_settings(c), true_parameters(c), c["ablation"]["seeds"]
    runs = [
        identify_recording(refined.literal if k else refined, recordings[0], tau_mean, signals, seed, true)
        for k, seed in enumerate(seeds)
    ]
    runs.append({**least_squares_of(recordings[0], signals, true), "seed": seeds[0]})
    scores = score_runs(runs, recordings, signals, metric_settings(c))
    by_seed = scores[scores["method"] == "algorithm1"].assign(on_id=scores["case"] == CASE)
    means = scores[scores["case"] != CASE].groupby("method")["total"].mean()
    medians = by_seed.groupby(["on_id", "seed"])["total"].mean().groupby("on_id").median()
    return {
        "id": float(medians[True]),
        "validation": float(medians[False]),
        "refined": float(means["algorithm1+refinement"]),
        "least_squares": float(means["least-squares"]),
        "true": float(means["true"]),
    }
