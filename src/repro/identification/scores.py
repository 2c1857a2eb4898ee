"""How well parameters rebuild a torque."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from repro.identification.regression import Regression
from repro.model.dynamics import rebuild_torque
from repro.model.parameters import Array
from repro.signals.metric import MetricSettings, metr2ev


def score(y: Array, tau: Array, estimates: Mapping[str, Any], metric: MetricSettings) -> pd.DataFrame:
    """Similarity of a torque and its rebuilding by each method (**metr2ev**).

    Parameters
    ----------
    y : array of shape (2, N, 9)
        Regressor.
    tau : array of shape (2, N)
        Torque, N m.
    estimates : mapping of str to mapping
        By method, with the parameters in ``beta``.
    metric : MetricSettings
        Formulas.

    Returns
    -------
    DataFrame
        Columns ``method, joint, time, frequency, total``, fractions of 1.
    """
    rows = []
    for method, estimate in estimates.items():
        s = metr2ev(tau, rebuild_torque(y, np.array(estimate["beta"])), metric)
        rows += [(method, j + 1, s.time[j], s.frequency[j], s.total[j]) for j in (0, 1)]
    return pd.DataFrame(rows, columns=["method", "joint", "time", "frequency", "total"])


def relative_rms(regression: Regression, beta: Array) -> tuple[float, float]:
    """RMS torque error over RMS torque of each joint.

    Parameters
    ----------
    regression : Regression
        Filtered regressor and torque of the motion predicted.
    beta : array of shape (9,)
        Parameters.

    Returns
    -------
    tuple of 2 floats
        Fractions of 1; 0 where a joint has no torque and none is predicted, infinity where one is.
    """
    error = np.sqrt(np.mean((regression.tau - regression.y @ beta) ** 2, axis=-1))
    whole = np.sqrt(np.mean(regression.tau**2, axis=-1))
    with np.errstate(divide="ignore", invalid="ignore"):
        first, second = np.where(error > 0.0, error / whole, 0.0)
    return float(first), float(second)


def similarity(regression: Regression, beta: Array) -> tuple[float, float]:
    """Total of ``metr2ev`` of each joint, fractions of 1; 0 where a joint has no torque."""
    totals = [
        float(metr2ev(tau, rebuilt).total) if np.any(tau) else 0.0
        for tau, rebuilt in zip(regression.tau, regression.y @ beta, strict=True)
    ]
    return totals[0], totals[1]
