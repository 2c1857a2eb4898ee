"""A simulated board behind a pseudo-terminal and a socket: no byte lost, hosts may go and come, and it keeps time."""

import os
import select
import time
from functools import partial
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
import serial
from experiment_example import refused
from fake_board import CONTROL, IDENTITY, PlayedBoard, frames_of, served

from repro.board.channel_errors import ErrorInjector, ErrorRates
from repro.board.controller import simulate
from repro.board.frames import RADIANS_PER_COUNT, encode
from repro.board.messages import MessageKind, encode_message, encode_program, encode_start
from repro.board.plant import Plant, Unmodelled
from repro.board.server import Board, BoardServer, PtyEndpoint, SocketEndpoint

pytestmark = pytest.mark.slow

DESIRED, FRAMES = frames_of(200)
BETA = (0.12, 0.0026, 0.0213, 0.95, 0.078, 0.08, 0.013, 0.4538, 0.12)


@pytest.fixture(params=["pty", "socket"])
def endpoint(request):
    return PtyEndpoint() if request.param == "pty" else SocketEndpoint("127.0.0.1", 0)


def opened(port):
    return serial.serial_for_url(port, timeout=5.0)


def until(found):
    """Wait for what another thread brings about."""
    deadline = time.monotonic() + 10.0
    while not (result := found()):
        assert time.monotonic() < deadline
        time.sleep(0.005)
    return result


def try_to_open(endpoint):
    """Open what may be a new terminal in a moment, or not at all."""
    try:
        return opened(endpoint.port)
    except OSError:
        return None


def test_a_board_sends_what_the_loop_computes():
    make_plant = partial(Plant, BETA, 0.0025, Unmodelled(stribeck=(0.3, 0.5), ripple=(0.05, 0.02)))
    position, pwm = simulate(make_plant(), CONTROL, DESIRED)
    expected = encode(position[0], pwm[0])
    board = Board(make_plant, CONTROL.torque_per_count, IDENTITY)
    for _ in range(2):  # each start begins with the arm at rest
        board.receive(encode_program(CONTROL, DESIRED) + 2 * encode_start(200))
        assert board.refusals[-1] == "START: the arm is moving."
        assert b"".join(board.tick() for _ in range(200)) == expected
    assert len(set(np.frombuffer(expected, dtype=">u8").tolist())) > 100
    for stop in (b"", encode_program(CONTROL, DESIRED) + encode_message(MessageKind.STOP)):
        board.receive(stop + encode_start(200))  # the trajectory is forgotten
        assert not board.running and "200 of 200 samples" in board.refusals[-1]
    turned = SimpleNamespace(state=RADIANS_PER_COUNT * np.array([[2**15], [-40000]]), advance=lambda *_: None)
    board = Board(lambda: turned, CONTROL.torque_per_count, IDENTITY)
    board.receive(encode_program(CONTROL, DESIRED) + encode_start(200))
    assert board.tick() == encode([[-(2**15)], [25536]], [[-1023], [1023]])  # as encoders wrap


def test_a_slow_reader_loses_nothing(endpoint):
    _, frames = frames_of(8192)
    with served(PlayedBoard(frames), endpoint, real_time=False) as port, opened(port) as line:
        line.write(encode_start(8192))
        time.sleep(0.2)  # far more than fits the buffers is ready by now
        data = b""
        while len(data) < len(frames):
            piece = line.read(min(4000, len(frames) - len(data)))
            assert piece
            data += piece
        assert data == frames


def test_what_a_host_sends_before_it_goes_is_read():
    endpoint = PtyEndpoint()
    assert endpoint.accept(0.0) is None
    line = opened(endpoint.port)
    line.write(encode_message(MessageKind.STOP))
    line.close()
    descriptor = endpoint.accept(0.0)
    assert os.read(descriptor, 4096) == encode_message(MessageKind.STOP)
    assert endpoint.accept(0.0) is None
    endpoint.close()


def test_a_host_may_go_in_the_middle_and_the_next_one_is_served(endpoint):
    board = PlayedBoard(FRAMES[:800])
    with served(board, endpoint, real_time=True) as port:
        with opened(port) as line:
            line.write(encode_start(100))
            assert line.read(80) == FRAMES[:80]
        until(lambda: not board.running)  # it goes on alone
        with opened(port) as line:
            line.timeout = 0.1  # what the first motion left is there at once
            while line.read(4096):
                pass
            line.timeout = 5.0
            line.write(encode_start(100))
            assert line.read(800) == FRAMES[:800]


