"""Incremental reader of an uplink stream that may have lost, flipped or gained bytes.

There is no checksum and no counter (Section III). These rules decide, however the stream is cut into pieces:

- A *candidate* at byte o is a word with identifier and zero bits right and no torque of -1024.
- Two candidates are *near* if no joint moved more than `max_step` counts for each frame time between them:
  |q(b) - q(a)| <= max_step ceil((b - a) / 8).
- A candidate is *closed* if the next frame's identifier follows it at o + 8 or, should that one be damaged, the one
  after that at o + 16, or if the stream ends with it. A byte inserted into a frame moves a byte with two zero bits
  to o + 8 and to o + 16, so such a frame is never accepted; a lost byte moves the identifier 0xA5 onto the zero bits.

*Locked*, after a good frame that ends at p: the next one is the first closed candidate in p ... p + 63 that is near the
last. If two or more candidates stand right before it, 8 bytes apart and each near the next, then the last good frame
was the odd one out (a flipped position bit) or frames are missing, and all of them count. If no frame is found, the
last good one is dropped as a reference and the lock is lost. So a false frame or a real jump is outlived within
64 bytes, which are read again.

*Acquiring*, at the start and after a lost lock: the first candidate with a near candidate right behind it is good. If
another alignment offers such a pair within these 16 bytes (an arm at rest whose position holds a byte 0xA5 does, for
ever), 64 frames are counted in each: the alignment the search began with wins if it has at most two candidates fewer
than the best, for that much one fault may cost it; else the best; the earliest of equals.
"""

from repro.fpga.alignment import MARK, Position, candidate, count_run, fault, find_pair, moved, settle
from repro.fpga.frames import FRAME_BYTES, IDENTIFIER, MAX_STEP
from repro.fpga.stream import REASONS, Counts, FrameRuns, Frames, Gap

#: Bytes searched for a frame near the last good one before that one is dropped as a reference.
WINDOW = 8 * FRAME_BYTES
# Frames tried at once, for speed alone: few behind a fault, then more and more.
_SMALLEST_BLOCK, _LARGEST_BLOCK = 16, 65536


