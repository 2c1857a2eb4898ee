"""Proof of Appendix A: how far its inequalities hold, and signs and factors in its matrices."""

import math
from collections.abc import Callable

from scipy.optimize import brentq

from repro.model.stability import stability_constants
from repro.paper.appendix import appendix_arm
from repro.paper.checks.finding import CONSISTENT, CONTRADICTS, IN_PART, MISPRINT, Finding, remark
from repro.paper.published import Published

PLACE = "Appendix A"


def _crossing(ratio: Callable[[float], float], level: float, low: float, high: float) -> float:
    """Where a falling ratio reaches `level`; nan if not between the ends."""
    if not ratio(low) > level > ratio(high):
        return math.nan
    return float(brentq(lambda x: ratio(x) - level, low, high, xtol=1e-12))


def bounds(p: Published) -> list[Finding]:
    """How far the three inequalities of the proof hold."""
    rho, gamma, domain = p["appendix/rho"], p["appendix/gamma"], p["appendix/domain"]
    steepness, speed = p["section4a/steepness"], p["section3/joint-speed"]
    radius = domain.value * math.pi
    cosine = _crossing(lambda x: (1.0 - math.cos(x)) / x**2, rho.value, 1e-3, 2.0 * math.pi)
    needed = math.sqrt(2.0) * radius
    enough = (1.0 - math.cos(needed)) / needed**2
    sine = _crossing(lambda x: math.sin(x) / x, rho.value, 1e-3, math.pi)
    tanh = _crossing(lambda u: math.tanh(u) / u, gamma.value, 1e-3, 1e6) / steepness.value
    return [
        Finding(
            "appendix/cosine",
            PLACE,
            f"1 - cos x > rho x^2 with rho = {rho.printed}, used at x = q1 + q2",
            f"holds up to |x| = {cosine:.3f}; ||q|| < pi lets |q1 + q2| reach sqrt(2) pi = {needed:.3f}",
            cosine,
            needed,
            math.nan,
            "rad",
            CONSISTENT if cosine >= needed else IN_PART,
            f"As stated, for |x| < pi, it holds. rho = {math.floor(1e3 * enough) / 1e3:g} would do for the sum.",
            (rho.id, domain.id),
        ),
        Finding(
            "appendix/sine",
            PLACE,
            f"q.g(q) >= rho q.Qq with rho = {rho.printed} for ||q|| < pi",
            f"at q2 = 0 it asks for sin(q1) / q1 >= {rho.printed}: holds up to q1 = {sine:.3f}; sin(3) / 3 = "
            f"{math.sin(3.0) / 3.0:.3f}",
            sine,
            radius,
            math.nan,
            "rad",
            CONSISTENT if sine >= radius else IN_PART,
            "No rho > 0 holds up to pi, where the left side is 0: the proof covers a smaller ball than ||q|| < pi.",
            (rho.id, domain.id),
        ),
        Finding(
            "appendix/tanh",
            PLACE,
            f"x tanh(lambda x) >= gamma lambda x^2 with gamma = {gamma.printed}, lambda = {steepness.printed}",
            f"holds up to |x| = {tanh:.3f} rad/s, above {speed.printed} rad/s",
            tanh,
            speed.value,
            math.nan,
            "rad/s",
            CONSISTENT if tanh >= speed.value else IN_PART,
            "No bound on x is printed; the joints turn no faster than Section III says.",
            (gamma.id, steepness.id, speed.id),
        ),
    ]


def matrices(p: Published) -> list[Finding]:
    """Signs and factors in Eq. 17, 20, 21 and 22."""
    scale = p["appendix/rho"].value * p["appendix/epsilon"].value
    arm = stability_constants(appendix_arm())
    return [
        remark(
            "appendix/eq17-sign",
            PLACE,
            "sign of the cross term in the lower bound of Eq. 17",
            "printed + epsilon lambda_M^max ||q|| ||dq||; q.M dq can be negative, so a bound from below needs -",
            MISPRINT,
            "With + the form is a sum of positive terms and needs no condition; the second one printed is that of the "
            "form with -. The sign may be lost in the extracted text.",
        ),
        Finding(
            "appendix/s1-corner",
            PLACE,
            "corner of S1 against the lower bound of Eq. 17 and its condition",
            "Eq. 17 and rho lambda_Q^min lambda_M^min / 2 - (epsilon lambda_M^max)^2 / 4 > 0 have lambda_M^min / 2; S1 "
            "has lambda_M^min",
            1.0,
            0.5,
            0.0,
            "lambda_M^min",
            CONTRADICTS,
            f"Without effect on an arm like the appendix's, where the other corner is the smaller: lambda_S1^min = "
            f"{arm.s1_min:.4f}, lambda_M^min / 2 = {0.5 * arm.lambda_m_min:.4f}.",
        ),
        Finding(
            "appendix/gain",
            PLACE,
            "a_1 of Eq. 22 against g_f of Eq. 21",
            f"g_f divides by lambda_R2^min, a_1 by lambda_R1^min = lambda_R2^min / (rho epsilon): a factor of "
            f"{1.0 / scale:.0f}",
            1.0 / scale,
            1.0,
            0.0,
            "1",
            CONTRADICTS,
            "Eq. 20 leads to R2. In Eq. 21 lambda_R2^min stands under the root, in a_1 lambda_R1^min outside it; where "
            "the root ends may be lost in the extracted text.",
            ("appendix/rho", "appendix/epsilon"),
        ),
        remark(
            "appendix/eq20-square",
            PLACE,
            "norm of the state in Eq. 20",
            "printed sqrt(||q||^2 + ||dq||); X = [||q||, ||dq||] has sqrt(||q||^2 + ||dq||^2)",
            MISPRINT,
            "The square may be lost in the extracted text.",
        ),
        remark(
            "appendix/skew",
            PLACE,
            "dq.(dM/dt - 2 C) dq = 0 with the printed C",
            "both terms are -I2 sin(q2) dq1 dq2 (dq1 + dq2)",
            CONSISTENT,
            "The matrix itself is not skew-symmetric, which the proof does not need.",
        ),
    ]
