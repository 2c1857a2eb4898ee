"""Outcomes of the study made by hand."""

import itertools

import numpy as np
import pandas as pd

from repro_studies.design import KEYS, RANKS


def outcomes(gain, arms=12, seed=4):
    """Outcomes in which the posterior's similarity is `gain` (by prior) above that of least squares.

    What varies from arm to arm is the same in all cells: all networks of a method are equally good.
    """
    rng, rows = np.random.default_rng(seed), []
    noise = 0.002 * rng.random((8, arms))
    levels = 0.8 + 0.1 * rng.random(arms)
    for cell in itertools.product(("eq10", "optimal"), (0.97, 0.9), ("wide", "narrow"), [1.0], range(arms)):
        *_, prior, _, arm = cell
        own = {"ordinary": 0.0, "consistent": 0.01, "posterior": gain[prior], "algorithm1": -0.1}
        own |= {"algorithm1+tracked": -0.1, "generalised+prior": 0.02, "flow": gain[prior] - 0.03, "generalised": 0.0}
        for (method, more), of_arms in zip(own.items(), noise, strict=True):
            at_random = dict(zip(RANKS, rng.random(9), strict=True)) if method == "posterior" else {}
            row = dict(zip(KEYS, (*cell, method), strict=True)) | dict.fromkeys(RANKS, np.nan) | at_random
            scores = {"id": levels[arm], "validation": levels[arm] + more + of_arms[arm]}
            rows.append({**row, **scores, "nearer": rng.random()})
    errors = dict.fromkeys(("torque_error", "parameter_error", "position_error"), 0.1)
    return pd.DataFrame(rows).assign(contraction=0.5, **errors)