class StreamParser:
    """Frames of a byte stream, fed in pieces of any size."""

    def __init__(self, max_step: int = MAX_STEP) -> None:
        if not 1 <= max_step <= 65535:
            raise ValueError(f"max_step: must lie in 1 ... 65535 counts, got {max_step}.")
        self.gaps: list[Gap] = []
        self._max_step = max_step
        self._finished = False
        self._received = 0
        self._good = 0
        self._refused = dict.fromkeys(REASONS, 0)
        # Bytes from `_base` of the stream on; those before `_place` are decided.
        self._data = b""
        self._base = 0
        self._place = 0
        self._locked = False
        # Position in the last good frame, where in the stream the next one should begin, and why it did not.
        self._last: Position | None = None
        self._expected = 0
        self._reason = ""
        self._block = _SMALLEST_BLOCK
        self._runs = FrameRuns()

    @property
    def counts(self) -> Counts:
        """Counts so far."""
        return Counts(
            received=self._received,
            good=self._good,
            skipped=sum(self._refused.values()),
            gaps=len(self.gaps),
            lost=sum(gap.lost for gap in self.gaps),
            **self._refused,
        )

    def feed(self, data: bytes) -> Frames:
        """Take the next bytes of the stream."""
        if self._finished:
            raise ValueError("data: the stream was finished.")
        self._received += len(data)
        self._data = self._data[self._place :] + data
        self._base += self._place
        self._place = 0
        self._advance()
        return self._runs.take()

    def finish(self) -> Frames:
        """End the stream and decide on what was held back."""
        self._finished = True
        self._advance()
        if self._place < len(self._data):
            self._refuse(len(self._data))
            self._end_gap(None)
        return self._runs.take()

    def _advance(self) -> None:
        """Decide on as many bytes as can be."""
        while self._place < len(self._data):
            if not (self._follow() if self._locked else self._acquire()):
                return

    def _acquire(self) -> bool:
        """Look for a pair; False if more bytes are needed."""
        o = find_pair(self._data, self._place, len(self._data), self._max_step)
        self._refuse(o if o >= 0 else len(self._data) - 2 * FRAME_BYTES + 1)
        if o < 0:
            return False
        chosen = settle(self._data, o, self._expected - self._base, self._max_step, self._finished)
        if chosen is None:
            return False
        self._refuse(chosen)
        self._accept(1)
        self._locked = True
        return True

    def _follow(self) -> bool:
        """Find the frame after the last good one, or lose the lock; False if more bytes are needed."""
        data, p, last = self._data, self._place, self._last
        assert last is not None  # a lock has a last good frame
        rows = min((len(data) - p) // FRAME_BYTES, self._block)
        run = count_run(data, p, rows, last, self._max_step)
        self._block = min(4 * self._block, _LARGEST_BLOCK) if run == rows else _SMALLEST_BLOCK
        if run > 1:  # each but the last is closed by the next
            self._accept(run - 1)
            return True
        o = data.find(MARK, p, p + WINDOW)
        while 0 <= o <= len(data) - FRAME_BYTES:
            position = candidate(data, o)
            # ceil((o - (p - 8)) / 8) frame times since the last good frame.
            if position and moved(last, position) <= self._max_step * ((o - p + 15) // FRAME_BYTES):
                closed = self._closed(o)
                if closed is None:
                    return False
                if closed:
                    self._take(o)
                    return True
            o = data.find(MARK, o + 1, p + WINDOW)
        if not self._finished and (o >= 0 or len(data) < p + WINDOW):
            return False
        self._locked = False
        return True

    def _closed(self, o: int) -> bool | None:
        """Whether the frame at `o` is closed; None if the bytes that tell have not come."""
        for place in (o + FRAME_BYTES, o + 2 * FRAME_BYTES):
            if place >= len(self._data):
                return place == o + FRAME_BYTES if self._finished else None
            if self._data[place] == IDENTIFIER:
                return True
        return False

    def _take(self, o: int) -> None:
        """Accept the frame at `o`, or the run that leads to it if there is one of at least three."""
        first, after = o, candidate(self._data, o)
        while first - FRAME_BYTES >= self._place:
            before = candidate(self._data, first - FRAME_BYTES)
            if not (before and after and moved(before, after) <= self._max_step):
                break
            first, after = first - FRAME_BYTES, before
        if o - first < 2 * FRAME_BYTES:
            first = o
        self._refuse(first)
        self._accept((o - first) // FRAME_BYTES + 1)

    def _accept(self, n: int) -> None:
        """Take `n` frames at the present place."""
        p = self._place
        end = p + n * FRAME_BYTES
        offset = self._base + p
        first = candidate(self._data, p)
        if offset != self._expected or (self._last and first and moved(self._last, first) > self._max_step):
            self._end_gap(first)
        self._runs.add(self._data[p:end], offset)
        self._good += n
        self._last = candidate(self._data, end - FRAME_BYTES)
        self._place = end
        self._expected = self._base + end

    def _refuse(self, stop: int) -> None:
        """Skip the bytes before `stop`, each for its reason."""
        start = self._place
        if stop <= start:
            return
        if self._base + start == self._expected:
            self._reason = self._fault(start)
        self._refused["identifier"] += stop - start - self._data.count(MARK, start, stop)
        o = self._data.find(MARK, start, stop)
        while o >= 0:
            self._refused[self._fault(o)] += 1
            o = self._data.find(MARK, o + 1, stop)
        self._place = stop

    def _fault(self, o: int) -> str:
        """Why no frame begins at `o`."""
        rule = fault(self._data, o)
        if rule:
            return rule
        frames = (self._base + o - self._expected + 15) // FRAME_BYTES
        position = candidate(self._data, o)
        far = self._last and position and moved(self._last, position) > self._max_step * frames
        return "step" if far else "unconfirmed"

    def _end_gap(self, position: Position | None) -> None:
        """Record the gap before the frame at the present place, or before the end of the stream."""
        skipped = self._base + self._place - self._expected
        lost = (skipped + FRAME_BYTES // 2) // FRAME_BYTES
        if position and self._last is not None:
            lost = max(lost, 1, -(-moved(self._last, position) // self._max_step) - 1)
        reason = self._reason if skipped else "step"
        self.gaps.append(Gap(self._expected, skipped, self._good, lost, reason))
