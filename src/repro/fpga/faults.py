"""Faults of a serial line, drawn from a seed: bytes lost, flipped or added, stalls, and a cable pulled out."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

FaultKind = Literal["drop", "flip", "insert", "stall", "disconnect"]


@dataclass(frozen=True)
class FaultSettings:
    """How often what goes wrong."""

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
        for name in ("drop", "flip", "insert", "stall"):
            value = getattr(self, name)
            if not 0.0 <= value <= 1.0:
                raise ValueError(f"{name}: a probability must lie in 0 ... 1, got {value}.")
        if self.drop + self.flip + self.insert > 1.0:
            raise ValueError("drop, flip, insert: must not exceed 1 together.")
        if not 0.0 <= self.stall_s < np.inf:
            raise ValueError(f"stall_s: must be finite and not negative, got {self.stall_s}.")
        if self.stall_bytes < 0:
            raise ValueError(f"stall_bytes: must not be negative, got {self.stall_bytes}.")
        if self.disconnect_after is not None and self.disconnect_after < 0:
            raise ValueError(f"disconnect_after: must not be negative, got {self.disconnect_after}.")


@dataclass(frozen=True)
class Fault:
    """One fault that was injected."""

    kind: FaultKind  # what happened
    offset: int  # byte of the undamaged stream that it befell, or before which it happened


class FaultInjector:
    """Damages a byte stream; the same seed does the same damage however the stream is cut."""

    def __init__(self, settings: FaultSettings, rng: np.random.Generator) -> None:
        self.log: list[Fault] = []
        self.stall_s = 0.0
        self.disconnected = settings.disconnect_after == 0
        if self.disconnected:
            self.log.append(Fault("disconnect", 0))
        self._settings = settings
        self._rng = rng
        self._offset = 0
        self._losing = 0

    def counts(self) -> dict[FaultKind, int]:
        """Faults so far by kind."""
        kinds: tuple[FaultKind, ...] = ("drop", "flip", "insert", "stall", "disconnect")
        return {kind: sum(fault.kind == kind for fault in self.log) for kind in kinds}

    def take_stall(self) -> float:
        """Silence due, s, which the caller promises to keep."""
        due, self.stall_s = self.stall_s, 0.0
        return due

    def apply(self, data: bytes) -> bytes:
        """Damage the next bytes."""
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
            self.log.append(Fault("disconnect", self._offset))
        return damaged

    def _damage(self, data: bytes, offset: int) -> bytes:
        settings = self._settings
        event, bit, value, stall = self._rng.random((len(data), 4)).T
        struck = (event < settings.drop + settings.flip + settings.insert) | (stall < settings.stall)
        parts: list[bytes] = []
        done = 0
        for i in np.flatnonzero(struck).tolist():
            parts.append(self._spare(data[done:i]))
            if stall[i] < settings.stall:
                self.stall_s += settings.stall_s
                self.log.append(Fault("stall", offset + i))
                self._losing = settings.stall_bytes
            parts.append(self._spare(self._befall(data[i], offset + i, event[i], bit[i], value[i])))
            done = i + 1
        parts.append(self._spare(data[done:]))
        return b"".join(parts)

    def _befall(self, byte: int, offset: int, event: float, bit: float, value: float) -> bytes:
        """What becomes of a byte, by three numbers from 0 to 1."""
        settings = self._settings
        if event < settings.drop:
            self.log.append(Fault("drop", offset))
            return b""
        if event < settings.drop + settings.flip:
            self.log.append(Fault("flip", offset))
            return bytes([byte ^ 1 << int(8 * bit)])
        if event < settings.drop + settings.flip + settings.insert:
            self.log.append(Fault("insert", offset))
            return bytes([int(256 * value), byte])
        return bytes([byte])

    def _spare(self, data: bytes) -> bytes:
        """Take away what a stall loses."""
        lost = min(self._losing, len(data))
        self._losing -= lost
        return data[lost:]
