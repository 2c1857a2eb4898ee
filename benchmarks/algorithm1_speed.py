"""Algorithm 1 for one arm: seconds after loading, and the cost of an image."""

import argparse
import os
import time
from pathlib import Path

from repro import contract

contract.hold(os.environ)

import numpy as np
import torch

from repro.cnn.network import load_network
from repro.config.check import load_config
from repro.config.sections import data_settings, search_settings
from repro.experiments.identifications import mean_training_torque
from repro.identification.algorithm1.preprocessing import filtered, prepare
from repro.identification.algorithm1.search import ResidualEstimator, search, select
from repro.model.dynamics import rebuild_torque, regressor
from repro.signals.trajectories import identification_trajectory


def main() -> None:
    """Time ten searches of each arm and print the median."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--weights", type=Path, default=Path("results/model/cnn.safetensors"))
    parser.add_argument("--config", type=Path, default=Path("config/config.yaml"))
    parser.add_argument("--threads", type=int, default=2)
    args = parser.parse_args()
    torch.set_num_threads(args.threads)
    config = load_config(args.config)
    signals, data = config.signals, data_settings(config)
    settings, n1 = search_settings(config), config.numeric.margin_samples
    network = load_network(args.weights, config.network)
    motion = identification_trajectory(signals.duration_s, signals.sampling_period_s, n1)
    y = regressor(motion.q, motion.dq, motion.ddq)
    mean = mean_training_torque(signals, data, 1)
    for name, parameters in config.numeric.arms:
        beta = np.array(parameters)
        seconds, images = [], []
        for seed in range(10):
            began = time.perf_counter()
            prepared = prepare(
                filtered(motion.q, rebuild_torque(y, beta), signals, n1, n1 + mean.shape[-1]), mean, signals
            )
            reader = ResidualEstimator(network, data.image, prepared)
            select(search(reader, prepared, settings, np.random.default_rng(seed)).beta, prepared, settings)
            seconds.append(time.perf_counter() - began)
            images.append(reader.images)
        cost = 1e3 * np.median(np.array(seconds) / np.array(images))
        print(f"{name}: {np.median(seconds):.2f} s, {np.median(images):.0f} images, {cost:.3f} ms an image")


if __name__ == "__main__":
    main()
