"""What a parser makes of an uplink stream: frames, gaps, counts, and what it cannot know."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from repro.fpga.frames import FRAME_BYTES, Int16Array, split_words

#: Why a byte is not the beginning of a frame; explained at `Counts`.
REASONS: Final = ("identifier", "zero_bits", "torque", "step", "unconfirmed", "incomplete")

#: What no reader of this protocol can tell, for it has neither checksum nor counter.
UNVERIFIABLE: Final = (
    "a flipped torque bit, unless it makes -1024",
    "a flipped low bit of a position: the change stays within what a joint may move between frames",
    "the loss of a whole number of frames while the arm moves slowly",
    "a frame put together from two, after the loss of a multiple of eight bytes across their boundary",
    "the frame boundary of an arm that stands still at a position holding the byte 0xA5, if the recording begins "
    "within a frame",
    "the time a frame was taken: only how many came before it",
)


@dataclass(frozen=True)
class Frames:
    """Good frames, oldest first."""

    position: Int16Array  # (2, n), encoder counts
    pwm: Int16Array  # (2, n), torque in PWM counts
    offset: NDArray[np.int64]  # (n,), byte of the whole stream at which each frame begins

    def __len__(self) -> int:
        return self.offset.size


@dataclass(frozen=True)
class Gap:
    """An interruption of the run of frames."""

    offset: int  # byte of the stream at which the next frame should have begun
    skipped: int  # bytes passed over; 0 if the positions jump from one frame to the next
    next_frame: int  # index of the first good frame after the gap; the number of frames if none follows
    # Estimate of the frames missing: the bytes skipped in frames, rounded, but not less than the speed limit
    # demands for the way the joints moved meanwhile, and not less than 1 between two good frames
    lost: int
    reason: str  # why no frame was accepted at `offset`, by the names of `Counts`


@dataclass(frozen=True)
class Counts:
    """What became of every byte so far: ``received = 8 good + skipped + held back``.

    Each byte skipped is a place where a frame might have begun and was refused; the six reasons add up to `skipped`.
    """

    received: int = 0  # bytes fed
    good: int = 0  # frames accepted
    skipped: int = 0  # bytes passed over
    identifier: int = 0  # skipped, not an identifier
    zero_bits: int = 0  # skipped, an identifier whose last two bits are not zero
    torque: int = 0  # skipped, a torque of -1024
    step: int = 0  # skipped, further from the last good frame than a joint can have moved
    unconfirmed: int = 0  # skipped, a possible frame without the neighbours that would confirm it
    incomplete: int = 0  # skipped, an identifier less than a frame before the end of the stream
    gaps: int = 0  # interruptions
    lost: int = 0  # sum of the gaps' estimates of frames missing


class FrameRuns:
    """Collects the bytes of accepted frames, run by run."""

    def __init__(self) -> None:
        self._pieces: list[bytes] = []
        self._starts: list[int] = []

    def add(self, piece: bytes, offset: int) -> None:
        """Add frames that follow each other from byte `offset` of the stream."""
        self._pieces.append(piece)
        self._starts.append(offset)

    def take(self) -> Frames:
        """Hand over the frames added since the last call."""
        words = np.frombuffer(b"".join(self._pieces), ">u8").astype(np.uint64)
        lengths = np.array([len(piece) for piece in self._pieces], dtype=np.int64)
        # Within a run, bytes of the collection and of the stream differ by a constant.
        shift = np.array(self._starts, dtype=np.int64) - (np.cumsum(lengths) - lengths)
        offset = np.repeat(shift, lengths // FRAME_BYTES) + FRAME_BYTES * np.arange(words.size)
        self._pieces, self._starts = [], []
        return Frames(*split_words(words), offset)
