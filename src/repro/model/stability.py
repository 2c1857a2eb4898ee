"""Input-to-state stability of Eq. 1 (Eq. 3-4 and Appendix A, Eq. 17-22): constants and conditions.

Every extreme eigenvalue is exact: M(q) is affine in c = cos q2 and H(q) in x = q2 sin q2. The smallest eigenvalue of an
affine symmetric family is concave and the largest convex, so both are at an end of the interval of c or x.
"""

from dataclasses import dataclass

import numpy as np

from repro.model.dynamics import LAMBDA, mass_matrix
from repro.model.parameters import Array, check_beta

#: Largest value of x sin x on [-pi, pi], reached at |x| = 2.0288 where tan x = -x; the smallest is 0.
MAX_X_SIN_X = 1.819705741159653


@dataclass(frozen=True)
class LyapunovSettings:
    """Constants of the stability proof as Appendix A sets them."""

    rho: float = 0.1  # of the bounds on the potential energy, 1 - cos x > rho x^2 and q.g(q) >= rho q.Qq
    epsilon: float = 1e-3  # weight of the cross term in Eq. 3, 1/s
    gamma: float = 2.5e-3  # of the bound on Coulomb friction, x tanh(lambda x) >= gamma lambda x^2
    friction_steepness: float = LAMBDA  # lambda of Eq. 1, s/rad


@dataclass(frozen=True)
class StabilityConstants:
    """Results of Appendix A for one parameter set."""

    lambda_m_min: float  # extreme eigenvalues of M(q) over every q2, kg m^2
    lambda_m_max: float
    lambda_q_min: float  # smallest eigenvalue of Q = [[g1 + g2, g2], [g2, g2]] (Eq. 17), N m
    lambda_h_min: float  # of H(q) (Eq. 18) over abs(q2) <= pi, the domain ||q|| < pi of the proof, N m s
    potential: float  # rho lambda_Q^min, first condition of Eq. 17: above 0
    energy: float  # rho lambda_Q^min lambda_M^min / 2 - (epsilon lambda_M^max)^2 / 4, second one: above 0
    #: Condition of Eq. 18: rho epsilon lambda_Q^min (lambda_H^min - epsilon lambda_M^max + gamma lambda lambda_K^min),
    #: the dissipation, is above epsilon^2 (lambda_B^max + lambda_K^max)^2 / 4, the coupling.
    dissipation: float
    coupling: float
    r1_min: float  # smallest eigenvalue of R1 (Eq. 18): above r2_max
    r2_max: float  # largest eigenvalue of R2 = rho epsilon R1 (Eq. 19)
    s1_min: float  # smallest eigenvalue of S1 (Eq. 21)


def eigenvalue_range(a: Array | float, b: Array | float, d: Array | float) -> tuple[float, float]:
    """Compute the smallest and the largest eigenvalue of the matrices [[a, b], [b, d]]."""
    mean = 0.5 * (a + d)
    radius = np.hypot(0.5 * (a - d), b)
    return float((mean - radius).min()), float((mean + radius).max())


def stability_constants(beta: Array) -> StabilityConstants:
    """Compute the constants and both sides of the conditions of Appendix A for one parameter set (9,), physical or not.

    The corner of R1 is rho epsilon lambda_Q^min; the paper prints D there, which appears nowhere else. With it a
    parameter set exists that gives all the printed numbers at once (`repro.paper.appendix`).
    """
    s, beta = LyapunovSettings(), check_beta(beta)
    _, i2, _, g1, g2, b1, b2, k1, k2 = beta.tolist()
    m = mass_matrix(np.array([[0.0, 0.0], [0.0, np.pi]]), beta)
    m_min, m_max = eigenvalue_range(m[:, 0, 0], m[:, 0, 1], m[:, 1, 1])
    q_min, _ = eigenvalue_range(g1 + g2, g2, g2)
    h = 0.25 * s.epsilon * i2 * np.array([0.0, MAX_X_SIN_X])  # H = [[b1, -h], [-h, b2 + 2 h]]
    h_min, _ = eigenvalue_range(b1, -h, b2 + 2.0 * h)
    b_max, k_min, k_max = max(b1, b2), min(k1, k2), max(k1, k2)

    corner = s.rho * s.epsilon * q_min
    cross = 0.5 * s.epsilon * (b_max + k_max)
    speed = h_min - s.epsilon * m_max + s.gamma * s.friction_steepness * k_min
    r1_min, r1_max = eigenvalue_range(corner, cross, speed)
    r2_max = s.rho * s.epsilon * r1_max
    s1_min, _ = eigenvalue_range(s.rho * q_min, 0.5 * s.epsilon * m_max, m_min)
    potential, energy = s.rho * q_min, 0.5 * s.rho * q_min * m_min - 0.25 * (s.epsilon * m_max) ** 2
    dissipation, coupling = corner * speed, cross**2
    eigenvalues, conditions = (m_min, m_max, q_min, h_min), (potential, energy, dissipation, coupling)
    return StabilityConstants(*eigenvalues, *conditions, r1_min, r2_max, s1_min)
