"""What the text says of the similarities (abstract, Sections VI and VII) against the tables that print them."""

import math

import numpy as np

from repro.model.parameters import NAMES
from repro.paper.appendix import FreeChoices
from repro.paper.checks.finding import (
    CONSISTENT,
    CONTRADICTS,
    IN_PART,
    OPEN,
    QUESTIONABLE,
    Finding,
    agreement,
    remark,
)
from repro.paper.metric_checks import abstract_check, torque_bounds
from repro.paper.published import NUMERIC_CASES, Published, PublishedValue
from repro.signals.metric import TIME_FORMULAS, MetricSettings

VALIDATION = ("T1", "T2", "T3", "T4")
JOINTS = (1, 2)
READINGS = {"energy": "energy ratio", "mean-square": "mean square"}


def _totals(p: Published, method: str, cases: tuple[str, ...]) -> list[PublishedValue]:
    """Totals of Table 10, case by case, joint 1 before joint 2."""
    return [p[f"table10/{case}/{method}/total/joint{j}"] for case in cases for j in JOINTS]


def _share(count: int, of: int) -> str:
    return CONSISTENT if count == of else IN_PART


def numeric_claims(p: Published) -> list[Finding]:
    """97.38 % of the abstract and 97 % of Section VI: the published pairs scored on Eq. 10."""
    found = []
    pairs = tuple(
        f"table0{4 if case in NUMERIC_CASES[:2] else 5}/{case}/{method}/{name}"
        for case in NUMERIC_CASES
        for method in ("true", "algorithm1")
        for name in NAMES
    )
    for formula in TIME_FORMULAS:
        check = abstract_check(p, MetricSettings(time_formula=formula))
        totals = 100.0 * check.cells["total"]
        for id_, claim in (("abstract/numeric/total", "Abstract"), ("section6/numeric/total", "Section VI")):
            stated = p[id_]
            over = int((totals > stated.value).sum())
            verdict = _share(over, len(totals))
            found.append(
                Finding(
                    f"{id_}/{formula}",
                    claim,
                    f"numeric similarities overcome {stated.printed} % (time factor read as {READINGS[formula]})",
                    f"pairs of Tables 4 and 5 on Eq. 10: {over} of {len(totals)} totals above {stated.printed} %; "
                    f"mean {totals.mean():.2f}, smallest {totals.min():.2f}",
                    float(totals.min()),
                    stated.value,
                    stated.half_step,
                    "%",
                    verdict,
                    "Rests on our reading of Algorithm 2, whose listing is lost, as is Table 6.",
                    (id_, *pairs),
                )
            )
    return found


def experimental_claims(p: Published) -> list[Finding]:
    """93.55 % of the abstract, 93 %, 93.91 % and the threshold of Sections VI and VII, against Table 10."""
    identification, validation = _totals(p, "algorithm1", ("ID",)), _totals(p, "algorithm1", VALIDATION)
    found = []
    stated = p["abstract/experimental/total"]
    least = min(identification, key=lambda v: v.value)
    below = sum(v.value < stated.value for v in validation)
    found.append(
        Finding(
            "abstract/experimental/total",
            "Abstract",
            f"experimental similarity is over {stated.printed} %",
            f"smallest on ID {least.printed}, on T1 to T4 {min(v.value for v in validation):.2f}; "
            f"{below} of {len(validation)} validation totals are below {stated.printed}",
            min(v.value for v in (*identification, *validation)),
            stated.value,
            stated.half_step,
            "%",
            CONSISTENT if below == 0 and least.value >= stated.value else IN_PART,
            "True of the identification trajectory only, where the smaller total is that number itself.",
            (stated.id, *(v.id for v in (*identification, *validation))),
        )
    )
    stated = p["section7/experimental/total"]
    best = max(validation, key=lambda v: v.value)
    found.append(
        Finding(
            stated.id,
            stated.place,
            f"validation similarity is up to {stated.printed} %",
            f"largest total on T1 to T4: {best.printed}; on ID: {max(v.value for v in identification):.2f}",
            best.value,
            stated.value,
            stated.half_step + best.half_step,
            "%",
            agreement(best.value, stated.value, stated.half_step + best.half_step),
            "Right for the validation trajectories, of which it speaks; the identification trajectory has more.",
            (stated.id, *(v.id for v in (*identification, *validation))),
        )
    )
    stated = p["section6/experimental/total"]
    above = sum(v.value > stated.value for v in validation)
    found.append(
        Finding(
            stated.id,
            stated.place,
            f"a rebuilt torque overcomes {stated.printed} %",
            f"{above} of {len(validation)} validation totals are above {stated.printed} %",
            above,
            len(validation),
            0.0,
            "totals",
            _share(above, len(validation)),
            "",
            (stated.id, *(v.id for v in validation)),
        )
    )
    threshold = p["section6/experimental/threshold"]
    mean = float(np.mean([v.value for v in identification]))
    found.append(
        Finding(
            threshold.id,
            threshold.place,
            f"the result passes the threshold of {threshold.printed} %",
            f"({' + '.join(v.printed for v in identification)}) / 2 = {mean:.2f} %",
            mean,
            threshold.value,
            math.nan,
            "%",
            CONSISTENT if mean > threshold.value else CONTRADICTS,
            "Line 27 of Algorithm 1 averages both joints; line 16 asks for more than the threshold.",
            (threshold.id, *(v.id for v in identification)),
        )
    )
    return found


