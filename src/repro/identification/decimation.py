"""Bring a long log to a lower rate, so that its cost grows with its length and not with its rate.

Samples are means of separate blocks. White noise of the recorded samples stays white, so that even and odd samples
have independent noise, on which instrumental variables depend. A longer filter would correlate them. A mean
attenuates what would be aliased to less than 10 Hz by a factor of 9 at 100 Hz, and shifts no phase.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from repro.identification.filtering import MAX_CONTAMINATION, MAX_CUTOFF_HZ
from repro.identification.log import Log, join_pieces, period
from repro.model.parameters import Array

MAX_SAMPLES = 100_000  # most samples of a log that keeps its rate
MIN_RATE_HZ = 10.0 * MAX_CUTOFF_HZ  # lowest rate that limits no cut-off
ENOUGH_HZ = 2.0 * MIN_RATE_HZ  # rate that does not limit that of every other sample either


def decimated(log: Log) -> Log:
    """Replace blocks of samples of an evenly sampled long log by their means, with a note; others stay as they are."""
    if log.t.size <= MAX_SAMPLES:
        return log
    rate = 1.0 / period(log)
    few, fewest = (int(rate / hertz * (1.0 + 1e-9)) for hertz in (ENOUGH_HZ, MIN_RATE_HZ))
    block = min(max(-(-log.t.size // MAX_SAMPLES), few), fewest)
    if block < 2:
        return log
    note = f"means of {block} samples are fitted ({rate / block:.4g} Hz instead of {rate:.4g} Hz), as the log is long"
    even = join_pieces(log, [_means(piece, block) for piece in log.pieces])
    return replace(even, block=block, notes=(*log.notes, note))


def _means(log: Log, block: int) -> Log:
    """Average blocks of a log in one piece; a rest at its end is left out."""

    def mean(x: Array | NDArray[np.bool_]) -> Array:
        blocks = x[..., : x.shape[-1] // block * block].reshape(*x.shape[:-1], -1, block)
        return np.asarray(blocks.mean(axis=-1))

    left_out = None if log.left_out is None else mean(log.left_out) > MAX_CONTAMINATION
    dq = None if log.dq is None else mean(log.dq)
    return replace(log, t=mean(log.t), q=mean(log.q), tau=mean(log.tau), dq=dq, left_out=left_out)
