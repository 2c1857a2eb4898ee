"""Progress of long work: a line every few seconds with what is done and how long the rest will take."""

import logging
import time
from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

T = TypeVar("T")
_LOG = logging.getLogger(__name__)


class Progress:
    """Logs how far a piece of work is."""

    def __init__(self, what: str, every: float = 3.0, clock: Callable[[], float] = time.monotonic) -> None:
        self._what = what
        self._every = every
        self._clock = clock
        self._began = self._last = clock()
        self._first: int | None = None

    def __call__(self, done: int, total: int, note: str | float = "") -> None:
        """Log if the last line is old enough, with a note, which is text or a loss."""
        now = self._clock()
        if self._first is None:  # work done before this run (a checkpoint) says nothing about its speed
            self._first = done
            self._began = now
        if now - self._last < self._every and done < total:
            return
        self._last = now
        fresh = done - self._first
        left = (
            f", about {(now - self._began) / fresh * (total - done):.0f} s left" if fresh > 0 and done < total else ""
        )
        noted = f", loss {note:.2e}" if isinstance(note, float) else note and f", {note}"
        _LOG.info("%s: %d of %d (%.0f %%)%s%s", self._what, done, total, 100 * done / total, left, noted)


def over(items: Sequence[T], what: str) -> Iterator[T]:
    """Iterate over items, and log how many are done."""
    progress = Progress(what)
    for k, item in enumerate(items, start=1):
        yield item
        progress(k, len(items))