class Still:
    """An endpoint nobody comes to, and a clock that only the test moves."""

    port = "nowhere"
    now = 100.0

    def accept(self, timeout):
        return None

    def on_disconnect(self):
        raise AssertionError("nobody was there")


def test_samples_are_caught_up_after_a_delay():
    board, still, looks = PlayedBoard(FRAMES), Still(), []
    server = BoardServer(board, still, clock=lambda: still.now)
    server._receive(encode_start(200))

    def stopped():
        still.now += [0.0, 0.001, 0.1, 0.0025, 0.00249][len(looks) % 5]
        looks.append((still.now, board.place // 8))
        return len(looks) > 40

    server.serve(stopped)
    # A sample at the start and every 2.5 ms since, counted by the clock as it stood when the board went on.
    for (now, _), (_, taken) in pairwise(looks):
        assert taken == min(200, int((now - 100.0) / 0.0025 + 1e-9) + 1)


def test_a_board_that_is_late_sends_between_bursts_and_is_not_taken_for_a_silent_one():
    board, still, taken = PlayedBoard(FRAMES), Still(), []
    server = BoardServer(board, still, clock=lambda: still.now)
    server._receive(encode_start(200))
    still.now += 10.0
    server.serve(lambda: taken.append(board.place // 8) or not board.running)
    assert taken == [0, 64, 128, 192, 200]


def test_a_link_is_made_and_removed_and_files_are_left_alone(tmp_path):
    link = tmp_path / "board"
    endpoint = PtyEndpoint(link)
    assert endpoint.port == str(link)
    with opened(endpoint.port):
        assert endpoint.accept(0.0) is not None
    endpoint.close()
    assert not list(tmp_path.iterdir())
    link.write_text("mine")
    assert refused(PtyEndpoint, link).place == f"link {link}"
    assert link.read_text() == "mine"
    missing = tmp_path / "missing" / "board"
    assert refused(PtyEndpoint, missing).place == f"link {missing}"


def test_faults_are_those_of_the_injector_and_a_stall_delays_the_rest(endpoint):
    rates = ErrorRates(drop=0.01, flip=0.01, insert=0.01, stall=0.002, stall_s=0.05)
    injectors = []

    def injector():
        injectors.append(ErrorInjector(rates, np.random.default_rng(3)))
        return injectors[-1]

    expected = injector().apply(FRAMES)
    with served(PlayedBoard(FRAMES), endpoint, real_time=False, injector=injector) as port, opened(port) as line:
        for motion in (1, 2):
            began = time.monotonic()
            line.write(encode_start(200))
            assert line.read(len(expected)) == expected
            assert time.monotonic() - began >= 0.05 * injectors[motion].counts["stall"] > 0
    assert expected != FRAMES


def test_a_cable_pulled_out_and_in_again(endpoint):
    injector = partial(ErrorInjector, ErrorRates(disconnect_after=805), np.random.default_rng(3))
    board = PlayedBoard(FRAMES)
    with served(board, endpoint, real_time=False, injector=injector):
        for _ in range(2):
            line = until(lambda: try_to_open(endpoint))
            line.write(encode_start(200))
            line.timeout = 0
            data = b""
            with pytest.raises(serial.SerialException):
                while select.select([line.fileno()], [], [], 5.0)[0]:
                    data += line.read(4096)
            assert data == FRAMES[:805]
            line.close()
            until(lambda: not board.running)


def test_frames_that_are_sent_without_a_host_are_lost(endpoint):
    board = PlayedBoard(FRAMES)
    with served(board, endpoint):
        with opened(endpoint.port) as line:
            line.write(encode_start(200))
            assert line.read(8) == FRAMES[:8]
        until(lambda: not board.running)
        time.sleep(0.3)  # the board waits for a host a while before it drops the last frame
        with until(lambda: try_to_open(endpoint)) as line:
            line.timeout = 0.3
            assert line.read(8) == b""


def test_a_link_that_another_board_has_taken_over_stays(tmp_path):
    endpoint = PtyEndpoint(tmp_path / "board")
    (tmp_path / "board").unlink()
    (tmp_path / "board").symlink_to("/dev/null")
    endpoint.close()
    assert (tmp_path / "board").is_symlink()
