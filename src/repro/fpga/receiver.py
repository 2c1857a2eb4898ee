"""Takes an uplink stream from a port: until all samples have come, or no more do."""

import time
from collections.abc import Callable
from typing import Final

import serial

from repro.fpga.about import Reason
from repro.fpga.frames import FRAME_BYTES, SAMPLING_PERIOD
from repro.fpga.parser import StreamParser

#: Seconds between two looks at a port that had nothing.
POLL: Final = 0.002
#: Seconds without a byte after which a line is taken to be at rest; a running board sends every 2.5 ms.
QUIET: Final = 0.1
#: Seconds between time stamps.
_STAMP: Final = 0.05
_READ: Final = 1 << 16
#: Seconds by which a recording may exceed twice the length of its motion: a simulated board can be slow.
_SLACK: Final = 10.0


def most_bytes(samples: int) -> int:
    """Most bytes that are received for a motion: four times its frames, and what a port gives at once."""
    return 4 * FRAME_BYTES * samples + 2 * _READ


def take(line: serial.SerialBase) -> bytes:
    """Bytes that have arrived at a port opened with a timeout of 0; pyserial loses none when it does not wait."""
    return bytes(line.read(_READ))


class Receiver:
    """Takes bytes until all samples have come or no more do."""

    def __init__(
        self,
        samples: int,
        silence: float,
        clock: Callable[[], float] = time.monotonic,
        keep: Callable[[bytes], object] = lambda piece: None,  # noqa: ARG005
    ) -> None:
        self.data = bytearray()
        self.stamps: list[tuple[int, float]] = []
        self.good = 0
        self._samples, self._silence, self._clock, self._keep = samples, silence, clock, keep
        self._parser = StreamParser()
        self._ended: Reason = ""

    def run(self, line: serial.SerialBase, progress: Callable[[int, int], None]) -> None:
        """Receive until there is a reason to end."""
        began = last = self._clock()
        longest = 2.0 * self._samples * SAMPLING_PERIOD + self._silence + _SLACK
        try:
            while True:
                piece = take(line)
                now = self._clock()
                if now - began > longest or len(self.data) + len(piece) > most_bytes(self._samples):
                    self._ended = "overrun"
                    break
                if piece:
                    last = now
                    if self._accept(piece):
                        break
                    self._stamp(now - began)
                    progress(min(self.good, self._samples), self._samples)
                elif now - last >= (QUIET if self._all_there() else self._silence):
                    self._ended = "silent"
                    break
                else:
                    time.sleep(POLL)
        except OSError:  # pyserial's exceptions are of this kind
            self._ended = "disconnected"
        except KeyboardInterrupt:
            if not self.data:
                raise
            self._ended = "interrupted"
        self._stamp(last - began, final=True)
        progress(self.good, self._samples)

    def close(self) -> Reason:
        """Decide on the last frames."""
        self.good = min(self.good + len(self._parser.finish()), self._samples)
        within = sum(gap.lost for gap in self._parser.gaps if gap.next_frame < self.good)
        return "" if self.good + within >= self._samples else self._ended

    def _accept(self, piece: bytes) -> bool:
        """Add bytes; True once all samples are there, what a board sends after them being cut off."""
        self.data += piece
        self._keep(piece)
        frames = self._parser.feed(piece)
        before, self.good = self.good, self.good + len(frames)
        if self.good < self._samples:
            return False
        del self.data[int(frames.offset[self._samples - before - 1]) + FRAME_BYTES :]
        self.good = self._samples
        return True

    def _all_there(self) -> bool:
        """Whether the samples would be complete if the parser found frames in all that it holds back."""
        counts = self._parser.counts
        held = counts.received - counts.skipped - FRAME_BYTES * counts.good
        return counts.good + held // FRAME_BYTES >= self._samples

    def _stamp(self, seconds: float, final: bool = False) -> None:
        if final and self.stamps and self.stamps[-1][0] == len(self.data):
            return
        if final or not self.stamps or seconds - self.stamps[-1][1] >= _STAMP:
            self.stamps.append((len(self.data), round(seconds, 6)))
