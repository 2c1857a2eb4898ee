"""Incremental reader of an uplink stream that may have lost, flipped or gained bytes.

There is no checksum and no counter (Section III). These rules decide, and how the stream is cut has no influence:

- A *candidate* at byte o is a word with the right identifier and zero bits and no torque of -1024.
- Two candidates are *near* if no joint moved more than `MAX_STEP` counts per frame time between them:
  |q(b) - q(a)| <= MAX_STEP ceil((b - a) / 8).
- A candidate is *closed* if the next identifier follows at o + 8 or, should that one be damaged, at o + 16, or if the
  stream ends with it. An inserted byte moves a byte with two zero bits to o + 8 and to o + 16, so such a frame is never
  closed; a lost byte moves the identifier 0xA5 onto the zero bits.

========= ================================================== =========================================================
state     condition                                          action and next state
========= ================================================== =========================================================
acquiring a candidate with a near candidate right behind it  accept it after `choose_alignment`: locked
locked    a closed candidate, near the last good frame,      accept it: locked. Two or more candidates right before it,
          within 64 bytes                                    each near the next, are accepted, too: then the last good
                                                             frame was wrong (a flipped bit) or frames are missing.
locked    no such candidate within 64 bytes                  read these 64 bytes again: acquiring
========= ================================================== =========================================================
"""

import re
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Final

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from repro.board.frames import FRAME_BYTES, IDENTIFIER, MAX_STEP, Int16Array, is_valid, split_words
from repro.documents import Section

#: Why no frame begins at a byte, in the order of the checks; see `Counts`.
REASONS: Final = ("identifier", "zero_bits", "torque", "step", "unconfirmed", "incomplete")
#: Bytes searched for a frame near the last good one.
WINDOW: Final = 8 * FRAME_BYTES
_MARK: Final = bytes([IDENTIFIER])
_MARKS: Final = re.compile(_MARK)
# Bytes in which a pair of another alignment must begin to be a rival, bytes over which rivals are compared, and the
# lead in frames that outweighs the alignment at which the search began.
_RIVAL_SPAN, _CONTEST_SPAN, _CONTEST_LEAD = 2 * FRAME_BYTES, 64 * FRAME_BYTES, 3
_WORD, _POSITION = struct.Struct(">Q"), struct.Struct(">hh")

#: Encoder counts of both joints.
Position = tuple[int, int]


@dataclass(frozen=True)
class Frames:
    """Good frames, oldest first."""

    position: Int16Array  # (2, n), encoder counts
    pwm: Int16Array  # (2, n), torque in PWM counts
    offset: NDArray[np.int64]  # (n,), byte of the stream at which each frame begins

    def __len__(self) -> int:
        return self.offset.size


@dataclass(frozen=True)
class Gap:
    """An interruption of the run of frames."""

    offset: int  # byte of the stream at which the next frame should have begun
    skipped: int  # bytes; 0 if the positions jump from one frame to the next
    next_frame: int  # index of the first good frame after the gap; the number of frames if none follows
    # Estimate of the frames missing: the bytes skipped in frames, rounded, but at least what the speed limit demands
    # for the distance that the joints moved meanwhile, and at least 1 between two good frames.
    lost: int
    reason: str  # why no frame was accepted at `offset`: one of `REASONS`


Count = Annotated[int, Field(ge=0)]


class Counts(Section):
    """Use of every byte so far: ``received = 8 good + skipped + undecided``; the six reasons add up to `skipped`."""

    received: Count
    good: Count  # frames accepted
    skipped: Count
    identifier: Count  # skipped: no identifier
    zero_bits: Count  # skipped: an identifier whose last two bits are not zero
    torque: Count  # skipped: a torque of -1024
    step: Count  # skipped: further from the last good frame than a joint can have moved
    unconfirmed: Count  # skipped: a possible frame without the neighbours that would confirm it
    incomplete: Count  # skipped: an identifier less than a frame before the end of the stream
    gaps: Count
    lost: Count  # sum of the gaps' estimates of frames missing