def comparison_with_least_squares(p: Published) -> list[Finding]:
    """Is Algorithm 1 better than least squares, as the abstract says?"""
    found = []
    for name, cases in (("identification", ("ID",)), ("validation", VALIDATION)):
        ours, theirs = _totals(p, "algorithm1", cases), _totals(p, "least-squares", cases)
        better = sum(a.value > b.value for a, b in zip(ours, theirs, strict=True))
        mean = [float(np.mean([v.value for v in side])) for side in (ours, theirs)]
        found.append(
            Finding(
                f"least-squares/{name}",
                "Table 10",
                f"Algorithm 1 has the larger total on {', '.join(cases)}",
                f"{better} of {len(ours)} totals are larger; means {mean[0]:.3f} and {mean[1]:.3f} %",
                better,
                len(ours),
                0.0,
                "totals",
                _share(better, len(ours)),
                "The abstract says better identification; Section V-C grants least squares joint 1 of ID, and its "
                "mean over both joints is the larger one too."
                if name == "identification"
                else "",
                tuple(v.id for v in (*ours, *theirs)),
            )
        )
    return found


def coulomb_friction(p: Published) -> list[Finding]:
    """Largest torques that the printed pairs of T1 and T4 permit for joint 1, against the Coulomb friction."""
    cases = ("T1", "T4")
    bounds = torque_bounds(p).set_index(["case", "joint"])["largest_mean_square"]
    largest = {case: math.sqrt(bounds[case, 1]) for case in cases}
    other = math.sqrt(bounds["T1", 2])
    least = min(largest.values())
    coupling, epsilon = p["appendix/coupling"], p["appendix/epsilon"]
    friction = 2.0 * math.sqrt(coupling.value) / epsilon.value
    ours = FreeChoices().k1
    verdict = CONTRADICTS if least < 0.5 * friction else QUESTIONABLE if least < friction else CONSISTENT
    pairs = tuple(
        f"table10/{case}/{method}/{factor}/joint1"
        for case in cases
        for method in ("algorithm1", "least-squares")
        for factor in ("time", "frequency")
    )
    return [
        Finding(
            "table10/coulomb-friction",
            "Table 10",
            "the torque of joint 1 on T1 and T4 can overcome the largest Coulomb friction",
            f"rms torque at most {' and '.join(f'{torque:.3f}' for torque in largest.values())} N m; "
            f"2 sqrt({coupling.printed}) / {epsilon.printed} = {friction:.4f} N m of viscous and Coulomb friction, the "
            f"larger part is Coulomb friction: {0.5 * friction:.3f} to {friction:.3f} N m",
            least,
            0.5 * friction,
            math.nan,
            "N m",
            verdict,
            "Assumes a time factor of the mean square in N m; Table 9 is lost. A joint that moves needs an rms torque "
            f"of about its Coulomb friction. The pairs therefore require a k1 of about {least:.2f} N m or less, or a "
            f"joint that hardly moves. A smaller k1 satisfies the appendix too; {ours:g}, the choice of this project, "
            f"satisfies the appendix only. The same bound for joint 2 on T1 is {other:.3f} N m.",
            (*pairs, coupling.id, epsilon.id),
        )
    ]


def lost_table(p: Published) -> list[Finding]:
    """Table 6 against the threshold of the numeric tests: lost."""
    stated, threshold = p["abstract/numeric/total"], p["section6/numeric/threshold"]
    return [
        remark(
            "table06",
            "Table 6",
            "the numeric totals themselves",
            f"abstract: over {stated.printed} %; threshold of the tests: {threshold.printed} %",
            OPEN,
            "Table 6 is lost with its picture, so the abstract's figure cannot be held against it.",
            (stated.id, threshold.id),
        )
    ]
