"""Downlink messages: to the byte, refused when wrong, and found again after damage."""

import json
import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import seeds

from repro.fpga.downlink import (
    RAM_SAMPLES,
    Gains,
    encode_gains,
    encode_identify,
    encode_identity,
    encode_program,
    encode_start,
    encode_stop,
    encode_trajectory,
    parse_gains,
    parse_identity,
    parse_start,
    parse_trajectory,
)
from repro.fpga.frames import encode
from repro.fpga.messages import Message, MessageDecoder, MessageKind, encode_message
from repro.fpga.stream import UNVERIFIABLE

GAINS = Gains(kp=(4000.0, 3500.5), kv=(20000.0, 15000.25), pwm_hz=(20e3, 20e3))


def split(data, sizes=()):
    """Messages of `data` fed in pieces, and the decoder."""
    decoder = MessageDecoder()
    messages, place = [], 0
    for size in sizes:
        messages += decoder.feed(data[place : place + size])
        place += size
    return messages + decoder.feed(data[place:]), decoder


@pytest.mark.parametrize(
    ("data", "text"),
    [
        # Checksums from an independent CRC-32 (the usual reflected polynomial 0xEDB88320), bit by bit.
        (encode_start(3770), "5a0300020eba"),
        (encode_stop(), "5a040000"),
        (encode_identify(), "5a050000"),
        (encode_trajectory([[1.0], [-2.0]]), "5a02000a00003f800000c0000000"),
        (encode_gains(Gains((1, 2), (0.5, 0), (4, 8))), "5a0100183f800000400000003f000000000000004080000041000000"),
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


@given(seed=seeds, n=st.integers(1, 700), sizes=st.lists(st.integers(0, 500), max_size=20))
def test_program_comes_back(seed, n, sizes):
    desired = np.random.default_rng(seed).normal(size=(2, n))
    messages, decoder = split(encode_program(GAINS, desired) + encode_start(n), sizes)
    assert (decoder.crc_failures, decoder.skipped) == (0, 0)
    assert parse_gains(messages[0]) == GAINS
    blocks = [parse_trajectory(m) for m in messages[1:-1]]
    assert [b.start for b in blocks] == list(range(0, n, 256))
    np.testing.assert_array_equal(np.concatenate([b.desired for b in blocks], axis=1), desired.astype(np.float32))
    assert parse_start(messages[-1]) == n


@given(seed=seeds)
def test_damage_costs_the_messages_it_hits(seed):
    rng = np.random.default_rng(seed)
    parts = [encode_message(MessageKind.START, bytes([1, i])) for i in range(40)]
    hit = set()
    for i in rng.integers(0, 40, 4).tolist():
        part = bytearray(parts[i])
        if i not in hit:
            j = int(rng.integers(len(part)))
            if rng.random() < 0.5:
                part[j] ^= 1 << int(rng.integers(8))
            else:
                del part[j]
        parts[i] = bytes(part)
        hit.add(i)
    data = b"".join(parts)
    messages, _ = split(data)
    assert [m.payload[1] for m in messages] == [i for i in range(40) if i not in hit]
    assert split(data, [1] * len(data))[0] == messages


@given(seed=seeds, sizes=st.lists(st.integers(0, 40), max_size=30))
def test_cutting_changes_nothing(seed, sizes):
    rng = np.random.default_rng(seed)
    data = b"".join(
        (encode_stop(), encode_start(5), encode_identity({"a": 1}), rng.bytes(9), b"\x5a\x02\x08\x02")[i][
            int(rng.integers(3)) :
        ]
        for i in rng.integers(0, 5, 20)
    )
    whole, decoder = split(data)
    cut, other = split(data, sizes)
    assert (cut, other.crc_failures, other.skipped) == (whole, decoder.crc_failures, decoder.skipped)


def test_stop_inside_an_unfinished_block_is_understood_at_once():
    block = encode_trajectory(np.zeros((2, 256)))
    messages, decoder = split(block[:1000] + encode_stop())
    assert [m.kind for m in messages] == [MessageKind.STOP]
    assert decoder.skipped == 1000


@pytest.mark.parametrize("header", ["5a01ffff", "5a02ffff", "5a020003", "5a03000a", "5a7f0002", "5a85ffff", "5a5a5a"])
def test_absurd_header_is_not_waited_for(header):
    messages, _ = split(bytes.fromhex(header) + encode_stop())
    assert [m.kind for m in messages] == [MessageKind.STOP]


def test_checksum_failures_are_counted():
    data = bytearray(encode_start(7))
    data[5] ^= 1
    messages, decoder = split(bytes(data) + encode_start(7))
    assert [parse_start(m) for m in messages] == [7]
    assert (decoder.crc_failures, decoder.skipped) == (1, len(data))


def test_identity():
    identity = {"simulated": True, "plant": {"stribeck": 0.3, "name": "Süd"}}
    ((message,), _) = split(encode_identity(identity))
    assert message.kind == 0x85
    assert parse_identity(message) == identity
    assert json.loads(message.payload) == identity


@pytest.mark.parametrize(
    ("payload", "message"),
    [(b"[1]", "must be a JSON object, got list"), (b"{", "must be UTF-8 JSON"), (b"\xff", "must be UTF-8 JSON")],
)
def test_wrong_identity(payload, message):
    with pytest.raises(ValueError, match=message):
        parse_identity(Message(MessageKind.IDENTITY, payload))


@pytest.mark.parametrize(
    ("desired", "message"),
    [
        (np.zeros((2, RAM_SAMPLES + 1)), r"RAM holds 1 ... 8192 samples \(20.48 s at 2.5 ms\), got 8193"),
        (np.zeros((2, 0)), "RAM holds 1 ... 8192 samples"),
        (np.zeros((3, 4)), r"must have the shape \(2, N\), got \(3, 4\)"),
        ([[np.nan], [0.0]], "every sample must be finite in single precision"),
        ([[1e39], [0.0]], "every sample must be finite in single precision"),
    ],
)
def test_trajectory_that_cannot_be_sent(desired, message):
    with pytest.raises(ValueError, match=message):
        encode_trajectory(desired)


def test_whole_ram_fits():
    messages, _ = split(encode_trajectory(np.zeros((2, RAM_SAMPLES))))
    last = parse_trajectory(messages[-1])
    assert last.start + last.desired.shape[1] == RAM_SAMPLES


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"kp": (np.inf, 1)}, "kp: must be finite in single precision and not negative"),
        ({"kv": (1, np.nan)}, "kv: must be finite"),
        ({"kp": (-1, 1)}, "kp: must be finite in single precision and not negative"),
        ({"kp": (1e39, 1)}, "kp: must be finite in single precision"),
        ({"pwm_hz": (0, 1)}, "pwm_hz: must be positive"),
        ({"pwm_hz": (1,)}, "pwm_hz: must hold one number for each joint, got 1"),
    ],
)
def test_gains_that_cannot_be(change, message):
    with pytest.raises(ValueError, match=message):
        Gains(**{"kp": (1, 1), "kv": (1, 1), "pwm_hz": (1, 1), **change})


