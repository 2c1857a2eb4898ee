"""Search for the formulas of Algorithm 2 and for the random motion of Table 7.

Tables 4 and 5 print four true parameter sets with their published estimates. Table 7 prints the similarity of the
torques of each pair on a random trajectory (Section V-B), in time and in frequency. Each candidate formula scores the
same pairs on random motions. Its figure of merit is the rms, over the eight cells (four arms, two joints), of
log(1 - s) - log(1 - s_published), with log(1 - s) averaged over the repeated motions. The logarithm compares
shortfalls from 100 % as ratios: 0.7 is a factor of two.

The paper prints the filter of its random trajectory (Eq. 14), but neither the unit of its omega nor the length of the
trajectory. The search therefore covers nine bandwidths at the length of Eq. 10, and the first 100 bands at six further
lengths; see `MOTIONS`. `repro.paper.metric_checks` contains the checks that need no random motion.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from repro.model.dynamics import rebuild_torque, regressor
from repro.model.parameters import Array
from repro.paper.metric_candidates import Candidate, Factor, Pair, frequency_candidates, time_candidates
from repro.paper.metric_checks import AbstractCheck, abstract_check, composition, pair_bounds
from repro.paper.published import NUMERIC_CASES, Published, load_published
from repro.signals.dct import spectrum
from repro.signals.metric import PUBLISHED_METRIC
from repro.signals.trajectories import Motion, identification_trajectory, random_trajectory

__all__ = [
    "AbstractCheck",
    "RandomMotion",
    "Scores",
    "abstract_check",
    "candidates",
    "compare_motions",
    "composition",
    "pair_bounds",
    "rank_candidates",
    "score_motions",
]

DURATION = 3.0 * np.pi  # s, that of Eq. 10
SAMPLING_PERIOD = 2.5e-3  # s


@dataclass(frozen=True)
class RandomMotion:
    """Length and bandwidth of a random motion (Section V-B)."""

    samples: int
    bandwidth: float  # rad/s, where the gain exp(-c_f omega^2) of Eq. 14 is 1/e, so c_f = 1/bandwidth^2

    def __post_init__(self) -> None:
        """Refuse a motion without samples or bandwidth."""
        if self.samples < 2 or not self.bandwidth > 0:
            raise ValueError(f"motion: at least two samples and a positive bandwidth are needed, got {self}.")

    @property
    def duration(self) -> float:
        """Duration, s."""
        return self.samples * SAMPLING_PERIOD

    @property
    def bands(self) -> float:
        """Number of the DCT-II band at the bandwidth."""
        return self.bandwidth * self.duration / np.pi

    @property
    def label(self) -> str:
        """Length and bandwidth in words."""
        return f"{self.samples} samples ({self.duration:.4g} s), {self.bandwidth:.3g} rad/s"

    def draw(self, rng: np.random.Generator) -> Motion:
        """Draw a motion."""
        return random_trajectory(rng, self.duration, SAMPLING_PERIOD, self.bandwidth**-2, "rad_per_s")


def band_number_motion(samples: int, c_f: float = 1e-4) -> RandomMotion:
    """Return the motion whose filter counts omega in bands: the published c_f = 1e-4 is 100 bands at any length."""
    return RandomMotion(samples, np.pi / (samples * SAMPLING_PERIOD * np.sqrt(c_f)))


#: Bandwidths at the length of Eq. 10, rad/s. The published c_f = 1e-4 is 33.3 rad/s if omega is the band number, 100
#: if omega is in rad/s and 628 if omega is in Hz.
BANDWIDTHS = (2.5, 5.0, 10.0, 20.0, 100.0 / 3.0, 50.0, 100.0, 200.0, 200.0 * np.pi)

#: Further lengths of the motion with 100 bands, samples.
LENGTHS = (6000, 8192, 12_000, 16_384, 24_000, 32_768)

#: Motions of the search.
MOTIONS = (
    *(RandomMotion(round(DURATION / SAMPLING_PERIOD), bandwidth) for bandwidth in BANDWIDTHS),
    *(band_number_motion(samples) for samples in LENGTHS),
)

#: The numeric validation motion of the configuration.
CHOSEN_MOTION = band_number_motion(12_000)

#: Half a printed step of a similarity: a smaller shortfall would be printed as 100.00 %.
SMALLEST_SHORTFALL = 5e-5

#: The candidates that `repro.signals.metric` computes by default.
CHOSEN: dict[Factor, str] = {
    "time": {"energy": "energy", "mean-square": "mean square"}[PUBLISHED_METRIC.time_formula],
    "frequency": "signed | 2-norm | 2-norm",
}


def candidates() -> tuple[Candidate, ...]:
    """Every candidate of both factors, time first."""
    return (*time_candidates(), *frequency_candidates())


def score_torques(actual: Array, rebuilt: Array, exponent: float = PUBLISHED_METRIC.exponent) -> Array:
    """Similarity (1 - error)^exponent of torques (2, N) by every candidate, floored at 0: (candidates, 2)."""
    pairs = {"time": Pair(actual, rebuilt), "frequency": Pair(spectrum(actual), spectrum(rebuilt))}
    error = np.stack([c.measure(pairs[c.factor]) for c in candidates()])
    return np.asarray(np.clip(1.0 - error, 0.0, 1.0) ** exponent)


def score_candidates(
    motion: Motion, true: Array, estimate: Array, exponent: float = PUBLISHED_METRIC.exponent
) -> Array:
    """Similarity of parameter sets (arms, 9) by every candidate, shape (candidates, arms, 2)."""
    return _scores_of(_torques(motion, true), _torques(motion, estimate), exponent)


def _torques(motion: Motion, beta: Array) -> Array:
    return rebuild_torque(regressor(motion.q, motion.dq, motion.ddq), beta)


def _scores_of(actual: Array, rebuilt: Array, exponent: float) -> Array:
    # One arm at a time: the arrays of one arm fit the processor's cache.
    return np.stack([score_torques(x, y, exponent) for x, y in zip(actual, rebuilt, strict=True)], axis=1)


@dataclass(frozen=True)
class Scores:
    """Scores of the published pairs by every candidate on every motion."""

    motions: tuple[RandomMotion, ...]
    # log(1 - s) - log(1 - s_published) in the cells of Table 7, shape (motions, candidates, arms, 2), with log(1 - s)
    # averaged over the repeats
    log_error: Array
    mean_square: Array  # median over the repeats of the mean-square actual torque, (N m)^2, shape (motions, arms, 2)
    exponent: float
    published: Published

    def rms(self, cells: Array | None = None) -> Array:
        """Rms log error over the cells (arms, 2) of a mask, by default all of them: (motions, candidates)."""
        errors = self.log_error[..., np.ones(self.log_error.shape[-2:], bool) if cells is None else cells]
        return np.asarray(np.sqrt(np.mean(errors**2, -1)))


def score_motions(
    seed: int,
    repeats: int = 32,
    motions: Sequence[RandomMotion] = MOTIONS,
    exponent: float = PUBLISHED_METRIC.exponent,
    published: Published | None = None,
) -> Scores:
    """Score the published pairs of Tables 4 and 5 by every candidate on random motions.

    1 - s is kept above `SMALLEST_SHORTFALL`; a similarity floored at 0 gives log(1 - s) = 0.
    """
    numbers = load_published() if published is None else published
    true, estimate = numbers.parameter_sets("true"), numbers.parameter_sets("algorithm1")
    printed = np.stack([numbers.similarities(c.factor) for c in candidates()])
    ours = np.zeros((len(motions), *printed.shape))
    mean_square = np.zeros((len(motions), repeats, *printed.shape[1:]))
    for m, motion in enumerate(motions):
        for repeat in range(repeats):
            drawn = motion.draw(np.random.default_rng([seed, repeat]))
            actual = _torques(drawn, true)
            shortfall = 1.0 - _scores_of(actual, _torques(drawn, estimate), exponent)
            ours[m] += np.log(np.maximum(shortfall, SMALLEST_SHORTFALL)) / repeats
            mean_square[m, repeat] = np.mean(actual**2, -1)
    log_error = ours - np.log(np.maximum(1.0 - printed, SMALLEST_SHORTFALL))
    return Scores(tuple(motions), log_error, np.median(mean_square, axis=1), exponent, numbers)


def rank_candidates(scores: Scores) -> pd.DataFrame:
    """Rank the candidates of each factor by their rms log error against Table 7 at their best motion.

    ``rank_low`` and ``rank_high`` are the smallest and the largest rank if one of the four arms is left out, with the
    best motion of each candidate chosen again from the other six cells.
    """
    rms = scores.rms()
    entries = candidates()
    best = [scores.motions[m] for m in rms.argmin(0)]
    table = pd.DataFrame(
        {
            "factor": [c.factor for c in entries],
            "candidate": [c.name for c in entries],
            "formula": [c.formula for c in entries],
            "rms_log_error_best": rms.min(0),
            "samples": [motion.samples for motion in best],
            "bandwidth": [motion.bandwidth for motion in best],
            "rms_log_error_mean": rms.mean(0),
        }
    )
    table["rank"] = _ranks(rms, table["factor"])
    left_out = []
    for arm in range(scores.log_error.shape[-2]):
        cells = np.ones(scores.log_error.shape[-2:], bool)
        cells[arm] = False
        left_out.append(_ranks(scores.rms(cells), table["factor"]))
    table["rank_low"], table["rank_high"] = np.min(left_out, axis=0), np.max(left_out, axis=0)
    table["chosen"] = [CHOSEN[c.factor] == c.name for c in entries]
    table["abstract_mean_total"] = _abstract_mean_totals(scores)
    table["is_frequency"] = table["factor"] == "frequency"
    table = table.sort_values(["is_frequency", "rank"], kind="stable", ignore_index=True)
    return table.drop(columns="is_frequency")


def _ranks(rms: Array, factor: pd.Series) -> pd.Series:
    """Ranks within each factor of the smallest errors over the motions."""
    # Equal formulas with two names differ by rounding, which would make their order depend on the machine.
    best = pd.Series(rms.min(0).round(9))
    return best.groupby(factor).rank(method="min").astype(int)


def _abstract_mean_totals(scores: Scores) -> Array:
    """Mean total on Eq. 10 of each candidate times the chosen candidate of the other factor."""
    motion = identification_trajectory(DURATION, SAMPLING_PERIOD)
    true, estimate = scores.published.parameter_sets("true"), scores.published.parameter_sets("algorithm1")
    s = score_candidates(motion, true, estimate, scores.exponent)
    entries = candidates()
    other = {"time": s[_place("frequency")], "frequency": s[_place("time")]}
    return np.array([np.mean(s[k] * other[c.factor]) for k, c in enumerate(entries)])


def _place(factor: Factor, name: str | None = None) -> int:
    """Index of a candidate, by default the chosen one of a factor."""
    keys = [(c.factor, c.name) for c in candidates()]
    return keys.index((factor, CHOSEN[factor] if name is None else name))


def compare_motions(scores: Scores) -> pd.DataFrame:
    """Compare the motions with Table 7: mean-square torque, published bounds satisfied, rms log errors.

    The bound of a cell is the largest mean-square torque for which its printed Time and Freq. can be a mean square and
    a distance of unit spectra (`pair_bounds`). ``rms_log_error_pair`` covers the 16 cells of the two chosen formulas.
    """
    bounds = pair_bounds(scores.published).set_index("id")["largest_rms"] ** 2
    largest = np.array([[bounds[f"table07/{case}/joint{j}"] for j in (1, 2)] for case in NUMERIC_CASES])
    rms = scores.rms()
    time, frequency = rms[:, _place("time")], rms[:, _place("frequency")]
    return pd.DataFrame(
        {
            "samples": [motion.samples for motion in scores.motions],
            "duration": [motion.duration for motion in scores.motions],
            "bandwidth": [motion.bandwidth for motion in scores.motions],
            "bands": [motion.bands for motion in scores.motions],
            "mean_square_low": scores.mean_square.min((-2, -1)),
            "mean_square_high": scores.mean_square.max((-2, -1)),
            "bounds_satisfied": (scores.mean_square <= largest).sum((-2, -1)),
            "rms_log_error_mean_square": rms[:, _place("time", "mean square")],
            "rms_log_error_energy": rms[:, _place("time", "energy")],
            "rms_log_error_frequency": frequency,
            "rms_log_error_pair": np.sqrt((time**2 + frequency**2) / 2.0),
            "chosen": [motion == CHOSEN_MOTION for motion in scores.motions],
        }
    )
