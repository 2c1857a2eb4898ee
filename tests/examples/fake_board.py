"""A board that plays back given frames: everything of a simulated board but the arm."""

import threading
from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from repro.board.controller import ControlConstants, PDController
from repro.board.frames import encode
from repro.board.messages import MessageDecoder, MessageKind, encode_identity, encode_program, parse_start
from repro.board.server import serve
from repro.board.sidecar import CaptureMetadata

CONTROL = ControlConstants(kp=(50.0, 40.0), kv=(100.0, 80.0), pwm_hz=(1e4, 1e4), full_torque=(2.7192, 2.7314))
IDENTITY = {"board": "played back", "plant": {"ripple": 0.05}}


def motion(samples=200):
    """Desired positions (rad), encoder counts and PWM of an arm that follows with a lag; shape (2, N) each."""
    time = 0.0025 * np.arange(samples)
    desired = np.stack([0.6 * np.sin(3.0 * time), -0.4 * np.sin(4.0 * time)])
    position = np.rint(np.roll(desired, 3, axis=1) * 8400 / (2 * np.pi)).astype(np.int32)
    position[:, :3] = 0
    control = PDController(CONTROL.kp_counts, CONTROL.kv_counts)
    pwm = [control(desired[:, i : i + 1].astype(np.float32), position[:, i : i + 1]) for i in range(samples)]
    return desired, position, np.concatenate(pwm, axis=1)


def metadata(desired, **changes):
    """Metadata of a capture of this motion."""
    n = desired.shape[1]
    unchanged = CaptureMetadata("T4", n, 0, n, 0.0025, encode_program(CONTROL, desired), CONTROL, IDENTITY)
    return replace(unchanged, **changes)


class PlayedBoard:
    """Sends a motion, again after each start."""

    def __init__(self, frames, identified_by=MessageKind.IDENTIFY):
        self.frames = frames
        self.identified_by = identified_by  # the message that it answers, None for a real board
        self.place = self.end = 0
        self.messages, self.refusals = [], []
        self._decoder = MessageDecoder()

    @property
    def running(self):
        return self.place < self.end

    def receive(self, data):
        answer = b""
        for message in self._decoder.feed(data):
            self.messages.append(message)
            if message.kind == self.identified_by:
                answer += encode_identity(IDENTITY)
            elif message.kind == MessageKind.START:
                self.place, self.end = 0, min(8 * parse_start(message), len(self.frames))
            elif message.kind == MessageKind.STOP:
                self.end = 0
        return answer

    def tick(self):
        if not self.running:
            return b""
        self.place += 8
        return self.frames[self.place - 8 : self.place]


@contextmanager
def served(board, endpoint, **options):
    """A board served by another thread; gives what pyserial opens."""
    over = threading.Event()
    thread = threading.Thread(target=serve, args=(board, endpoint), kwargs={"stopped": over.is_set, **options})
    thread.start()
    try:
        yield endpoint.port
    finally:
        over.set()
        thread.join(timeout=10)
        assert not thread.is_alive()


def frames_of(samples=200):
    """Desired positions and the frames of `motion`."""
    desired, position, pwm = motion(samples)
    return desired, encode(position, pwm)
