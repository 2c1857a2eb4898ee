"""Outcomes of the study made by hand."""

import itertools

import numpy as np
import pandas as pd

from repro.study.design import RANKS


def outcomes(gain, arms=12, seed=4):
    """Outcomes in which the posterior's similarity is `gain` (by prior) above that of least squares."""
    rng, rows = np.random.default_rng(seed), []
    levels = 0.8 + 0.1 * rng.random(arms)
    cells = itertools.product(("eq10", "optimal"), (0.97, 0.9), ("wide", "narrow"), range(arms))
    for excitation, discrepancy, prior, arm in cells:
        own = {"ordinary": 0.0, "consistent": 0.01, "posterior": gain[prior], "algorithm1": -0.1}
        own |= {"algorithm1+tracked": -0.1, "generalised+prior": 0.02, "flow": gain[prior] - 0.03}
        for method, more in own.items():
            at_random = dict(zip(RANKS, rng.random(9), strict=True)) if method == "posterior" else {}
            rows.append(
                {
                    "excitation": excitation, "discrepancy": discrepancy, "prior": prior, "friction": 1.0,
                    "arm": arm, "method": method, "validation": levels[arm] + more + 0.002 * rng.random(),
                    "id": levels[arm], "torque_error": 0.1, "parameter_error": 0.1, "position_error": 0.1,
                    "contraction": 0.5, "nearer": rng.random(), **dict.fromkeys(RANKS, np.nan), **at_random,
                }
            )  # fmt: skip
    return pd.DataFrame(rows)
