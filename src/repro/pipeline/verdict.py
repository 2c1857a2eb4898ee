"""Does a method beat another on T1 to T4: in how many runs, and by how much, over arms and specimens."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from repro.model.parameters import Array
from repro.streams import Stream, stream

#: Resamples of the bootstrap.
RESAMPLES = 9999


def verdict(scores: pd.DataFrame, methods: Sequence[str], opponents: Sequence[str]) -> pd.DataFrame:
    """Is a method better than an opponent: in how many runs, and by how much?

    From columns ``case, joint, method, duration, arm, seed, total``.
    """
    index = ["motion", "joint", "duration", "arm", "seed"]
    totals = scores.rename(columns={"case": "motion"}).pivot(index=index, columns="method", values="total")
    rows = []
    for method in methods:
        for opponent in opponents:
            difference = (totals[method] - totals[opponent]).rename("difference").reset_index()
            for k, (key, group) in enumerate(difference.groupby(["motion", "joint", "duration"], sort=True)):
                of_arms = [arm.to_numpy() for _, arm in group.groupby("arm")["difference"]]
                d = np.stack(of_arms)  # (arms, specimens)
                won = (int((d > 0).sum()), float((d > 0).mean()))
                rows.append((*list(key), method, opponent, len(d), d.size, *won, *_median(d, k)))
    columns = ["motion", "joint", "duration", "method", "opponent", "arms", "runs", "wins"]
    columns += ["win_share", "difference_median", "difference_low", "difference_high"]
    return pd.DataFrame(rows, columns=columns)


def _median(values: Array, index: int) -> tuple[float, float, float]:
    """Median with its 95 % bootstrap percentile interval; equal values are their own interval."""
    rng, (arms, specimens) = stream(0, Stream.BOOTSTRAP, index), values.shape
    arm = rng.integers(arms, size=(RESAMPLES, arms, 1))
    drawn = values[arm, rng.integers(specimens, size=(RESAMPLES, arms, specimens))]
    low, high = np.quantile(np.median(drawn.reshape(RESAMPLES, -1), axis=1), [0.025, 0.975])
    return float(np.median(values)), float(low), float(high)
