"""Train and evaluate the networks of other interpretations of the paper."""

from collections.abc import Sequence
from pathlib import Path

from repro.config.model import Configuration
from repro.config.sections import data_settings
from repro.experiments.arm import read_recordings, true_parameters
from repro.experiments.identifications import (
    CASE,
    identify_arms,
    identify_recording,
    least_squares_of,
    mean_training_torque,
    score_estimates,
    score_runs,
)
from repro.experiments.networks import algorithm1_of, for_the_arm
from repro.experiments.stored_networks import configuration_digest
from repro.experiments.training import train_and_keep
from repro_studies.interpretations import INTERPRETATIONS, MEASURED, configuration_of


def train_variant(
    trained: str, weights: Path, history: Path, tracked: Path, checkpoint: str, config: Configuration
) -> None:
    """Train the network of an interpretation; write its weights and history."""
    interpretation = INTERPRETATIONS[trained]
    label, c = f"{interpretation.question}: {interpretation.name}", configuration_of(config, interpretation)
    train_and_keep(label, weights, history, checkpoint, c, tracked)


def run_variant(reading: str, weights: Path, captures: Sequence[Path], config: Configuration) -> dict[str, float]:
    """Headline numbers under an interpretation: medians of the seeds, of which the first is refined on the arm."""
    # Every interpretation is refined, whatever its network is used for elsewhere.
    c = configuration_of(config, INTERPRETATIONS[reading]).model_copy(update={"refinement": config.refinement})
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
