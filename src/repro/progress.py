"""Progress of long work: a line every few seconds with what is done and how long the rest will take."""

import logging
import time
from collections.abc import Iterator, Sequence
from typing import TypeVar

T = TypeVar("T")
_LOG = logging.getLogger(__name__)
#: Time between lines, s.
EVERY = 3.0


class Progress:
    """Logs how far a piece of work is."""

    def __init__(self, what: str) -> None:
        self._what = what
        self._began = self._last = time.monotonic()
        self._first: int | None = None

    def __call__(self, done: int, total: int, note: str | float = "") -> None:
        """Log if the last line is old enough, with a note, which is text or a loss."""
        now = time.monotonic()
        if self._first is None:  # work done before this run (a checkpoint) says nothing about its speed
            self._first, self._began = done, now
        if now - self._last < EVERY and done < total:
            return
        self._last = now
        fresh, rest = done - self._first, total - done
        left = f", about {(now - self._began) / fresh * rest:.0f} s left" if fresh > 0 and rest > 0 else ""
        noted = f", loss {note:.2e}" if isinstance(note, float) else note and f", {note}"
        _LOG.info("%s: %d of %d (%.0f %%)%s%s", self._what, done, total, 100 * done / total, left, noted)


def over(items: Sequence[T], what: str) -> Iterator[T]:
    """Iterate over items, and log how many are done."""
    progress = Progress(what)
    for k, item in enumerate(items, start=1):
        yield item
        progress(k, len(items))
