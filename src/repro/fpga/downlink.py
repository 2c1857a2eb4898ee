"""What the host tells the board: gains, desired trajectory, start, stop (Section III); and who the board says it is."""

import json
import struct
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from repro.documents import parse_json
from repro.fpga.messages import BLOCK_SAMPLES, Message, MessageDecoder, MessageKind, encode_message
from repro.signals.programs import MEMORY_SAMPLES

#: Samples of both joints that the board's RAM holds as single-precision numbers.
RAM_SAMPLES: Final = MEMORY_SAMPLES

SingleArray = NDArray[np.float32]
Pair = tuple[float, float]

_GAINS = struct.Struct(">6f")
_SAMPLE = struct.Struct(">H")


@dataclass(frozen=True)
class Gains:
    """Constants of the controller, as the board is sent them."""

    kp: Pair  # proportional gains, PWM counts per rad
    kv: Pair  # derivative gains, PWM counts per rad between two samples
    pwm_hz: Pair  # PWM frequencies, Hz

    def __post_init__(self) -> None:
        for name in ("kp", "kv", "pwm_hz"):
            values = tuple(float(v) for v in getattr(self, name))
            if len(values) != 2:
                raise ValueError(f"{name}: must hold one number for each joint, got {len(values)}.")
            if not all(0.0 <= v <= float(np.finfo(np.float32).max) for v in values):
                raise ValueError(f"{name}: must be finite in single precision and not negative, got {values}.")
            object.__setattr__(self, name, values)
        if min(np.float32(v) for v in self.pwm_hz) == 0.0:
            raise ValueError(f"pwm_hz: must be positive, got {self.pwm_hz}.")


@dataclass(frozen=True)
class TrajectoryBlock:
    """Part of the desired trajectory."""

    start: int  # sample at which it begins
    desired: SingleArray  # (2, n), q_d, rad


def encode_gains(gains: Gains) -> bytes:
    """Message that sets the controller's constants."""
    return encode_message(MessageKind.GAINS, _GAINS.pack(*gains.kp, *gains.kv, *gains.pwm_hz))


def encode_trajectory(desired: ArrayLike) -> bytes:
    """Messages that fill the board's RAM, blocks of at most 256 samples."""
    wanted = np.asarray(desired, dtype=np.float64)
    if wanted.ndim != 2 or wanted.shape[0] != 2:
        raise ValueError(f"desired: must have the shape (2, N), got {wanted.shape}.")
    n = wanted.shape[1]
    _check_samples(n)
    if not (np.abs(wanted) <= np.finfo(np.float32).max).all():
        raise ValueError("desired: every sample must be finite in single precision.")
    samples = wanted.T.astype(">f4")
    return b"".join(
        encode_message(MessageKind.TRAJECTORY, _SAMPLE.pack(start) + samples[start : start + BLOCK_SAMPLES].tobytes())
        for start in range(0, n, BLOCK_SAMPLES)
    )


def encode_program(gains: Gains, desired: ArrayLike) -> bytes:
    """Gains and trajectory: all that the board needs before its start; see `encode_trajectory`."""
    return encode_gains(gains) + encode_trajectory(desired)


def parse_program(data: bytes) -> tuple[Gains, SingleArray]:
    """Read what `encode_program` wrote."""
    decoder = MessageDecoder()
    messages = decoder.feed(data)
    read = sum(len(encode_message(message.kind, message.payload)) for message in messages)
    if not messages or read != len(data):
        raise ValueError(f"program: {len(data) - read} of {len(data)} bytes belong to no intact message.")
    gains, blocks = parse_gains(messages[0]), [parse_trajectory(message) for message in messages[1:]]
    end = 0
    for block in blocks:
        if block.start != end:
            raise ValueError(f"program: a block begins at sample {block.start}, must begin at {end}.")
        end += block.desired.shape[1]
    if not blocks:
        raise ValueError("program: has no trajectory.")
    return gains, np.concatenate([block.desired for block in blocks], axis=1)


def encode_start(samples: int) -> bytes:
    """Message that starts the arm for a number of samples."""
    _check_samples(samples)
    return encode_message(MessageKind.START, _SAMPLE.pack(samples))


def encode_stop() -> bytes:
    """Message that stops the arm."""
    return encode_message(MessageKind.STOP)


def encode_identify() -> bytes:
    """Message that asks the board who it is."""
    return encode_message(MessageKind.IDENTIFY)


def encode_identity(identity: dict[str, Any]) -> bytes:
    """Board's answer to `encode_identify`: one JSON object."""
    text = json.dumps(identity, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return encode_message(MessageKind.IDENTITY, text.encode())


def parse_gains(message: Message) -> Gains:
    """Constants of the controller; ValueError if it is another message or `Gains` refuses them."""
    _check_kind(message, MessageKind.GAINS)
    numbers = _GAINS.unpack(message.payload)
    return Gains(kp=numbers[0:2], kv=numbers[2:4], pwm_hz=numbers[4:6])


def parse_trajectory(message: Message) -> TrajectoryBlock:
    """Part of the trajectory; ValueError if it is another message, does not fit the RAM or is not finite."""
    _check_kind(message, MessageKind.TRAJECTORY)
    (start,) = _SAMPLE.unpack_from(message.payload)
    samples = np.frombuffer(message.payload, dtype=">f4", offset=_SAMPLE.size).reshape(-1, 2)
    if start + len(samples) > RAM_SAMPLES:
        raise ValueError(f"trajectory: samples {start} ... {start + len(samples) - 1} lie beyond the RAM.")
    if not np.isfinite(samples).all():
        raise ValueError("trajectory: every sample must be finite.")
    return TrajectoryBlock(start, np.ascontiguousarray(samples.T, dtype=np.float32))


def parse_start(message: Message) -> int:
    """Count the samples to run for; ValueError if it is another message or the RAM does not hold them."""
    _check_kind(message, MessageKind.START)
    (samples,) = _SAMPLE.unpack(message.payload)
    _check_samples(samples)
    return int(samples)


def parse_identity(message: Message) -> dict[str, Any]:
    """What the board says of itself; ValueError if it is another message or not one JSON object."""
    _check_kind(message, MessageKind.IDENTITY)
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


def _check_samples(n: int) -> None:
    if not 1 <= n <= RAM_SAMPLES:
        raise ValueError(
            f"trajectory: the board's RAM holds 1 ... {RAM_SAMPLES} samples "
            f"({RAM_SAMPLES * 2.5e-3:g} s at 2.5 ms), got {n}."
        )
