"""Monte Carlo study: the experiment over many simulated specimens of several arms, and methods compared over arms.

A specimen is one arm with its share of unmodelled effects and its random motion T1. In comparisons the value of a
method for an arm is the mean of its totals over T1 to T4 and both joints, so that the dependent cells of an arm count
once. The difference of a pair of methods has one value per arm; all statements on pairs are valid at once.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from repro.errors import InputError
from repro.files import read_tensors, write_tensors
from repro.fpga.controller import simulate
from repro.fpga.plant import Plant
from repro.model.parameters import Array
from repro.pipeline.experiment import (
    Recording,
    control_constants,
    disturbance,
    limits,
    program_from_config,
    true_parameters,
)
from repro.pipeline.experiment_runs import identify_recording, least_squares_of, score_runs
from repro.pipeline.job import Config
from repro.pipeline.tracked import draw_arms, tracking_error
from repro.progress import Progress
from repro.settings import metric_settings, signal_settings
from repro.signals.programs import VALIDATION, ReferenceTrajectory, check_limits
from repro.streams import Stream, stream

if TYPE_CHECKING:
    from repro.identification.algorithm1.refinement import Algorithm1

#: Arms drawn for each that is wanted.
DRAWN = 8
#: A loop chatters if more than this share of the power of a joint's torque on ID is above this frequency, Hz: a rule on
#: the recording alone, whatever the methods make of it. The arm behind the captures has 0.21.
CHATTER_SHARE, CHATTER_HZ = 0.75, 25.0


@dataclass(frozen=True)
class Specimen:
    """One specimen and its recordings."""

    seed: int  # of what Eq. 1 leaves out, and of T1
    arm: int  # which arm; 0 is that of section ``arm``
    true: Array  # its parameters
    recordings: dict[str, Recording]  # by motion, ID first


def spread_arms(config: Config) -> Array:
    """Arms of the spread: that of section ``arm``, and others that can do the same motions."""
    seeds = config["spread"]["seeds"]
    motions = [program_from_config(config, "ID", duration=d) for d in config["spread"]["durations_s"]]
    motions += [program_from_config(config, name, seed) for name in VALIDATION for seed in seeds]
    count = config["spread"]["arms"]
    drawn = draw_arms(stream(config["experiment"]["seed"], Stream.SPREAD_ARMS), DRAWN * count, config)
    drawn[:, 5:7] += config["arm"]["back_emf_nm_s_per_rad"]  # all arms have the same motors
    capable = [beta for beta in drawn if all(_is_within_limits(motion, beta, config) for motion in motions)]
    fastest = min(motions[: len(config["spread"]["durations_s"])], key=lambda motion: motion.q.shape[1])
    plant = Plant(np.stack([true_parameters(config), *capable]), fastest.h)
    position, _ = simulate(plant, control_constants(config), fastest.q)
    tracked = tracking_error(position, fastest) <= config["data"]["tracked"]["largest_error_rad"]
    arms = np.stack([true_parameters(config), *(beta for beta, ok in zip(capable, tracked[1:], strict=True) if ok)])
    if len(arms) < count:
        raise InputError.at("spread.arms", count, f"at most {len(arms)}, of {DRAWN * count} drawn ones that can")
    return arms[:count]


def chatters(recorded: Recording) -> bool:
    """Whether the loop of a specimen chatters on ID, so that its torque tells little about the arm."""
    tau = recorded.tau - recorded.tau.mean(axis=-1, keepdims=True)
    power = np.abs(np.fft.rfft(tau, axis=-1)) ** 2
    fast = np.fft.rfftfreq(tau.shape[-1], recorded.program.h) > CHATTER_HZ
    return bool((power[..., fast].sum(axis=-1) > CHATTER_SHARE * power.sum(axis=-1)).any())


def _is_within_limits(motion: ReferenceTrajectory, beta: Array, config: Config) -> bool:
    """Whether a motion stays within torque and speed of an arm."""
    try:
        check_limits(motion, beta, *limits(config))
    except InputError:
        return False
    return True


def programs(config: Config, seed: int, duration: float) -> dict[str, ReferenceTrajectory]:
    """The motions of one seed and one identification duration."""
    found: dict[str, ReferenceTrajectory] = {"ID": program_from_config(config, "ID", duration=duration)}
    return found | {name: program_from_config(config, name, seed) for name in VALIDATION}


def simulate_spread(config: Config, out: Path) -> None:
    """Simulate every seed and motion as one batch, which shares its substeps, and keep the counts."""
    seeds, durations = config["spread"]["seeds"], config["spread"]["durations_s"]
    desired = {
        f"ID{k}": np.stack([program_from_config(config, "ID", duration=d).q] * len(seeds))
        for k, d in enumerate(durations)
    }
    desired |= {name: np.stack([program_from_config(config, name, seed).q for seed in seeds]) for name in VALIDATION}
    arms, control, h = spread_arms(config), control_constants(config), config["signals"]["sampling_period_s"]
    beta = arms[np.arange(len(seeds)) % len(arms)]
    levels, phase = zip(*(disturbance(config, seed) for seed in seeds), strict=True)
    n, longest = len(desired), max(q.shape[-1] for q in desired.values())
    plant = Plant(np.tile(beta, (n, 1)), h, levels * n, np.tile(phase, (n, 1)))
    held = [np.pad(q, ((0, 0), (0, 0), (0, longest - q.shape[-1])), mode="edge") for q in desired.values()]
    progress = Progress(f"simulating {n} motions of {len(seeds)} seeds")
    position, pwm = simulate(plant, control, np.concatenate(held), progress)
    kept: dict[str, np.ndarray[Any, np.dtype[Any]]] = {"parameters": beta}
    for k, (name, q) in enumerate(desired.items()):
        own = np.s_[k * len(seeds) : (k + 1) * len(seeds), :, : q.shape[-1]]
        kept |= {f"{name}/position": position[own], f"{name}/pwm": pwm[own]}
        kept[f"{name}/desired"] = q.astype(np.float32)
    write_tensors(out, kept)


def read_spread(path: Path, config: Config, index: int) -> list[Specimen]:
    """Recordings of every seed for one identification duration."""
    seeds, duration = config["spread"]["seeds"], config["spread"]["durations_s"][index]
    kept, _ = read_tensors(path, "the recordings of the spread")
    true = kept.get("parameters", np.empty(0))
    if true.shape != (len(seeds), 9):
        raise InputError.at(f"{path}: parameters", "another shape or nothing", f"an array of shape ({len(seeds)}, 9)")
    control = control_constants(config)
    found = []
    for k, seed in enumerate(seeds):
        recordings = {}
        for name, program in programs(config, seed, duration).items():
            key = f"ID{index}" if name == "ID" else name
            expected = (len(seeds), *program.q.shape)
            signals = [kept.get(f"{key}/{signal}") for signal in ("position", "pwm", "desired")]
            shaped = [signal[k] for signal in signals if signal is not None and signal.shape == expected]
            if len(shaped) != len(signals):
                raise InputError.at(f"{path}: {key}", "another shape", f"arrays of shape {expected}")
            position, pwm, desired = shaped
            sent = replace(program, q=desired.astype(np.float64))
            recordings[name] = Recording.of_counts(sent, position, pwm, control)
        found.append(Specimen(seed, k % config["spread"]["arms"], true[k], recordings))
    return found


def score_specimens(
    networks: Sequence["Algorithm1"], recordings: Path, index: int, tau_mean: Array, config: Config
) -> pd.DataFrame:
    """Similarity of every method on every motion of every specimen, for identification duration `index`."""
    signals, duration = signal_settings(config), config["spread"]["durations_s"][index]
    specimens = read_spread(recordings, config, index)
    progress = Progress(f"spread, identification of {duration:.4g} s")
    frames = []
    for k, one in enumerate(specimens):
        recorded = one.recordings["ID"]
        runs = [identify_recording(each, recorded, tau_mean, signals, one.seed, one.true) for each in networks]
        runs.append({**least_squares_of(recorded, signals, one.true), "seed": one.seed})
        scores = score_runs(runs, list(one.recordings.values()), signals, metric_settings(config))
        frames.append(scores.assign(duration=duration, arm=one.arm, chatter=int(chatters(recorded))))
        progress(k + 1, len(specimens))
    table = pd.concat(frames, ignore_index=True)
    return table[["case", "joint", "method", "duration", "arm", "chatter", "seed", "time", "frequency", "total"]]


#: Mean totals that lie no further apart count as the same.
EQUIVALENT = 0.005
#: Probability of one false statement in a family of pairs.
FAMILY_LEVEL = 0.05
BETTER, WORSE, SAME, OPEN = "better", "worse", "equivalent", "open"
#: Sets of arms that each comparison is made on.
ALL, STEADY = "all", "without chatter"
COMPARISON_COLUMNS = (
    "set", "duration", "method", "opponent", "arms", "wins", "difference", "low", "high", "p", "p_holm", "conclusion",
)  # fmt: skip


def comparisons(scores: pd.DataFrame, methods: Sequence[str], opponents: Sequence[str]) -> pd.DataFrame:
    """Compare each method with each opponent, for each duration, on all arms and on those whose loop is steady.

    `scores` has columns ``case, joint, method, duration, arm, chatter, total``; the result has `COMPARISON_COLUMNS`,
    differences as fractions of 1. A family is the pairs of one set and duration.
    """
    of_arms = scores[scores["case"] != "ID"].groupby(["duration", "arm", "chatter", "method"])["total"].mean().unstack()
    pairs = [(method, opponent) for method in methods for opponent in opponents]
    rows = []
    for name, kept in ((ALL, of_arms), (STEADY, of_arms[of_arms.index.get_level_values("chatter") == 0])):
        for duration, family in kept.groupby("duration"):
            differences = [(family[method] - family[opponent]).to_numpy() for method, opponent in pairs]
            p = np.array([_signed_rank_p(d) for d in differences])
            for (method, opponent), d, own, adjusted in zip(pairs, differences, p, holm(p), strict=True):
                low, high = walsh_interval(d, 1.0 - FAMILY_LEVEL / len(pairs))
                wins, middle = int((d > 0).sum()), float(np.median(walsh_averages(d)))
                conclusion = conclude(middle, low, high, adjusted)
                rows.append(
                    (name, duration, method, opponent, len(d), wins, middle, low, high, own, adjusted, conclusion)
                )
    return pd.DataFrame(rows, columns=list(COMPARISON_COLUMNS))


def conclude(difference: float, low: float, high: float, p: float) -> str:
    """Word for a pair: equivalent where the whole interval is within the margin, then by the adjusted p value."""
    if low > -EQUIVALENT and high < EQUIVALENT:
        return SAME
    if p >= FAMILY_LEVEL:
        return OPEN
    return BETTER if difference > 0 else WORSE


def _signed_rank_p(differences: Array) -> float:
    """Two-sided p value of Wilcoxon's signed-rank test; 1 where no arm shows a difference."""
    if not np.any(differences):
        return 1.0
    from scipy import stats  # noqa: PLC0415 (a quarter of a second, in each job that reads the workflow)

    return float(stats.wilcoxon(differences, zero_method="pratt").pvalue)


