"""The published test arms: can they exist, and could the published ranges have made them?"""

import numpy as np

from repro.model.parameters import NAMES, STANDARD_GRAVITY, Array, Links, inertial_from_links, is_positive_definite
from repro.paper.checks.finding import CONSISTENT, NOT_POSSIBLE, OUTSIDE, Finding, compares
from repro.paper.published import NUMERIC_CASES, Published, parameter_id

RANGES = tuple(f"section4a/{name}-{end}" for name in ("length", "mass") for end in ("low", "high"))


def _ids(case: str, method: str, names: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(parameter_id(case, method, name) for name in names)


def definiteness(p: Published) -> list[Finding]:
    """Is M(q) positive definite for every q2? One finding for each true set and each published estimate."""
    found = []
    for method, words in (("true", "true parameters"), ("algorithm1", "published estimate")):
        for case, beta in zip(NUMERIC_CASES, p.parameter_sets(method), strict=True):
            i1, i2, i3 = beta[:3]
            determinant = float(i3 * (i1 - i3) - 0.25 * i2**2)
            note = "I1 is not above I3: more inertia about joint 2 than about joint 1." if i1 <= i3 else ""
            if method == "algorithm1":
                note = f"Line 22 of Algorithm 1 rejects what is not physically possible. {note}".strip()
            found.append(
                compares(
                    (f"definite/{case}/{method}", f"Table {4 if case in NUMERIC_CASES[:2] else 5}"),
                    f"inertia matrix of {case}, {words}: positive definite for every q2",
                    f"I3 (I1 - I3) - I2^2/4 = {i3:.4f} x ({i1:.4f} - {i3:.4f}) - {i2:.4f}^2/4 = {determinant:.4f}",
                    determinant,
                    0.0,
                    CONSISTENT if is_positive_definite(beta) else NOT_POSSIBLE,
                    unit="kg^2 m^4",
                    uses=_ids(case, method, ("I1", "I2", "I3")),
                    note=note,
                )
            )
    return found


def _link_limits(p: Published) -> tuple[Array, Array]:
    """Smallest and largest (I1, I2, I3, g1, g2, I1 - I3) that Section IV-A's ranges allow.

    Each rises with every link quantity, so the ends of the ranges give the ends; I1 - I3 = m1 lc1^2 + J1 + m2 l1^2 too.
    """
    ends = []
    for end in ("low", "high"):
        length, mass = p[f"section4a/length-{end}"].value, p[f"section4a/mass-{end}"].value
        links = Links(m1=mass, m2=mass, l1=length, lc1=length, lc2=length, j1=length, j2=mass)
        made = inertial_from_links(links)
        ends.append(np.append(made, 2.0 * mass * length**2 + length))
    return ends[0], ends[1]


def training_ranges(p: Published) -> list[Finding]:
    """Could the published ranges have made N1 to N4?"""
    low, high = _link_limits(p)
    true = p.parameter_sets("true")
    values = np.column_stack([true[:, :5], true[:, 0] - true[:, 2]])
    length, mass = p["section4a/length-high"].printed, p["section4a/mass-high"].printed
    formulas = {
        "I1": f"m1 lc1^2 + J1 + m2 l1^2 + m2 lc2^2 + J2 <= 3 x {mass} x {length}^2 + {length} + {mass}",
        "I2": f"2 m2 l1 lc2 <= 2 x {mass} x {length} x {length}",
        "I3": f"m2 lc2^2 + J2 <= {mass} x {length}^2 + {mass}",
        "g1": f"(m1 lc1 + m2 l1) g <= 2 x {mass} x {length} x {STANDARD_GRAVITY}",
        "g2": f"m2 lc2 g <= {mass} x {length} x {STANDARD_GRAVITY}",
        "I1 - I3": f"m1 lc1^2 + J1 + m2 l1^2 <= 2 x {mass} x {length}^2 + {length}",
    }
    found = []
    for k, (name, formula) in enumerate(formulas.items()):
        parts = tuple(name.split(" - "))
        v = values[:, k]
        outside = int(((v < low[k]) | (v > high[k])).sum())
        farthest = v[np.argmax(np.maximum(v - high[k], low[k] - v))] if outside else v.max()
        found.append(
            compares(
                (f"range/{name.replace(' ', '')}", "Section IV-A"),
                f"{name} of N1 to N4 within what the ranges of the training links allow",
                f"{formula} = {high[k]:.4g}, >= {low[k]:.3g}; N1 to N4: {', '.join(f'{x:.4f}' for x in v)}",
                float(high[k]),
                float(farthest),
                OUTSIDE if outside else CONSISTENT,
                unit="kg m^2/s^2" if name[0] == "g" else "kg m^2",
                uses=(*RANGES, *(i for case in NUMERIC_CASES for i in _ids(case, "true", parts))),
                note=f"{outside} of 4 arms lie outside; the value printed here is the farthest." if outside else "",
            )
        )
    return [*found, _friction(p, true), _link_one(p, true), _reach(p)]


def _friction(p: Published, true: Array) -> Finding:
    """Friction b and k of the true sets against the range of the friction coefficients."""
    low, high = p["section4a/friction-low"], p["section4a/friction-high"]
    least, most = float(true[:, 5:].min()), float(true[:, 5:].max())
    return compares(
        ("range/friction", "Section IV-A"),
        "friction of N1 to N4 within the published range",
        f"{low.printed} <= {least:.4f} and {most:.4f} <= {high.printed}",
        most,
        high.value,
        CONSISTENT if low.value <= least and most <= high.value else OUTSIDE,
        unit="SI",
        uses=(low, high, *(i for case in NUMERIC_CASES for i in _ids(case, "true", NAMES[5:]))),
    )


def _link_one(p: Published, true: Array) -> Finding:
    """Length of link 1 that I2 and g2 imply: I2 / g2 = 2 l1 / g whatever the masses."""
    l1 = true[:, 1] * STANDARD_GRAVITY / (2.0 * true[:, 4])
    limit = p["section4a/length-high"]
    return compares(
        ("range/l1", "Section IV-A"),
        "length of link 1 that N1 to N4 imply",
        f"l1 = I2 g / (2 g2) = {', '.join(f'{x:.2f}' for x in l1)} m; range ends at {limit.printed} m",
        float(l1.min()),
        limit.value,
        OUTSIDE if (l1 > limit.value).any() else CONSISTENT,
        unit="m",
        uses=(limit, *(i for case in NUMERIC_CASES for i in _ids(case, "true", ("I2", "g2")))),
        note="Found is the shortest. Eq. 1 fixes the ratio, so no masses can mend it.",
    )


def _reach(p: Published) -> Finding:
    """Reach of the real arm against link lengths of the training data."""
    tip, speed, limit = p["section3/tip-speed"], p["section3/joint-speed"], p["section4a/length-high"]
    reach, longest = tip.value / speed.value, 3.0 * limit.value
    return compares(
        ("range/reach", "Section III"),
        "reach of the real arm within the training range of the lengths",
        f"{tip.printed} / {speed.printed} = {reach:.3f} m = l1 + l2 (joint 1 at full speed) or l1 + 2 l2 (both); "
        f"the ranges allow {2.0 * limit.value:.3g} or {longest:.3g} m",
        reach,
        longest,
        CONSISTENT if reach <= longest else OUTSIDE,
        unit="m",
        uses=(tip, speed, limit),
        note="Held against the larger of the two.",
    )
