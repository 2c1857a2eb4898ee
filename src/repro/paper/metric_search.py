"""Which formulas did Algorithm 2 hold? A search that asks the published numbers.

Tables 4 and 5 print four true parameter sets with their published estimates, Table 7 the similarity of the
torques of each pair on a random trajectory (Section V-B), in time and in frequency. Each candidate formula
scores the same pairs on random trajectories made here; the nearer it comes to the printed rows, the better it
explains them. The figure of merit is the rms, over the eight cells (four arms, two joints), of
log(1 - s) - log(1 - s_published), with log(1 - s) averaged over the repeated trajectories: a shortfall from
100 % is compared as a ratio, so 0.7 means wrong by a factor of two.

The paper gives the filter of its random trajectory (Eq. 14) but not the unit of its omega, so the search
runs over nine bandwidths, which include the three readings; see `BANDWIDTHS`. `repro.paper.metric_checks`
holds the checks that need no random trajectory.
"""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from repro.model.dynamics import rebuild_torque, regressor
from repro.model.parameters import Array
from repro.paper.metric_candidates import Candidate, Factor, frequency_candidates, time_candidates
from repro.paper.metric_checks import AbstractCheck, abstract_check, composition, pair_bounds
from repro.paper.published import Published, load_published
from repro.signals.dct import spectrum
from repro.signals.metric import PUBLISHED_METRIC
from repro.signals.trajectories import Motion, identification_trajectory, random_trajectory

__all__ = ["AbstractCheck", "abstract_check", "candidates", "composition", "log_errors", "pair_bounds", "search"]

#: Bandwidths of the random trajectory: omega at which exp(-c_f omega^2) is 1/e, rad/s, so c_f = 1/omega^2.
#: The published c_f = 1e-4 gives 33.3 over 3 pi s if omega is the band number, 100 if rad/s, 628 if Hz.
BANDWIDTHS = (2.5, 5.0, 10.0, 20.0, 100.0 / 3.0, 50.0, 100.0, 200.0, 200.0 * np.pi)

DURATION = 3.0 * np.pi  # s, that of Eq. 10
SAMPLING_PERIOD = 2.5e-3  # s

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


def score_candidates(
    motion: Motion, true: Array, estimate: Array, exponent: float = PUBLISHED_METRIC.exponent
) -> Array:
    """Similarity (1 - error)^exponent, floored at 0, by every candidate for pairs of parameter sets."""
    y = regressor(motion.q, motion.dq, motion.ddq)
    actual, rebuilt = rebuild_torque(y, true), rebuild_torque(y, estimate)
    pair = {"time": (actual, rebuilt), "frequency": (spectrum(actual), spectrum(rebuilt))}
    error = np.stack([c.error(*pair[c.factor]) for c in candidates()])
    return np.asarray(np.clip(1.0 - error, 0.0, 1.0) ** exponent)


def log_errors(
    seed: int,
    repeats: int = 32,
    bandwidths: Sequence[float] = BANDWIDTHS,
    exponent: float = PUBLISHED_METRIC.exponent,
    published: Published | None = None,
) -> Array:
    """log(1 - s) - log(1 - s_published) on the cells of Table 7, for every candidate.

    1 - s is held above `SMALLEST_SHORTFALL`; a similarity floored at 0 gives log(1 - s) = 0.
    """
    if repeats < 1:
        raise ValueError(f"repeats: at least one trajectory is needed, got {repeats}.")
    if not bandwidths or not min(bandwidths) > 0:
        raise ValueError(f"bandwidths: at least one, all positive, got {tuple(bandwidths)}.")
    numbers = load_published() if published is None else published
    true, estimate = numbers.parameter_sets("true"), numbers.parameter_sets("algorithm1")
    printed = np.stack([numbers.similarities(c.factor) for c in candidates()])
    ours = np.zeros((len(bandwidths), *printed.shape))
    for b, omega in enumerate(bandwidths):
        for repeat in range(repeats):
            rng = np.random.default_rng([seed, repeat])
            motion = random_trajectory(rng, DURATION, SAMPLING_PERIOD, omega**-2, "rad_per_s")
            shortfall = 1.0 - score_candidates(motion, true, estimate, exponent)
            ours[b] += np.log(np.maximum(shortfall, SMALLEST_SHORTFALL)) / repeats
    return np.asarray(ours - np.log(np.maximum(1.0 - printed, SMALLEST_SHORTFALL)))


def search(
    seed: int,
    repeats: int = 32,
    bandwidths: Sequence[float] = BANDWIDTHS,
    exponent: float = PUBLISHED_METRIC.exponent,
    published: Published | None = None,
) -> pd.DataFrame:
    """Score every candidate formula against the Time and Freq. rows of Table 7."""
    numbers = load_published() if published is None else published
    rms = np.sqrt(np.mean(log_errors(seed, repeats, bandwidths, exponent, numbers) ** 2, axis=(-2, -1)))
    entries = candidates()
    table = pd.DataFrame(
        {
            "factor": [c.factor for c in entries],
            "candidate": [c.name for c in entries],
            "formula": [c.formula for c in entries],
            "rms_log_error_best": rms.min(0),
            "rms_log_error_mean": rms.mean(0),
            "best_bandwidth": np.asarray(bandwidths, dtype=np.float64)[rms.argmin(0)],
        }
    )
    # Equal formulas under two names differ by rounding; without it their order would hang on the machine.
    best = table["rms_log_error_best"].round(9)
    table["rank"] = best.groupby(table["factor"]).rank(method="min").astype(int)
    table["chosen"] = [CHOSEN[c.factor] == c.name for c in entries]
    table["abstract_mean_total"] = _abstract_mean_totals(numbers, exponent)
    table["is_frequency"] = table["factor"] == "frequency"
    table = table.sort_values(["is_frequency", "rank"], kind="stable", ignore_index=True)
    return table.drop(columns="is_frequency")


def _abstract_mean_totals(numbers: Published, exponent: float) -> Array:
    """Mean total on Eq. 10 of each candidate times the chosen one of the other factor."""
    motion = identification_trajectory(DURATION, SAMPLING_PERIOD)
    true, estimate = numbers.parameter_sets("true"), numbers.parameter_sets("algorithm1")
    s = score_candidates(motion, true, estimate, exponent)
    entries = candidates()
    chosen = {c.factor: s[k] for k, c in enumerate(entries) if CHOSEN[c.factor] == c.name}
    other = {"time": chosen["frequency"], "frequency": chosen["time"]}
    return np.array([np.mean(s[k] * other[c.factor]) for k, c in enumerate(entries)])
