"""Receiving: when a recording ends, and why."""

import pytest
from fake_board import frames_of

from repro.fpga.link import Receiver, most_bytes

_, FRAMES = frames_of(200)


class Line:
    """A port that gives these pieces, one a look; an exception among them is raised."""

    def __init__(self, *pieces):
        self.pieces = list(pieces)

    def read(self, size):
        piece = self.pieces.pop(0) if self.pieces else b""
        if isinstance(piece, type):
            raise piece
        return piece


def receive(*pieces, samples=200):
    told = []
    receiver = Receiver(samples, silence=0.1)
    receiver.run(Line(*pieces), lambda done, total: told.append((done, total)))
    return receiver, receiver.close(), told


def cut(data, size):
    return [data[i : i + size] for i in range(0, len(data), size)]


@pytest.mark.parametrize("size", [1, 7, 64, 5000])
def test_it_ends_when_all_samples_have_come(size):
    receiver, reason, told = receive(*cut(FRAMES, size))
    assert (bytes(receiver.data), reason, receiver.good) == (FRAMES, "", 200)
    assert told[-1][1] == 200
    assert [done for done, _ in told] == sorted(done for done, _ in told)
    assert receiver.stamps[-1][0] == len(FRAMES)


@pytest.mark.parametrize("size", [1, 7, 5000])
def test_what_comes_after_the_last_sample_is_left_out(size):
    receiver, reason, _ = receive(*cut(FRAMES, size), samples=150)
    assert (bytes(receiver.data), reason, receiver.good) == (FRAMES[:1200], "", 150)


@pytest.mark.parametrize(
    ("end", "expected"), [((), "silent"), ((OSError,), "disconnected"), ((KeyboardInterrupt,), "interrupted")]
)
def test_what_arrived_before_a_bad_end_is_kept(end, expected):
    receiver, reason, _ = receive(*cut(FRAMES[:1001], 100), *end)
    assert (bytes(receiver.data), reason, receiver.good) == (FRAMES[:1001], expected, 125)


def test_a_bad_end_after_the_last_sample_is_none():
    assert receive(FRAMES, OSError)[1] == ""


def test_an_interruption_before_the_first_byte_is_passed_on():
    with pytest.raises(KeyboardInterrupt):
        receive(KeyboardInterrupt)


def test_lost_frames_within_make_no_recording_incomplete():
    damaged = FRAMES[:800] + bytes(8) + FRAMES[808:]
    receiver, reason, _ = receive(*cut(damaged, 64))
    assert (bytes(receiver.data), reason, receiver.good) == (damaged, "", 199)


def test_a_byte_too_many_does_not_cut_off_the_last_frame():
    for place in (1500, 1550, 1590):
        longer = FRAMES[:place] + b"\x11" + FRAMES[place:]
        receiver, _, _ = receive(*cut(longer, 3))
        assert bytes(receiver.data) == longer


@pytest.mark.parametrize("last", [b"", FRAMES[1592:-1], bytes(8)])
def test_without_the_last_sample_it_is_incomplete(last):
    assert receive(FRAMES[:1592] + last)[1] == "silent"


class Ticking:
    """A port that gives the same bytes at each look, and its clock, which a look advances."""

    def __init__(self, piece, seconds):
        self.piece, self.seconds, self.now = piece, seconds, 0.0

    def read(self, size):
        self.now += self.seconds
        return self.piece

    def clock(self):
        return self.now


@pytest.mark.parametrize(
    ("piece", "seconds"), [(b"\xa5", 1.0), (b"\x11", 1e-3), (bytes(1 << 16), 1e-6)], ids=["slow", "garbage", "flood"]
)
def test_a_device_that_sends_no_frame_ends_a_recording(piece, seconds):
    line, kept = Ticking(piece, seconds), []
    receiver = Receiver(200, 2.0, line.clock, kept.append)
    receiver.run(line, lambda done, total: None)
    assert receiver.close() == "overrun"
    assert receiver.good == 0
    assert line.now < 15.0  # a motion of 0.5 s
    assert len(receiver.data) <= most_bytes(200)
    assert b"".join(kept) == receiver.data
    assert receiver.data
