"""The 64-bit uplink frame (Section III)."""

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st

from repro.board.frames import encode, is_valid, split_words

POSITION, PWM = st.integers(-(2**15), 2**15 - 1), st.integers(-1023, 1023)


@example([(32767, -32768, 1023, 1023), (-1, 1, -1, 2), (165, -2, 5, -1023)])
@given(st.lists(st.tuples(POSITION, POSITION, PWM, PWM), max_size=20))
def test_frames_are_their_bits_and_come_back(rows):
    numbers = np.array(rows, dtype=int).reshape(-1, 4).T
    data = encode(numbers[:2], numbers[2:])
    fields = [((0xA5, 8), (q1, 16), (q2, 16), (tau1, 11), (tau2, 11), (0, 2)) for q1, q2, tau1, tau2 in rows]
    text = "".join(f"{value % 2**width:0{width}b}" for frame in fields for value, width in frame)
    assert data == bytes(int(text[i : i + 8], 2) for i in range(0, len(text), 8))
    words = np.frombuffer(data, ">u8").astype(np.uint64)
    assert all(map(is_valid, words.tolist()))
    read = split_words(words)
    np.testing.assert_array_equal(np.concatenate(read), numbers)
    assert all(part.dtype == np.int16 for part in read)


@example(word=0xA5 << 56 | 0x400 << 13)
@example(word=0xA5 << 56 | 0x400 << 2)
@given(word=st.integers(0, 2**64 - 1) | st.integers(0, 2**54 - 1).map(lambda w: 0xA5 << 56 | w << 2))
def test_a_word_is_valid_by_its_bits(word):
    text = f"{word:064b}"
    never = "1" + "0" * 10
    expected = text[:8] == f"{0xA5:08b}" and text[-2:] == "00" and never not in (text[40:51], text[51:62])
    assert is_valid(word) == expected
