"""Downlink messages (Section III): gains, desired trajectory, start and stop for the board, and the board's identity.

A message is ``0x5A, type, payload length (uint16), payload, CRC-32``, numbers big-endian; the checksum covers type,
length and payload. This layout is ours: the paper describes the content, not the encoding.
"""

import json
import math
import re
import struct
import zlib
from collections.abc import Iterator
from enum import IntEnum
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from repro.board.controller import ControlConstants
from repro.board.frames import PWM_LIMIT, SingleArray
from repro.documents import parse_json
from repro.signals.programs import MEMORY_SAMPLES

SYNC: Final = 0x5A
#: Samples of both joints in a trajectory block at most.
BLOCK_SAMPLES: Final = 256
#: Bytes of the board's description of itself at most.
IDENTITY_BYTES: Final = 4096

_HEADER = struct.Struct(">BBH")
_CHECKSUM = struct.Struct(">I")
_FRAMING = _HEADER.size + _CHECKSUM.size
_GAINS = struct.Struct(">6f")
_SAMPLE = struct.Struct(">H")


class MessageKind(IntEnum):
    """Type byte of a message."""

    GAINS = 0x01
    TRAJECTORY = 0x02
    START = 0x03
    STOP = 0x04
    IDENTIFY = 0x05
    IDENTITY = 0x85


# Lengths that a payload can have. A header with another one is damaged, so its payload is never waited for.
_LENGTHS: Final[dict[int, range]] = {
    MessageKind.GAINS: range(24, 25),
    MessageKind.TRAJECTORY: range(2 + 8, 2 + 8 * BLOCK_SAMPLES + 1, 8),
    MessageKind.START: range(2, 3),
    MessageKind.STOP: range(1),
    MessageKind.IDENTIFY: range(1),
    MessageKind.IDENTITY: range(1, IDENTITY_BYTES + 1),
}


class Message(NamedTuple):
    """A message that arrived whole."""

    kind: MessageKind
    payload: bytes


class MessageDecoder:
    """Messages of a byte stream, fed in pieces of any size.

    Of messages that overlap, the one that ends first counts. So a message after one that lost bytes is understood at
    once, not taken for the rest of the damaged one.
    """

    def __init__(self) -> None:
        self._data = b""

    def feed(self, data: bytes) -> list[Message]:
        """Give the messages complete by now, oldest first."""
        self._data += data
        spans = [*_spans(self._data)]
        messages: list[Message] = []
        place = 0
        for end, start in sorted((end, start) for start, end in spans if _intact(self._data, start, end)):
            if start >= place:
                payload = self._data[start + _HEADER.size : end - _CHECKSUM.size]
                messages.append(Message(MessageKind(self._data[start + 1]), payload))
                place = end
        # What is before the first incomplete message cannot become one.
        waiting = (start for start, end in spans if start >= place and end > len(self._data))
        self._data = self._data[next(waiting, len(self._data)) :]
        return messages


def _spans(data: bytes) -> Iterator[tuple[int, int]]:
    """Find where messages can begin and end; one whose header is incomplete ends behind the data."""
    for start in (sync.start() for sync in re.finditer(bytes([SYNC]), data)):
        kind, length = data[start + 1 : start + 2], data[start + 2 : start + 4]
        if len(length) == 2:
            if int.from_bytes(length) in _LENGTHS.get(kind[0], ()):
                yield start, start + int.from_bytes(length) + _FRAMING
        elif not kind or kind[0] in _LENGTHS:
            yield start, len(data) + 1


def _intact(data: bytes, start: int, end: int) -> bool:
    """Check whether the message is complete and its checksum right."""
    last = end - _CHECKSUM.size
    return end <= len(data) and data[last:end] == _CHECKSUM.pack(zlib.crc32(data[start + 1 : last]))


def encode_message(kind: MessageKind, payload: bytes = b"") -> bytes:
    """Encode a message; ValueError if its payload cannot have this length."""
    if len(payload) not in _LENGTHS[kind]:
        raise ValueError(f"payload: {kind.name} cannot have {len(payload)} bytes.")
    head = _HEADER.pack(SYNC, kind, len(payload))
    return head + payload + _CHECKSUM.pack(zlib.crc32(head[1:] + payload))


def encode_gains(control: ControlConstants) -> bytes:
    """Encode the message that sets the controller's constants."""
    return encode_message(MessageKind.GAINS, _GAINS.pack(*control.kp_counts, *control.kv_counts, *control.pwm_hz))


