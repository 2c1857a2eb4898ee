"""The host's end of the link: whatever the port does, what arrived is kept or one line tells why nothing did."""

import _thread
import signal
import threading
import time

import numpy as np
import pytest
import serial
from fake_board import IDENTITY, PlayedBoard, frames_of, metadata, served

from repro.errors import InputError
from repro.fpga.channel_errors import ErrorInjector, ErrorRates
from repro.fpga.link import Receiver, most_bytes, record
from repro.fpga.messages import MessageKind, encode_start
from repro.fpga.server import PtyEndpoint, SocketEndpoint

DESIRED, FRAMES = frames_of(200)


def tcp():
    return SocketEndpoint("127.0.0.1", 0)


def recorded(port, silence=0.2):
    return record(port, metadata(DESIRED, board=None), 115200, silence, lambda piece: None)


@pytest.mark.slow
@pytest.mark.parametrize(("make", "real_time"), [(PtyEndpoint, False), (PtyEndpoint, True), (tcp, False)])
def test_a_recording_has_the_very_bytes(make, real_time):
    board = PlayedBoard(FRAMES)
    with served(board, make(), real_time=real_time) as port:
        data, received = recorded(port)
    assert (data, received.board, received.end_reason) == (FRAMES, IDENTITY, "")
    kinds = [message.kind for message in board.messages]
    assert kinds == [MessageKind.IDENTIFY, MessageKind.GAINS, MessageKind.TRAJECTORY, MessageKind.START]
    host = received.host
    assert (host.port, host.baud) == (port, 115200)
    offsets, seconds = np.array(host.chunks).T
    assert offsets[-1] == 1600 and (np.diff(offsets) > 0).all() and (np.diff(seconds) >= 0).all()
    if real_time:  # 0.5 s of motion, a stamp every 50 ms
        assert 2 <= len(host.chunks) <= 12 and seconds[-1] >= 0.49


def test_hardware_does_not_answer():
    with served(PlayedBoard(FRAMES, silent=True), PtyEndpoint(), real_time=False) as port:
        data, received = recorded(port)
    assert (data, received.board, received.end_reason) == (FRAMES, None, "")


@pytest.mark.slow
def test_what_an_earlier_recording_left_is_dropped():
    board = PlayedBoard(FRAMES)
    with served(board, PtyEndpoint(), real_time=True) as port:
        with serial.Serial(port) as line:
            line.write(encode_start(200))
            line.read(16)
        data, received = recorded(port)  # while the board is still running
    assert (data, received.end_reason) == (FRAMES, "")


@pytest.mark.slow
@pytest.mark.parametrize(("make", "after"), [(PtyEndpoint, 8), (PtyEndpoint, 805), (PtyEndpoint, 1599), (tcp, 805)])
def test_an_unplugged_cable(make, after):
    injector = lambda: ErrorInjector(ErrorRates(disconnect_after=after), np.random.default_rng(0))  # noqa: E731
    with served(PlayedBoard(FRAMES), make(), real_time=False, injector=injector) as port:
        if after == 8:  # one frame is not enough to be sure of it
            with pytest.raises(InputError, match="found 8 bytes without a frame"):
                recorded(port)
            return
        data, received = recorded(port)
    assert (data, received.end_reason) == (FRAMES[:after], "disconnected")


def wait_for_stop(board):
    deadline = time.monotonic() + 5.0
    while board.messages[-1].kind != MessageKind.STOP:
        assert time.monotonic() < deadline
        time.sleep(0.001)


def test_a_board_that_stops_in_the_middle():
    board = PlayedBoard(FRAMES[:800])
    with served(board, PtyEndpoint(), real_time=False) as port:
        data, received = recorded(port)
        wait_for_stop(board)
    assert (data, received.end_reason) == (FRAMES[:800], "silent")


@pytest.fixture
def heeding_control_c():
    """Ctrl-C as in a terminal: a process started in the background ignores it, and so would these tests."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("heeding_control_c")
def test_control_c_keeps_what_arrived():
    board = PlayedBoard(FRAMES[:800])  # it waits in the middle, however late the key is pressed
    with served(board, PtyEndpoint(), real_time=True) as port:

        def press():
            while board.place < 400:
                time.sleep(0.001)
            _thread.interrupt_main()

        presser = threading.Thread(target=press)
        presser.start()
        data, received = recorded(port, silence=60.0)
        presser.join()
        wait_for_stop(board)
    assert received.end_reason == "interrupted"
    assert 0 < len(data) <= 800 and FRAMES.startswith(data)


@pytest.mark.parametrize(
    ("frames", "found"),
    [
        (b"", "found nothing in the 0.2 s after the start .*refused.*, expected 200 frames"),
        (bytes(1600), "found 1600 bytes without a frame .*baud rate 115200.*, expected 200 frames"),
    ],
)
def test_no_frame_at_all_is_reported_in_one_line(frames, found):
    with served(PlayedBoard(frames), PtyEndpoint(), real_time=False) as port:
        with pytest.raises(InputError, match=found) as caught:
            recorded(port)
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize("port", ["/nowhere/at/all", "/dev/null", "socket://127.0.0.1:1", ""])
def test_a_port_that_cannot_be_opened_is_reported_in_one_line(port):
    with pytest.raises(InputError, match=f"port {port}: found one that cannot be opened .*, expected a") as caught:
        recorded(port)
    assert "\n" not in str(caught.value)


# --- The receiver, with a line of its own ----------------------------------------------------------------------------


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
    progress = []
    receiver = Receiver(samples, 0.1, lambda piece: None)
    receiver.run(Line(*pieces), lambda done, total: progress.append((done, total)))
    return receiver, receiver.close(), progress


def cut(data, size):
    return [data[i : i + size] for i in range(0, len(data), size)]


@pytest.mark.parametrize("size", [1, 7, 64, 5000])
def test_it_ends_when_all_samples_have_come(size):
    receiver, reason, progress = receive(*cut(FRAMES, size))
    assert (bytes(receiver.data), reason, receiver.good) == (FRAMES, "", 200)
    assert progress[-1][1] == 200
    assert [done for done, _ in progress] == sorted(done for done, _ in progress)
    assert receiver.stamps[-1][0] == len(FRAMES)


def test_what_comes_after_the_last_sample_is_left_out():
    receiver, reason, _ = receive(*cut(FRAMES, 7), samples=150)
    assert (bytes(receiver.data), reason, receiver.good) == (FRAMES[:1200], "", 150)


@pytest.mark.parametrize(
    ("end", "expected"), [((), "silent"), ((OSError,), "disconnected"), ((KeyboardInterrupt,), "interrupted")]
)
def test_what_arrived_before_a_bad_end_is_kept(end, expected):
    receiver, reason, _ = receive(*cut(FRAMES[:1001], 100), *end)
    assert (bytes(receiver.data), reason, receiver.good) == (FRAMES[:1001], expected, 125)


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
    receiver = Receiver(200, 2.0, kept.append, line.clock)
    receiver.run(line, lambda done, total: None)
    assert (receiver.close(), receiver.good) == ("overrun", 0)
    assert line.now < 15.0  # a motion of 0.5 s
    assert b"".join(kept) == receiver.data
    assert 0 < len(receiver.data) <= most_bytes(200)
