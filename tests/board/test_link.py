"""The host's end of the link: whatever the port does, what arrived is kept or one line tells why nothing did."""

import _thread
import signal
import time
from functools import partial
from itertools import count
from types import SimpleNamespace

import numpy as np
import pytest
import serial
from fake_board import IDENTITY, PlayedBoard, frames_of, metadata, motion, served

from repro.board.channel_errors import ErrorInjector, ErrorRates
from repro.board.frames import encode
from repro.board.link import Receiver, most_bytes, record
from repro.board.messages import MessageKind, encode_message, encode_start
from repro.board.server import PtyEndpoint, SocketEndpoint
from repro.errors import InputError

DESIRED, FRAMES = frames_of(200)


def tcp():
    return SocketEndpoint("127.0.0.1", 0)


def recorded(port, silence=0.2):
    return record(port, metadata(DESIRED, board=None), 115200, silence, lambda piece: None)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("make", "real_time", "identified_by"),
    [(PtyEndpoint, False, None), (PtyEndpoint, True, MessageKind.IDENTIFY), (tcp, False, MessageKind.GAINS)],  # late
)
def test_a_recording_has_the_very_bytes(make, real_time, identified_by):
    board = PlayedBoard(FRAMES, identified_by)
    with served(board, make(), real_time=real_time) as port:
        data, received = recorded(port)
    assert (data, received.board, received.end_reason) == (FRAMES, identified_by and IDENTITY, "")
    kinds = [message.kind.name for message in board.messages]
    assert kinds == ["STOP", "IDENTIFY", "GAINS", "TRAJECTORY", "START", "STOP"]
    host = received.host
    assert (host.port, host.baud) == (port, 115200)
    offsets, seconds = np.array(host.chunks).T
    assert offsets[-1] == 1600 and (np.diff(offsets) > 0).all() and (np.diff(seconds) >= 0).all()
    if real_time:  # 0.5 s of motion, a stamp every 50 ms
        assert 2 <= len(host.chunks) <= 12 and seconds[-1] >= 0.49


@pytest.mark.slow
def test_what_an_earlier_recording_left_is_dropped_once_the_board_is_at_rest():
    board, busy = PlayedBoard(FRAMES), []
    receive = board.receive
    board.receive = lambda data: busy.append(board.running) or receive(data)
    with served(board, PtyEndpoint(), real_time=True) as port:
        with serial.Serial(port) as line:
            line.write(encode_start(80))
            line.read(16)
        data, received = recorded(port)  # while the board is still running
    assert (data, received.end_reason, any(busy)) == (FRAMES, "", False)


@pytest.mark.slow
def test_an_unplugged_cable_ends_a_recording_over_a_socket():
    """Over a terminal: test_board_commands.py."""
    injector = partial(ErrorInjector, ErrorRates(disconnect_after=805), np.random.default_rng(0))
    with served(PlayedBoard(FRAMES), tcp(), real_time=False, injector=injector) as port:
        data, received = recorded(port)
    assert (data, received.end_reason) == (FRAMES[:805], "disconnected")


class Pressing(PlayedBoard):
    """Ctrl-C is pressed in the middle of its motion."""

    def tick(self):
        if self.place == 400:
            _thread.interrupt_main()
        return super().tick()


class HardOfHearing(Pressing):
    """Loses two of the stops that are sent while it moves."""

    lost = 0

    def receive(self, data):
        if self.running and self.lost < 2 and encode_message(MessageKind.STOP) in data:
            self.lost += 1
            return b""
        return super().receive(data)


