"""Does Algorithm 1 beat least squares on T1 to T4? Shares of runs won, and medians of the difference."""

from collections.abc import Sequence
from math import sqrt
from statistics import NormalDist

import numpy as np
import pandas as pd

from repro.model.parameters import Array
from repro.streams import Stream, stream

#: Resamples of the bootstrap.
RESAMPLES = 9999


def verdict(scores: pd.DataFrame, methods: Sequence[str], opponent: str = "least-squares") -> pd.DataFrame:
    """Is a method better than least squares: in how many runs, and by how much?

    Parameters
    ----------
    scores : DataFrame
        Columns ``case, joint, method, duration, seed, total``.
    methods : sequence of str
        Methods to compare with `opponent`.
    opponent : str
        What they are compared with.

    Returns
    -------
    DataFrame
        For each method, motion, joint and duration: runs, wins, their share with its 95 % Wilson interval, and
        the median of the paired difference of total similarity with its 95 % bootstrap percentile interval.
    """
    index = ["motion", "joint", "duration", "seed"]
    totals = scores.rename(columns={"case": "motion"}).pivot(index=index, columns="method", values="total")
    rows = []
    for method in methods:
        difference = (totals[method] - totals[opponent]).rename("difference").reset_index()
        for k, (key, group) in enumerate(difference.groupby(["motion", "joint", "duration"], sort=True)):
            d = group["difference"].to_numpy()
            wins = int((d > 0).sum())
            rows.append((*list(key), method, len(d), wins, wins / len(d), *wilson(wins, len(d)), *_median(d, k)))
    columns = ["motion", "joint", "duration", "method", "runs", "wins", "win_share", "win_low", "win_high"]
    return pd.DataFrame(rows, columns=[*columns, "difference_median", "difference_low", "difference_high"])


def wilson(wins: int, runs: int) -> tuple[float, float]:
    """95 % interval of a share after Wilson (1927): shares p with (wins - runs p)^2 <= z^2 runs p (1 - p).

    Parameters
    ----------
    wins, runs : int
        Successes, and trials in all, at least 1.

    Returns
    -------
    low, high : float
        Ends of the interval; exactly 0 without a win, exactly 1 without a loss.
    """
    z2 = NormalDist().inv_cdf(0.975) ** 2
    centre, half = wins + z2 / 2, sqrt(z2 * wins * (runs - wins) / runs + z2**2 / 4)
    low = (centre - half) / (runs + z2) if wins else 0.0
    high = (centre + half) / (runs + z2) if wins < runs else 1.0
    return low, high


def _median(values: Array, index: int) -> tuple[float, float, float]:
    """Median with its 95 % bootstrap percentile interval; a single value, or equal ones, are their own interval."""
    middle = float(np.median(values))
    if np.ptp(values) == 0:
        return middle, middle, middle
    resamples = stream(0, Stream.BOOTSTRAP, index).choice(values, (RESAMPLES, len(values)))
    low, high = np.quantile(np.median(resamples, axis=1), [0.025, 0.975])
    return middle, float(low), float(high)
