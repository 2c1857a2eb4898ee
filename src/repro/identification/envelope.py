"""What an arm may do: ranges of position, speed, torque and of its points in space, and how far a motion uses them."""

from dataclasses import dataclass

import numpy as np

from repro.errors import InputError
from repro.logs.armfile import Arm
from repro.model.dynamics import LAMBDA, regressor
from repro.model.parameters import Array
from repro.signals.kinematics import ArmGeometry, forward_kinematics

#: Position, velocity and acceleration, each of shape (..., 2, N).
Moved = tuple[Array, Array, Array]

#: Share of each limit that is used, so that nothing between two samples passes it.
TIGHT = 0.999
_HALVINGS = 30
#: Part of the way from the middle of a range to its end within which a motion may begin.
_ROOM = 0.9


@dataclass(frozen=True)
class Envelope:
    """Limits of an arm.

    Attributes
    ----------
    arm : Arm
        With `position_limit` and `speed_limit`; `workspace` counts with `link_lengths`.
    beta : array of shape (9,) or None
        Guess of the parameters, with which `torque_limit` counts.

    Raises
    ------
    InputError
        If a key that is needed is missing, or the arm at rest is outside of a limit.
    """

    arm: Arm
    beta: Array | None = None

    def __post_init__(self) -> None:
        arm, told = self.arm, {"position_limit": "two ranges, rad", "speed_limit": "two numbers above 0, rad/s"}
        if self.beta is not None:
            told["torque_limit"] = "two numbers above 0, N m, because there is a guess"
        if arm.workspace is not None:
            told["link_lengths"] = "two numbers above 0, m, because there is a workspace"
        for key, words in told.items():
            if getattr(arm, key) is None:
                raise InputError.at(f"{arm.file}: {key}", "nothing", words)
        still = self.rest[:, None]
        beyond = np.abs(self.shares((still, 0.0 * still, 0.0 * still)))[4:, 0] >= TIGHT
        if beyond.any():
            key = "torque_limit" if self.beta is not None and beyond[:2].any() else "workspace"
            at = ", ".join(f"{angle:.4g}" for angle in self.rest)
            raise InputError.at(f"{arm.file}: {key}", getattr(arm, key), f"room for the arm at rest at {at} rad")

    @property
    def rest(self) -> Array:
        """Where a motion begins and ends, rad: hanging, or in the middle of the range of a joint that cannot."""
        low, high = self.position
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        return np.where(np.abs(middle) < _ROOM * half, 0.0, middle)

    @property
    def position(self) -> Array:
        """Lowest and highest position, shape (2, joint), rad."""
        return np.array(self.arm.position_limit, dtype=np.float64).T

    @property
    def steepness(self) -> float:
        """Steepness of Coulomb friction, s/rad."""
        return self.arm.friction_steepness or LAMBDA

    def shares(self, moved: Moved, y: Array | None = None) -> Array:
        """Part of each limit that a motion uses at each sample.

        Parameters
        ----------
        moved : tuple of 3 arrays of shape (..., 2, N)
            Motion.
        y : array of shape (..., 2, N, 9), optional
            Its regressor, where it is there already.

        Returns
        -------
        array of shape (..., L, N)
            -1 to 1 where a limit is kept: positions, speeds, torques, x and y of elbow and tip.
        """
        arm, (q, dq, _) = self.arm, moved
        used = [_within(q, *self.position), dq / np.array(arm.speed_limit)[:, None]]
        if self.beta is not None:
            y = regressor(*moved, self.steepness) if y is None else y
            used.append(y @ self.beta / np.array(arm.torque_limit)[:, None])
        if arm.workspace is not None and arm.link_lengths is not None:
            points = forward_kinematics(q, ArmGeometry(*arm.link_lengths))
            used += [_within(point, *np.array(arm.workspace).T) for point in points]
        return np.concatenate(used, axis=-2)

    def largest(self, shape: Moved, centre: Array) -> Array:
        """Factors by which motions about a centre reach a limit.

        Parameters
        ----------
        shape : tuple of 3 arrays of shape (..., 2, N)
            Distances from the centre and their derivatives.
        centre : array of shape (2,)
            rad.

        Returns
        -------
        array of shape (..., 1, 1)
            0 where the centre is outside of a limit itself.
        """
        high = 1.0 / np.abs(shape[1] / np.array(self.arm.speed_limit)[:, None]).max(axis=(-2, -1), keepdims=True)
        low = np.zeros_like(high)
        for _ in range(_HALVINGS):
            factor = 0.5 * (low + high)
            q, dq, ddq = (factor * x for x in shape)
            used = np.abs(self.shares((centre[:, None] + q, dq, ddq))).max(axis=(-2, -1), keepdims=True)
            low, high = np.where(used <= TIGHT, factor, low), np.where(used <= TIGHT, high, factor)
        return np.asarray(low)


def _within(value: Array, low: Array, high: Array) -> Array:
    """Distance from the middle of bounds over that of a bound from it."""
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    return np.asarray((value - middle[:, None]) / half[:, None])
