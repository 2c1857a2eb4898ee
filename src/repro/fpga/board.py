"""The simulated FPGA board between the serial line and the arm (Section III, Fig. 2)."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from repro.fpga import messages
from repro.fpga.controller import ControlConstants, ControlLoop, PDController
from repro.fpga.frames import encode
from repro.fpga.messages import RAM_SAMPLES, Message, MessageDecoder, MessageKind
from repro.fpga.plant import Plant


class Board:
    """A board with its arm, advanced by one sampling period at a time.

    Blocks of Fig. 2: **Write Ram** and **Ram-FPGA** are `receive` and the memory it fills, **Read Ram**,
    **Decoder**, **PD**, **PWM gen** and **Aq uart** are `tick`.
    """

    def __init__(
        self, make_plant: Callable[[], Plant], torque_per_count: ArrayLike, identity: Mapping[str, Any]
    ) -> None:
        self._make_plant = make_plant
        self._torque = np.asarray(torque_per_count, dtype=np.float64)
        self._identity = dict(identity)
        self._decoder = MessageDecoder()
        self._ram = np.zeros((2, RAM_SAMPLES), dtype=np.float32)
        self._written = np.zeros(RAM_SAMPLES, dtype=np.bool_)
        self._gains: ControlConstants | None = None
        self._loop: ControlLoop | None = None
        self._sample = self._samples = 0
        self.refusals: list[str] = []

    @property
    def identity(self) -> dict[str, Any]:
        """Description that the board answers to IDENTIFY."""
        return dict(self._identity)

    @property
    def running(self) -> bool:
        """Whether the arm is moving."""
        return self._loop is not None

    def receive(self, data: bytes) -> bytes:
        """Take bytes of the downlink; while the arm moves only a stop is obeyed. Gives the answer, if any."""
        answer = b""
        for message in self._decoder.feed(data):
            try:
                answer += self._obey(message)
            except ValueError as error:
                self.refusals.append(f"{message.kind.name}: {error}")
        return answer

    def _obey(self, message: Message) -> bytes:
        if message.kind is MessageKind.STOP:
            self._loop = None
        elif self.running:
            raise ValueError("the arm is moving.")
        elif message.kind is MessageKind.GAINS:
            self._gains = messages.parse_gains(message)
        elif message.kind is MessageKind.TRAJECTORY:
            start, desired = messages.parse_trajectory(message)
            place = slice(start, start + desired.shape[1])
            self._ram[:, place], self._written[place] = desired, True
        elif message.kind is MessageKind.START:
            self._start(messages.parse_start(message))
        elif message.kind is MessageKind.IDENTIFY:
            return messages.encode_identity(self._identity)
        else:
            raise ValueError("only a board sends it.")
        return b""

    def _start(self, samples: int) -> None:
        if self._gains is None:
            raise ValueError("no gains have been received.")
        missing = int(np.count_nonzero(~self._written[:samples]))
        if missing:
            raise ValueError(f"{missing} of {samples} samples of the trajectory have not been received.")
        controller = PDController(self._gains.kp_counts, self._gains.kv_counts)
        self._loop = ControlLoop(self._make_plant(), controller, self._torque)
        self._sample, self._samples = 0, samples

    def tick(self) -> bytes:
        """Advance by one sampling period and give its frame, nothing if the arm is not moving.

        After the last sample the motors are off and the trajectory is forgotten: a new start needs a whole program.
        """
        if self._loop is None:
            return b""
        i = self._sample
        position, pwm = self._loop.step(self._ram[:, i : i + 1])
        self._sample += 1
        if self._sample == self._samples:
            self._loop = None
            self._written[:] = False
        return encode(position, pwm)
