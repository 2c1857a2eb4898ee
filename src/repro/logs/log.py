"""A recording of a two-joint arm in SI units."""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from repro.model.parameters import Array


@dataclass(frozen=True)
class Log:
    """A recording in SI units and the angles of Eq. 1."""

    name: str  # file name without folders
    t: Array  # (N,), time of each sample, s: strictly increasing, not necessarily uniform
    q: Array  # (2, N), position, rad: ``q1 = 0`` hangs down, ``q2`` is relative to link 1
    tau: Array  # (2, N), torque at the joints, N m
    dq: Array | None = None  # (2, N), measured velocity, rad/s, if it was recorded
    notes: tuple[str, ...] = ()  # what was assumed or converted on reading, one line each
    simulated: bool = False  # whether it comes from the simulated board
    torque_limit: Array | None = None  # (2,), largest torque the drives can give, N m, where it is known
    breaks: tuple[int, ...] = ()  # samples that begin a new piece behind a long gap, of a log that was made even

    def piece(self, begin: int, end: int) -> "Log":
        """Cut out samples ``begin ... end - 1``."""
        cut = slice(begin, end)
        dq = None if self.dq is None else self.dq[:, cut]
        return replace(self, t=self.t[cut], q=self.q[:, cut], tau=self.tau[:, cut], dq=dq, breaks=())

    @property
    def pieces(self) -> tuple["Log", ...]:
        """The log cut at its breaks."""
        if not self.breaks:
            return (self,)
        return tuple(self.piece(*edges) for edges in pairwise((0, *self.breaks, self.t.size)))

    @property
    def longest(self) -> "Log":
        """The piece with the most samples."""
        return max(self.pieces, key=lambda piece: piece.t.size)


#: Shortest log, s, and fewest samples.
SHORTEST, FEWEST = 2.0, 200
#: Range of positions below which a joint does not move, rad.
STILL = 0.02
#: Half the time that a difference spans, s.
HALF_SPAN = 0.02


def period(log: Log) -> float:
    """Typical time from one sample to the next, s."""
    return float(np.median(np.diff(log.t)))


def half_window(log: Log) -> int:
    """Number of samples to each side that a difference spans."""
    return max(1, round(HALF_SPAN / period(log)))


def speed(log: Log) -> Array:
    """Velocity (2, N - 2 w) by central differences over about 40 ms, rad/s; w is `half_window`."""
    w = half_window(log)
    return np.asarray((log.q[:, 2 * w :] - log.q[:, : -2 * w]) / (log.t[2 * w :] - log.t[: -2 * w]))
