"""Appendix A: the arm that it describes, and the checks of its six numbers, inequalities and matrices.

Table 9 is lost, but Appendix A prints six numbers of the identified arm. They fix four combinations of its parameters:

==================================== ============================================================
7.2e-3, and the roots of the next    lambda_Q^min, hence g2 once g1 is chosen
1.3659e-7, 3.4422e-6, 1.8986e-6      rho epsilon lambda_Q^min and the other corner of R1, which is
                                     lambda_H^min - epsilon lambda_M^max + gamma lambda lambda_K^min,
                                     hence b2 once k2 is chosen
7.1236e-8                            lambda_B^max + lambda_K^max, hence b1 once k1 is chosen
6.2020e-5                            lambda_M^min, hence I3 once I1 and I2 are chosen
==================================== ============================================================

Free are I1, l1 (which gives I2 = 2 l1 g2 / g), g1, k1 and k2. Joint 1 is taken to have the larger friction.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from repro.model.parameters import STANDARD_GRAVITY, Array, is_positive, is_positive_definite
from repro.model.stability import LyapunovSettings, eigenvalue_range, stability_constants
from repro.paper.finding import Check, Finding
from repro.paper.published import Published, PublishedValue, load_published

#: The printed numbers, by the `repro.model.stability.StabilityConstants` field that each is.
APPENDIX_NUMBERS = ("potential", "energy", "dissipation", "coupling", "r1_min", "r2_max")


@dataclass(frozen=True)
class FreeChoices:
    """What the printed numbers of the appendix leave open, by default as in accepted experiment 1."""

    i1: float = 0.105388  # inertia of both links seen by joint 1, kg m^2. At least 0.09, or no I3 gives lambda_M^min
    l1: float = 0.196946  # length of link 1, m
    g1: float = 0.444465  # gravity load on joint 1, N m: above the inertias, as Section V-C says of Table 9
    k1: float = 0.3866  # Coulomb friction, N m: b1 and b2 stay below it, as Section V-C says of Table 9
    k2: float = 0.18823902


def appendix_numbers(published: Published | None = None) -> dict[str, PublishedValue]:
    """Six numbers that Appendix A prints."""
    numbers = published or load_published()
    return {name: numbers[f"appendix/{name}"] for name in APPENDIX_NUMBERS}


def reproduced(beta: Array, published: Published | None = None) -> dict[str, bool]:
    """Which printed numbers a parameter set gives, each to its last printed digit."""
    ours, printed = stability_constants(beta), appendix_numbers(published)
    return {name: abs(getattr(ours, name) - p.value) <= p.half_step for name, p in printed.items()}


def appendix_arm(choices: FreeChoices | None = None, published: Published | None = None) -> Array:
    """Parameter set that gives the six printed numbers of Appendix A."""
    c = choices or FreeChoices()
    published, s = published or load_published(), LyapunovSettings()
    p = {name: number.value for name, number in appendix_numbers(published).items()}

    # R1 = [[x, .], [., y]]: its trace is the sum of its two eigenvalues, x y is the dissipation.
    trace = p["r1_min"] + p["r2_max"] / (s.rho * s.epsilon)
    if not (0.0 < 4.0 * p["dissipation"] <= trace**2 and p["coupling"] >= 0.0):
        raise ValueError(f"published: no real R1 has dissipation {p['dissipation']} and trace {trace}.")
    y = 0.5 * (trace + np.sqrt(trace**2 - 4.0 * p["dissipation"]))
    lambda_q = p["dissipation"] / y / (s.rho * s.epsilon)
    friction = 2.0 * np.sqrt(p["coupling"]) / s.epsilon

    if c.g1 <= 2.0 * lambda_q:
        raise ValueError(f"g1: must be above {2.0 * lambda_q:.4f} N m for lambda_Q^min = {lambda_q:.4f}, got {c.g1}.")
    g2 = lambda_q * (c.g1 - lambda_q) / (c.g1 - 2.0 * lambda_q)  # det(Q - lambda_Q^min) = 0
    i2 = 2.0 * c.l1 * g2 / STANDARD_GRAVITY
    beta = np.array([c.i1, i2, 0.0, c.g1, g2, friction - c.k1, 0.0, c.k1, c.k2])

    def energy_error(i3: float) -> float:
        beta[2] = i3
        return stability_constants(beta).energy - p["energy"]

    # lambda_M^min <= I3 bounds I3 from below; lambda_M^min(I3) rises up to about I3 = I1 / 3.
    low, high = 2.0 * p["energy"] / (s.rho * lambda_q), c.i1 / 3.0
    if low >= high or energy_error(low) > 0.0 or energy_error(high) < 0.0:
        raise ValueError(f"i1, l1: no I3 gives the printed {p['energy']:.4e} with i1 = {c.i1}, l1 = {c.l1}.")
    beta[2] = brentq(energy_error, low, high, xtol=1e-14)

    # lambda_H^min is b2 (H is diag(b1, b2) where q2 sin q2 = 0) as long as b2 is the smaller.
    lambda_m_max = stability_constants(beta).lambda_m_max
    beta[6] = y + s.epsilon * lambda_m_max - s.gamma * s.friction_steepness * c.k2
    if not (is_positive(beta) and is_positive_definite(beta)):
        raise ValueError(f"choices: {c} lead to a parameter set that is not physical, {beta.tolist()}.")
    if not all(reproduced(beta, published).values()):
        raise ValueError(f"choices: {c} make joint 2's friction the larger; the numbers are solved for joint 1's.")
    return beta


def determinant(c: Check) -> Finding:
    """Compare the determinant of R1, which the print over-determines: from its eigenvalues, and from Eq. 18's sides."""
    n, scale = c.numbers, c.rho * c.epsilon
    found, printed = c.r1_min * (c.r2_max / scale), c.dissipation - c.coupling
    rounding = n["r1_min"].half_step / c.r1_min + n["r2_max"].half_step / c.r2_max
    tolerance = found * rounding + n["dissipation"].half_step + n["coupling"].half_step
    return c.equals(found, printed, tolerance, scale=scale)


