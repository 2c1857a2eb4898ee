"""Energy function of the hanging arm (Eq. 3), its lower bound (Eq. 17), and the constants of the proof."""

from dataclasses import dataclass

import numpy as np

from repro.model.dynamics import LAMBDA, mass_matrix
from repro.model.parameters import Array, check_beta


@dataclass(frozen=True)
class LyapunovSettings:
    """Constants of the stability proof, by default as Appendix A sets them.

    Attributes
    ----------
    rho : float
        Of the bounds on the potential energy, 1 - cos x > rho x^2 and q.g(q) >= rho q.Qq.
    epsilon : float
        Weight of the cross term in Eq. 3, 1/s.
    gamma : float
        Of the bound on Coulomb friction, x tanh(lambda x) >= gamma lambda x^2.
    friction_steepness : float
        lambda of Eq. 1, s/rad.

    Raises
    ------
    ValueError
        If one is not positive and finite.
    """

    rho: float = 0.1
    epsilon: float = 1e-3
    gamma: float = 2.5e-3
    friction_steepness: float = LAMBDA

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not 0 < value < np.inf:
                raise ValueError(f"{name}: must be positive and finite, got {value}.")


def lyapunov_function(q: Array, dq: Array, beta: Array, epsilon: float = 1e-3) -> Array:
    """Energy function V(q, dq) of Eq. 3.

    Parameters
    ----------
    q, dq : arrays of shape (..., 2)
        Position (rad) and velocity (rad/s).
    beta : array of shape (9,)
        Parameter set.
    epsilon : float
        Weight of the cross term, 1/s.

    Returns
    -------
    array of shape (...)
        J; 0 in the resting arm that hangs down.

    Raises
    ------
    ValueError
        If `beta` does not hold nine finite numbers or a state does not have two joints.
    """
    q, dq, beta = np.asarray(q, dtype=np.float64), np.asarray(dq, dtype=np.float64), check_beta(beta)
    for name, state in (("q", q), ("dq", dq)):
        if state.shape[-1:] != (2,):
            raise ValueError(f"{name}: the last axis must hold two joints, got shape {state.shape}.")
    momentum = (mass_matrix(q, beta) @ dq[..., None])[..., 0]
    potential = beta[3] * (1.0 - np.cos(q[..., 0])) + beta[4] * (1.0 - np.cos(q[..., 0] + q[..., 1]))
    return np.asarray((0.5 * dq * momentum).sum(-1) + potential + epsilon * (q * momentum).sum(-1))


def lyapunov_lower_bound(
    q_norm: Array, dq_norm: Array, lambda_q_min: float, lambda_m: tuple[float, float], settings: LyapunovSettings
) -> Array:
    """Lower bound of V by Eq. 17.

    Parameters
    ----------
    q_norm, dq_norm : arrays of shape (...)
        ||q|| (rad) and ||dq|| (rad/s).
    lambda_q_min : float
        Smallest eigenvalue of Q, N m.
    lambda_m : tuple of float
        Smallest and largest eigenvalue of M(q) over every q2, kg m^2.
    settings : LyapunovSettings
        rho and epsilon.

    Returns
    -------
    array of shape (...)
        J.

    Notes
    -----
    Printed with ``+ epsilon lambda_M^max ||q|| ||dq||``; a bound from below needs the minus sign. The bound on the
    potential energy behind it, 1 - cos x > rho x^2, is used at x = q1 + q2 too and holds to abs(x) = 4.03 for
    rho = 0.1, so the whole bound holds to ||q|| = 4.03 / sqrt(2) = 2.85 rad, a little short of pi.
    """
    q_norm, dq_norm = np.asarray(q_norm), np.asarray(dq_norm)
    kinetic = 0.5 * lambda_m[0] * dq_norm**2
    return np.asarray(
        kinetic + settings.rho * lambda_q_min * q_norm**2 - settings.epsilon * lambda_m[1] * q_norm * dq_norm
    )
