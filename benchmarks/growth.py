"""How cost grows with what there is more of: processor time at three sizes, one thread, and the exponent through them.

An exponent of 1 is proportional to the size; below it what is done once, or side by side, still shows.
"""

import os
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from repro import contract

contract.hold(os.environ)

import numpy as np
import torch
from identify_speed import made_up, silent

from repro.board.controller import simulate
from repro.board.plant import Plant
from repro.cnn.train import train
from repro.commands.identify import LEAST_SQUARES
from repro.config.check import load_config
from repro.config.sections import data_settings, of_network
from repro.experiments.arm import control_constants, program_from_config, read_recordings, true_parameters
from repro.experiments.identifications import identify_recording, mean_training_torque
from repro.experiments.networks import algorithm1_of, for_the_arm
from repro.experiments.simulated_arms import training_motion
from repro.experiments.stored_networks import configuration_digest, stored_files
from repro.fitting.evaluate import assemble, fit_all, resolve
from repro.fitting.prepare import Options, load_log
from repro.fitting.problem import make_problem
from repro.identification.armfile import Arm

CONFIG = load_config(Path("config/config.yaml"))
TRACKED = of_network(CONFIG, "tracked")


def searches(recordings: int, seeds: int) -> None:
    """Algorithm 1 with the network of tracked motions on as many recordings and with as many seeds."""
    weights, signals = stored_files("data/networks", "-tracked")["weights"], TRACKED.signals
    algorithm1 = for_the_arm(algorithm1_of("tracked", str(weights), TRACKED, configuration_digest(TRACKED)), TRACKED)
    (recorded,) = read_recordings(["data/captures/ID.bin"], TRACKED)
    mean = mean_training_torque(signals, data_settings(TRACKED), 1)
    for _ in range(recordings):
        for seed in range(seeds):
            identify_recording(algorithm1, recorded, mean, signals, seed, true_parameters(TRACKED))


def specimens(count: int) -> None:
    """Specimens of the arm along the identification trajectory, simulated as one batch."""
    program = program_from_config(CONFIG, "ID")
    plant = Plant(np.stack([true_parameters(CONFIG)] * count), program.h)
    simulate(plant, control_constants(CONFIG), program.q)


def log(seconds: int) -> None:
    """All methods of least squares on a log, from opening it to the answer."""
    with tempfile.TemporaryDirectory() as folder:
        options = Options(LEAST_SQUARES, Path(folder))
        problem = make_problem(
            (load_log(made_up(Path(folder) / "log.csv", float(seconds)), Arm()),), (), Arm(), options
        )
        assemble(problem, fit_all(problem, resolve(options, silent), 1, silent), Arm())


def training(steps: int) -> None:
    """Steps of the published network's training."""
    settings = replace(CONFIG.training, steps=steps, test_samples=256)
    train(training_motion(CONFIG, None), data_settings(CONFIG), CONFIG.network, settings)


GROWTH: dict[str, tuple[tuple[int, ...], Callable[[int], None]]] = {
    "recordings, a search each": ((1, 2, 4), lambda n: searches(n, 1)),
    "seeds of the search": ((1, 2, 4), lambda n: searches(1, n)),
    "specimens simulated": ((6, 24, 96), specimens),
    "length of a log, s": ((20, 40, 80), log),
    "steps of training": ((50, 100, 200), training),
}


def main() -> None:
    """Print one line for each."""
    torch.set_num_threads(1)
    for name, (sizes, work) in GROWTH.items():
        work(sizes[0])  # loads what is loaded once
        taken = []
        for size in sizes:
            began = time.process_time()
            work(size)
            taken.append(time.process_time() - began)
        exponent = np.polyfit(np.log(sizes), np.log(taken), 1)[0]
        cells = ", ".join(f"{size}: {seconds:.2f} s" for size, seconds in zip(sizes, taken, strict=True))
        print(f"{name:24} {cells}; exponent {exponent:.2f}", flush=True)


if __name__ == "__main__":
    main()
