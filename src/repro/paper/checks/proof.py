"""Appendix A: its six numbers against each other, the range of its inequalities, signs and factors in its matrices.

The identified arm is lost with Table 9, but the numbers over-determine what they are computed from: with R2 = rho
epsilon R1, both eigenvalues, the product of the diagonal and the square of the other corner of R1 are printed.
"""

import math
from collections.abc import Callable

from scipy.optimize import brentq

from repro.model.stability import stability_constants
from repro.paper.appendix import APPENDIX_NUMBERS, appendix_arm, appendix_numbers, reproduced
from repro.paper.checks.finding import CONSISTENT, CONTRADICTS, IN_PART, MISPRINT, Finding, compares, equals, remark
from repro.paper.published import Published

PLACE = "Appendix A"


def numbers_against_each_other(p: Published) -> list[Finding]:
    """Check relations between the six numbers that need no arm, and whether one arm gives all of them."""
    n = appendix_numbers(p)
    rho, epsilon = p["appendix/rho"], p["appendix/epsilon"]
    scale = rho.value * epsilon.value
    r1_min, r1_max = n["r1_min"].value, n["r2_max"].value / scale
    determinant, product = r1_min * r1_max, n["dissipation"].value - n["coupling"].value
    tolerance = (
        determinant * (n["r1_min"].half_step / r1_min + n["r2_max"].half_step / n["r2_max"].value)
        + n["dissipation"].half_step
        + n["coupling"].half_step
    )
    trace = r1_min + r1_max
    inside = trace**2 - 4.0 * n["dissipation"].value
    corner = 0.5 * (trace - math.sqrt(inside)) if inside >= 0.0 else math.nan
    lambda_q, potential = corner / scale, n["potential"]
    condition = r1_max / r1_min
    return [
        equals(
            ("appendix/determinant", PLACE),
            "determinant of R1 from its eigenvalues and from the sides of Eq. 18's condition",
            f"{n['r1_min'].printed} x {n['r2_max'].printed} / {scale:g} = {determinant:.5e}; "
            f"{n['dissipation'].printed} - {n['coupling'].printed} = {product:.5e}",
            determinant,
            printed=product,
            tolerance=tolerance,
            unit="(N m)^2",
            uses=(n["r1_min"], n["r2_max"], n["dissipation"], n["coupling"], rho, epsilon),
        ),
        equals(
            ("appendix/corner", PLACE),
            "lambda_Q^min from R1's corner, which is printed with D for Q",
            f"smaller root of x^2 - {trace:.5e} x + {n['dissipation'].printed}, over {scale:g}: {lambda_q:.5f}, so rho "
            f"lambda_Q^min = {rho.value * lambda_q:.6f}",
            rho.value * lambda_q,
            printed=potential.value,
            tolerance=potential.half_step,
            unit="N m",
            uses=(n["r1_min"], n["r2_max"], n["dissipation"], potential, rho, epsilon),
            note="D stands nowhere else in the paper; the numbers are those of Q.",
        ),
        compares(
            ("appendix/condition", PLACE),
            "smallest eigenvalue of R1 above the largest of R2 = rho epsilon R1",
            f"the same as lambda_R1^max / lambda_R1^min < 1 / (rho epsilon): {r1_max:.5e} / {n['r1_min'].printed} = "
            f"{condition:.0f} < {1.0 / scale:.0f}",
            condition,
            1.0 / scale,
            CONSISTENT if condition < 1.0 / scale else CONTRADICTS,
            unit="1",
            uses=(n["r1_min"], n["r2_max"], rho, epsilon),
        ),
        compares(
            ("appendix/rate", PLACE),
            "condition of Eq. 18",
            f"{n['dissipation'].printed} > {n['coupling'].printed}",
            n["dissipation"].value,
            n["coupling"].value,
            CONSISTENT if n["dissipation"].value > n["coupling"].value else CONTRADICTS,
            unit="(N m)^2",
            uses=(n["dissipation"], n["coupling"]),
        ),
        _arm(p),
    ]


def _arm(p: Published) -> Finding:
    """Is there a physical arm that gives all six numbers?"""
    try:
        beta = appendix_arm(published=p)
    except ValueError as error:
        count, text = 0, f"no physical arm: {error}"
    else:
        count = sum(reproduced(beta, p).values())
        text = f"beta = ({', '.join(f'{x:.4g}' for x in beta)}) gives {count} of {len(APPENDIX_NUMBERS)}"
    return equals(
        ("appendix/arm", PLACE),
        "a physical arm that gives all six numbers to their last digit",
        text,
        count,
        printed=len(APPENDIX_NUMBERS),
        tolerance=0.0,
        unit="numbers",
        uses=appendix_numbers(p).values(),
        note="One member of a family with five free parameters; evaluated with the paper's own rho, epsilon and gamma.",
    )


def _crossing(ratio: Callable[[float], float], level: float, low: float, high: float) -> float:
    """Find where a falling ratio reaches `level`; nan if not between the ends."""
    if not ratio(low) > level > ratio(high):
        return math.nan
    return float(brentq(lambda x: ratio(x) - level, low, high, xtol=1e-12))


