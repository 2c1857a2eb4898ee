"""What every method solves: tau = Y beta along one motion, with torque and motion through the same filters."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from repro.model.parameters import Array


@dataclass(frozen=True)
class Regression:
    """A recording made ready for a method.

    Attributes
    ----------
    t : array of shape (n,)
        Time of each kept sample, s.
    y : array of shape (2, n, 9)
        Filtered regressor.
    tau : array of shape (2, n)
        Filtered torque, N m.
    q, dq, ddq : arrays of shape (2, n)
        Smoothed motion.
    moving : bool array of shape (2, n)
        Where the rows of a joint count, see `repro.identification.standstill`.
    h : float
        Time between kept samples, s.
    interleaved : array of shape (2, 2, n, 9) or None
        The same regressor from the odd and from the even samples of the position alone, where it was made. Their
        noise is independent if that of the samples is.
    """

    t: Array
    y: Array
    tau: Array
    q: Array
    dq: Array
    ddq: Array
    moving: NDArray[np.bool_]
    h: float
    interleaved: Array | None = None

    def take(self, rows: NDArray[np.intp]) -> "Regression":
        """The samples of these numbers, in their order; one may come more than once."""
        return replace(
            self,
            t=self.t[rows],
            y=self.y[:, rows],
            tau=self.tau[:, rows],
            q=self.q[:, rows],
            dq=self.dq[:, rows],
            ddq=self.ddq[:, rows],
            moving=self.moving[:, rows],
            interleaved=None if self.interleaved is None else self.interleaved[:, :, rows],
        )