def holm(p: Array) -> Array:
    """Adjust the p values of a family (Holm 1979): the k-th smallest of m times m - k + 1, never below an earlier."""
    order = np.argsort(p)
    adjusted = np.empty(len(p))
    adjusted[order] = np.minimum(1.0, np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1)))
    return adjusted


def walsh_averages(x: Array) -> Array:
    """Means of all pairs, each value with itself too, sorted; their median is the Hodges-Lehmann estimate."""
    first, second = np.triu_indices(len(x))
    return np.sort(0.5 * (x[first] + x[second]))


def walsh_interval(x: Array, level: float) -> tuple[float, float]:
    """Exact distribution-free interval of the centre that belongs to the signed-rank test (Hollander and Wolfe).

    Infinite where so few values cannot reach the level.
    """
    counts = np.ones(1)  # of subsets of the ranks 1 ... n by their sum: the null distribution of the statistic
    for rank in range(1, len(x) + 1):
        counts = np.convolve(counts, np.r_[1.0, np.zeros(rank - 1), 1.0])
    below = np.cumsum(counts) / counts.sum()
    left_out = int(np.searchsorted(below, 0.5 * (1.0 - level), side="right"))
    averages = walsh_averages(x)
    return (-np.inf, np.inf) if left_out == 0 else (float(averages[left_out - 1]), float(averages[-left_out]))
