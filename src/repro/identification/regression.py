"""What every method solves: tau = Y beta along one motion, with torque and motion through the same filters."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from repro.model.parameters import Array


@dataclass(frozen=True, eq=False)  # hashed by identity: what is made of one is kept for it
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


def joined(parts: Sequence[Regression], weights: Sequence[float] | None = None) -> Regression:
    """Regressions of several logs of one arm as one.

    Parameters
    ----------
    parts : sequence of Regression
        One for each log; times go on from one to the next.
    weights : sequence of float, optional
        By which rows of each are multiplied on both sides.

    Returns
    -------
    Regression
        A single one is returned as it is.
    """
    if len(parts) == 1:
        return parts[0]
    factors = weights or [1.0] * len(parts)
    begins = np.cumsum([0.0, *(part.t[-1] - part.t[0] + part.h for part in parts[:-1])])
    halves = [part.interleaved for part in parts]

    def beside(name: str, sizes: Sequence[float]) -> Array:
        return np.concatenate([getattr(part, name) * size for part, size in zip(parts, sizes, strict=True)], axis=1)

    same = [1.0] * len(parts)
    return Regression(
        np.concatenate([part.t - part.t[0] + begin for part, begin in zip(parts, begins, strict=True)]),
        beside("y", factors),
        beside("tau", factors),
        beside("q", same),
        beside("dq", same),
        beside("ddq", same),
        np.concatenate([part.moving for part in parts], axis=1),
        parts[0].h,
        None
        if any(half is None for half in halves)
        else np.concatenate(
            [half * factor for half, factor in zip(halves, factors, strict=True) if half is not None], axis=2
        ),
    )
