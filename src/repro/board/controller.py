"""The PD controller of the FPGA (Eq. 2, Fig. 3) in the board's single precision, and its closed loop with the arm."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from repro.board.frames import PWM_LIMIT, RADIANS_PER_COUNT, Int16Array, SingleArray
from repro.model.parameters import Array

if TYPE_CHECKING:
    from repro.board.plant import Plant

Counts = NDArray[np.int32]


@dataclass(frozen=True)
class ControlConstants:
    """Constants of Table 8 for both joints, in N m, or in PWM counts with a full torque of 1023."""

    kp: tuple[float, float]  # proportional gains K_p, N m/rad
    kv: tuple[float, float]  # derivative gains K_v with the sampling time inside, N m per rad between two samples
    pwm_hz: tuple[float, float]  # PWM frequencies, Hz
    full_torque: tuple[float, float]  # torque at a PWM of 1023 counts, N m

    @property
    def torque_per_count(self) -> NDArray[np.float64]:
        """Torque of one PWM count (2,), N m."""
        return np.array(self.full_torque) / PWM_LIMIT

    @property
    def kp_counts(self) -> SingleArray:
        """K_p as sent to the board (2,), PWM counts per rad."""
        return (np.array(self.kp) / self.torque_per_count).astype(np.float32)

    @property
    def kv_counts(self) -> SingleArray:
        """K_v as sent to the board (2,), PWM counts per rad between two samples."""
        return (np.array(self.kv) / self.torque_per_count).astype(np.float32)


class PDController:
    """Eq. 2 with the saturation of Fig. 3, for one board or a batch of boards.

    Each operation is rounded to single precision, in the order conversion, scaling, differences, products,
    difference, rounding to the nearest integer (ties to even), saturation.
    """

    def __init__(self, kp: ArrayLike, kv: ArrayLike) -> None:
        self._kp = np.asarray(kp, dtype=np.float32).reshape(2, 1)
        self._kv = np.asarray(kv, dtype=np.float32).reshape(2, 1)
        self._previous: SingleArray | None = None

    def __call__(self, desired: SingleArray, position: Counts) -> Counts:
        """Compute the PWM (2, B) of one sample from q_d (2, 1 or B), rad, and encoder counts (2, B)."""
        q = position.astype(np.float32) * np.float32(RADIANS_PER_COUNT)
        before = q if self._previous is None else self._previous  # q_0 - q_-1 = 0: the arm starts at rest
        self._previous = q
        u = self._kp * (desired - q) - self._kv * (q - before)
        # Saturating before the conversion gives the same integer and cannot overflow it.
        pwm: Counts = np.rint(u).clip(-PWM_LIMIT, PWM_LIMIT).astype(np.int32)
        return pwm


class ControlLoop:
    """A plant behind its encoders, its PD controller and its PWM."""

    def __init__(self, plant: "Plant", constants: ControlConstants, torque_per_count: ArrayLike) -> None:
        self._plant, self._controller = plant, PDController(constants.kp_counts, constants.kv_counts)
        self._torque = np.asarray(torque_per_count, dtype=np.float64)

    def step(self, desired: SingleArray) -> tuple[Counts, Counts]:
        """Read the encoders, set the PWM and let the arm move for one period; gives both in counts (2, B)."""
        position = np.rint(self._plant.state[:2] / RADIANS_PER_COUNT).astype(np.int32)
        pwm = self._controller(desired, position)
        self._plant.advance(pwm, self._torque)
        return position, pwm


def simulate(
    plant: "Plant", constants: ControlConstants, desired: Array, progress: Callable[[int, int], None] | None = None
) -> tuple[Int16Array, Int16Array]:
    """Run the closed loop along q_d, (2, N) or (B, 2, N) in rad; gives encoder and PWM counts (B, 2, N)."""
    q_d = np.moveaxis(np.atleast_3d(desired.T).T, 0, -1).astype(np.float32)  # (2, N, 1 or B)
    n, loop = q_d.shape[1], ControlLoop(plant, constants, constants.torque_per_count)
    position, pwm = np.empty((2, n, 2, plant.state.shape[1]), dtype=np.int16)
    for i in range(n):
        position[i], pwm[i] = loop.step(q_d[:, i])
        if progress is not None and i % 400 == 0:
            progress(i, n)
    return position.transpose(2, 1, 0), pwm.transpose(2, 1, 0)
