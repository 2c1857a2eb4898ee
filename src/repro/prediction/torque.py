"""Error of the rebuilt torque."""

import numpy as np

from repro.model.parameters import Array
from repro.regression.prepare import Regression
from repro.signals.metric import metr2ev


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