def corner(c: Check) -> Finding:
    """Compute lambda_Q^min from the corner of R1, the smaller root of its characteristic polynomial."""
    scale = c.rho * c.epsilon
    trace = c.r1_min + c.r2_max / scale
    inside = trace**2 - 4.0 * c.dissipation
    lambda_q = (0.5 * (trace - math.sqrt(inside)) if inside >= 0.0 else math.nan) / scale
    tolerance = c.numbers["potential"].half_step
    return c.equals(c.rho * lambda_q, c.potential, tolerance, trace=trace, scale=scale, lambda_q=lambda_q)


def arm(c: Check) -> Finding:
    """Look for a physical arm that gives the printed numbers; `appendix_arm` finds none that gives only some."""
    found, of = 0, len(APPENDIX_NUMBERS)
    try:
        beta = ", ".join(f"{x:.4g}" for x in appendix_arm(published=c.published))
        found, outcome = of, f"beta = ({beta}) gives {of} of {of}"
    except ValueError as error:
        outcome = f"no physical arm: {error}"
    return c.equals(found, of, 0.0, outcome=outcome)


def _crossing(ratio: Callable[[float], float], level: float, low: float, high: float) -> float:
    """Find where a falling ratio reaches `level`; nan if not between the ends."""
    if not ratio(low) > level > ratio(high):
        return math.nan
    return float(brentq(lambda x: ratio(x) - level, low, high, xtol=1e-12))


def cosine(c: Check) -> Finding:
    """Find where 1 - cos x > rho x^2 ends; ||q|| < pi lets |q1 + q2| reach sqrt(2) pi."""
    end = _crossing(lambda x: (1.0 - math.cos(x)) / x**2, c.rho, 1e-3, 2.0 * math.pi)
    needed = math.sqrt(2.0) * (c.domain * math.pi)
    enough = math.floor(1e3 * ((1.0 - math.cos(needed)) / needed**2)) / 1e3
    return c.compares(end, needed, end >= needed, enough=enough)


def sine(c: Check) -> Finding:
    """Find where sin(q1) / q1 >= rho, which q.g(q) >= rho q.Qq requires at q2 = 0, ends."""
    end, radius = _crossing(lambda x: math.sin(x) / x, c.rho, 1e-3, math.pi), c.domain * math.pi
    return c.compares(end, radius, end >= radius, at_3=math.sin(3.0) / 3.0)


def tanh(c: Check) -> Finding:
    """Find where x tanh(lambda x) >= gamma lambda x^2 ends."""
    end = _crossing(lambda u: math.tanh(u) / u, c.gamma, 1e-3, 1e6) / c.steepness
    return c.compares(end, c.speed, end >= c.speed)


def s1_corner(c: Check) -> Finding:
    """Compare the corner of S1 with the lower bound of Eq. 17."""
    constants = stability_constants(appendix_arm())
    half = 0.5 * constants.lambda_m_min
    return c.compares(1.0, 0.5, False, tolerance=0.0, s1_min=constants.s1_min, half=half)


def s2_corner(c: Check) -> Finding:
    """Compare the largest eigenvalue of S2 with that of the upper bound of Eq. 3: 1 - cos x is at most x^2 / 2."""
    beta, e = appendix_arm(), c.epsilon
    m_min, m_max = stability_constants(beta).lambda_m_min, stability_constants(beta).lambda_m_max
    g1, g2 = beta[3:5].tolist()
    q_max = eigenvalue_range(g1 + g2, g2, g2)[1]
    printed = eigenvalue_range(c.rho * q_max, 0.5 * e * m_min, m_max)[1]
    needed = eigenvalue_range(0.5 * q_max, 0.5 * e * m_max, 0.5 * m_max)[1]
    return c.compares(needed, printed, printed >= needed, ratio=math.sqrt(printed / needed))
