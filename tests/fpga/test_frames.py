"""The 64-bit uplink frame (Section III)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import seeds

from repro.fpga.frames import COUNTS_PER_TURN, MAX_STEP, RADIANS_PER_COUNT, SAMPLING_PERIOD, decode, encode, valid_words

# Built by hand: identifier, two int16, two 11-bit torques, two zero bits.
GOLDEN = {
    "a500000000000000": ((0, 0), (0, 0)),
    "a500a5fffe00b004": ((165, -2), (5, -1023)),
    "a57fff80007feffc": ((32767, -32768), (1023, 1023)),
    "a5ffff0001ffe008": ((-1, 1), (-1, 2)),
}


def bits(position, pwm):
    """The frame as a string of bits."""
    fields = [(0xA5, 8), (position[0], 16), (position[1], 16), (pwm[0], 11), (pwm[1], 11), (0, 2)]
    return "".join(format(value % 2**width, f"0{width}b") for value, width in fields)


@pytest.mark.parametrize("text", GOLDEN)
def test_golden_frames(text):
    position, pwm = GOLDEN[text]
    assert encode(np.array([position]).T, np.array([pwm]).T).hex() == text
    read = decode(bytes.fromhex(text))
    np.testing.assert_array_equal(read, (np.array([position]).T, np.array([pwm]).T))


@given(seed=seeds, n=st.integers(0, 20))
def test_frames_are_their_bits_and_come_back(seed, n):
    rng = np.random.default_rng(seed)
    position, pwm = rng.integers(-(2**15), 2**15, (2, n)), rng.integers(-1023, 1024, (2, n))
    data = encode(position, pwm)
    text = "".join(bits(position[:, i].tolist(), pwm[:, i].tolist()) for i in range(n))
    assert data == bytes(int(text[i : i + 8], 2) for i in range(0, len(text), 8))
    read = decode(data)
    np.testing.assert_array_equal(read, (position, pwm))
    assert all(part.dtype == np.int16 and part.shape == (2, n) for part in read)


def test_constants_are_the_papers():
    assert round(RADIANS_PER_COUNT * 1e3, 3) == 0.748
    assert round(2**15 / COUNTS_PER_TURN, 1) == 3.9
    assert MAX_STEP == 27 >= 8 * SAMPLING_PERIOD / RADIANS_PER_COUNT > 26


@pytest.mark.parametrize(
    ("position", "pwm", "message"),
    [
        ([[0], [32768]], [[0], [0]], "position: must lie in -32768 ... 32767, got 32768"),
        ([[0], [0]], [[-1024], [0]], "pwm: must lie in -1023 ... 1023, got -1024"),
        ([[0], [0]], [[0, 1], [0, 1]], "must be equally long, got 1 and 2"),
        ([0, 0], [[0], [0]], r"position: must have the shape \(2, N\), got \(2,\)"),
        ([[0.5], [0]], [[0], [0]], "position: must hold integers, got float64"),
    ],
)
def test_what_cannot_be_encoded(position, pwm, message):
    with pytest.raises(ValueError, match=message):
        encode(position, pwm)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a500", "whole frames of 8 bytes, got 2"),
        ("a500000000000000a400000000000000", "identifier must be 0xA5; frame 1 is a400000000000000"),
        ("a500000000000001", "last two bits must be zero; frame 0"),
        ("a5ff5b03e8801ffc", "torque must not be -1024"),
        ("a500000000001000", "torque must not be -1024"),
    ],
)
def test_what_is_no_frame(text, message):
    with pytest.raises(ValueError, match=message):
        decode(bytes.fromhex(text))


@given(word=st.integers(0, 2**64 - 1) | st.integers(0, 2**54 - 1).map(lambda w: 0xA5 << 56 | w << 2))
def test_a_word_is_valid_exactly_if_it_decodes(word):
    data = word.to_bytes(8)
    try:
        decode(data)
        readable = True
    except ValueError:
        readable = False
    assert valid_words(np.array([word], dtype=np.uint64)).tolist() == [readable]
