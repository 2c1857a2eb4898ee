"""Samples in which a joint stands still: left out of the fit, because Eq. 1 does not say what holds it there.

At rest static friction takes any torque up to its limit, and tanh(lambda dq) of Eq. 1 is zero. A still sample of one
joint says nothing about that joint's row of Eq. 1; the other row counts as before.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from repro.identification.regression import Regression

#: Speed below which a joint stands still, rad/s.
STILL = 0.02
#: Share of the time that a joint must move for its standstill to be left out: of a joint that hardly moves there
#: would be nothing left.
MOVES = 0.2
#: Share below which it does not move at all.
RESTS = 0.01


def _only(regression: Regression, rows: NDArray[np.bool_]) -> Regression:
    """The regression with all rows but these zero on both sides."""
    kept = rows[..., None]
    return replace(
        regression,
        y=regression.y * kept,
        tau=regression.tau * rows,
        interleaved=None if regression.interleaved is None else regression.interleaved * kept,
        moving=rows,
    )


def without_rest(regression: Regression) -> Regression:
    """Take out the rows of joints that never move: what holds them is not known of any sample."""
    moves = (np.abs(regression.dq) >= STILL).mean(-1, keepdims=True) >= RESTS
    return _only(regression, np.broadcast_to(moves, regression.dq.shape))


def without_standstill(regression: Regression) -> Regression:
    """Take out the rows of joints that stand still.

    Parameters
    ----------
    regression : Regression
        All samples.

    Returns
    -------
    Regression
        Of the same size: rows that are out are zero on both sides, so that they weigh nothing, and marked in
        `Regression.moving`.
    """
    moving = np.abs(regression.dq) >= STILL
    share = moving.mean(-1, keepdims=True)
    return _only(regression, np.where(share < RESTS, False, moving | (share < MOVES)))
