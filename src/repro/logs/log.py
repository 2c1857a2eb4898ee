"""A recording of a two-joint arm in SI units."""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from repro.model.parameters import Array


@dataclass(frozen=True)
class Log:
    """What was recorded, in SI units and the angles of Eq. 1.

    Attributes
    ----------
    name : str
        File name without folders.
    t : array of shape (N,)
        Time of each sample, s: strictly increasing, not necessarily uniform.
    q : array of shape (2, N)
        Position, rad: ``q1 = 0`` hangs down, ``q2`` is relative to link 1.
    tau : array of shape (2, N)
        Torque at the joints, N m.
    dq : array of shape (2, N) or None
        Measured velocity, rad/s, if it was recorded.
    notes : tuple of str
        What was assumed or converted on reading, one line each.
    simulated : bool
        Whether it comes from the simulated board.
    torque_limit : array of shape (2,) or None
        Largest torque the drives can give, N m, where it is known.
    breaks : tuple of int
        Samples that begin a new piece behind a long gap, of a log that was made even.
    """

    name: str
    t: Array
    q: Array
    tau: Array
    dq: Array | None = None
    notes: tuple[str, ...] = ()
    simulated: bool = False
    torque_limit: Array | None = None
    breaks: tuple[int, ...] = ()

    def piece(self, begin: int, end: int) -> "Log":
        """The samples from one number to before another."""
        cut = slice(begin, end)
        dq = None if self.dq is None else self.dq[:, cut]
        return replace(self, t=self.t[cut], q=self.q[:, cut], tau=self.tau[:, cut], dq=dq, breaks=())

    @property
    def pieces(self) -> tuple["Log", ...]:
        """What is between the breaks; a log without is one piece."""
        if not self.breaks:
            return (self,)
        return tuple(self.piece(*edges) for edges in pairwise((0, *self.breaks, self.t.size)))

    @property
    def longest(self) -> "Log":
        """The piece with the most samples."""
        return max(self.pieces, key=lambda piece: piece.t.size)


#: Half the time that a difference spans, s.
HALF_SPAN = 0.02


def period(log: Log) -> float:
    """Typical time from one sample to the next, s."""
    return float(np.median(np.diff(log.t)))


def spanned(log: Log) -> int:
    """Samples to each side that a difference spans."""
    return max(1, round(HALF_SPAN / period(log)))


def speed(log: Log) -> Array:
    """Velocity by central differences over about 40 ms.

    Parameters
    ----------
    log : Log
        Recording of N samples.

    Returns
    -------
    array of shape (2, N - 2 w)
        rad/s, at the samples but the first and last w of `spanned`.
    """
    w = spanned(log)
    return np.asarray((log.q[:, 2 * w :] - log.q[:, : -2 * w]) / (log.t[2 * w :] - log.t[: -2 * w]))
