"""Samples at which a drive gave all it could."""

import numpy as np

from repro.logs.log import Log
from repro.logs.quantisation import quantisation_step
from repro.model.parameters import Array

#: Samples at an extreme value that are too few to say that it is a limit.
_FEW = 5
#: Times as many samples at the extreme value as one step below it, if it is a limit.
_PILE = 4.0


def saturated_share(log: Log) -> tuple[float, float]:
    """Share of the samples whose torque is at its limit.

    Where the limit is not known, a largest or smallest torque that comes up again and again, far more often than
    the values next to it, is taken for one.

    Parameters
    ----------
    log : Log
        Recording.

    Returns
    -------
    tuple of 2 floats
        Fraction for each joint.
    """
    if log.torque_limit is not None:
        known = np.mean(np.abs(log.tau) >= 0.999 * log.torque_limit[:, np.newaxis], axis=1)
        return float(known[0]), float(known[1])
    return _piled_up(log.tau[0]), _piled_up(log.tau[1])


def _piled_up(tau: Array) -> float:
    """Share of samples at the extreme values, if they pile up there."""
    largest = float(np.abs(tau).max())
    step = quantisation_step(tau) or 1e-6 * largest
    share = 0.0
    for side in (tau, -tau):
        top = float(side.max())
        if top < 0.5 * largest or largest == 0.0:
            continue
        at_top = int(np.count_nonzero(side > top - 0.5 * step))
        below = int(np.count_nonzero(side > top - 1.5 * step)) - at_top
        if at_top >= _FEW and at_top > _PILE * below:
            share += at_top / tau.size
    return share
