"""Methods compared over the accepted experiments.

The value of a method for an experiment is the mean of its totals over T1 to T4 and both joints, so that the dependent
cells count once. The difference of a pair of methods has one value each; all statements on pairs are valid at once.
"""

from collections.abc import Sequence
from itertools import product

import numpy as np
import pandas as pd

from repro.config.model import Configuration
from repro.experiments.arm import Recording
from repro.model.parameters import Array
from repro.signals.metric import MetricSettings, TorqueScorer

#: Mean totals that lie no further apart count as the same.
EQUIVALENT = 0.005
#: Probability of one false statement in a family of pairs.
FAMILY_LEVEL = 0.05
BETTER, WORSE, SAME, OPEN = "better", "worse", "equivalent", "open"
COMPARISON_COLUMNS = (
    "method", "opponent", "experiments", "wins", "difference", "low", "high", "p", "p_holm", "conclusion",
)  # fmt: skip


class ArmScores:
    """Similarity of estimates on the recordings of one experiment, the one that is identified from first."""

    def __init__(self, recordings: Sequence[Recording], config: Configuration) -> None:
        self.regressions = [recording.regression(config.signals) for recording in recordings]
        self._of: dict[MetricSettings, list[TorqueScorer]] = {}

    def __call__(self, beta: Array, metric: MetricSettings) -> dict[str, float]:
        """Mean total of both joints on ID, and over T1 to T4."""
        if metric not in self._of:
            self._of[metric] = [TorqueScorer(r.tau, r.y, metric) for r in self.regressions]
        totals = [float(score(beta).total.mean()) for score in self._of[metric]]
        return {"id": totals[0], "validation": float(np.mean(totals[1:]))}


def comparisons(scores: pd.DataFrame, methods: Sequence[str], opponents: Sequence[str]) -> pd.DataFrame:
    """Compare each method with each opponent; the pairs are one family."""
    validated = scores[scores["case"] != "ID"]
    values = validated.groupby(["experiment", "method"])["total"].mean().unstack()
    pairs, rows = [*product(methods, opponents)], []
    differences = [(values[method] - values[opponent]).to_numpy() for method, opponent in pairs]
    p = np.array([_signed_rank_p(d) for d in differences])
    for pair, d, own, adjusted in zip(pairs, differences, p, holm(p), strict=True):
        middle, low, high = interval(d, 1.0 - FAMILY_LEVEL / len(pairs))
        conclusion = conclude(low, high, middle * (adjusted < FAMILY_LEVEL))
        rows.append((*pair, len(d), int((d > 0).sum()), middle, low, high, own, adjusted, conclusion))
    return pd.DataFrame(rows, columns=list(COMPARISON_COLUMNS))


def conclude(low: float, high: float, sign: float) -> str:
    """Word for an interval of a difference: equivalent within the margin, then by its sign, 0 where it is open."""
    if low > -EQUIVALENT and high < EQUIVALENT:
        return SAME
    return BETTER if sign > 0 else WORSE if sign < 0 else OPEN


def _signed_rank_p(differences: Array) -> float:
    """Two-sided p value of Wilcoxon's signed-rank test; 1 where no arm shows a difference."""
    if not np.any(differences):
        return 1.0
    from scipy import stats  # noqa: PLC0415 (a quarter of a second, in each job that reads the workflow)

    return float(stats.wilcoxon(differences, zero_method="pratt").pvalue)


def holm(p: Array) -> Array:
    """Adjust the p values of a family (Holm 1979): the k-th smallest of m times m - k + 1, never below an earlier."""
    order = np.argsort(p)
    adjusted = np.minimum(1.0, np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1)))
    return adjusted[np.argsort(order)]


def interval(x: Array, level: float) -> tuple[float, float, float]:
    """Centre of values (Hodges and Lehmann) and its exact distribution-free interval (Hollander and Wolfe).

    The interval belongs to the signed-rank test, and is infinite where so few values cannot reach the level.
    """
    first, second = np.triu_indices(len(x))
    averages = np.sort(0.5 * (x[first] + x[second]))  # of all pairs, each value with itself too
    counts = np.ones(1)  # of subsets of the ranks 1 ... n by their sum: the null distribution of the statistic
    for rank in range(1, len(x) + 1):
        counts = np.convolve(counts, np.r_[1.0, np.zeros(rank - 1), 1.0])
    below = np.cumsum(counts) / counts.sum()
    left_out = int(np.searchsorted(below, 0.5 * (1.0 - level), side="right"))
    ends = (-np.inf, np.inf) if left_out == 0 else (float(averages[left_out - 1]), float(averages[-left_out]))
    return float(np.median(averages)), *ends
