"""The 64-bit uplink frame (Section III)."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from strategies import seeds

from repro.fpga.frames import encode, is_valid, split_words

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
    word = np.array([int(text, 16)], dtype=np.uint64)
    np.testing.assert_array_equal(split_words(word), (np.array([position]).T, np.array([pwm]).T))


@given(seed=seeds, n=st.integers(0, 20))
def test_frames_are_their_bits_and_come_back(seed, n):
    rng = np.random.default_rng(seed)
    position, pwm = rng.integers(-(2**15), 2**15, (2, n)), rng.integers(-1023, 1024, (2, n))
    data = encode(position, pwm)
    text = "".join(bits(position[:, i].tolist(), pwm[:, i].tolist()) for i in range(n))
    assert data == bytes(int(text[i : i + 8], 2) for i in range(0, len(text), 8))
    words = np.frombuffer(data, ">u8").astype(np.uint64)
    assert all(map(is_valid, words.tolist()))
    read = split_words(words)
    np.testing.assert_array_equal(read, (position, pwm))
    assert all(part.dtype == np.int16 and part.shape == (2, n) for part in read)


@example(word=0xA5 << 56 | 0x400 << 13)
@example(word=0xA5 << 56 | 0x400 << 2)
@given(word=st.integers(0, 2**64 - 1) | st.integers(0, 2**54 - 1).map(lambda w: 0xA5 << 56 | w << 2))
def test_a_word_is_valid_by_its_bits(word):
    text = f"{word:064b}"
    never = "1" + "0" * 10
    expected = text[:8] == f"{0xA5:08b}" and text[-2:] == "00" and never not in (text[40:51], text[51:62])
    assert is_valid(word) == expected
