"""Eq. 1 of the paper, tau = M(q) ddq + C(q, dq) dq + g(q) + B dq + K tanh(lambda dq), and the kinematics of Fig. 1.

The paper prints ``tanh(lambda q)``; Coulomb friction opposes velocity, so the velocity is meant.
``q = 0`` hangs down and ``q2`` is relative to link 1. Joint 1 is the origin, x points right and y up. Arrays are
``(..., 2, N)``: joint, then time.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from repro.model.parameters import Array, check_beta

LAMBDA = 20.0  # steepness of the Coulomb friction's tanh, s/rad (Section IV-A)
_ROUNDING = 1e-12  # a point this fraction of the reach outside the workspace is outside by rounding


def check_motion(*signals: ArrayLike) -> tuple[Array, ...]:
    """Return the signals (..., 2, N) as float64, or raise ValueError if a shape differs or a sample is not finite."""
    checked = tuple(np.asarray(s, dtype=np.float64) for s in signals)
    for s in checked:
        if s.ndim < 2 or s.shape[-2] != 2:
            raise ValueError(f"signal: the last two axes must be (2, N), got shape {s.shape}.")
        if s.shape[-2:] != checked[0].shape[-2:]:
            raise ValueError(f"signals: shapes {s.shape} and {checked[0].shape} differ in their last two axes.")
        if not np.isfinite(s).all():
            raise ValueError("signal: every sample must be finite.")
    return checked


def regressor(q: ArrayLike, dq: ArrayLike, ddq: ArrayLike, friction_steepness: float = LAMBDA) -> Array:
    """Compute the regressor Y of Eq. 1, which is linear in beta: tau = Y(q, dq, ddq) beta.

    Parameters
    ----------
    q, dq, ddq : array_like of shape (..., 2, N)
        Position (rad), velocity (rad/s) and acceleration (rad/s^2).
    friction_steepness : float
        lambda of Eq. 1, s/rad.

    Returns
    -------
    array of shape (..., 2, N, 9)
        One column for each of ``I1, I2, I3, g1, g2, b1, b2, k1, k2``.

    Raises
    ------
    ValueError
        If a signal is not ``(..., 2, N)`` or not finite, or lambda is not above 0.

    Examples
    --------
    >>> q = np.array([[np.pi / 2], [0.0]])  # level, at rest: gravity alone
    >>> repro.regressor(q, 0 * q, 0 * q)[0, 0]
    array([0., 0., 0., 1., 1., 0., 0., 0., 0.])
    """
    if not 0.0 < friction_steepness < np.inf:
        raise ValueError(f"friction_steepness: must be positive and finite, got {friction_steepness!r}.")
    q, dq, ddq = np.broadcast_arrays(*check_motion(q, dq, ddq))
    q1, q2 = q[..., 0, :], q[..., 1, :]
    dq1, dq2 = dq[..., 0, :], dq[..., 1, :]
    ddq1, ddq2 = ddq[..., 0, :], ddq[..., 1, :]
    c2, s2, s1, s12 = np.cos(q2), np.sin(q2), np.sin(q1), np.sin(q1 + q2)
    y = np.zeros((*q.shape, 9))
    y[..., 0, :, 0] = ddq1
    y[..., 0, :, 1] = c2 * (ddq1 + 0.5 * ddq2) - s2 * dq2 * (dq1 + 0.5 * dq2)
    y[..., 1, :, 1] = 0.5 * (c2 * ddq1 + s2 * dq1**2)
    y[..., 0, :, 2] = ddq2
    y[..., 1, :, 2] = ddq1 + ddq2
    y[..., 0, :, 3] = s1
    y[..., 0, :, 4] = s12
    y[..., 1, :, 4] = s12
    y[..., 0, :, 5] = dq1
    y[..., 1, :, 6] = dq2
    y[..., 0, :, 7] = np.tanh(friction_steepness * dq1)
    y[..., 1, :, 8] = np.tanh(friction_steepness * dq2)
    return y


def inverse_dynamics(
    q: ArrayLike, dq: ArrayLike, ddq: ArrayLike, beta: ArrayLike, friction_steepness: float = LAMBDA
) -> Array:
    """Compute the torque that a motion needs (Eq. 1).

    Parameters
    ----------
    q, dq, ddq : array_like of shape (2, N)
        Position (rad), velocity (rad/s) and acceleration (rad/s^2).
    beta : array_like of shape (..., 9)
        Parameter sets, SI units.
    friction_steepness : float
        lambda of Eq. 1, s/rad.

    Returns
    -------
    array of shape (..., 2, N)
        Torque of each joint for each parameter set, N m.

    Raises
    ------
    ValueError
        If a shape is wrong, a value is not finite, or lambda is not above 0.

    Examples
    --------
    >>> q = np.array([[np.pi / 2], [0.0]])  # level, at rest: g1 + g2 and g2
    >>> repro.inverse_dynamics(q, 0 * q, 0 * q, np.array([0.3, 0.05, 0.1, 1.2, 0.4, 0.1, 0.05, 0.3, 0.2]))
    array([[1.6],
           [0.4]])
    """
    return rebuild_torque(regressor(q, dq, ddq, friction_steepness), beta)


def rebuild_torque(y: Array, beta: ArrayLike) -> Array:
    """Compute the torque Y beta (..., 2, N), N m, from a regressor (2, N, 9) and parameter sets (..., 9)."""
    beta = check_beta(beta)
    flat = beta @ y.reshape(-1, 9).T  # (..., 2N)
    return flat.reshape((*beta.shape[:-1], *y.shape[:-1]))


def mass_matrix(q: Array, beta: Array) -> Array:
    """Compute M(q) of Eq. 1 (..., 2, 2), kg m^2, from positions (..., 2) and parameter sets (..., 9) that broadcast."""
    i1, i2, i3 = (check_beta(beta)[..., k] for k in range(3))
    c2 = np.cos(np.asarray(q)[..., 1])
    m12 = i3 + 0.5 * i2 * c2
    return np.stack(np.broadcast_arrays(i1 + i2 * c2, m12, m12, i3), -1).reshape(*m12.shape, 2, 2)


def forward_dynamics(q: Array, dq: Array, tau: Array, beta: Array, friction_steepness: float = LAMBDA) -> Array:
    """Solve Eq. 1 for the acceleration (..., 2); unchecked, as an integrator needs a value when a state diverges."""
    i1, i2, i3, g1, g2 = (beta[..., k] for k in range(5))
    q1, q2, dq1, dq2 = q[..., 0], q[..., 1], dq[..., 0], dq[..., 1]
    driving = tau - beta[..., 5:7] * dq - beta[..., 7:9] * np.tanh(friction_steepness * dq)
    swing, load = 0.5 * i2 * np.sin(q2), g2 * np.sin(q1 + q2)
    r1 = driving[..., 0] + swing * dq2 * (2.0 * dq1 + dq2) - g1 * np.sin(q1) - load
    r2 = driving[..., 1] - swing * dq1**2 - load
    m11, m12 = i1 + i2 * np.cos(q2), i3 + 0.5 * i2 * np.cos(q2)
    determinant = m11 * i3 - m12**2
    return np.stack([i3 * r1 - m12 * r2, m11 * r2 - m12 * r1], axis=-1) / determinant[..., None]


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
    """Compute joint positions (..., 2, N), -pi < q1 <= pi and q2 >= 0, that put the tip on points (..., 2, N), m."""
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