def test_board_refuses_what_a_host_should_not_send():
    nan = np.array([np.nan, 0], dtype=">f4").tobytes()
    with pytest.raises(ValueError, match="trajectory: every sample must be finite"):
        parse_trajectory(Message(MessageKind.TRAJECTORY, b"\0\0" + nan))
    with pytest.raises(ValueError, match=r"samples 8191 \.\.\. 8192 lie beyond the RAM"):
        parse_trajectory(Message(MessageKind.TRAJECTORY, (8191).to_bytes(2) + bytes(16)))
    with pytest.raises(ValueError, match="kp: must be finite"):
        parse_gains(Message(MessageKind.GAINS, nan * 3))
    with pytest.raises(ValueError, match="RAM holds 1"):
        parse_start(Message(MessageKind.START, b"\0\0"))
    with pytest.raises(ValueError, match="message: must be START, got STOP"):
        parse_start(Message(MessageKind.STOP, b""))


@pytest.mark.parametrize(
    ("kind", "length"),
    [(MessageKind.GAINS, 23), (MessageKind.TRAJECTORY, 2), (MessageKind.TRAJECTORY, 2058), (MessageKind.STOP, 1)],
)
def test_payload_of_the_wrong_length(kind, length):
    with pytest.raises(ValueError, match=f"{kind.name} cannot have {length} bytes"):
        encode_message(kind, bytes(length))


def test_start_range():
    assert zlib.crc32(encode_start(8192)[1:6]) == int.from_bytes(encode_start(8192)[6:])
    for n in (0, 8193):
        with pytest.raises(ValueError, match=r"RAM holds 1 \.\.\. 8192"):
            encode_start(n)


def test_examples_of_the_document():
    text = (Path(__file__).parents[2] / "docs" / "protocol.md").read_text(encoding="utf-8")
    examples = [bytes.fromhex(line) for line in text.splitlines() if line.startswith("    ")]
    assert examples == [encode([[165], [-2]], [[5], [-1023]]), encode_start(3770)]
    assert all(sentence.split(":")[0] in " ".join(text.split()).replace("`", "") for sentence in UNVERIFIABLE)
