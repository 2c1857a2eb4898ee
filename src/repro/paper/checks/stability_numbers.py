"""Six numbers of Appendix A against each other.

The identified arm is lost with Table 9, but the numbers over-determine what they are made of: with R2 = rho
epsilon R1, both eigenvalues, the product of the diagonal and the square of the other corner of R1 are printed.
"""

import math

from repro.paper.appendix import APPENDIX_NUMBERS, appendix_arm, appendix_numbers, reproduced
from repro.paper.checks.finding import CONSISTENT, CONTRADICTS, Finding, agreement
from repro.paper.published import Published

PLACE = "Appendix A"


def _ids(*names: str) -> tuple[str, ...]:
    return tuple(f"appendix/{name}" for name in names)


def numbers_against_each_other(p: Published) -> list[Finding]:
    """Relations between the six numbers that need no arm, and whether one arm gives all of them."""
    n = appendix_numbers(p)
    rho, epsilon = p["appendix/rho"].value, p["appendix/epsilon"].value
    scale = rho * epsilon
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
        Finding(
            "appendix/determinant",
            PLACE,
            "determinant of R1 from its eigenvalues and from the sides of Eq. 18's condition",
            f"{n['r1_min'].printed} x {n['r2_max'].printed} / {scale:g} = {determinant:.5e}; "
            f"{n['dissipation'].printed} - {n['coupling'].printed} = {product:.5e}",
            determinant,
            product,
            tolerance,
            "(N m)^2",
            agreement(determinant, product, tolerance),
            "",
            _ids("r1_min", "r2_max", "dissipation", "coupling", "rho", "epsilon"),
        ),
        Finding(
            "appendix/corner",
            PLACE,
            "lambda_Q^min from R1's corner, which is printed with D for Q",
            f"smaller root of x^2 - {trace:.5e} x + {n['dissipation'].printed}, over {scale:g}: {lambda_q:.5f}, so rho "
            f"lambda_Q^min = {rho * lambda_q:.6f}",
            rho * lambda_q,
            potential.value,
            potential.half_step,
            "N m",
            agreement(rho * lambda_q, potential.value, potential.half_step),
            "D stands nowhere else in the paper; the numbers are those of Q.",
            _ids("r1_min", "r2_max", "dissipation", "potential", "rho", "epsilon"),
        ),
        Finding(
            "appendix/condition",
            PLACE,
            "smallest eigenvalue of R1 above the largest of R2 = rho epsilon R1",
            f"the same as lambda_R1^max / lambda_R1^min < 1 / (rho epsilon): {r1_max:.5e} / {n['r1_min'].printed} = "
            f"{condition:.0f} < {1.0 / scale:.0f}",
            condition,
            1.0 / scale,
            math.nan,
            "1",
            CONSISTENT if condition < 1.0 / scale else CONTRADICTS,
            "",
            _ids("r1_min", "r2_max", "rho", "epsilon"),
        ),
        Finding(
            "appendix/rate",
            PLACE,
            "condition of Eq. 18",
            f"{n['dissipation'].printed} > {n['coupling'].printed}",
            n["dissipation"].value,
            n["coupling"].value,
            math.nan,
            "(N m)^2",
            CONSISTENT if n["dissipation"].value > n["coupling"].value else CONTRADICTS,
            "",
            _ids("dissipation", "coupling"),
        ),
        _arm(p),
    ]


def _arm(p: Published) -> Finding:
    """Is there a physical arm that gives all six numbers?"""
    try:
        beta = appendix_arm(published=p)
    except ValueError as error:
        count, words = 0, f"no physical arm: {error}"
    else:
        count = sum(reproduced(beta, p).values())
        words = f"beta = ({', '.join(f'{x:.4g}' for x in beta)}) gives {count} of {len(APPENDIX_NUMBERS)}"
    return Finding(
        "appendix/arm",
        PLACE,
        "a physical arm that gives all six numbers to their last digit",
        words,
        count,
        len(APPENDIX_NUMBERS),
        0.0,
        "numbers",
        agreement(count, len(APPENDIX_NUMBERS), 0.0),
        "One member of a family with five free parameters; evaluated with the paper's own rho, epsilon and gamma.",
        _ids(*APPENDIX_NUMBERS),
    )