@pytest.fixture
def heeding_control_c():
    """Ctrl-C as in a terminal: a process started in the background ignores it, and so would these tests."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("heeding_control_c")
@pytest.mark.parametrize(("make", "silence", "reason"), [(PlayedBoard, 0.2, "silent"), (Pressing, 60.0, "interrupted")])
def test_a_recording_that_ends_in_the_middle_stops_the_board_and_keeps_what_arrived(make, silence, reason):
    board = make(FRAMES[:800])
    with served(board, PtyEndpoint(), real_time=True) as port:
        data, received = recorded(port, silence)
        deadline = time.monotonic() + 60.0
        while board.messages[-1].kind != MessageKind.STOP:
            assert time.monotonic() < deadline
            time.sleep(0.001)
    assert received.end_reason == reason
    assert FRAMES.startswith(data)
    assert len(data) == 800 if reason == "silent" else 0 < len(data) <= 800


@pytest.mark.usefixtures("heeding_control_c")
def test_a_stop_that_is_lost_is_sent_again():
    desired, frames = frames_of(2000)  # 5 s
    board = HardOfHearing(frames)
    with served(board, PtyEndpoint(), real_time=True) as port:
        _, received = record(port, metadata(desired, board=None), 115200, 60.0, lambda piece: None)
        assert not board.running
    assert received.end_reason == "interrupted"
    assert board.lost == 2
    assert board.place < len(frames)


@pytest.mark.parametrize(
    ("frames", "found"),
    [
        (FRAMES[:8], "found 8 bytes without a frame"),  # one alone is not certain
        (bytes(1600), "found 1600 bytes without a frame .*baud rate 115200.*, expected 200 frames"),
        (encode(np.add(motion()[1], [[0], [1183]]), motion()[2]), "joint 2: found 0.885 rad, expected .* hang at rest"),
        (encode(np.subtract(motion()[1], [[0], [1183]]), motion()[2]), "joint 2: found -0.885 rad, expected .* hang"),
    ],
)
def test_no_frame_at_all_and_an_arm_away_from_its_start_are_reported_in_one_line(frames, found):
    board, one_line = PlayedBoard(frames), pytest.raises(InputError, match=rf"\A.*{found}.*\Z")
    with served(board, PtyEndpoint(), real_time=False) as port, one_line:
        recorded(port)
    assert board.messages[-1].kind == MessageKind.STOP


def test_a_board_whose_answer_cannot_be_read_is_not_taken_for_a_real_one():
    board = PlayedBoard(FRAMES)
    board.receive = lambda data: encode_message(MessageKind.IDENTITY, b"[1]")
    answer = pytest.raises(InputError, match="found an unreadable answer")
    with served(board, PtyEndpoint(), real_time=False) as port, answer:
        recorded(port)


@pytest.mark.parametrize("port", ["/nowhere/at/all", "/dev/null", "socket://127.0.0.1:1", ""])
def test_a_port_that_cannot_be_opened_is_reported_in_one_line(port):
    with pytest.raises(InputError, match=rf"\A.*port {port}: found one that cannot be opened .*, expected a.*\Z"):
        recorded(port)


class Line:
    """A port that gives these pieces, one a look, and raises an exception among them."""

    def __init__(self, *pieces):
        self.pieces = list(pieces)

    def read(self, size):
        piece = self.pieces.pop(0) if self.pieces else None
        if isinstance(piece, type):
            raise piece
        return piece or b""


#: The stream without frame 100, with a byte too many before the last frame or in it, and without the last frame.
LOST = FRAMES[:800] + bytes(8) + FRAMES[808:]
#: A jump that looks like the loss of 111 frames.
JUMP = encode(np.where(np.arange(200) < 100, np.zeros((2, 1)), 3000), np.zeros((2, 200)))
LONGER, LONGEST = FRAMES[:1550] + b"\x11" + FRAMES[1550:], FRAMES[:1596] + b"\x11" + FRAMES[1596:]
SHORT = FRAMES[:1592]


@pytest.mark.parametrize(
    ("data", "size", "end", "samples", "expected"),
    [
        *((FRAMES, size, None, 200, (FRAMES, "", 200)) for size in (1, 7, 64, 5000)),
        (FRAMES, 7, None, 150, (FRAMES[:1200], "", 150)),
        (FRAMES[:1001], 100, None, 200, (FRAMES[:1001], "silent", 125)),
        (FRAMES[:1001], 100, OSError, 200, (FRAMES[:1001], "disconnected", 125)),
        (FRAMES[:1001], 100, KeyboardInterrupt, 200, (FRAMES[:1001], "interrupted", 125)),
        (JUMP[:1001], 100, KeyboardInterrupt, 200, (JUMP[:1001], "interrupted", 125)),
        (LOST, 64, None, 200, (LOST, "", 199)),
        (LONGER, 3, None, 200, (LONGER, "", 199)),
        (LONGEST, 3, None, 200, (LONGEST, "silent", 199)),
        (SHORT, 5000, None, 200, (SHORT, "silent", 199)),
        (FRAMES[:-1], 5000, None, 200, (FRAMES[:-1], "silent", 199)),
        (SHORT + bytes(8), 5000, None, 200, (SHORT + bytes(8), "silent", 198)),
    ],
)
def test_a_recording_ends_with_the_last_sample_or_keeps_what_arrived(data, size, end, samples, expected):
    pieces = [data[i : i + size] for i in range(0, len(data), size)]
    progress = []
    receiver = Receiver(samples, 0.1, lambda piece: None)
    reason = receiver.run(Line(*pieces, end), lambda done, total: progress.append((done, total)))
    assert (bytes(receiver.data), reason, receiver.good) == expected
    assert [done for done, _ in progress] == sorted(done for done, _ in progress)
    assert (progress[-1][1], receiver.stamps[-1][0]) == (samples, len(receiver.data))


@pytest.mark.parametrize(
    ("piece", "seconds"), [(b"\xa5", 1.0), (b"\x11", 1e-3), (bytes(1 << 16), 1e-6)], ids=["slow", "garbage", "flood"]
)
def test_a_device_that_sends_no_frame_ends_a_recording(piece, seconds):
    """Each look gives the same bytes and takes so many seconds."""
    line, clock, kept = SimpleNamespace(read=lambda size: piece), count(0.0, seconds), []
    receiver = Receiver(200, 2.0, kept.append, clock.__next__)
    assert (receiver.run(line, lambda done, total: None), receiver.good) == ("overrun", 0)
    assert next(clock) - seconds < 15.0  # the last look, at a motion of 0.5 s
    assert b"".join(kept) == receiver.data
    assert 0 < len(receiver.data) <= most_bytes(200)
