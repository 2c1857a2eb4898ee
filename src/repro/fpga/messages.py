"""Downlink messages: framing, checksum, and an incremental decoder that finds its way back after damage.

A message is ``0x5A, type, payload length (uint16), payload, CRC-32``, numbers big-endian; the checksum covers type,
length and payload. This layout is ours: the paper tells what is sent, not how.
"""

import struct
import zlib
from dataclasses import dataclass
from enum import IntEnum
from typing import Final

SYNC: Final = 0x5A
#: Samples of both joints in a trajectory block at most.
BLOCK_SAMPLES: Final = 256
#: Bytes of the board's description of itself at most.
IDENTITY_BYTES: Final = 4096

_HEADER = struct.Struct(">BBH")
_CHECKSUM = struct.Struct(">I")
_FRAMING = _HEADER.size + _CHECKSUM.size


class MessageKind(IntEnum):
    """Type byte of a message."""

    GAINS = 0x01
    TRAJECTORY = 0x02
    START = 0x03
    STOP = 0x04
    IDENTIFY = 0x05
    IDENTITY = 0x85


# Lengths a payload can have. A header that tells another one is damaged, so it is never waited for.
_LENGTHS: Final = {
    MessageKind.GAINS: range(24, 25),
    MessageKind.TRAJECTORY: range(2 + 8, 2 + 8 * BLOCK_SAMPLES + 1, 8),
    MessageKind.START: range(2, 3),
    MessageKind.STOP: range(1),
    MessageKind.IDENTIFY: range(1),
    MessageKind.IDENTITY: range(1, IDENTITY_BYTES + 1),
}


@dataclass(frozen=True)
class Message:
    """A message that arrived whole."""

    kind: MessageKind  # what it is
    payload: bytes  # its content


def encode_message(kind: MessageKind, payload: bytes = b"") -> bytes:
    """Bytes of a message."""
    if len(payload) not in _LENGTHS[MessageKind(kind)]:
        raise ValueError(f"payload: {MessageKind(kind).name} cannot have {len(payload)} bytes.")
    head = _HEADER.pack(SYNC, kind, len(payload))
    return head + payload + _CHECKSUM.pack(zlib.crc32(head[1:] + payload))


class MessageDecoder:
    """Messages of a byte stream, fed in pieces of any size.

    Of messages that overlap the one that ends first counts, so a message after one that lost bytes is understood at
    once instead of being taken for the rest of it.
    """

    def __init__(self) -> None:
        self.crc_failures = 0
        self.skipped = 0
        self._data = b""

    def feed(self, data: bytes) -> list[Message]:
        """Take the next bytes."""
        self._data += data
        messages: list[Message] = []
        place = 0
        while place < len(self._data):
            start = self._data.find(SYNC, place)
            if start < 0:
                start = len(self._data)
            self.skipped += start - place
            place = start
            end = _end(self._data, place)
            if end == place:  # no message begins here
                self.skipped += 1
                place += 1
                continue
            inner = _first_inside(self._data, place, min(end - 1, len(self._data)))
            if inner is not None:
                self.skipped += inner - place
                place, end = inner, _end(self._data, inner)
            elif end > len(self._data):
                break
            if _intact(self._data, place, end):
                payload = self._data[place + _HEADER.size : end - _CHECKSUM.size]
                messages.append(Message(MessageKind(self._data[place + 1]), payload))
                place = end
            else:
                self.crc_failures += 1
                self.skipped += 1
                place += 1
        self._data = self._data[place:]
        return messages


def _first_inside(data: bytes, outer: int, limit: int) -> int | None:
    """Start of the intact message behind `outer` that ends first, `limit` at the latest; None if there is none."""
    found: int | None = None
    start = data.find(SYNC, outer + 1, limit)
    while start >= 0:
        end = _end(data, start)
        if start < end <= limit and _intact(data, start, end):
            found, limit = start, end - 1
        start = data.find(SYNC, start + 1, limit)
    return found


def _end(data: bytes, start: int) -> int:
    """End of the message that begins at `start`: `start` if its header is wrong, beyond the data if that is cut off."""
    if start + _HEADER.size > len(data):
        known = [kind for kind in _LENGTHS if start + 1 >= len(data) or data[start + 1] == kind]
        return len(data) + 1 if known else start
    kind = data[start + 1]
    length = int.from_bytes(data[start + 2 : start + 4])
    if kind not in _LENGTHS or length not in _LENGTHS[MessageKind(kind)]:
        return start
    return start + length + _FRAMING


def _intact(data: bytes, start: int, end: int) -> bool:
    """Whether the checksum of the message in ``start ... end - 1`` is right."""
    checksum = int.from_bytes(data[end - _CHECKSUM.size : end])
    return checksum == zlib.crc32(data[start + 1 : end - _CHECKSUM.size])
