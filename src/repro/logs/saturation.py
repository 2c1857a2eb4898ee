"""What samples show of where they come from: the step they were rounded to, and the limit of the drive."""

import numpy as np

from repro.logs.log import Log
from repro.model.parameters import Array

#: Changes of more steps than this say nothing, because rounding on printing adds up.
_FEW_STEPS = 50.0


def quantisation_step(x: Array) -> float | None:
    """Smallest change that most changes are multiples of."""
    changes = np.abs(np.diff(x))
    changes = changes[changes > 1e-9 * np.abs(x).max(initial=0.0)]
    if changes.size < 20:
        return None
    small = changes[changes <= _FEW_STEPS * changes.min()]
    if small.size < max(20, 0.3 * changes.size):
        return None
    step = float(small.min())
    for _ in range(3):  # what was printed with few digits is a multiple on average
        step = float(small.sum() / np.rint(small / step).sum())
    apart = np.abs(small / step - np.rint(small / step))
    return step if float((apart < 0.1).mean()) > 0.9 else None


#: Samples at an extreme value that are too few to say that it is a limit.
_FEW = 5
#: Times as many samples at the extreme value as one step below it, if it is a limit.
_PILE = 4.0


def saturated_share(log: Log) -> tuple[float, float]:
    """Share of the samples whose torque is at its limit.

    Where the limit is not known, a largest or smallest torque that comes up again and again, far more often than
    the values next to it, is taken for one.
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
