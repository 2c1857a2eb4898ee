"""Eq. 1 of the paper: tau = M(q) ddq + C(q, dq) dq + g(q) + B dq + K tanh(lambda dq).

The paper prints ``tanh(lambda q)``; Coulomb friction opposes velocity, so the velocity is meant.
``q = 0`` hangs down and ``q2`` is relative to link 1. Arrays are ``(..., 2, N)``: joint, then time.
"""

import numpy as np

from repro.model.parameters import Array, check_beta

#: Steepness of the Coulomb friction's tanh, s/rad (Section IV-A).
LAMBDA = 20.0


def check_motion(*signals: Array) -> tuple[Array, ...]:
    """Return the signals as float64 after checking that all are ``(..., 2, N)`` and finite.

    Parameters
    ----------
    *signals : arrays of shape (..., 2, N)
        Positions, velocities, accelerations or torques.

    Returns
    -------
    tuple of arrays of shape (..., 2, N)
        The same numbers.

    Raises
    ------
    ValueError
        If a signal has no joint axis of length 2, is not finite, or the last two axes differ.
    """
    checked = tuple(np.asarray(s, dtype=np.float64) for s in signals)
    for s in checked:
        if s.ndim < 2 or s.shape[-2] != 2:
            raise ValueError(f"signal: the last two axes must be (2, N), got shape {s.shape}.")
        if s.shape[-2:] != checked[0].shape[-2:]:
            raise ValueError(f"signals: shapes {s.shape} and {checked[0].shape} differ in their last two axes.")
        if not np.isfinite(s).all():
            raise ValueError("signal: every sample must be finite.")
    return checked


def regressor(q: Array, dq: Array, ddq: Array, friction_steepness: float = LAMBDA) -> Array:
    """Regressor Y of Eq. 1, which is linear in beta: tau = Y(q, dq, ddq) beta.

    Parameters
    ----------
    q, dq, ddq : arrays of shape (..., 2, N)
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
        If a signal is not ``(..., 2, N)`` or not finite.
    """
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


def inverse_dynamics(q: Array, dq: Array, ddq: Array, beta: Array, friction_steepness: float = LAMBDA) -> Array:
    """Torque that a motion needs (Eq. 1).

    Parameters
    ----------
    q, dq, ddq : arrays of shape (2, N)
        Position (rad), velocity (rad/s) and acceleration (rad/s^2).
    beta : array of shape (..., 9)
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
        If a shape is wrong or a value is not finite.
    """
    return rebuild_torque(regressor(q, dq, ddq, friction_steepness), beta)


def rebuild_torque(y: Array, beta: Array) -> Array:
    """Torque Y beta for a regressor that is already there.

    Parameters
    ----------
    y : array of shape (2, N, 9)
        Regressor of one motion.
    beta : array of shape (..., 9)
        Parameter sets.

    Returns
    -------
    array of shape (..., 2, N)
        Torque, N m.
    """
    beta = check_beta(beta)
    if y.ndim < 1 or y.shape[-1] != 9:
        raise ValueError(f"y: the last axis of a regressor must hold 9 columns, got shape {y.shape}.")
    flat = beta @ y.reshape(-1, 9).T  # (..., 2N)
    return flat.reshape((*beta.shape[:-1], *y.shape[:-1]))


def mass_matrix(q: Array, beta: Array) -> Array:
    """Inertia matrix M(q) of Eq. 1.

    Parameters
    ----------
    q : array of shape (..., 2)
        Position, rad.
    beta : array of shape (..., 9)
        Parameter sets, broadcast against `q`.

    Returns
    -------
    array of shape (..., 2, 2)
        Inertia matrix, kg m^2.
    """
    i1, i2, i3 = (check_beta(beta)[..., k] for k in range(3))
    c2 = np.cos(np.asarray(q)[..., 1])
    m12 = i3 + 0.5 * i2 * c2
    return np.stack(
        [np.stack([i1 + i2 * c2, m12], -1), np.stack([m12, np.broadcast_to(i3, m12.shape)], -1)],
        -2,
    )


