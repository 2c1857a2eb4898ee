"""Input-to-state stability of Eq. 1 (Eq. 3-4 and Appendix A, Eq. 17-22): constants and conditions.

Every extreme eigenvalue is exact, not searched. M(q) is affine in c = cos q2 and H(q) in x = q2 sin q2; the
smallest eigenvalue of an affine symmetric family is concave and the largest convex, so both are reached at an
end of the interval that c or x covers.
"""

from dataclasses import dataclass

import numpy as np

from repro.model.dynamics import mass_matrix
from repro.model.lyapunov import LyapunovSettings
from repro.model.parameters import Array, check_beta

#: Largest value of x sin x on [-pi, pi], reached at |x| = 2.0288 where tan x = -x; the smallest is 0.
MAX_X_SIN_X = 1.819705741159653


@dataclass(frozen=True)
class StabilityConstants:
    """What Appendix A computes from one parameter set.

    Attributes
    ----------
    lambda_m_min, lambda_m_max : float
        Extreme eigenvalues of M(q) over every q2, kg m^2.
    lambda_q_min, lambda_q_max : float
        Eigenvalues of Q = [[g1 + g2, g2], [g2, g2]] (Eq. 17), N m.
    lambda_h_min : float
        Smallest eigenvalue of H(q) (Eq. 18) over abs(q2) <= pi, the domain ||q|| < pi of the proof, N m s.
    lambda_b_max, lambda_k_min, lambda_k_max : float
        Of the viscous friction (N m s) and the Coulomb friction (N m).
    potential : float
        rho lambda_Q^min, first condition of Eq. 17: above 0.
    energy : float
        rho lambda_Q^min lambda_M^min / 2 - (epsilon lambda_M^max)^2 / 4, second condition of Eq. 17: above 0.
    dissipation, coupling : float
        Two sides of the condition of Eq. 18: rho epsilon lambda_Q^min (lambda_H^min - epsilon lambda_M^max
        + gamma lambda lambda_K^min) is above epsilon^2 (lambda_B^max + lambda_K^max)^2 / 4.
    r1_min, r1_max, r2_min, r2_max : float
        Eigenvalues of R1 (Eq. 18) and of R2 = rho epsilon R1 (Eq. 19): r1_min is above r2_max.
    s1_min, s2_max : float
        Smallest eigenvalue of S1 and largest of S2 (Eq. 21).
    g_f : float
        Factor of ||tau|| in Eq. 21; nan where its square roots have no real value.
    a_1 : float
        Gain of Eq. 4 and 22; nan likewise.
    conditions : dict
        Which of the conditions ``potential``, ``energy``, ``dissipation`` and ``rate`` (r1_min above r2_max) hold.
    """

    lambda_m_min: float
    lambda_m_max: float
    lambda_q_min: float
    lambda_q_max: float
    lambda_h_min: float
    lambda_b_max: float
    lambda_k_min: float
    lambda_k_max: float
    potential: float
    energy: float
    dissipation: float
    coupling: float
    r1_min: float
    r1_max: float
    r2_min: float
    r2_max: float
    s1_min: float
    s2_max: float
    g_f: float
    a_1: float
    conditions: dict[str, bool]


def eigenvalue_range(a: Array) -> tuple[float, float]:
    """Smallest and largest eigenvalue in a stack of symmetric 2 x 2 matrices.

    Parameters
    ----------
    a : array of shape (..., 2, 2)
        Symmetric matrices.

    Returns
    -------
    tuple of float
        Over the whole stack.
    """
    mean = 0.5 * (a[..., 0, 0] + a[..., 1, 1])
    radius = np.hypot(0.5 * (a[..., 0, 0] - a[..., 1, 1]), a[..., 0, 1])
    return float((mean - radius).min()), float((mean + radius).max())


def dissipation_matrix(x: Array, beta: Array, epsilon: float) -> Array:
    """H(q) of Eq. 18 for x = q2 sin q2.

    Parameters
    ----------
    x : array of shape (...)
        q2 sin q2, rad.
    beta : array of shape (9,)
        Parameter set.
    epsilon : float
        Weight of the cross term in Eq. 3, 1/s.

    Returns
    -------
    array of shape (..., 2, 2)
        N m s.
    """
    beta = check_beta(beta)
    cross = 0.25 * epsilon * beta[1] * np.asarray(x, dtype=np.float64)
    b1, b2 = np.broadcast_to(beta[5], cross.shape), beta[6] + 2.0 * cross
    return np.stack([np.stack([b1, -cross], -1), np.stack([-cross, b2], -1)], -2)


