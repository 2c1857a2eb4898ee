"""Do the intervals of the network's estimate cover? Arms of known parameters, with and without unmodelled torque."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from repro.cnn.dataset import sample_motion
from repro.fpga.frames import RADIANS_PER_COUNT
from repro.identification.algorithm1.listing import Prepared
from repro.identification.algorithm1.residual import ResidualReader
from repro.identification.algorithm1.run import Algorithm1
from repro.identification.algorithm1.uncertainty import (
    Spread,
    covered,
    distances,
    misses,
    spread_of,
    stretch_factors,
    unlike_beyond,
)
from repro.model.parameters import NAMES, Array
from repro.pipeline.experiment import control_constants, true_parameters
from repro.pipeline.experiment_runs import prepare_recording
from repro.pipeline.job import Config
from repro.pipeline.recordings import Recording
from repro.pipeline.tracked import Tracked, derived_motion, simulate_arms, training_motion
from repro.progress import Progress
from repro.settings import signal_settings
from repro.signals.programs import Program
from repro.streams import Stream, stream

#: Set of guesses of the recorded arm; those of simulated arms are 0 and up.
OWN = 3


def read_arms(
    algorithm1: Algorithm1, arms: Tracked, tau_mean: Array, guesses: int, config: Config, which: int
) -> tuple[Array, Array]:
    """Estimates of each arm from uniform guesses, and its parameters, in units of the largest torque."""
    torque = control_constants(config).torque_per_count[:, np.newaxis]
    estimates, truth = np.empty((len(arms.position), guesses, 9)), np.empty((len(arms.position), 9))
    progress = Progress(f"reading {len(truth)} arms")
    for k, (position, pwm) in enumerate(zip(arms.position, arms.pwm, strict=True)):
        recording = Recording(arms.program, position * RADIANS_PER_COUNT, pwm * torque)
        prepared, estimates[k] = _read(algorithm1, recording, tau_mean, guesses, config, which, k)
        # In canonical time, which is the recorded one here, and in units of the largest torque.
        truth[k] = arms.parameters[k] / prepared.largest
        progress(k + 1, len(truth))
    return estimates, truth


def _read(
    algorithm1: Algorithm1, recording: Recording, tau_mean: Array, guesses: int, config: Config, which: int, k: int
) -> tuple[Prepared, Array]:
    search = algorithm1.search
    prepared = prepare_recording(recording, tau_mean, signal_settings(config), search.image_motion)
    rng = stream(config["coverage"]["seed"], Stream.COVERAGE_GUESSES, which, k)
    guess = rng.uniform(search.low, search.high, (guesses, 9))
    return prepared, ResidualReader(algorithm1.network, algorithm1.image, prepared).estimate(guess)


def coverage(
    algorithm1: Algorithm1, tracked: Path, recording: Recording, tau_mean: Array, config: Config
) -> dict[str, pd.DataFrame]:
    """Calibrate on arms with torque beyond Eq. 1 that training never saw, and test on others."""
    c = config["coverage"]
    levels, guesses = tuple(c["levels"]), c["guesses"]

    def read(which: int, effects: bool) -> tuple[Tracked, Array, Array]:
        arms = simulate_arms(config, c["arms"], stream(c["seed"], Stream.COVERAGE_ARMS, which), effects)
        return arms, *read_arms(algorithm1, arms, tau_mean, guesses, config, which)

    _, estimates, truth = read(0, effects=True)
    known = spread_of(estimates)
    factors, calibration = stretch_factors(known, truth, levels), misses(known, truth)
    training = training_motion(config, tracked).torque
    beyond = unlike_beyond(training)
    rows: list[dict[str, Any]] = []
    ranks: list[dict[str, Any]] = []
    for which, (name, effects) in enumerate((("Eq. 1", False), ("unmodelled", True)), start=1):
        arms, found, right = read(which, effects)
        spread = spread_of(found)
        motions = np.stack([_torque(q * RADIANS_PER_COUNT, arms.program, config) for q in arms.position])
        warned = float((distances(motions, training) > beyond).mean())
        rows += [{**row, "warned": warned} for row in _coverage_rows(name, found, right, spread, factors, levels)]
        ranks += _rank_rows(name, found, right, misses(spread, right), calibration)
    near = distances(_torque(recording.q, recording.program, config)[np.newaxis], training)
    own = _intervals(algorithm1, recording, tau_mean, guesses, factors[-1], config)
    return {
        "coverage": pd.DataFrame(rows),
        "ranks": pd.DataFrame(ranks),
        "intervals": own.assign(level=levels[-1], warned=int(near[0] > beyond)),
    }


def _intervals(
    algorithm1: Algorithm1, recording: Recording, tau_mean: Array, guesses: int, factor: Array, config: Config
) -> pd.DataFrame:
    prepared, found = _read(algorithm1, recording, tau_mean, guesses, config, OWN, 0)
    spread = spread_of(found)
    bounds = (spread.centre, spread.centre - factor * spread.width, spread.centre + factor * spread.width)
    centre, low, high = (prepared.recorded(x * prepared.largest) for x in bounds)
    true = true_parameters(config)
    return pd.DataFrame({"parameter": NAMES, "true": true, "centre": centre, "low": low, "high": high})


def _torque(q: Array, program: Program, config: Config) -> Array:
    signals = signal_settings(config)
    return sample_motion(derived_motion(q, signals), signals, slice(program.n1, program.n2)).torque


def _coverage_rows(
    name: str, found: Array, right: Array, spread: Spread, factors: Array, levels: tuple[float, ...]
) -> list[dict[str, Any]]:
    stretched = covered(spread, right, factors)
    rows = []
    for i, level in enumerate(levels):
        low, high = np.quantile(found, [0.5 - level / 2, 0.5 + level / 2], axis=1)
        raw = ((low <= right) & (right <= high)).mean(axis=0)
        width = np.median(factors[i] * spread.width, axis=0)
        rows += [
            {
                "arms": name, "parameter": parameter, "level": level, "raw": raw[j],
                "calibrated": stretched[i, j], "factor": factors[i, j], "width": width[j],
            }
            for j, parameter in enumerate(NAMES)
        ]  # fmt: skip
    return rows


def _rank_rows(name: str, found: Array, right: Array, missed: Array, calibration: Array) -> list[dict[str, Any]]:
    """Simulation-based calibration: by tenths, the level at which an interval first reaches the truth.

    Of the range of the guesses that is twice the truth's rank off the middle; of the calibrated interval the rank of
    what it misses by among the arms it was calibrated on.
    """
    n, m = found.shape[1], len(calibration)
    below = (found < right[:, np.newaxis]).sum(axis=1)  # (arms, 9), 0 to n
    raw = np.abs(2 * below - n)
    ordered = np.sort(calibration, axis=0)
    rows = []
    for j, parameter in enumerate(NAMES):
        rank = np.searchsorted(ordered[:, j], missed[:, j])
        tenths = (np.minimum(10 * raw[:, j] // (n + 1), 9), np.minimum(10 * rank // (m + 1), 9))
        shares = (np.bincount(tenth, minlength=10) / len(right) for tenth in tenths)
        rows += [
            {
                "arms": name,
                "parameter": parameter,
                "bin": k,
                "number": len(right),
                "known": m,
                "raw": a,
                "calibrated": b,
            }
            for k, (a, b) in enumerate(zip(*shares, strict=True))
        ]
    return rows
