"""Errors of a serial line, drawn from a seed: bytes lost, flipped or added, stalls, and a cable pulled out."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

ErrorKind = Literal["drop", "flip", "insert", "stall", "disconnect"]


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

    def __post_init__(self) -> None:
        """Refuse rates and sizes that a user cannot mean."""
        for name in ("drop", "flip", "insert", "stall"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise ValueError(f"{name}: a probability must be in 0 ... 1, got {getattr(self, name)}.")
        if self.drop + self.flip + self.insert > 1.0:
            raise ValueError("drop, flip, insert: must not exceed 1 together.")


@dataclass(frozen=True)
class ChannelError:
    """One error that was injected."""

    kind: ErrorKind
    offset: int  # byte of the undamaged stream that it changed, or before which it happened


class ErrorInjector:
    """Damages a byte stream; the damage depends on the seed, not on how the stream is cut."""

    def __init__(self, settings: ErrorRates, rng: np.random.Generator) -> None:
        self.log: list[ChannelError] = []
        self.stall_s = 0.0
        self.disconnected = settings.disconnect_after == 0
        if self.disconnected:
            self.log.append(ChannelError("disconnect", 0))
        self._settings = settings
        self._rng = rng
        self._offset = 0
        self._losing = 0

    def counts(self) -> dict[ErrorKind, int]:
        """Count the errors so far by kind."""
        kinds: tuple[ErrorKind, ...] = ("drop", "flip", "insert", "stall", "disconnect")
        return {kind: sum(error.kind == kind for error in self.log) for kind in kinds}

    def take_stall(self) -> float:
        """Give the silence that is due, s, for the caller to observe."""
        due, self.stall_s = self.stall_s, 0.0
        return due

    def apply(self, data: bytes) -> bytes:
        """Damage the next bytes of the stream."""
        settings, offset = self._settings, self._offset
        if self.disconnected:
            return b""
        ends = settings.disconnect_after is not None and offset + len(data) >= settings.disconnect_after
        if ends and settings.disconnect_after is not None:
            data = data[: settings.disconnect_after - offset]
        self._offset += len(data)
        damaged = self._damage(data, offset)
        if ends:
            self.disconnected = True
            self.log.append(ChannelError("disconnect", self._offset))
        return damaged

    def _damage(self, data: bytes, offset: int) -> bytes:
        settings = self._settings
        event, bit, value, stall = self._rng.random((len(data), 4)).T
        hit = (event < settings.drop + settings.flip + settings.insert) | (stall < settings.stall)
        parts: list[bytes] = []
        done = 0
        for i in np.flatnonzero(hit).tolist():
            parts.append(self._after_stall(data[done:i]))
            if stall[i] < settings.stall:
                self.stall_s += settings.stall_s
                self.log.append(ChannelError("stall", offset + i))
                self._losing = settings.stall_bytes
            parts.append(self._after_stall(self._damage_byte(data[i], offset + i, event[i], bit[i], value[i])))
            done = i + 1
        parts.append(self._after_stall(data[done:]))
        return b"".join(parts)

    def _damage_byte(self, byte: int, offset: int, event: float, bit: float, value: float) -> bytes:
        """Damage one byte, by three numbers from 0 to 1."""
        settings = self._settings
        if event < settings.drop:
            self.log.append(ChannelError("drop", offset))
            return b""
        if event < settings.drop + settings.flip:
            self.log.append(ChannelError("flip", offset))
            return bytes([byte ^ 1 << int(8 * bit)])
        if event < settings.drop + settings.flip + settings.insert:
            self.log.append(ChannelError("insert", offset))
            return bytes([int(256 * value), byte])
        return bytes([byte])

    def _after_stall(self, data: bytes) -> bytes:
        """Remove the bytes that a stall loses."""
        lost = min(self._losing, len(data))
        self._losing -= lost
        return data[lost:]