def coriolis_matrix(q: Array, dq: Array, beta: Array) -> Array:
    """Coriolis matrix C(q, dq) of Eq. 1.

    Parameters
    ----------
    q, dq : arrays of shape (..., 2)
        Position (rad) and velocity (rad/s).
    beta : array of shape (..., 9)
        Parameter sets, broadcast against `q`.

    Returns
    -------
    array of shape (..., 2, 2)
        Coriolis matrix, kg m^2/s.
    """
    dq = np.asarray(dq)
    h = 0.5 * check_beta(beta)[..., 1] * np.sin(np.asarray(q)[..., 1])
    dq1, dq2 = dq[..., 0], dq[..., 1]
    return np.stack(
        [np.stack([-2.0 * h * dq2, -h * dq2], -1), np.stack([h * dq1, np.zeros_like(h * dq1)], -1)],
        -2,
    )


def gravity_torque(q: Array, beta: Array) -> Array:
    """Gravity torque g(q) of Eq. 1.

    Parameters
    ----------
    q : array of shape (..., 2)
        Position, rad.
    beta : array of shape (..., 9)
        Parameter sets, broadcast against `q`.

    Returns
    -------
    array of shape (..., 2)
        Torque, N m.
    """
    q, beta = np.asarray(q), check_beta(beta)
    link2 = beta[..., 4] * np.sin(q[..., 0] + q[..., 1])
    return np.stack([beta[..., 3] * np.sin(q[..., 0]) + link2, link2], -1)


def forward_dynamics(q: Array, dq: Array, tau: Array, beta: Array, friction_steepness: float = LAMBDA) -> Array:
    """Acceleration that a torque causes: Eq. 1 solved for ddq.

    Parameters
    ----------
    q, dq, tau : arrays of shape (..., 2)
        Position (rad), velocity (rad/s) and torque (N m).
    beta : array of shape (..., 9)
        Parameter sets, broadcast against `q`.
    friction_steepness : float
        lambda of Eq. 1, s/rad.

    Returns
    -------
    array of shape (..., 2)
        Acceleration, rad/s^2.

    Raises
    ------
    ValueError
        If a shape is wrong, a value is not finite, or M(q) is singular.
    """
    for name, state in (("q", q), ("dq", dq), ("tau", tau)):
        if np.shape(state)[-1:] != (2,) or not np.isfinite(state).all():
            raise ValueError(f"{name}: must be finite with two joints on the last axis, got shape {np.shape(state)}.")
    q, dq, tau, beta = np.asarray(q), np.asarray(dq), np.asarray(tau), check_beta(beta)
    with np.errstate(divide="ignore", invalid="ignore"):
        ddq = acceleration(q, dq, tau, beta, friction_steepness)
    if not np.isfinite(ddq).all():
        raise ValueError("beta: the inertia matrix is singular, so torque does not determine acceleration.")
    return ddq


def acceleration(q: Array, dq: Array, tau: Array, beta: Array, friction_steepness: float = LAMBDA) -> Array:
    """Eq. 1 solved for ddq without checks, for integrators: a state that runs away gives what is not finite.

    Parameters
    ----------
    q, dq, tau : arrays of shape (..., 2)
        Position (rad), velocity (rad/s) and torque (N m).
    beta : array of shape (..., 9)
        Parameter sets, broadcast against `q`.
    friction_steepness : float
        lambda of Eq. 1, s/rad.

    Returns
    -------
    array of shape (..., 2)
        Acceleration, rad/s^2.
    """
    i1, i2, i3, g1, g2 = (beta[..., k] for k in range(5))
    q1, q2, dq1, dq2 = q[..., 0], q[..., 1], dq[..., 0], dq[..., 1]
    driving = tau - beta[..., 5:7] * dq - beta[..., 7:9] * np.tanh(friction_steepness * dq)
    swing, load = 0.5 * i2 * np.sin(q2), g2 * np.sin(q1 + q2)
    r1 = driving[..., 0] + swing * dq2 * (2.0 * dq1 + dq2) - g1 * np.sin(q1) - load
    r2 = driving[..., 1] - swing * dq1**2 - load
    m11, m12 = i1 + i2 * np.cos(q2), i3 + 0.5 * i2 * np.cos(q2)
    determinant = m11 * i3 - m12**2
    ddq: Array = np.stack([i3 * r1 - m12 * r2, m11 * r2 - m12 * r1], axis=-1) / determinant[..., None]
    return ddq
