"""Audit of the paper: its printed numbers and formulas against each other, each check with its arithmetic.

The audit uses the paper only, not our results. A check either computes a printed number from others, or compares a
statement with the numbers it is about; where a part of the paper is lost, the note names what the check assumes. The
texts, and findings about words alone, are in ``findings.csv`` (`repro.paper.finding`).
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd

from repro.model.parameters import NAMES, STANDARD_GRAVITY, Array, Links, inertial_from_links, is_positive_definite
from repro.paper import appendix
from repro.paper.arithmetic_checks import ARITHMETIC
from repro.paper.finding import CONTRADICTS, QUESTIONABLE, Check, Finding, read_checks
from repro.paper.metric_search import abstract_check, composition, torque_bounds
from repro.paper.published import NUMERIC_CASES, Published, PublishedValue, load_published, parameter_id
from repro.signals.metric import MetricSettings, TimeFormula

VALIDATION = ("T1", "T2", "T3", "T4")
#: Interpretations of the time factor, by the formula of the metric.
TIME_FACTORS: dict[TimeFormula, str] = {"mean-square": "mean square", "energy": "energy ratio"}


def _cell(c: Check, total: str) -> tuple[PublishedValue, ...]:
    """Time, Freq. and Total of a cell, by the id of its Total."""
    return tuple(c.published[total.replace("/total/", f"/{name}/")] for name in ("time", "frequency", "total"))


def _totals_of_table(c: Check) -> list[Finding]:
    findings = []
    for place, cells in composition(c.published).groupby("place", sort=False):
        used = [number for total in cells["id"] for number in _cell(c, total)]
        texts = {"table": used[0].id.split("/")[0], "cells_place": place}
        findings.append(c.equals(int(cells["agrees"].sum()), len(cells), 0.0, used, **texts))
    return findings


def _wrong_totals(c: Check) -> list[Finding]:
    cells, findings = composition(c.published), []
    for cell in cells[~cells["agrees"]].to_dict("records"):
        time, frequency, total = used = _cell(c, cell["id"])
        texts: dict[str, Any] = {"tolerance": cell["tolerance"], "time": time, "frequency": frequency, "total": total}
        findings.append(c.compares(cell["product"], total.value, False, uses=used, **texts))
    return findings


def _totals(c: Check, method: str, *cases: str) -> list[PublishedValue]:
    """Totals of Table 10, case by case, joint 1 before joint 2."""
    return [c.published[f"table10/{case}/{method}/total/joint{j}"] for case in cases for j in (1, 2)]


def _numeric_statements(c: Check) -> list[Finding]:
    """Score the published pairs on Eq. 10, against 97.38 % of the abstract and 97 % of Section VI."""
    pairs = [
        parameter_id(case, method, n) for case in NUMERIC_CASES for method in ("true", "algorithm1") for n in NAMES
    ]
    findings = []
    for formula, factor in TIME_FACTORS.items():
        totals = 100.0 * abstract_check(c.published, MetricSettings(time_formula=formula))["total"]
        for stated in (c.published["abstract/numeric/total"], c.published["section6/numeric/total"]):
            over, least = int((totals > stated.value).sum()), float(totals.min())
            findings.append(
                c.compares(
                    least, stated.value, over == len(totals), tolerance=stated.half_step, uses=(stated, *pairs),
                    stated=stated, formula=formula, factor=factor, over=over, of=len(totals), mean=totals.mean(),
                )
            )  # fmt: skip
    return findings


def _abstract_total(c: Check) -> Finding:
    identification, validation = _totals(c, "algorithm1", "ID"), _totals(c, "algorithm1", *VALIDATION)
    both, below = (*identification, *validation), sum(v.value < c.abstract for v in validation)
    least, smallest = min(identification, key=lambda v: v.value), min(v.value for v in both)
    texts: dict[str, Any] = {
        "least": least,
        "least_validation": f"{min(v.value for v in validation):.2f}",
        "below": below,
    }
    tolerance, satisfied = c.numbers["abstract"].half_step, below == 0 and least.value >= c.abstract
    return c.compares(smallest, c.abstract, satisfied, tolerance=tolerance, uses=both, of=len(validation), **texts)


def _conclusion_total(c: Check) -> Finding:
    identification, validation = _totals(c, "algorithm1", "ID"), _totals(c, "algorithm1", *VALIDATION)
    best = max(validation, key=lambda v: v.value)
    best_identification = f"{max(v.value for v in identification):.2f}"
    tolerance, uses = c.numbers["conclusion"].half_step + best.half_step, (*identification, *validation)
    return c.equals(best.value, None, tolerance, uses, best=best, best_identification=best_identification)


def _discussion_total(c: Check) -> Finding:
    validation = _totals(c, "algorithm1", *VALIDATION)
    return c.equals(sum(v.value > c.discussion for v in validation), len(validation), 0.0, validation)


def _against_least_squares(c: Check) -> Finding:
    cases = VALIDATION if c.id.endswith("validation") else ("ID",)
    sides = [_totals(c, method, *cases) for method in ("algorithm1", "least-squares")]
    better = sum(a.value > b.value for a, b in zip(*sides, strict=True))
    ours, theirs = (float(np.mean([v.value for v in side])) for side in sides)
    return c.equals(better, len(sides[0]), 0.0, (*sides[0], *sides[1]), ours=ours, theirs=theirs)


def _coulomb_friction(c: Check) -> Finding:
    """Compare the largest torques that the printed pairs of T1 and T4 permit for joint 1 with the Coulomb friction."""
    bounds = torque_bounds(c.published).set_index(["case", "joint"])["largest_mean_square"]
    t1, t4, joint2 = (math.sqrt(bounds[cell]) for cell in (("T1", 1), ("T4", 1), ("T1", 2)))
    least, friction = min(t1, t4), 2.0 * math.sqrt(c.coupling) / c.epsilon
    verdict = CONTRADICTS if least < 0.5 * friction else QUESTIONABLE
    texts: dict[str, Any] = {"t1": t1, "t4": t4, "joint2": joint2, "k1": appendix.FreeChoices().k1}
    return c.compares(least, 0.5 * friction, least >= friction, verdict=verdict, friction=friction, **texts)


def _definite(c: Check) -> list[Finding]:
    """Is M(q) positive definite for every q2? One finding for each true set or each published estimate."""
    method, findings = c.id.rpartition("/")[2], []
    for case, beta in zip(NUMERIC_CASES, c.published.parameter_sets(method), strict=True):
        i1, i2, i3 = beta[:3]
        order = "I1 is not above I3: more inertia about joint 2 than about joint 1." if i1 <= i3 else ""
        uses = [parameter_id(case, method, name) for name in ("I1", "I2", "I3")]
        texts = {"case": case, "table": 4 if case in NUMERIC_CASES[:2] else 5, "order": order, "i1": i1, "i2": i2}
        found, definite = float(i3 * (i1 - i3) - 0.25 * i2**2), bool(is_positive_definite(beta))
        findings.append(c.compares(found, 0.0, definite, uses=uses, i3=i3, **texts))
    return findings


def _true_ids(*names: str) -> list[str]:
    return [parameter_id(case, "true", name) for case in NUMERIC_CASES for name in names]


def _link_limits(length: float, mass: float) -> Array:
    """Compute (I1, I2, I3, g1, g2, I1 - I3) of links of one length and mass; each rises with every link quantity."""
    inertial = inertial_from_links(Links(m1=mass, m2=mass, l1=length, lc1=length, lc2=length, j1=length, j2=mass))
    return np.append(inertial, 2.0 * mass * length**2 + length)


def _training_ranges(c: Check) -> list[Finding]:
    """Could the published ranges of the links have made N1 to N4?"""
    low, high = _link_limits(c.length_low, c.mass_low), _link_limits(c.length_high, c.mass_high)
    true = c.published.parameter_sets("true")
    values = np.column_stack([true[:, :5], true[:, 0] - true[:, 2]])
    length, mass = c.numbers["length_high"], c.numbers["mass_high"]
    formulas = {
        "I1": f"m1 lc1^2 + J1 + m2 l1^2 + m2 lc2^2 + J2 <= 3 x {mass} x {length}^2 + {length} + {mass}",
        "I2": f"2 m2 l1 lc2 <= 2 x {mass} x {length} x {length}",
        "I3": f"m2 lc2^2 + J2 <= {mass} x {length}^2 + {mass}",
        "g1": f"(m1 lc1 + m2 l1) g <= 2 x {mass} x {length} x {STANDARD_GRAVITY}",
        "g2": f"m2 lc2 g <= {mass} x {length} x {STANDARD_GRAVITY}",
        "I1 - I3": f"m1 lc1^2 + J1 + m2 l1^2 <= 2 x {mass} x {length}^2 + {length}",
    }
    findings = []
    for (name, formula), v, least, most in zip(formulas.items(), values.T, low, high, strict=True):
        count = int(((v < least) | (v > most)).sum())
        outside = f"{count} of 4 arms lie outside; the value printed here is the farthest." if count else ""
        farthest = v[np.argmax(np.maximum(v - most, least - v))] if count else v.max()
        texts = {"id": name.replace(" ", ""), "name": name, "formula": formula, "low": least, "outside": outside}
        texts |= {"range_unit": "N m" if name[0] == "g" else "kg m^2", "values": ", ".join(f"{x:.4f}" for x in v)}
        uses = _true_ids(*name.split(" - "))
        findings.append(c.compares(float(most), float(farthest), count == 0, uses=uses, **texts))
    return findings


def _friction_range(c: Check) -> Finding:
    friction = c.published.parameter_sets("true")[:, 5:]
    least, most = float(friction.min()), float(friction.max())
    return c.compares(most, c.high, c.low <= least and most <= c.high, uses=_true_ids(*NAMES[5:]), least=least)


def _link_one(c: Check) -> Finding:
    """Compute the length of link 1 that I2 and g2 imply: I2 / g2 = 2 l1 / g whatever the masses."""
    true = c.published.parameter_sets("true")
    l1 = true[:, 1] * STANDARD_GRAVITY / (2.0 * true[:, 4])
    lengths = ", ".join(f"{x:.2f}" for x in l1)
    inside = not (l1 > c.limit).any()
    return c.compares(float(l1.min()), c.limit, inside, uses=_true_ids("I2", "g2"), lengths=lengths)


def _repeated(c: Check) -> Finding:
    """Compare a number that is stated more than once with itself."""
    numbers = c.numbers.values()
    places = ", ".join(dict.fromkeys(v.place for v in numbers))
    texts = {"places": places, "values": " = ".join(v.text or v.printed for v in numbers)}
    values, units = zip(*((v.value, v.unit) for v in numbers), strict=True)
    return c.equals(max(values), min(values), 0.0, number_unit=units[0], **texts)


def _trajectory_speed(c: Check) -> Finding:
    t = np.linspace(0.0, c.duration * math.pi, 20001)
    second = (-c.a1 * c.f1 * np.sin(c.f1 * t + c.p1), c.a2 * c.f2 * np.cos(c.f2 * t + c.p2))
    peak1, peak2 = (float(np.abs(first + s).max()) for first, s in zip((np.cos(t), np.sin(t)), second, strict=True))
    return c.compares(max(peak1, peak2), c.speed, max(peak1, peak2) <= c.speed, peak1=peak1, peak2=peak2)


def _map_sizes(c: Check) -> Finding:
    """Follow the sizes of the maps through kernels without padding, and pooling in the first two layers."""
    sizes, fits = [c.side], True
    for layer, kernel in enumerate((c.kernel1, c.kernel2, c.kernel3), start=1):
        sizes.append(sizes[-1] - kernel + 1.0)
        if layer < 3:
            fits &= sizes[-1] % c.pool == 0
            sizes.append(sizes[-1] / c.pool)
    size = sizes[-1]
    whole = fits and size > 0 and size == round(size)
    chain = " -> ".join(f"{each:g}" for each in sizes)
    return c.compares(size, round(size), whole, tolerance=0.0, chain=chain, inputs=size**2 * c.maps)


#: Checks by the id of their row in ``findings.csv``; the other rows are about words or symbols.
CHECKS: dict[str, Callable[[Check], Finding | list[Finding]]] = {
    **ARITHMETIC,
    "composition/{table}": _totals_of_table,
    "composition/{total.id}": _wrong_totals,
    "{stated.id}/{formula}": _numeric_statements,
    "abstract/experimental/total": _abstract_total,
    "section7/experimental/total": _conclusion_total,
    "section6/experimental/total": _discussion_total,
    "least-squares/identification": _against_least_squares,
    "least-squares/validation": _against_least_squares,
    "table10/coulomb-friction": _coulomb_friction,
    "definite/{case}/true": _definite,
    "definite/{case}/algorithm1": _definite,
    "range/{id}": _training_ranges,
    "range/friction": _friction_range,
    "range/l1": _link_one,
    "eq10/speed": _trajectory_speed,
    "section4b/sizes": _map_sizes,
    "appendix/determinant": appendix.determinant,
    "appendix/corner": appendix.corner,
    "appendix/arm": appendix.arm,
    "appendix/cosine": appendix.cosine,
    "appendix/sine": appendix.sine,
    "appendix/tanh": appendix.tanh,
    "appendix/s1-corner": appendix.s1_corner,
    "appendix/s2-corner": appendix.s2_corner,
}


def findings(published: Published) -> tuple[Finding, ...]:
    """Run every check, in the order of ``findings.csv``."""
    found: list[Finding] = []
    for check in read_checks(published):
        function = _repeated if check.id.startswith("repeated/") else CHECKS.get(check.id, Check.in_words)
        result = function(check)
        found += [result] if isinstance(result, Finding) else result
    return tuple(found)


def findings_table() -> pd.DataFrame:
    """Tabulate every finding, with the ids of its published numbers."""
    found = findings(load_published())
    return pd.DataFrame([{**vars(finding), "numbers": " ".join(finding.numbers)} for finding in found])
