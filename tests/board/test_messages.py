"""Downlink messages: to the byte, refused when wrong, and found again after damage."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fake_board import CONTROL
from hypothesis import example, given
from hypothesis import strategies as st
from strategies import cut, seeds

from repro.board import messages
from repro.board.controller import ControlConstants
from repro.board.frames import encode
from repro.board.messages import Message, MessageKind, parse_gains, parse_identity, parse_start, parse_trajectory
from repro.signals.programs import MEMORY_SAMPLES

STOP = messages.encode_message(MessageKind.STOP)


def split(data, sizes=()):
    decoder = messages.MessageDecoder()
    return [message for piece in cut(data, sizes) for message in decoder.feed(piece)]


#: Constants whose counts are these numbers.
PLAIN = ControlConstants((1.0, 2.0), (0.5, 0.25), (4.0, 8.0), (1023.0, 1023.0))


@pytest.mark.parametrize(
    ("data", "text"),
    [
        # Checksums from an independent CRC-32 (the usual reflected polynomial 0xEDB88320), bit by bit.
        (messages.encode_start(3770), "5a0300020eba"),
        (STOP, "5a040000"),
        (messages.encode_message(MessageKind.IDENTIFY), "5a050000"),
        (messages.encode_trajectory([[1.0], [-2.0]]), "5a02000a00003f800000c0000000"),
        (messages.encode_gains(PLAIN), "5a0100183f800000400000003f0000003e8000004080000041000000"),
    ],
)
def test_messages_to_the_byte(data, text):
    body = bytes.fromhex(text)
    crc = 0xFFFFFFFF
    for byte in body[1:]:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xEDB88320 if crc & 1 else 0)
    assert data == body + (crc ^ 0xFFFFFFFF).to_bytes(4)


@example(seed=0, n=MEMORY_SAMPLES, sizes=[])
@given(seed=seeds, n=st.integers(1, 700), sizes=st.lists(st.integers(0, 500), max_size=20))
def test_program_comes_back(seed, n, sizes):
    desired = np.random.default_rng(seed).normal(size=(2, n))
    received = split(messages.encode_program(CONTROL, desired) + messages.encode_start(n), sizes)
    gains = parse_gains(received[0])
    assert (*gains.kp, *gains.kv, *gains.pwm_hz) == (*CONTROL.kp_counts, *CONTROL.kv_counts, *CONTROL.pwm_hz)
    blocks = [parse_trajectory(m) for m in received[1:-1]]
    assert [start for start, _ in blocks] == list(range(0, n, 256))
    np.testing.assert_array_equal(np.concatenate([q for _, q in blocks], axis=1), desired.astype(np.float32))
    assert parse_start(received[-1]) == n


@given(seed=seeds)
def test_damage_costs_the_messages_it_hits(seed):
    rng = np.random.default_rng(seed)
    parts = [messages.encode_message(MessageKind.START, bytes([1, i])) for i in range(40)]
    hit = rng.choice(40, 4, replace=False).tolist()
    for i in hit:
        part = bytearray(parts[i])
        j = int(rng.integers(len(part)))
        if rng.random() < 0.5:
            part[j] ^= 1 << int(rng.integers(8))
        else:
            del part[j]
        parts[i] = bytes(part)
    data = b"".join(parts)
    received = split(data)
    assert [m.payload[1] for m in received] == [i for i in range(40) if i not in hit]
    assert split(data, [1] * len(data)) == received


@pytest.mark.parametrize("header", ["5a01ffff", "5a020003", "5a7f0002", "5a5a5a"])
def test_an_absurd_header_is_not_waited_for(header):
    assert [m.kind for m in split(bytes.fromhex(header) + STOP)] == [MessageKind.STOP]


def test_identity():
    identity = {"simulated": True, "plant": {"stribeck": 0.3, "name": "Süd"}}
    (message,) = split(messages.encode_identity(identity))
    assert message.kind == 0x85
    assert parse_identity(message) == json.loads(message.payload) == identity


NAN = np.array([np.nan, 0], dtype=">f4").tobytes()


def gains_message(**changes):
    return split(messages.encode_gains(replace(PLAIN, **changes)))[0]


@pytest.mark.parametrize(
    ("parse", "message", "found"),
    [
        (parse_trajectory, Message(MessageKind.TRAJECTORY, b"\0\0" + NAN), "trajectory: every sample must be finite"),
        (parse_trajectory, Message(MessageKind.TRAJECTORY, (8191).to_bytes(2) + bytes(16)), "beyond the RAM"),
        (parse_gains, Message(MessageKind.GAINS, NAN * 3), "kp: must be finite"),
        (parse_gains, gains_message(kp=(-1.0, 1.0)), "kp: must be finite in single precision and not negative"),
        (parse_gains, gains_message(pwm_hz=(0.0, 1.0)), "pwm_hz: must be positive"),
        (parse_start, Message(MessageKind.START, b"\0\0"), "RAM contains 1"),
        (parse_identity, Message(MessageKind.IDENTITY, b"[1]"), "must be a JSON object, got list"),
        (parse_identity, Message(MessageKind.IDENTITY, b"{"), "must be UTF-8 JSON"),
    ],
)
def test_a_wrong_payload_is_refused(parse, message, found):
    with pytest.raises(ValueError, match=found):
        parse(message)


def test_examples_of_the_document():
    text = (Path(__file__).parents[2] / "docs" / "protocol.md").read_text(encoding="utf-8")
    examples = [bytes.fromhex(block) for block in re.findall(r"^```text\n(.*?)^```", text, re.MULTILINE | re.DOTALL)]
    assert examples == [encode([[165], [-2]], [[5], [-1023]]), messages.encode_start(3770)]
