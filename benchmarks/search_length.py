"""How many guesses change what Algorithm 1 finds on the arm: mean similarity by the number of guesses in an execution.

Usage: ``python benchmarks/search_length.py [SEEDS]``, with the networks and the recordings that come with the project.
No execution meets the threshold of 0.9237 on the arm, so that all of them run to the limit L_exe.
"""

import os
import sys
from dataclasses import replace
from pathlib import Path

from repro import contract

contract.hold(os.environ)

import numpy as np
import pandas as pd

from repro.cnn.network import load_network
from repro.config import load_config
from repro.identification.algorithm1.search import ImageMotion, ResidualEstimator, select
from repro.model.parameters import FEASIBILITY
from repro.pipeline.experiment import read_recordings
from repro.pipeline.identifications import mean_training_torque, prepare_recording
from repro.settings import data_settings, metric_settings, network_settings, search_settings, signal_settings
from repro.signals.metric import TorqueScorer
from repro.streams import Stream, stream

ROOT = Path(__file__).resolve().parents[1]
#: Networks, and the motion of line 18.
NETWORKS: dict[str, ImageMotion] = {"cnn": "measured", "cnn-tracked": "desired"}
LENGTHS = (1, 5, 10, 20, 50, 100)


def main(seeds: int) -> pd.DataFrame:
    """Similarity (%) on ID and on T1 to T4, mean over the seeds, by network and length."""
    config = load_config(ROOT / "config/config.yaml")
    signals, settings = signal_settings(config), search_settings(config)
    settings = replace(settings, inner_limit=max(LENGTHS), threshold=config["experiment"]["threshold"])
    recordings = read_recordings(sorted((ROOT / "data/captures").glob("*.bin")), config)
    (recording,) = (one for one in recordings if one.program.name == "ID")
    others = [one.regression(signals) for one in recordings if one is not recording]
    scorers = [TorqueScorer(r.tau, r.y, metric_settings(config)) for r in others]
    tau_mean = mean_training_torque(signals, data_settings(config), config["training"]["seed"])
    rows = []
    for name, image_motion in NETWORKS.items():
        network = load_network(ROOT / f"data/networks/{name}.safetensors", network_settings(config))
        prepared = prepare_recording(recording, tau_mean, signals, image_motion)
        estimator = ResidualEstimator(network, data_settings(config).image, prepared)
        for seed in range(1, seeds + 1):
            streams = stream(seed, Stream.EXPERIMENT_SEARCH).spawn(settings.executions)
            guesses = [s.uniform(settings.low, settings.high, (settings.inner_limit, 9)) for s in streams]
            beta = estimator.estimate(np.concatenate(guesses)).reshape(settings.executions, -1, 9)
            for length in LENGTHS:
                first = beta[:, :length].reshape(-1, 9)
                found = select(first[FEASIBILITY[settings.feasibility](first)], prepared, settings)
                others_total = np.mean([scorer(found.beta).total for scorer in scorers])
                rows.append((name, length, 100.0 * found.similarity, 100.0 * others_total))
    table = pd.DataFrame(rows, columns=["network", "guesses", "ID", "T1 to T4"])
    means: pd.DataFrame = table.groupby(["network", "guesses"]).mean().round(1)
    return means


if __name__ == "__main__":
    print(main(int(sys.argv[1]) if len(sys.argv) > 1 else 5))
