"""The PD controller of the FPGA (Eq. 2, Fig. 3) in the single precision and operation order of the board."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from repro.fpga.frames import PWM_LIMIT, RADIANS_PER_COUNT

Single = NDArray[np.float32]
Counts = NDArray[np.int32]

#: One encoder count in rad, as the board holds it.
RESOLUTION = np.float32(RADIANS_PER_COUNT)


@dataclass(frozen=True)
class ControlConstants:
    """Constants of Table 8 for both joints."""

    kp: tuple[float, float]  # proportional gains K_p, N m/rad
    # Derivative gains K_v, N m per rad between two samples (the sampling time is inside, Section II-A)
    kv: tuple[float, float]
    pwm_hz: tuple[float, float]  # PWM frequencies, Hz
    full_torque: tuple[float, float]  # torque at a PWM of 1023 counts, N m

    def __post_init__(self) -> None:
        """Refuse constants that are not positive and finite."""
        for name in ("kp", "kv", "pwm_hz", "full_torque"):
            values = getattr(self, name)
            if len(values) != 2 or not all(0 < v < np.inf for v in values):
                raise ValueError(f"{name}: must be two positive finite numbers, got {values}.")

    @property
    def torque_per_count(self) -> NDArray[np.float64]:
        """Torque of one PWM count, N m, shape (2,)."""
        return np.array(self.full_torque) / PWM_LIMIT

    @property
    def kp_counts(self) -> Single:
        """K_p in PWM counts per rad, shape (2,): what the board is sent."""
        return (np.array(self.kp) / self.torque_per_count).astype(np.float32)

    @property
    def kv_counts(self) -> Single:
        """K_v in PWM counts per rad between two samples, shape (2,)."""
        return (np.array(self.kv) / self.torque_per_count).astype(np.float32)


class PDController:
    """Eq. 2 with the saturation of Fig. 3, for one board or a batch of boards.

    Each operation is rounded to single precision, in the order conversion, scaling, differences, products,
    difference, rounding to the nearest integer (ties to even), saturation.
    """

    def __init__(self, kp: ArrayLike, kv: ArrayLike) -> None:
        self._kp = np.asarray(kp, dtype=np.float32).reshape(2, 1)
        self._kv = np.asarray(kv, dtype=np.float32).reshape(2, 1)
        if not (np.isfinite(self._kp).all() and np.isfinite(self._kv).all()):
            raise ValueError("kp, kv: must be finite.")
        self._previous: Single | None = None

    def __call__(self, desired: Single, position: Counts) -> Counts:
        """PWM of one sample."""
        q = position.astype(np.float32) * RESOLUTION
        before = q if self._previous is None else self._previous  # q_0 - q_-1 = 0: the arm starts at rest
        self._previous = q
        u = self._kp * (desired - q) - self._kv * (q - before)
        # Saturating before the conversion gives the same integer and cannot overflow it.
        pwm: Counts = np.rint(u).clip(-PWM_LIMIT, PWM_LIMIT).astype(np.int32)
        return pwm
