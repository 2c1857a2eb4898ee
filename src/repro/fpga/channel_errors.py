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


class ErrorInjector:
    """Damages a byte stream; the damage depends on the seed, not on how the stream is cut."""

    def __init__(self, settings: ErrorRates, rng: np.random.Generator) -> None:
        self.counts: Counter[str] = Counter()  # errors so far by kind
        self.stall_s = 0.0
        self.disconnected = settings.disconnect_after == 0
        self._settings = settings
        self._rng = rng
        self._offset = 0
        self._losing = 0

    def take_stall(self) -> float:
        """Give the silence that is due, s, for the caller to observe."""
        due, self.stall_s = self.stall_s, 0.0
        return due

    def apply(self, data: bytes) -> bytes:
        """Damage the next bytes of the stream."""
        if self.disconnected:
            return b""
        after = self._settings.disconnect_after
        if after is not None:
            data = data[: after - self._offset]
        self._offset += len(data)
        self.disconnected = self._offset == after
        return self._damage(data)

    def _damage(self, data: bytes) -> bytes:
        settings = self._settings
        event, bit, value, stall = self._rng.random((len(data), 4)).T
        hit = (event < settings.drop + settings.flip + settings.insert) | (stall < settings.stall)
        parts: list[bytes] = []
        done = 0
        for i in np.flatnonzero(hit).tolist():
            parts.append(self._after_stall(data[done:i]))
            if stall[i] < settings.stall:
                self.stall_s += settings.stall_s
                self.counts["stall"] += 1
                self._losing = settings.stall_bytes
            parts.append(self._after_stall(self._damage_byte(data[i], event[i], bit[i], value[i])))
            done = i + 1
        parts.append(self._after_stall(data[done:]))
        return b"".join(parts)

    def _damage_byte(self, byte: int, event: float, bit: float, value: float) -> bytes:
        """Damage one byte, by three numbers from 0 to 1."""
        settings = self._settings
        if event < settings.drop:
            kind, damaged = "drop", b""
        elif event < settings.drop + settings.flip:
            kind, damaged = "flip", bytes([byte ^ 1 << int(8 * bit)])
        elif event < settings.drop + settings.flip + settings.insert:
            kind, damaged = "insert", bytes([int(256 * value), byte])
        else:
            return bytes([byte])
        self.counts[kind] += 1
        return damaged

    def _after_stall(self, data: bytes) -> bytes:
        """Remove the bytes that a stall loses."""
        lost = min(self._losing, len(data))
        self._losing -= lost
        return data[lost:]
