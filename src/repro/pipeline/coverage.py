"""Do the intervals of the network's estimate cover? Arms of known parameters, with and without unmodelled torque."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy import stats

from repro.cnn.dataset import sample_motion
from repro.fpga.frames import RADIANS_PER_COUNT
from repro.identification.algorithm1.conformal import (
    GuessSpread,
    covered,
    distances,
    normalised_errors,
    novelty_limit,
    spread_of,
    stretch_factors,
)
from repro.identification.algorithm1.preprocessing import PreparedSignals
from repro.identification.algorithm1.refinement import Algorithm1
from repro.identification.algorithm1.search import ResidualEstimator
from repro.model.parameters import NAMES, Array
from repro.pipeline.experiment import Recording, control_constants, read_recordings, true_parameters
from repro.pipeline.identifications import prepare_recording, read_mean_torque
from repro.pipeline.job import Config
from repro.pipeline.networks import algorithm1_of, for_the_arm
from repro.pipeline.simulated_arms import (
    Draw,
    Tracked,
    derived_motion,
    draw_arms,
    draw_built_arms,
    simulate_arms,
    training_motion,
)
from repro.progress import Progress
from repro.settings import signal_settings
from repro.signals.programs import ReferenceTrajectory
from repro.streams import Stream, stream

#: Set of guesses of the recorded arm; those of simulated arms are 0 and up.
OWN = 3
#: Sets of test arms: name, whether their torque has more than Eq. 1, and the law they are drawn from. The arms that
#: calibrate, number 0, are drawn like the second set.
TESTED = (
    (1, "Eq. 1", False, draw_arms),
    (2, "unmodelled", True, draw_arms),
    (4, "other generator", True, draw_built_arms),
)
#: Row of the nine parameters together.
TOGETHER = "all nine"
#: Levels at which the distribution of the levels that reach the truth is kept.
GRID = np.linspace(0.0, 1.0, 41)


def read_arms(
    algorithm1: Algorithm1, arms: Tracked, tau_mean: Array, guesses: int, config: Config, which: int
) -> tuple[Array, Array]:
    """Estimates of each arm from uniform guesses, and its parameters, in units of the largest torque."""
    control = control_constants(config)
    estimates, truth = np.empty((len(arms.position), guesses, 9)), np.empty((len(arms.position), 9))
    progress = Progress(f"reading {len(truth)} arms")
    for k, (position, pwm) in enumerate(zip(arms.position, arms.pwm, strict=True)):
        recording = Recording.of_counts(arms.program, position, pwm, control)
        prepared, estimates[k] = _read(algorithm1, recording, tau_mean, guesses, config, which, k)
        # In canonical time, which is the recorded one here, and in units of the largest torque.
        truth[k] = arms.parameters[k] / prepared.torque_scale
        progress(k + 1, len(truth))
    return estimates, truth


def _read(
    algorithm1: Algorithm1, recording: Recording, tau_mean: Array, guesses: int, config: Config, which: int, k: int
) -> tuple[PreparedSignals, Array]:
    search = algorithm1.search
    prepared = prepare_recording(recording, tau_mean, signal_settings(config), search.image_motion)
    rng = stream(config["coverage"]["seed"], Stream.COVERAGE_GUESSES, which, k)
    guess = rng.uniform(search.low, search.high, (guesses, 9))
    return prepared, ResidualEstimator(algorithm1.network, algorithm1.image, prepared).estimate(guess)


def check_coverage(
    captures: Sequence[Path], weights: Path, motions: Path, mean_torque: Path, trained_as: str, config: Config
) -> list[pd.DataFrame]:
    """Whether the intervals of the network of tracked motions cover: the tables of `coverage`."""
    tau_mean = read_mean_torque(mean_torque, signal_settings(config))
    (recording,) = read_recordings(captures, config)
    algorithm1 = for_the_arm(algorithm1_of("tracked", weights, config, trained_as), config)
    return coverage(algorithm1, motions, recording, tau_mean, config)


def coverage(
    algorithm1: Algorithm1, tracked: Path, recording: Recording, tau_mean: Array, config: Config
) -> list[pd.DataFrame]:
    """Calibrate on arms with torque beyond Eq. 1 that training never saw, and test on others."""
    c = config["coverage"]
    levels, guesses = tuple(c["levels"]), c["guesses"]

    def read(which: int, effects: bool, draw: Draw) -> tuple[Tracked, Array, Array]:
        arms = simulate_arms(config, c["arms"], stream(c["seed"], Stream.COVERAGE_ARMS, which), effects, draw)
        return arms, *read_arms(algorithm1, arms, tau_mean, guesses, config, which)

    _, estimates, truth = read(0, True, draw_arms)
    known = spread_of(estimates)
    factors, calibration = stretch_factors(known, truth, levels), normalised_errors(known, truth)
    together = joint_factors(factors, calibration, levels)
    training = training_motion(config, tracked).torque
    beyond = novelty_limit(training)
    rows: list[dict[str, Any]] = []
    ranks: list[dict[str, Any]] = []
    for which, name, effects, draw in TESTED:
        arms, found, right = read(which, effects, draw)
        spread = spread_of(found)
        motions = np.stack([_torque(q * RADIANS_PER_COUNT, arms.program, config) for q in arms.position])
        warned = float((distances(motions, training) > beyond).mean())
        rows += [
            {**row, "warned": warned} for row in _coverage_rows(name, found, right, spread, factors, together, levels)
        ]
        ranks += _rank_rows(name, found, right, normalised_errors(spread, right), calibration)
    near = distances(_torque(recording.q, recording.program, config)[np.newaxis], training)
    own = _intervals(algorithm1, recording, tau_mean, guesses, factors[-1], config)
    return [pd.DataFrame(rows), pd.DataFrame(ranks), own.assign(level=levels[-1], warned=int(near[0] > beyond))]


def _intervals(
    algorithm1: Algorithm1, recording: Recording, tau_mean: Array, guesses: int, factor: Array, config: Config
) -> pd.DataFrame:
    prepared, found = _read(algorithm1, recording, tau_mean, guesses, config, OWN, 0)
    spread = spread_of(found)
    bounds = (spread.centre, spread.centre - factor * spread.width, spread.centre + factor * spread.width)
    centre, low, high = (prepared.to_recorded_time(x * prepared.torque_scale) for x in bounds)
    true = true_parameters(config)
    return pd.DataFrame({"parameter": NAMES, "true": true, "centre": centre, "low": low, "high": high})


def _torque(q: Array, program: ReferenceTrajectory, config: Config) -> Array:
    signals = signal_settings(config)
    return sample_motion(derived_motion(q, signals), signals, slice(program.n1, program.n2)).torque


def joint_factors(factors: Array, calibration: Array, levels: tuple[float, ...]) -> Array:
    """By how much more the intervals of each level are stretched so that all nine cover at once (split conformal)."""
    worst = np.sort((calibration[:, np.newaxis] / factors).max(axis=2), axis=0)  # (arms, levels)
    ranks = np.ceil((len(worst) + 1) * np.asarray(levels)).astype(int) - 1
    stretched: Array = worst[ranks, np.arange(len(levels))]
    return stretched


def _coverage_rows(
    name: str,
    found: Array,
    right: Array,
    spread: GuessSpread,
    factors: Array,
    together: Array,
    levels: tuple[float, ...],
) -> list[dict[str, Any]]:
    missed, prior = normalised_errors(spread, right), right.var(axis=0)
    stretched = covered(spread, right, factors)
    rows: list[dict[str, Any]] = []
    for i, level in enumerate(levels):
        low, high = np.quantile(found, [0.5 - level / 2, 0.5 + level / 2], axis=1)
        raw = (low <= right) & (right <= high)
        width = np.median(factors[i] * spread.width, axis=0)
        # Variance of the parameter that the interval leaves, as that of a normal error of this width.
        contraction = 1.0 - (width / stats.norm.ppf(0.5 + level / 2)) ** 2 / prior
        rows += [
            {
                "arms": name, "parameter": parameter, "level": level, "raw": raw[:, j].mean(),
                "calibrated": stretched[i, j], "factor": factors[i, j], "width": width[j],
                "contraction": contraction[j],
            }
            for j, parameter in enumerate(NAMES)
        ]  # fmt: skip
        jointly = (missed <= together[i] * factors[i]).all(axis=1).mean()
        rows.append(
            {
                "arms": name, "parameter": TOGETHER, "level": level, "raw": raw.all(axis=1).mean(),
                "calibrated": jointly, "factor": together[i], "width": np.nan, "contraction": np.nan,
            }
        )  # fmt: skip
    return rows


def _rank_rows(name: str, found: Array, right: Array, missed: Array, calibration: Array) -> list[dict[str, Any]]:
    """Simulation-based calibration (Talts and others 2018): distribution of the level that first reaches the truth.

    Of the range of the guesses that is twice the truth's rank off the middle; of the calibrated interval the rank of
    what it misses by among the arms it was calibrated on. The distribution is uniform where levels are right.
    """
    n, m = found.shape[1], len(calibration)
    below = (found < right[:, np.newaxis]).sum(axis=1)  # (arms, 9), 0 to n
    raw = np.abs(2 * below - n) / n
    ordered = np.sort(calibration, axis=0)
    rows = []
    for j, parameter in enumerate(NAMES):
        rank = np.searchsorted(ordered[:, j], missed[:, j]) / m
        rows += [
            {
                "arms": name, "parameter": parameter, "level": level, "number": len(right), "known": m,
                "raw": (raw[:, j] <= level).mean(), "calibrated": (rank <= level).mean(),
            }
            for level in GRID
        ]  # fmt: skip
    return rows