def bounds(p: Published) -> list[Finding]:
    """Find the ranges in which the three inequalities of the proof are valid."""
    rho, gamma, domain = p["appendix/rho"], p["appendix/gamma"], p["appendix/domain"]
    steepness, speed = p["section4a/steepness"], p["section3/joint-speed"]
    radius = domain.value * math.pi
    cosine = _crossing(lambda x: (1.0 - math.cos(x)) / x**2, rho.value, 1e-3, 2.0 * math.pi)
    needed = math.sqrt(2.0) * radius
    enough = (1.0 - math.cos(needed)) / needed**2
    sine = _crossing(lambda x: math.sin(x) / x, rho.value, 1e-3, math.pi)
    tanh = _crossing(lambda u: math.tanh(u) / u, gamma.value, 1e-3, 1e6) / steepness.value
    return [
        compares(
            ("appendix/cosine", PLACE),
            f"1 - cos x > rho x^2 with rho = {rho.printed}, used at x = q1 + q2",
            f"holds up to |x| = {cosine:.3f}; ||q|| < pi lets |q1 + q2| reach sqrt(2) pi = {needed:.3f}",
            cosine,
            needed,
            CONSISTENT if cosine >= needed else IN_PART,
            unit="rad",
            uses=(rho, domain),
            note=f"As stated, for |x| < pi, it holds. rho = {math.floor(1e3 * enough) / 1e3:g} would do for the sum.",
        ),
        compares(
            ("appendix/sine", PLACE),
            f"q.g(q) >= rho q.Qq with rho = {rho.printed} for ||q|| < pi",
            f"at q2 = 0 it asks for sin(q1) / q1 >= {rho.printed}: holds up to q1 = {sine:.3f}; sin(3) / 3 = "
            f"{math.sin(3.0) / 3.0:.3f}",
            sine,
            radius,
            CONSISTENT if sine >= radius else IN_PART,
            unit="rad",
            uses=(rho, domain),
            note="No rho > 0 holds up to pi, where the left side is 0: the proof covers a smaller ball than ||q|| < "
            "pi.",
        ),
        compares(
            ("appendix/tanh", PLACE),
            f"x tanh(lambda x) >= gamma lambda x^2 with gamma = {gamma.printed}, lambda = {steepness.printed}",
            f"holds up to |x| = {tanh:.3f} rad/s, above {speed.printed} rad/s",
            tanh,
            speed.value,
            CONSISTENT if tanh >= speed.value else IN_PART,
            unit="rad/s",
            uses=(gamma, steepness, speed),
            note="No bound on x is printed; the joints turn no faster than Section III says.",
        ),
    ]


def matrices(p: Published) -> list[Finding]:
    """Check signs and factors in Eq. 17, 20, 21 and 22."""
    rho, epsilon = p["appendix/rho"], p["appendix/epsilon"]
    scale = rho.value * epsilon.value
    arm = stability_constants(appendix_arm())
    return [
        remark(
            ("appendix/eq17-sign", PLACE),
            "sign of the cross term in the lower bound of Eq. 17",
            "printed + epsilon lambda_M^max ||q|| ||dq||; q.M dq can be negative, so a bound from below needs -",
            MISPRINT,
            "With + the form is a sum of positive terms and needs no condition; the second one printed is that of the "
            "form with -. The sign may be lost in the extracted text.",
        ),
        compares(
            ("appendix/s1-corner", PLACE),
            "corner of S1 against the lower bound of Eq. 17 and its condition",
            "Eq. 17 and rho lambda_Q^min lambda_M^min / 2 - (epsilon lambda_M^max)^2 / 4 > 0 have lambda_M^min / 2; S1 "
            "has lambda_M^min",
            1.0,
            0.5,
            CONTRADICTS,
            unit="lambda_M^min",
            tolerance=0.0,
            note=f"Without effect on an arm like the appendix's, where the other corner is the smaller: lambda_S1^min "
            f"= {arm.s1_min:.4f}, lambda_M^min / 2 = {0.5 * arm.lambda_m_min:.4f}.",
        ),
        compares(
            ("appendix/gain", PLACE),
            "a_1 of Eq. 22 against g_f of Eq. 21",
            f"g_f divides by lambda_R2^min, a_1 by lambda_R1^min = lambda_R2^min / (rho epsilon): a factor of "
            f"{1.0 / scale:.0f}",
            1.0 / scale,
            1.0,
            CONTRADICTS,
            unit="1",
            tolerance=0.0,
            uses=(rho, epsilon),
            note="Eq. 20 leads to R2. In Eq. 21 lambda_R2^min stands under the root, in a_1 lambda_R1^min outside it; "
            "where the root ends may be lost in the extracted text.",
        ),
        remark(
            ("appendix/eq20-square", PLACE),
            "norm of the state in Eq. 20",
            "printed sqrt(||q||^2 + ||dq||); X = [||q||, ||dq||] has sqrt(||q||^2 + ||dq||^2)",
            MISPRINT,
            "The square may be lost in the extracted text.",
        ),
        remark(
            ("appendix/skew", PLACE),
            "dq.(dM/dt - 2 C) dq = 0 with the printed C",
            "both terms are -I2 sin(q2) dq1 dq2 (dq1 + dq2)",
            CONSISTENT,
            "The matrix itself is not skew-symmetric, which the proof does not need.",
        ),
    ]
