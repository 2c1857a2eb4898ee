"""Search for the formulas of Algorithm 2 and for the random motion of Table 7; checks of the published similarities.

Tables 4 and 5 print four true parameter sets with their estimates, Table 7 the similarity of the torques of each pair
on a random trajectory (Section V-B). Each candidate formula scores the same pairs on random motions. Its figure of
merit is the rms, over the eight cells (four arms, two joints), of log(1 - s) - log(1 - s_published), with log(1 - s)
averaged over the repeated motions. The logarithm compares shortfalls from 100 % as ratios: 0.7 is a factor of two.

The paper prints the filter of its random trajectory (Eq. 14), but neither the unit of its omega nor the length of the
trajectory: the search covers the `MOTIONS`. Checks that need no random motion follow the search.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from repro.config.model import Configuration
from repro.model.dynamics import rebuild_torque, regressor
from repro.model.parameters import Array
from repro.paper.metric_candidates import CANDIDATES, Factor, Pair
from repro.paper.published import CELL, NUMERIC_CASES, Published, load_published, similarity_cells
from repro.signals.dct import spectrum
from repro.signals.metric import PUBLISHED_METRIC, MetricSettings, metr2ev
from repro.signals.trajectories import Motion, identification_trajectory, random_trajectory

DURATION = 3.0 * np.pi  # s, that of Eq. 10
SAMPLING_PERIOD = 2.5e-3  # s
EXPONENT = PUBLISHED_METRIC.exponent


@dataclass(frozen=True)
class RandomMotion:
    """Length and bandwidth of a random motion (Section V-B)."""

    samples: int
    bandwidth: float  # rad/s, where the gain exp(-c_f omega^2) of Eq. 14 is 1/e, so c_f = 1/bandwidth^2

    @property
    def duration(self) -> float:
        """Duration, s."""
        return self.samples * SAMPLING_PERIOD

    @property
    def bands(self) -> float:
        """Number of the DCT-II band at the bandwidth."""
        return self.bandwidth * self.duration / np.pi

    def draw(self, rng: np.random.Generator) -> Motion:
        """Draw a motion."""
        return random_trajectory(rng, self.duration, SAMPLING_PERIOD, self.bandwidth**-2, "rad_per_s")


def band_number_motion(samples: int, c_f: float = 1e-4) -> RandomMotion:
    """Return the motion whose filter counts omega in bands: the published c_f = 1e-4 is 100 bands at any length."""
    return RandomMotion(samples, np.pi / (samples * SAMPLING_PERIOD * np.sqrt(c_f)))


#: Bandwidths at the length of Eq. 10, rad/s. The published c_f = 1e-4 is 33.3 rad/s if omega is the band number, 100
#: if omega is in rad/s and 628 if omega is in Hz.
BANDWIDTHS = (2.5, 5.0, 10.0, 20.0, 100.0 / 3.0, 50.0, 100.0, 200.0, 200.0 * np.pi)

#: Motions of the search: those bandwidths, then further lengths in samples with 100 bands.
MOTIONS = (
    *(RandomMotion(round(DURATION / SAMPLING_PERIOD), bandwidth) for bandwidth in BANDWIDTHS),
    *(band_number_motion(samples) for samples in (6000, 8192, 12_000, 16_384, 24_000, 32_768)),
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


def _torques(motion: Motion, published: Published) -> tuple[Array, Array]:
    """Torques of the true parameters of Tables 4 and 5, and of their estimates."""
    y = regressor(motion.q, motion.dq, motion.ddq)
    true, estimate = (rebuild_torque(y, published.parameter_sets(name)) for name in ("true", "algorithm1"))
    return true, estimate


def score_torques(actual: Array, rebuilt: Array) -> Array:
    """Similarity (1 - error)^0.4 of torques (arms, 2, N) by every candidate, floored at 0: (candidates, arms, 2)."""
    scores = []
    for x, y in zip(actual, rebuilt, strict=True):  # the arrays of one arm fit the processor's cache
        pairs = {"time": Pair(x, y), "frequency": Pair(spectrum(x), spectrum(y))}
        error = np.stack([c.measure(pairs[c.factor]) for c in CANDIDATES])
        scores.append(np.clip(1.0 - error, 0.0, 1.0) ** EXPONENT)
    return np.stack(scores, axis=1)


def score_candidates(motion: Motion, published: Published) -> Array:
    """Similarity of the pairs of Tables 4 and 5 by every candidate, shape (candidates, arms, 2)."""
    return score_torques(*_torques(motion, published))


def search_metric(config: Configuration) -> list[pd.DataFrame]:
    """Make the tables of the search and of the checks, in the order of the rule's files."""
    settings, published = config.metric_search, load_published()
    scores = score_motions(published, settings.seed, settings.repeats)
    checks = composition, abstract_check, pair_bounds, torque_bounds, least_squares_torque
    return [rank_candidates(scores), compare_motions(scores), *(check(published) for check in checks)]


