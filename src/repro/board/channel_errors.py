"""Errors of a serial line, drawn from a seed: bytes lost, flipped or added, stalls, and a cable pulled out."""

from collections import Counter
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class ErrorRates:
    """Rates and sizes of the errors."""

    # Probability per byte that it is lost, that one of its bits is flipped, or that a random byte comes before
    # it; at most one of the three befalls a byte
    drop: float = 0.0
    flip: float = 0.0
    insert: float = 0.0
    stall: float = 0.0  # probability per byte that the line falls silent before it
    stall_s: float = 0.0  # how long it is silent, s
    stall_bytes: int = 0  # bytes lost because of it; 0 for a line that only waits
    disconnect_after: int | None = None  # bytes after which nothing arrives any more; None for never


#: Errors of a byte; a byte with the index behind them arrives as it is.
_KINDS = ("drop", "flip", "insert")


class ErrorInjector:
    """Damages a byte stream; the damage depends on the seed, not on how the stream is cut."""

    def __init__(self, settings: ErrorRates, rng: np.random.Generator) -> None:
        self.counts: Counter[str] = Counter()  # errors so far by kind
        self.stall_s = 0.0
        self.disconnected = settings.disconnect_after == 0
        self._settings, self._rng = settings, rng
        self._offset = self._losing = 0

    def take_stall(self) -> float:
        """Give the silence that is due, s, for the caller to observe."""
        due, self.stall_s = self.stall_s, 0.0
        return due

    def apply(self, data: bytes) -> bytes:
        """Damage the next bytes of the stream."""
        if self.disconnected:
            return b""
        settings, after = self._settings, self._settings.disconnect_after
        if after is not None:
            data = data[: after - self._offset]
        self._offset += len(data)
        self.disconnected = self._offset == after
        event, bit, value, stall = self._rng.random((len(data), 4)).T
        kind = np.searchsorted(np.cumsum([settings.drop, settings.flip, settings.insert]), event, side="right")
        damaged = b""
        done = 0
        for i in np.flatnonzero((kind < len(_KINDS)) | (stall < settings.stall)).tolist():
            damaged += self._after_stall(data[done:i])
            if stall[i] < settings.stall:
                self.stall_s += settings.stall_s
                self.counts["stall"] += 1
                self._losing = settings.stall_bytes
            flipped, added = data[i] ^ 1 << int(8 * bit[i]), int(256 * value[i])
            self.counts.update(_KINDS[kind[i] :][:1])
            damaged += self._after_stall((b"", bytes([flipped]), bytes([added, data[i]]), data[i : i + 1])[kind[i]])
            done = i + 1
        return damaged + self._after_stall(data[done:])

    def _after_stall(self, data: bytes) -> bytes:
        """Remove the bytes that a stall loses."""
        lost = min(self._losing, len(data))
        self._losing -= lost
        return data[lost:]
