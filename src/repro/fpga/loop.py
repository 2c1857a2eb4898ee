"""The closed loop of arm, encoder and PD controller, sample by sample, for one arm or a batch."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from repro.fpga.controller import ControlConstants, Counts, PDController, Single
from repro.fpga.frames import RADIANS_PER_COUNT
from repro.fpga.plant import Plant
from repro.model.parameters import Array


class ControlLoop:
    """A plant behind its encoders, its PD controller and its PWM."""

    def __init__(self, plant: Plant, controller: PDController, torque_per_count: ArrayLike) -> None:
        self._plant, self._controller = plant, controller
        self._torque = np.asarray(torque_per_count, dtype=np.float64)

    def step(self, desired: Single) -> tuple[Counts, Counts]:
        """One sampling period: read the encoders, set the PWM, let the arm move."""
        position = np.rint(self._plant.state[:2] / RADIANS_PER_COUNT).astype(np.int32)
        pwm = self._controller(desired, position)
        self._plant.advance(pwm, self._torque)
        return position, pwm


def simulate(
    plant: Plant,
    constants: ControlConstants,
    desired: Array,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[NDArray[np.int16], NDArray[np.int16]]:
    """Run the closed loop along a desired motion."""
    batch = plant.state.shape[1]
    q_d = np.moveaxis(np.atleast_3d(desired.T).T, 0, -1).astype(np.float32)  # (2, N, 1 or B)
    if q_d.shape[0] != 2 or q_d.shape[2] not in (1, batch):
        raise ValueError(f"desired: must have shape (2, N) or ({batch}, 2, N), got {desired.shape}.")
    n = q_d.shape[1]
    loop = ControlLoop(plant, PDController(constants.kp_counts, constants.kv_counts), constants.torque_per_count)
    position, pwm = (np.empty((n, 2, batch), dtype=np.int16) for _ in range(2))
    for i in range(n):
        position[i], pwm[i] = loop.step(q_d[:, i])
        if progress is not None and i % 400 == 0:
            progress(i, n)
    return position.transpose(2, 1, 0), pwm.transpose(2, 1, 0)