@dataclass(frozen=True)
class Scores:
    """Scores of the published pairs by every candidate on every motion."""

    motions: tuple[RandomMotion, ...]
    # log(1 - s), averaged over the repeats, minus log(1 - s_published) in Table 7: (motions, candidates, arms, 2)
    log_error: Array
    mean_square: Array  # median over the repeats of the mean-square actual torque, (N m)^2, shape (motions, arms, 2)
    published: Published

    def rms(self, without: int | None = None) -> Array:
        """Rms log error over the cells of all arms, or of all but one: (motions, candidates)."""
        arms = [arm for arm in range(self.log_error.shape[-2]) if arm != without]
        errors = self.log_error[..., arms, :].reshape(*self.log_error.shape[:2], -1)
        return np.asarray(np.sqrt(np.mean(errors**2, -1)))


def score_motions(published: Published, seed: int, repeats: int, motions: Sequence[RandomMotion] = MOTIONS) -> Scores:
    """Score the published pairs of Tables 4 and 5 by every candidate on random motions."""
    printed = np.stack([published.similarities(c.factor) for c in CANDIDATES])
    ours = np.zeros((len(motions), *printed.shape))
    mean_square = np.zeros((len(motions), repeats, *printed.shape[1:]))
    for m, motion in enumerate(motions):
        for repeat in range(repeats):
            actual, rebuilt = _torques(motion.draw(np.random.default_rng([seed, repeat])), published)
            shortfall = 1.0 - score_torques(actual, rebuilt)
            ours[m] += np.log(np.maximum(shortfall, SMALLEST_SHORTFALL)) / repeats
            mean_square[m, repeat] = np.mean(actual**2, -1)
    log_error = ours - np.log(np.maximum(1.0 - printed, SMALLEST_SHORTFALL))
    return Scores(tuple(motions), log_error, np.median(mean_square, axis=1), published)


def rank_candidates(scores: Scores) -> pd.DataFrame:
    """Rank the candidates of each factor by their rms log error against Table 7 at their best motion."""
    rms = scores.rms()
    best = [scores.motions[m] for m in rms.argmin(0)]
    # One arm left out at a time, with the best motion of each candidate chosen again from the other six cells.
    left_out = [_ranks(scores.rms(arm)) for arm in range(scores.log_error.shape[-2])]
    on_eq10 = score_candidates(identification_trajectory(DURATION, SAMPLING_PERIOD), scores.published)
    other = {"time": on_eq10[_place("frequency")], "frequency": on_eq10[_place("time")]}
    table = pd.DataFrame(
        {
            "factor": [c.factor for c in CANDIDATES],
            "candidate": [c.name for c in CANDIDATES],
            "formula": [c.formula for c in CANDIDATES],
            "rms_log_error_best": rms.min(0),
            "samples": [motion.samples for motion in best],
            "bandwidth": [motion.bandwidth for motion in best],
            "rms_log_error_mean": rms.mean(0),
            "rank": _ranks(rms),
            "rank_low": np.min(left_out, axis=0),
            "rank_high": np.max(left_out, axis=0),
            "chosen": [CHOSEN[c.factor] == c.name for c in CANDIDATES],
            # On Eq. 10, with the chosen candidate of the other factor.
            "abstract_mean_total": [np.mean(s * other[c.factor]) for s, c in zip(on_eq10, CANDIDATES, strict=True)],
        }
    )
    return table.sort_values(["factor", "rank"], ascending=[False, True], kind="stable", ignore_index=True)


def _ranks(rms: Array) -> pd.Series:
    """Ranks within each factor of the smallest errors over the motions."""
    # Equal formulas with two names differ by rounding, which would make their order depend on the machine.
    best = pd.Series(rms.min(0).round(9))
    return best.groupby([c.factor for c in CANDIDATES]).rank(method="min").astype(int)


def _place(factor: Factor, name: str | None = None) -> int:
    """Index of a candidate, by default the chosen one of a factor."""
    return [(c.factor, c.name) for c in CANDIDATES].index((factor, name or CHOSEN[factor]))


