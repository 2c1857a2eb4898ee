"""The whole design behind its pins: stored recordings, the closed loop, and the answers to a damaged downlink."""

import itertools
from pathlib import Path

import numpy as np
import pytest

from repro.board.capture import read_capture
from repro.board.channel_errors import ErrorInjector, ErrorRates
from repro.board.messages import (
    MessageDecoder,
    MessageKind,
    encode_gains,
    encode_message,
    encode_start,
    encode_trajectory,
)
from repro.board.server import Board
from repro.config.check import load_config
from repro.experiments.arm import board_from_config, control_constants, metadata_for, program_from_config
from rtl.loop import LogicBoard
from rtl.simulation import Simulation

ROOT = Path(__file__).parents[2]
CONFIG = load_config(ROOT / "config/config.yaml")


@pytest.mark.parametrize("motion", ["ID", "T1", "T2", "T3", "T4"])
def test_recorded_positions_give_the_recorded_frames(motion):
    capture = read_capture(ROOT / f"data/captures/{motion}.bin")
    board = Simulation()
    board.send(capture.metadata.program)
    board.run(idle=True)
    # A motion starts at the position where the encoders rest.
    positions = capture.position.astype(int).T.tolist()
    board.move(*positions[0])
    board.run(idle=True)
    board.send(encode_start(capture.metadata.samples))
    data = bytearray()
    for position in [*positions[1:], positions[-1]]:
        board.run(bytes_=8, clocks=20 * board.period)
        data += board.read(8)
        board.move(*position)
    assert board.refused() == []
    assert bytes(data) == capture.data


@pytest.mark.parametrize(("motion", "samples"), [("ID", 4694), ("T1", 800)])
def test_closed_loop_is_that_of_the_board_in_python(motion, samples):
    metadata = metadata_for(program_from_config(CONFIG, motion), CONFIG)
    frames = []
    for make in (LogicBoard, Board):
        board = board_from_config(CONFIG, make=make)
        board.receive(metadata.program + encode_start(metadata.samples))
        frames.append(b"".join(board.tick() for _ in range(samples)))
        assert len(frames[-1]) == 8 * samples
    assert frames[0] == frames[1]


@pytest.fixture(scope="module")
def boards():
    return [board_from_config(CONFIG, make=make) for make in (LogicBoard, Board)]


def check_same(boards, pieces, ticks=5):
    """Give the pieces of a downlink to both boards and compare all that can be seen of them."""
    seen, frames = [], []
    for board in boards:
        before = len(board.refusals)
        answers = [MessageDecoder().feed(board.receive(piece)) for piece in pieces]
        refused = [refusal.split(":")[0] for refusal in board.refusals[before:]]
        seen.append(([len(messages) for messages in answers], refused, board.running))
        frames.append([board.tick() for _ in range(ticks)])
        ticks += 100  # the design's time goes on while it receives
        board.receive(encode_message(MessageKind.STOP))
        assert not board.running
    assert seen[0] == seen[1]
    n = len(frames[0])
    assert frames[0] in [frames[1][k : k + n] for k in range(100)]
    return *seen[0], frames[0]


def program(samples=400, start=True):
    desired = 0.3 * np.sin(np.arange(2)[:, None] + 0.01 * np.arange(samples))
    blocks = encode_gains(control_constants(CONFIG)) + encode_trajectory(desired)
    return blocks + (encode_start(samples) if start else b"")


NAN, ONE = b"\x7f\xc0\x00\x00", b"\x3f\x80\x00\x00"
FAULTY = {
    "start without trajectory": [encode_start(8000)],
    "no samples": [encode_start(0)],
    "more samples than the memory has": [encode_start(8193)],
    "beyond the memory": [encode_message(MessageKind.TRAJECTORY, b"\x1f\xff" + 4 * ONE)],
    "not a number": [encode_message(MessageKind.TRAJECTORY, b"\x00\x00" + 3 * ONE + NAN)],
    "infinite gain": [encode_message(MessageKind.GAINS, b"\x7f\x80\x00\x00" + 5 * ONE)],
    "negative gain": [encode_message(MessageKind.GAINS, 3 * ONE + b"\xbf\x80\x00\x00" + 2 * ONE)],
    "gain of minus zero": [encode_message(MessageKind.GAINS, 3 * ONE + b"\x80\x00\x00\x00" + 2 * ONE)],
    "first PWM frequency of zero": [encode_message(MessageKind.GAINS, 4 * ONE + bytes(4) + ONE)],
    "second PWM frequency of zero": [encode_message(MessageKind.GAINS, 5 * ONE + bytes(4))],
    "gain of zero": [encode_message(MessageKind.GAINS, 3 * ONE + bytes(4) + 2 * ONE)],
    "identity": [encode_message(MessageKind.IDENTITY, b"{}")],
    "identify": [encode_message(MessageKind.IDENTIFY)],
    "wrong checksum": [program()[:-1] + b"\x00"],
    "a message within a damaged one": [b"\x5a\x02\x00\x0a" + encode_message(MessageKind.IDENTIFY)],
    "sync bytes before a message": [b"\x5a\x5a\x5a" + encode_message(MessageKind.IDENTIFY)],
    "messages while the arm moves": [program(), program(20), encode_message(MessageKind.IDENTIFY)],
    "start again after a stop": [program(), encode_message(MessageKind.STOP), encode_start(400)],
}


@pytest.mark.parametrize("name", FAULTY)
def test_faulty_message_gets_the_same_answer(boards, name):
    check_same(boards, FAULTY[name])


def test_trajectory_is_forgotten_after_a_motion(boards):
    _, refused, _, frames = check_same(boards, [program(5)], ticks=7)
    assert (refused, [len(frame) for frame in frames]) == ([], [8] * 5 + [0] * 2)
    assert check_same(boards, [encode_start(5)])[1] == ["START"]


@pytest.mark.parametrize("seed", range(12))
def test_damaged_downlink_gets_the_same_answers(boards, seed):
    rng = np.random.default_rng(seed)
    messages = [
        program(int(rng.integers(20, 300)), start=False),
        encode_message(MessageKind.IDENTIFY),
        encode_trajectory(rng.uniform(-1, 1, (2, 40))),
        encode_start(int(rng.integers(200, 320))),
        encode_message(MessageKind.IDENTIFY),
        encode_message(MessageKind.STOP),
    ]
    stream = b"".join(messages[i] for i in rng.integers(0, len(messages), 12))
    damaged = ErrorInjector(ErrorRates(drop=1e-3, flip=1e-3, insert=1e-3), rng).apply(stream)
    cuts = [0, *sorted(rng.integers(0, len(damaged), 4).tolist()), len(damaged)]
    check_same(boards, [damaged[a:b] for a, b in itertools.pairwise(cuts)])
