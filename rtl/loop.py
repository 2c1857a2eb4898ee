"""The closed loop of the simulated design and the simulated arm: `repro.board.server.Board` with the design's logic.

The arm sees the board's pins alone. Its encoders turn to the position of the next sampling instant, and the torque of a
frame acts on it for one sampling period, as for the board in Python.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from repro.board.frames import FRAME_BYTES, RADIANS_PER_COUNT, split_words
from repro.board.messages import MessageKind, encode_identity
from repro.board.plant import Plant
from repro.board.server import Board
from rtl.simulation import Simulation


class LogicBoard(Board):
    """A board whose every answer but its identity comes from the design."""

    def __init__(
        self, make_plant: Callable[[], Plant], torque_per_count: ArrayLike, identity: Mapping[str, Any]
    ) -> None:
        super().__init__(make_plant, torque_per_count, {**identity, "board": "rtl"})
        self._simulation = Simulation()
        self._plant: Plant | None = None
        self._frames = bytearray()
        self._identified = 0
        self._simulation.run(idle=True)

    @property
    def running(self) -> bool:
        """Whether the arm is moving."""
        return self._plant is not None

    def receive(self, data: bytes) -> bytes:
        """Put bytes on the design's line, and let time pass until it has obeyed them."""
        simulation = self._simulation
        simulation.send(data)
        while True:
            simulation.run(bytes_=FRAME_BYTES, idle=True)
            if simulation.running and self._plant is None:
                self._plant = self._make_plant()
            if not self._take_frame():
                break
        self.refusals += [f"{MessageKind(kind).name}: refused by the design." for kind in simulation.refused()]
        asked, self._identified = simulation.identified - self._identified, simulation.identified
        return self._rest_of_motion() + asked * encode_identity(self.identity)

    def tick(self) -> bytes:
        """Let time pass until the next frame, nothing if the arm is not moving."""
        if self._plant is None:
            return b""
        if not self._frames:
            self._simulation.run(bytes_=FRAME_BYTES, over=True)
            self._take_frame()
        frame = bytes(self._frames[:FRAME_BYTES])
        del self._frames[:FRAME_BYTES]
        if not self._frames:
            self._end_motion()
        return frame

    def _take_frame(self) -> bool:
        """Let the arm follow a frame's torque, if one came."""
        frame = self._simulation.read(FRAME_BYTES)
        if not frame or self._plant is None:
            return False
        self._frames += frame
        pwm = split_words(np.frombuffer(frame, dtype=">u8").astype(np.uint64))[1]
        self._plant.advance(pwm.astype(np.int32), self._torque)
        self._turn(np.rint(self._plant.state[:2, 0] / RADIANS_PER_COUNT))
        if self._simulation.last:
            self._simulation.run(over=True)
        return True

    def _rest_of_motion(self) -> bytes:
        """Give the frames that were sent before a stop."""
        if self._simulation.running:
            return b""
        self._end_motion()
        frames = bytes(self._frames)
        self._frames.clear()
        return frames

    def _end_motion(self) -> None:
        """Let the arm hang at rest again once its motion is over."""
        if self._plant is not None and not self._simulation.running:
            self._plant = None
            self._turn(np.zeros(2))
            self._simulation.run(idle=True)

    def _turn(self, counts: ArrayLike) -> None:
        first, second = np.asarray(counts, dtype=np.int64).tolist()
        self._simulation.move(first, second)
