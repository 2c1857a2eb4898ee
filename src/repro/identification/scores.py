"""How well parameters rebuild a torque."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from repro.identification.regression import Regression
from repro.model.dynamics import rebuild_torque
from repro.model.parameters import Array
from repro.signals.metric import UNIT_FREE_METRIC, MetricSettings, metr2ev

#: Torque over the torques that it is made of, below which a joint is not driven.
LITTLE = 0.02


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
    """RMS torque error over RMS torque of each joint, or over the torques that it is made of.

    An arm that falls freely has no torque to compare with, but inertia, gravity and friction that add up to it: where
    the torque is less than `LITTLE` of these, they are what the error is compared with.

    Parameters
    ----------
    regression : Regression
        Filtered regressor and torque of the motion predicted.
    beta : array of shape (9,)
        Parameters.

    Returns
    -------
    tuple of 2 floats
        Fractions of 1; 0 where there is no error.
    """
    error = np.sqrt(np.mean((regression.tau - regression.y @ beta) ** 2, axis=-1))
    whole = np.where(driven(regression, beta), _rms(regression.tau), _parts(regression, beta))
    first, second = np.divide(error, whole, out=np.zeros(2), where=error > 0.0)
    return float(first), float(second)


def driven(regression: Regression, beta: Array) -> NDArray[np.bool_]:
    """Whether each joint has a torque worth comparing with, shape (2,)."""
    return np.asarray(_rms(regression.tau) >= LITTLE * _parts(regression, beta))


def _rms(tau: Array) -> Array:
    size: Array = np.sqrt(np.mean(tau**2, axis=-1))
    return size


def _parts(regression: Regression, beta: Array) -> Array:
    """RMS of the torques of inertia, gravity and friction, whatever their signs."""
    return _rms(np.abs(regression.y) @ np.abs(beta))


def similarity(regression: Regression, beta: Array) -> tuple[float, float]:
    """Total of ``metr2ev`` with the energy ratio of each joint, fractions of 1; 0 where a joint has no torque."""
    totals = [
        float(metr2ev(tau, rebuilt, UNIT_FREE_METRIC).total) if np.any(tau) else 0.0
        for tau, rebuilt in zip(regression.tau, regression.y @ beta, strict=True)
    ]
    return totals[0], totals[1]