class StreamParser:
    """Frames of a byte stream, fed in pieces of any size."""

    def __init__(self) -> None:
        self.gaps: list[Gap] = []
        self._finished = False
        self._received = self._good = 0
        self._skipped = dict.fromkeys(REASONS, 0)
        # Bytes from `_base` of the stream on; those before `_place` are decided.
        self._data = b""
        self._base = self._place = 0
        self._locked = False
        # Position in the last good frame, where in the stream the next one should begin, and why it did not.
        self._last: Position | None = None
        self._expected = 0
        self._reason = ""
        # Accepted since the last call: bytes of the frames, and where in the stream each begins.
        self._accepted, self._offsets = bytearray(), list[int]()

    @property
    def counts(self) -> Counts:
        """Counts so far."""
        return Counts(
            received=self._received,
            good=self._good,
            skipped=sum(self._skipped.values()),
            gaps=len(self.gaps),
            lost=sum(gap.lost for gap in self.gaps),
            **self._skipped,
        )

    def feed(self, data: bytes) -> Frames:
        """Give the frames decided by now; the last frame of a stream waits for the byte after it, or for `finish`."""
        self._received += len(data)
        self._data = self._data[self._place :] + data
        self._base += self._place
        self._place = 0
        return self._advance()

    def finish(self) -> Frames:
        """End the stream and decide on the last bytes; no frames if it was finished before."""
        self._finished = True
        frames = self._advance()
        if self._place < len(self._data):
            self._skip_to(len(self._data))
            self._record_gap(None)
        return frames

    def _advance(self) -> Frames:
        """Decide on as many bytes as possible."""
        self._accepted, self._offsets = bytearray(), []
        while self._place < len(self._data) and (self._follow() if self._locked else self._acquire()):
            pass
        words = np.frombuffer(self._accepted, ">u8").astype(np.uint64)
        return Frames(*split_words(words), np.array(self._offsets, dtype=np.int64))

    def _acquire(self) -> bool:
        """Look for a pair; False if more bytes are needed."""
        pair = next(_pairs(self._data, self._place, len(self._data)), None)
        self._skip_to(len(self._data) - 2 * FRAME_BYTES + 1 if pair is None else pair)
        grid = self._expected - self._base
        if pair is None or (chosen := choose_alignment(self._data, pair, grid, self._finished)) is None:
            return False
        self._skip_to(chosen)
        self._accept(1)
        self._locked = True
        return True

    def _follow(self) -> bool:
        """Find the frame after the last good one, or lose the lock; False if more bytes are needed."""
        data, p, last = self._data, self._place, self._last
        assert last is not None  # a lock has a last good frame
        run = _count_run(data, p, last)
        if run > 1:  # each but the last is closed by the next
            self._accept(run - 1)
            return True
        o = data.find(_MARK, p, p + WINDOW)
        while 0 <= o <= len(data) - FRAME_BYTES:
            position = _candidate(data, o)
            # ceil((o - (p - 8)) / 8) frame times since the last good frame.
            if position and _distance(last, position) <= MAX_STEP * ((o - p + 15) // FRAME_BYTES):
                closed = self._closed(o)
                if closed is None:
                    return False
                if closed:
                    self._accept_run_to(o)
                    return True
            o = data.find(_MARK, o + 1, p + WINDOW)
        if not self._finished and (o >= 0 or len(data) < p + WINDOW):
            return False
        self._locked = False
        return True

    def _closed(self, o: int) -> bool | None:
        """Whether the frame at `o` is closed; None if the bytes that decide have not come."""
        for place in (o + FRAME_BYTES, o + 2 * FRAME_BYTES):
            if place >= len(self._data):
                return place == o + FRAME_BYTES if self._finished else None
            if self._data[place] == IDENTIFIER:
                return True
        return False

    def _accept_run_to(self, o: int) -> None:
        """Accept the frame at `o`, or the run of at least three that ends with it."""
        first, after = o, _candidate(self._data, o)
        while first - FRAME_BYTES >= self._place:
            before = _candidate(self._data, first - FRAME_BYTES)
            if not (before and after and _distance(before, after) <= MAX_STEP):
                break
            first, after = first - FRAME_BYTES, before
        first = o if o - first < 2 * FRAME_BYTES else first
        self._skip_to(first)
        self._accept((o - first) // FRAME_BYTES + 1)

    def _accept(self, n: int) -> None:
        """Accept `n` frames at the present place."""
        p, end = self._place, self._place + n * FRAME_BYTES
        first = _candidate(self._data, p)
        if self._base + p != self._expected or (self._last and first and _distance(self._last, first) > MAX_STEP):
            self._record_gap(first)
        self._accepted += self._data[p:end]
        self._offsets += range(self._base + p, self._base + end, FRAME_BYTES)
        self._good += n
        self._last = _candidate(self._data, end - FRAME_BYTES)
        self._place = end
        self._expected = self._base + end

    def _skip_to(self, stop: int) -> None:
        """Skip the bytes before `stop` and count the reason of each."""
        start = self._place
        if stop <= start:
            return
        if self._base + start == self._expected:
            self._reason = self._reject_reason(start)
        self._skipped["identifier"] += stop - start - self._data.count(_MARK, start, stop)
        for mark in _MARKS.finditer(self._data, start, stop):
            self._skipped[self._reject_reason(mark.start())] += 1
        self._place = stop

    def _reject_reason(self, o: int) -> str:
        """Name the reason why no frame begins at `o`."""
        if self._data[o] != IDENTIFIER:
            return "identifier"
        if o + FRAME_BYTES > len(self._data):
            return "incomplete"
        if self._data[o + FRAME_BYTES - 1] & 0b11:
            return "zero_bits"
        position = _candidate(self._data, o)
        if not position:
            return "torque"
        frames = (self._base + o - self._expected + 15) // FRAME_BYTES
        return "step" if self._last and _distance(self._last, position) > MAX_STEP * frames else "unconfirmed"

    def _record_gap(self, position: Position | None) -> None:
        """Record the gap before the frame at the present place, or before the end of the stream."""
        skipped = self._base + self._place - self._expected
        lost = (skipped + FRAME_BYTES // 2) // FRAME_BYTES
        if position and self._last is not None:
            lost = max(lost, 1, -(-_distance(self._last, position) // MAX_STEP) - 1)
        reason = self._reason if skipped else "step"
        self.gaps.append(Gap(self._expected, skipped, self._good, lost, reason))


def choose_alignment(data: bytes, pair: int, grid: int, final: bool) -> int | None:
    """Choose between the alignment of the first pair of candidates and its rivals; None if more bytes are needed.

    An arm at rest whose position contains a byte 0xA5 offers a second alignment for ever. If another alignment offers
    a pair within 16 bytes, the candidates among 64 frames are counted in each. The alignment at which the search began
    (`grid`, modulo 8) wins if it has at most two fewer than the best, which one error may cost it; else the best wins,
    the earliest of equals. Gives the place of the first pair of that alignment.
    """
    if not final and len(data) < pair + _RIVAL_SPAN + 2 * FRAME_BYTES:
        return None
    rivals: dict[int, int] = {}
    for o in _pairs(data, pair, pair + _RIVAL_SPAN):
        rivals.setdefault(o % FRAME_BYTES, o)
    if len(rivals) == 1:
        return pair
    if not final and len(data) < pair + _CONTEST_SPAN + 2 * FRAME_BYTES:
        return None
    votes = {}
    for phase in rivals:
        first = pair + (phase - pair) % FRAME_BYTES
        places = range(first, min(first + _CONTEST_SPAN, len(data) - FRAME_BYTES + 1), FRAME_BYTES)
        votes[phase] = sum(_candidate(data, place) is not None for place in places)
    best = max(votes, key=lambda phase: (votes[phase], -rivals[phase]))
    grid %= FRAME_BYTES
    if grid in votes and votes[grid] > votes[best] - _CONTEST_LEAD:
        best = grid
    return rivals[best]


def _pairs(data: bytes, start: int, stop: int) -> Iterator[int]:
    """Find the places in ``start ... stop - 1`` of a candidate with a near one right behind it."""
    for mark in _MARKS.finditer(data, start, min(stop, len(data) - 2 * FRAME_BYTES + 1)):
        first, second = (_candidate(data, o) for o in (mark.start(), mark.start() + FRAME_BYTES))
        if first and second and _distance(first, second) <= MAX_STEP:
            yield mark.start()


def _candidate(data: bytes, o: int) -> Position | None:
    """Read the position of the frame at `o`; None if the frame by itself breaks a rule."""
    if not is_valid(_WORD.unpack_from(data, o)[0]):
        return None
    q1, q2 = _POSITION.unpack_from(data, o + 1)
    return q1, q2


def _distance(a: Position, b: Position) -> int:
    """Give the larger difference of the two joints, counts."""
    return max(abs(a[0] - b[0]), abs(a[1] - b[1]))


def _count_run(data: bytes, o: int, last: Position) -> int:
    """Count candidates from `o` on, each near the one before it, the first near `last`."""
    places = range(o, len(data) - FRAME_BYTES + 1, FRAME_BYTES)
    for n, place in enumerate(places):
        position = _candidate(data, place)
        if not position or _distance(last, position) > MAX_STEP:
            return n
        last = position
    return len(places)
