"""Forward and inverse kinematics of the planar two-link arm (Fig. 1).

``q = 0`` hangs straight down, q2 is relative to link 1, joint 1 is the origin, x points right and y up.
"""

from dataclasses import dataclass

import numpy as np

from repro.model.dynamics import check_motion
from repro.model.parameters import Array

# A point this share of the reach outside the workspace is put down to rounding.
_ROUNDING = 1e-12


@dataclass(frozen=True)
class ArmGeometry:
    """Link lengths, m."""

    l1: float
    l2: float

    @property
    def reach(self) -> float:
        """Length of the straight arm, m."""
        return self.l1 + self.l2


def forward_kinematics(q: Array, geometry: ArmGeometry) -> tuple[Array, Array]:
    """Compute the positions of elbow and tip, m, each (..., 2, N) with x and y, for joint positions (..., 2, N)."""
    (q,) = check_motion(q)
    q1, q12 = q[..., 0, :], q[..., 0, :] + q[..., 1, :]
    elbow = geometry.l1 * np.stack([np.sin(q1), -np.cos(q1)], -2)
    return elbow, elbow + geometry.l2 * np.stack([np.sin(q12), -np.cos(q12)], -2)


def inverse_kinematics(tip: Array, geometry: ArmGeometry) -> Array:
    """Compute joint positions (..., 2, N), rad, with q2 >= 0, that put the tip on points (..., 2, N), m.

    q1 is within (-pi, pi]: a path around joint 1 jumps by 2 pi where it passes straight above it.
    """
    (tip,) = check_motion(tip)
    x, y = tip[..., 0, :], tip[..., 1, :]
    l1, l2, reach = geometry.l1, geometry.l2, geometry.reach
    r = np.hypot(x, y)
    outside = (r > reach * (1.0 + _ROUNDING)) | (r < abs(l1 - l2) - reach * _ROUNDING)
    if outside.any():
        raise ValueError(
            f"tip: every point must be {abs(l1 - l2):.4g} to {reach:.4g} m from joint 1, "
            f"got one at {r[outside].flat[0]:.4g} m."
        )
    # Law of cosines in half angles: cos q2 itself would lose digits where the arm is nearly straight or folded.
    folded = np.sqrt(np.clip((reach - r) * (reach + r), 0.0, None))
    straight = np.sqrt(np.clip((r - abs(l1 - l2)) * (r + abs(l1 - l2)), 0.0, None))
    q2 = 2.0 * np.arctan2(folded, straight)
    q1 = np.arctan2(x, -y) - np.arctan2(l2 * np.sin(q2), l1 + l2 * np.cos(q2))
    return np.stack([np.pi - np.mod(np.pi - q1, 2.0 * np.pi), q2], -2)