def _gain(s1_min: float, s2_max: float, r_min: float) -> float:
    """sqrt(2 lambda_S2^max) / (sqrt(lambda_S1^min) lambda_R^min), nan where it has no real value."""
    if s1_min <= 0.0 or s2_max < 0.0 or r_min <= 0.0:
        return float("nan")
    return float(np.sqrt(2.0 * s2_max / s1_min) / r_min)


def stability_constants(beta: Array, settings: LyapunovSettings | None = None) -> StabilityConstants:
    """Constants and conditions of Appendix A for one parameter set.

    Parameters
    ----------
    beta : array of shape (9,)
        Parameter set, SI units. It need not be physical: the conditions then say so.
    settings : LyapunovSettings, optional
        Constants of the proof; the published ones by default.

    Returns
    -------
    StabilityConstants
        Eigenvalues, both sides of each condition, and whether it holds.

    Raises
    ------
    ValueError
        If `beta` does not hold nine finite numbers.

    Notes
    -----
    Where the print is not clear: the corner of R1 is rho epsilon lambda_Q^min (printed with D, which appears
    nowhere else), and g_f is what Eq. 20 and the two bounds give, with lambda_R2^min outside the root. With these
    readings a parameter set exists that gives all the printed numbers at once (`repro.paper.appendix`).
    """
    s = settings or LyapunovSettings()
    beta = check_beta(beta)
    if beta.shape != (9,):
        raise ValueError(f"beta: one set of nine parameters is needed, got shape {beta.shape}.")
    g1, g2, b1, b2, k1, k2 = beta[3:].tolist()
    m_min, m_max = eigenvalue_range(mass_matrix(np.array([[0.0, 0.0], [0.0, np.pi]]), beta))
    q_min, q_max = eigenvalue_range(np.array([[g1 + g2, g2], [g2, g2]]))
    h_min, _ = eigenvalue_range(dissipation_matrix(np.array([0.0, MAX_X_SIN_X]), beta, s.epsilon))
    b_max, k_min, k_max = max(b1, b2), min(k1, k2), max(k1, k2)

    corner = s.rho * s.epsilon * q_min
    cross = 0.5 * s.epsilon * (b_max + k_max)
    speed = h_min - s.epsilon * m_max + s.gamma * s.friction_steepness * k_min
    r1_min, r1_max = eigenvalue_range(np.array([[corner, cross], [cross, speed]]))
    r2_min, r2_max = s.rho * s.epsilon * r1_min, s.rho * s.epsilon * r1_max
    s1_min, _ = eigenvalue_range(np.array([[s.rho * q_min, 0.5 * s.epsilon * m_max], [0.5 * s.epsilon * m_max, m_min]]))
    _, s2_max = eigenvalue_range(np.array([[s.rho * q_max, 0.5 * s.epsilon * m_min], [0.5 * s.epsilon * m_min, m_max]]))
    energy = 0.5 * s.rho * q_min * m_min - 0.25 * (s.epsilon * m_max) ** 2
    dissipation, coupling = corner * speed, cross**2
    return StabilityConstants(
        lambda_m_min=m_min,
        lambda_m_max=m_max,
        lambda_q_min=q_min,
        lambda_q_max=q_max,
        lambda_h_min=h_min,
        lambda_b_max=b_max,
        lambda_k_min=k_min,
        lambda_k_max=k_max,
        potential=s.rho * q_min,
        energy=energy,
        dissipation=dissipation,
        coupling=coupling,
        r1_min=r1_min,
        r1_max=r1_max,
        r2_min=r2_min,
        r2_max=r2_max,
        s1_min=s1_min,
        s2_max=s2_max,
        g_f=_gain(s1_min, s2_max, r2_min),
        a_1=_gain(s1_min, s2_max, r1_min),
        conditions={
            "potential": q_min > 0.0,
            "energy": energy > 0.0,
            "dissipation": dissipation > coupling,
            "rate": r1_min > r2_max,
        },
    )
