"""The step that a signal was rounded to, where its samples show one."""

import numpy as np

from repro.model.parameters import Array

#: Changes of more steps than this say nothing, because rounding on printing adds up.
_FEW_STEPS = 50.0


def quantisation_step(x: Array) -> float | None:
    """Smallest change that most changes are multiples of.

    Parameters
    ----------
    x : array of shape (N,)
        Samples.

    Returns
    -------
    float or None
        Step, in the unit of `x`; None if none can be seen.
    """
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
