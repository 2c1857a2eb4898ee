"""Do the intervals of the network's estimate cover? Arms of known parameters, with and without unmodelled torque.

The network estimates the same arm from many guesses. Their spread is too narrow, because they share their error. Split
conformal calibration (Vovk, Gammerman, Shafer, "Algorithmic Learning in a Random World", 2005) stretches it by a factor
found on arms of known parameters, which covers arms drawn like those for any network.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from scipy import stats

from repro.config.model import Configuration
from repro.experiments.arm import Recording, read_recordings, true_parameters
from repro.experiments.identifications import prepare_recording, read_mean_torque
from repro.experiments.networks import algorithm1_of, for_the_arm
from repro.experiments.simulated_arms import (
    Draw,
    draw_arms,
    draw_built_arms,
    sampled_tracks,
    simulate_arms,
    training_motion,
)
from repro.identification.algorithm1.preprocessing import PreparedSignals
from repro.identification.algorithm1.search import ResidualEstimator
from repro.model.parameters import NAMES, Array
from repro.progress import over
from repro.streams import Stream, stream

#: Sets of test arms: name, whether their torque has more than Eq. 1, and the law they are drawn from. The arms that
#: calibrate, number 0, are drawn like the second set.
TESTED = (
    (1, "Eq. 1", False, draw_arms),
    (2, "unmodelled", True, draw_arms),
    (4, "other generator", True, draw_built_arms),
)
#: Levels at which the distribution of the levels that reach the truth is kept.
GRID = np.linspace(0.0, 1.0, 41)
CENTRAL_FRACTION = 0.68  # central fraction of the estimates whose half range is the width
MIN_WIDTH = 1e-4  # least width, over the largest torque: an estimate's rounding to a digit
#: Fraction of training motions that are as far from their nearest one as a motion that is called novel.
NOVEL_FRACTION = 0.01


def spread_of(estimates: Array) -> tuple[Array, Array]:
    """Compute median and half the central range, each (..., 9), of estimates from many guesses (..., guesses, 9)."""
    low, middle, high = np.quantile(estimates, [0.5 - CENTRAL_FRACTION / 2, 0.5, 0.5 + CENTRAL_FRACTION / 2], axis=-2)
    return middle, np.maximum((high - low) / 2, MIN_WIDTH)


def normalised_errors(estimates: Array, truth: Array) -> Array:
    """Compute |truth - centre| / width (..., 9) of estimates (..., guesses, 9)."""
    centre, width = spread_of(estimates)
    return np.abs(truth - centre) / width


def stretch_factors(errors: Array, levels: Sequence[float]) -> Array:
    """Compute the factors (levels, 9) on the width that cover: the ceil((n + 1) level)-th smallest of errors (n, 9)."""
    n = len(errors)
    ranks = np.ceil((n + 1) * np.asarray(levels)).astype(int)
    if (ranks > n).any() or (ranks < 1).any():
        raise ValueError(f"levels: {n} arms can calibrate shares of 0 to {n / (n + 1):.4g}, got {tuple(levels)}.")
    return np.asarray(np.sort(errors, axis=0)[ranks - 1])


def distances(motions: Array, others: Array | None = None) -> Array:
    """Compute the distance (n,) of motions, as regressors (n, 2, M, 9), from the nearest of `others`, or of each other.

    It is the root of the mean over parameters of |Y - Y_k|^2 / |Y|^2 at the nearest k, which does not depend on units.
    """
    own = np.moveaxis(motions, -1, 1).reshape(len(motions), 9, -1)
    size = np.sum(own**2, axis=-1)  # (n, 9)
    nearest = np.empty(len(own))
    pool = own if others is None else np.moveaxis(others, -1, 1).reshape(len(others), 9, -1)
    for k, motion in enumerate(own):
        gap = np.sqrt(np.mean(np.sum((pool - motion) ** 2, axis=-1) / size[k], axis=-1))
        if others is None:
            gap[k] = np.inf
        nearest[k] = gap.min()
    return nearest


def novelty_limit(training: Array) -> float:
    """Compute the distance beyond which a motion is unlike the training motions (K, 2, M, 9)."""
    return float(np.quantile(distances(training), 1.0 - NOVEL_FRACTION))


def check_coverage(
    captures: Sequence[Path], weights: Path, motions: Path, mean_torque: Path, trained_as: str, config: Configuration
) -> list[pd.DataFrame]:
    """Calibrate the network of tracked motions on arms beyond Eq. 1 that training never saw, and test it on others.

    Shares of arms that intervals cover, distributions of the levels that reach the truth, and intervals of the arm.
    """
    signals, c = config.signals, config.coverage
    tau_mean, levels = read_mean_torque(mean_torque, signals), tuple(c.levels)
    algorithm1 = for_the_arm(algorithm1_of("tracked", weights, config, trained_as), config)
    search, training = algorithm1.search, training_motion(config, motions).torque
    beyond = novelty_limit(training)

    def read(which: int, recordings: Sequence[Recording]) -> tuple[list[PreparedSignals], Array]:
        """Prepared signals, and estimates (n, guesses, 9) from uniform guesses in units of the largest torque."""
        prepared = [prepare_recording(one, tau_mean, signals, search.image_motion) for one in recordings]
        found = []
        for k, one in enumerate(over(prepared, f"reading {len(prepared)} arms")):
            rng = stream(c.seed, Stream.COVERAGE_GUESSES, which, k)
            guess = rng.uniform(search.guess_low, search.guess_high, (c.guesses, 9))
            found.append(ResidualEstimator(algorithm1.network, algorithm1.image, one).estimate(guess))
        return prepared, np.stack(found)

    def simulated(which: int, effects: bool, draw: Draw) -> tuple[list[Recording], Array, Array]:
        """Recordings of arms, their estimates and their parameters; canonical time is the recorded one here."""
        rng = stream(c.seed, Stream.COVERAGE_ARMS, which)
        program, position, pwm, beta = simulate_arms(config, c.arms, rng, effects, draw)
        recordings = [Recording.of_counts(program, *both, config) for both in zip(position, pwm, strict=True)]
        prepared, found = read(which, recordings)
        return recordings, found, beta / np.array([[one.torque_scale] for one in prepared])

    def unlike(recordings: Sequence[Recording]) -> float:
        """Share whose motion is unlike those of the training."""
        own = sampled_tracks([one.q for one in recordings], recordings[0].program, signals)
        return float((distances(own.torque, training) > beyond).mean())

    _, estimates, truth = simulated(0, True, draw_arms)
    calibration = normalised_errors(estimates, truth)
    factors = stretch_factors(calibration, levels)
    together = joint_factors(factors, calibration, levels)
    shares, ranks = [], []
    for which, name, effects, draw in TESTED:
        recordings, found, right = simulated(which, effects, draw)
        table = coverage_shares(name, found, right, factors, together, levels)
        shares.append(table.assign(warned=unlike(recordings)))
        ranks.append(_rank_shares(name, found, right, calibration))
    recordings = read_recordings(captures, config)
    (prepared,), found = read(3, recordings)  # a set of guesses that no simulated arms have
    centre, width = spread_of(found[0])
    own = {"centre": centre, "low": centre - factors[-1] * width, "high": centre + factors[-1] * width}
    own = {name: prepared.to_recorded_time(x * prepared.torque_scale) for name, x in own.items()}
    intervals = pd.DataFrame({"parameter": NAMES, "true": true_parameters(config), **own})
    intervals = intervals.assign(level=levels[-1], warned=int(unlike(recordings)))
    return [pd.concat(shares, ignore_index=True), pd.concat(ranks, ignore_index=True), intervals]


def joint_factors(factors: Array, calibration: Array, levels: tuple[float, ...]) -> Array:
    """By how much more the intervals of each level are stretched so that all nine cover at once (split conformal)."""
    worst = np.sort((calibration[:, np.newaxis] / factors).max(axis=2), axis=0)  # (arms, levels)
    ranks = np.ceil((len(worst) + 1) * np.asarray(levels)).astype(int) - 1
    return np.asarray(worst[ranks, np.arange(len(levels))])


def coverage_shares(
    name: str, found: Array, right: Array, factors: Array, together: Array, levels: tuple[float, ...]
) -> pd.DataFrame:
    """Shares of arms that the intervals of each level cover, of estimates `found` (arms, guesses, 9)."""
    _, spread = spread_of(found)
    missed, prior = normalised_errors(found, right), right.var(axis=0)
    stretched = (missed <= factors[:, np.newaxis]).mean(axis=1)
    rows = []
    for i, level in enumerate(levels):
        low, high = np.quantile(found, [0.5 - level / 2, 0.5 + level / 2], axis=1)
        raw = (low <= right) & (right <= high)
        width = np.median(factors[i] * spread, axis=0)
        # Variance of the parameter that the interval leaves, as that of a normal error of this width.
        contraction = 1.0 - (width / stats.norm.ppf(0.5 + level / 2)) ** 2 / prior
        each = (NAMES, raw.mean(axis=0), stretched[i], factors[i], width, contraction)
        jointly = (missed <= together[i] * factors[i]).all(axis=1).mean()
        both = ("all nine", raw.all(axis=1).mean(), jointly, together[i], np.nan, np.nan)
        rows += [(name, of[0], level, *of[1:]) for of in (*zip(*each, strict=True), both)]
    columns = ["arms", "parameter", "level", "raw", "calibrated", "factor", "width", "contraction"]
    return pd.DataFrame(rows, columns=columns)


def _rank_shares(name: str, found: Array, right: Array, calibration: Array) -> pd.DataFrame:
    """Simulation-based calibration (Talts and others 2018): distribution of the level that first reaches the truth.

    Raw: twice the truth's rank off the middle of the guesses. Calibrated: the rank of the error among the arms that
    calibrated. Where levels are right, the distribution is uniform.
    """
    n, missed, known = found.shape[1], normalised_errors(found, right), np.sort(calibration, axis=0)
    below = (found < right[:, np.newaxis]).sum(axis=1)  # (arms, 9), 0 to n
    ranks = [np.searchsorted(known[:, j], missed[:, j]) / len(known) for j in range(len(NAMES))]
    reached = {"raw": np.abs(2 * below - n) / n, "calibrated": np.stack(ranks, axis=1)}
    places = {"parameter": np.repeat(NAMES, len(GRID)), "level": np.tile(GRID, len(NAMES))}
    shares = {column: (at[..., np.newaxis] <= GRID).mean(axis=0).ravel() for column, at in reached.items()}
    return pd.DataFrame({"arms": name, **places, "number": len(right), "known": len(known), **shares})