def compare_motions(scores: Scores) -> pd.DataFrame:
    """Compare the motions with Table 7: mean-square torque, bounds of `pair_bounds` satisfied, rms log errors."""
    bounds = pair_bounds(scores.published).set_index("id")["largest_rms"] ** 2
    largest = np.array([[bounds[f"table07/{case}/joint{j}"] for j in (1, 2)] for case in NUMERIC_CASES])
    rms = scores.rms()
    time, frequency = rms[:, _place("time")], rms[:, _place("frequency")]
    of_motions = {
        name: [getattr(motion, name) for motion in scores.motions]
        for name in ("samples", "duration", "bandwidth", "bands")
    }
    return pd.DataFrame(
        {
            **of_motions,
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


def composition(published: Published) -> pd.DataFrame:
    """Check the published Totals of Tables 7 and 10 against the factors printed with them, to rounding."""
    t = similarity_cells(published)
    # Total = Time x Freq. if the power 0.4 is part of the factors; otherwise it is (Time x Freq.)^0.4.
    product = t["time"] * t["frequency"] / 100.0
    power_last = 100.0 * (product / 100.0) ** EXPONENT
    # First order in the half steps: their product, 2.5e-7 %, is far below any difference found.
    tolerance = t["total_step"] + (t["time_step"] * t["frequency"] + t["frequency_step"] * t["time"]) / 100.0
    return t[["id", *CELL, "time", "frequency", "total"]].assign(
        product=product,
        difference=t["total"] - product,
        tolerance=tolerance,
        agrees=(t["total"] - product).abs() <= tolerance,
        agrees_power_last=(t["total"] - power_last).abs() <= tolerance,
    )


def abstract_check(published: Published, settings: MetricSettings = PUBLISHED_METRIC) -> pd.DataFrame:
    """Score the pairs of Tables 4 and 5 on Eq. 10; the abstract has 97.38 % as their least total, Table 6 is lost."""
    s = metr2ev(*_torques(identification_trajectory(h=SAMPLING_PERIOD), published), settings)
    columns = {name: getattr(s, name).ravel() for name in ("time", "frequency", "total")}
    return pd.DataFrame({"case": np.repeat(NUMERIC_CASES, 2), "joint": np.tile([1, 2], len(NUMERIC_CASES)), **columns})


def _error(percent: pd.Series) -> pd.Series:
    """Error of a printed similarity."""
    return 1.0 - (percent / 100.0) ** (1.0 / EXPONENT)


def _least_energy_error(percent: pd.Series) -> pd.Series:
    """Least |x-y|^2 / |x|^2 that a printed Freq. value permits."""
    return 1.0 - (1.0 - 0.5 * _error(percent) ** 2) ** 2


def pair_bounds(published: Published) -> pd.DataFrame:
    """Compute which Time values are possible with the printed Freq. values.

    Let the frequency error be d = |X/|X| - Y/|Y||. The DCT-II preserves inner products, so the signals have the cosine
    c = 1 - d^2/2, and |x - y|^2 >= |x|^2 (1 - c^2) for any scale of y. A time error |x-y|^2 / |x|^2 is therefore at
    least 1 - c^2 for any torque. A time error mean((x-y)^2) has no such limit, but it bounds the torque: rms(x) <=
    sqrt(error / (1 - c^2)). With unsigned spectra |X| instead of X the true c is smaller, and both bounds remain valid.
    """
    t = similarity_cells(published)
    error, least = _error(t["time"] - t["time_step"]), _least_energy_error(t["frequency"] + t["frequency_step"])
    return t[["id", *CELL, "time", "frequency"]].assign(
        id=t["id"].str.replace("/total/", "/"),
        time_error=error,
        least_energy_error=least,
        energy_possible=error >= least,
        largest_rms=np.sqrt(error / least),
    )


def torque_bounds(published: Published) -> pd.DataFrame:
    """Compute the largest mean-square torque of each motion and joint of Table 10, in (N m)^2.

    The bound of `pair_bounds` applies to the actual torque, which is the same for both methods: the smaller one counts.
    """
    bounds = pair_bounds(published).query("place == 'Table 10'")
    smallest = bounds.loc[bounds.groupby(["case", "joint"], sort=False)["largest_rms"].idxmin()]
    largest = {"largest_mean_square": smallest["largest_rms"] ** 2, "published_method": smallest["method"]}
    return smallest[["case", "joint"]].assign(**largest).reset_index(drop=True)


def least_squares_torque(published: Published) -> pd.DataFrame:
    """Estimate the mean-square torque of the identification run from the pairs of least squares, in (N m)^2.

    The bound of `pair_bounds` is reached by a rebuilt torque with the best scale, which least squares need not give to
    a single joint: it fits both with common parameters. `low` and `high` come from the rounding of the print. An
    estimate that is not `possible`, being above the bound of Algorithm 1 for the same torque, is an upper bound only.
    """
    bound = pair_bounds(published).set_index("id")["largest_rms"] ** 2
    t = similarity_cells(published).query("case == 'ID' and method == 'least-squares'")
    low, estimate, high = (
        _error(t["time"] - s * t["time_step"]) / _least_energy_error(t["frequency"] + s * t["frequency_step"])
        for s in (-1.0, 0.0, 1.0)
    )
    possible = low.to_numpy() <= bound[[f"table10/ID/algorithm1/joint{joint}" for joint in t["joint"]]].to_numpy()
    columns = {"joint": t["joint"], "mean_square": estimate, "low": low, "high": high, "possible": possible}
    return pd.DataFrame(columns).reset_index(drop=True)