def encode_trajectory(desired: ArrayLike) -> bytes:
    """Encode q_d (2, N), rad, as messages that fill the board's RAM."""
    samples = np.asarray(desired, dtype=np.float64).T.astype(">f4")
    return b"".join(
        encode_message(MessageKind.TRAJECTORY, _SAMPLE.pack(start) + samples[start : start + BLOCK_SAMPLES].tobytes())
        for start in range(0, len(samples), BLOCK_SAMPLES)
    )


def encode_program(control: ControlConstants, desired: ArrayLike) -> bytes:
    """Encode all that the board needs before its start: gains and q_d (2, N), rad."""
    return encode_gains(control) + encode_trajectory(desired)


def encode_start(samples: int) -> bytes:
    """Encode the message that starts the arm for a number of samples."""
    return encode_message(MessageKind.START, _SAMPLE.pack(samples))


def encode_identity(identity: dict[str, Any]) -> bytes:
    """Encode the board's answer to IDENTIFY, one JSON object."""
    text = json.dumps(identity, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return encode_message(MessageKind.IDENTITY, text.encode())


def parse_program(data: bytes) -> tuple[ControlConstants, SingleArray]:
    """Read what `encode_program` wrote: gains and q_d (2, N), rad; ValueError if it is anything else."""
    messages = MessageDecoder().feed(data)
    read = sum(len(message.payload) + _FRAMING for message in messages)
    if not messages or read != len(data):
        raise ValueError(f"program: {len(data) - read} of {len(data)} bytes belong to no intact message.")
    gains, trajectory = parse_gains(messages[0]), np.empty((2, 0), dtype=np.float32)
    for start, desired in map(parse_trajectory, messages[1:]):
        if start != trajectory.shape[1]:
            raise ValueError(f"program: a block begins at sample {start}, must begin at {trajectory.shape[1]}.")
        trajectory = np.concatenate([trajectory, desired], axis=1)
    if not trajectory.size:
        raise ValueError("program: has no trajectory.")
    return gains, trajectory


def parse_gains(message: Message) -> ControlConstants:
    """Read the controller's constants in PWM counts; ValueError if they are impossible."""
    _check_kind(message, MessageKind.GAINS)
    numbers = _GAINS.unpack(message.payload)
    gains = {"kp": numbers[0:2], "kv": numbers[2:4], "pwm_hz": numbers[4:6]}
    for name, values in gains.items():
        if not all(0.0 <= value < math.inf for value in values):
            raise ValueError(f"{name}: must be finite in single precision and not negative, got {values}.")
    if min(gains["pwm_hz"]) == 0.0:
        raise ValueError(f"pwm_hz: must be positive, got {gains['pwm_hz']}.")
    return ControlConstants(**gains, full_torque=(float(PWM_LIMIT), float(PWM_LIMIT)))


def parse_trajectory(message: Message) -> tuple[int, SingleArray]:
    """Read a block of the trajectory: its first sample and q_d (2, n), rad; ValueError if the RAM cannot contain it."""
    _check_kind(message, MessageKind.TRAJECTORY)
    (start,) = _SAMPLE.unpack_from(message.payload)
    samples = np.frombuffer(message.payload, dtype=">f4", offset=_SAMPLE.size).reshape(-1, 2)
    if start + len(samples) > MEMORY_SAMPLES:
        raise ValueError(f"trajectory: samples {start} ... {start + len(samples) - 1} are beyond the RAM.")
    if not np.isfinite(samples).all():
        raise ValueError("trajectory: every sample must be finite.")
    return int(start), np.ascontiguousarray(samples.T, dtype=np.float32)


def parse_start(message: Message) -> int:
    """Read the number of samples to run for; ValueError if the RAM cannot contain them."""
    (samples,) = _SAMPLE.unpack(message.payload)
    if not 1 <= samples <= MEMORY_SAMPLES:
        raise ValueError(f"trajectory: the board's RAM contains 1 ... {MEMORY_SAMPLES} samples, got {samples}.")
    return int(samples)


def parse_identity(message: Message) -> dict[str, Any]:
    """Read the board's description of itself; ValueError if it is not one JSON object."""
    try:
        identity = parse_json(message.payload.decode(), "identity")
    except ValueError as error:
        raise ValueError(f"identity: must be UTF-8 JSON ({error}).") from error
    if not isinstance(identity, dict):
        raise ValueError(f"identity: must be a JSON object, got {type(identity).__name__}.")
    return identity


def _check_kind(message: Message, kind: MessageKind) -> None:
    if message.kind != kind:
        raise ValueError(f"message: must be {kind.name}, got {message.kind.name}.")
