"""Printed tables against each other and against the text: similarities, repeated numbers, misprints."""

import math

import numpy as np

from repro.model.parameters import NAMES
from repro.paper.appendix import FreeChoices
from repro.paper.checks.finding import (
    CONSISTENT,
    CONTRADICTS,
    IN_PART,
    MISPRINT,
    OPEN,
    QUESTIONABLE,
    Finding,
    compares,
    equals,
    remark,
)
from repro.paper.metric_checks import abstract_check, composition, torque_bounds
from repro.paper.published import NUMERIC_CASES, Published, PublishedValue, parameter_id
from repro.signals.metric import TIME_FORMULAS, MetricSettings

VALIDATION = ("T1", "T2", "T3", "T4")
JOINTS = (1, 2)
#: Interpretations of the time factor, by the formula of the metric.
TIME_FACTORS = {"energy": "energy ratio", "mean-square": "mean square"}


def _cells(total: str) -> tuple[str, ...]:
    """Ids of Time, Freq. and Total of a cell, by the id of its Total."""
    return tuple(total.replace("/total/", f"/{quantity}/") for quantity in ("time", "frequency", "total"))


def totals_against_factors(p: Published) -> list[Finding]:
    """Compare each Total of Tables 7 and 10 with Time x Freq.: one finding a table, and one for each that differs."""
    checks = composition(p)
    found = []
    for place, cells in checks.groupby("place", sort=False):
        agree, all_ = int(cells["agrees"].sum()), len(cells)
        ids = tuple(id_ for total in cells["id"] for id_ in _cells(total))
        found.append(
            equals(
                (f"composition/{ids[0].split('/')[0]}", str(place)),
                "Totals that are Time x Freq. to rounding",
                f"{agree} of {all_}",
                agree,
                printed=all_,
                tolerance=0.0,
                unit="totals",
                uses=ids,
                note="Algorithm 2 multiplies the two similarities; its power 0.4 is in the printed factors already.",
            )
        )
    for cell in checks[~checks["agrees"]].itertuples():
        time, frequency, total = (p[id_] for id_ in _cells(str(cell.id)))
        product = time.value * frequency.value / 100.0
        found.append(
            compares(
                (f"composition/{cell.id}", str(cell.place)),
                f"Total of {cell.case}, {cell.method}, joint {cell.joint}",
                f"{time.printed} % x {frequency.printed} % = {product:.3f} %",
                product,
                total.value,
                CONTRADICTS,
                tolerance=float(str(cell.tolerance)),
                unit="%",
                uses=(time, frequency, total),
                note="Which of the three numbers is wrong is not known.",
            )
        )
    return found


def _totals(p: Published, method: str, cases: tuple[str, ...]) -> list[PublishedValue]:
    """Totals of Table 10, case by case, joint 1 before joint 2."""
    return [p[f"table10/{case}/{method}/total/joint{j}"] for case in cases for j in JOINTS]


def _all_or_part(count: int, of: int) -> str:
    return CONSISTENT if count == of else IN_PART


def numeric_claims(p: Published) -> list[Finding]:
    """Score the published pairs on Eq. 10, against 97.38 % of the abstract and 97 % of Section VI."""
    found = []
    pairs = [
        parameter_id(case, method, name)
        for case in NUMERIC_CASES
        for method in ("true", "algorithm1")
        for name in NAMES
    ]
    for formula in TIME_FORMULAS:
        totals = 100.0 * abstract_check(p, MetricSettings(time_formula=formula)).cells["total"]
        for stated in (p["abstract/numeric/total"], p["section6/numeric/total"]):
            over = int((totals > stated.value).sum())
            found.append(
                compares(
                    (f"{stated.id}/{formula}", stated.place),
                    f"numeric similarities overcome {stated.printed} % (time factor read as {TIME_FACTORS[formula]})",
                    f"pairs of Tables 4 and 5 on Eq. 10: {over} of {len(totals)} totals above {stated.printed} %; "
                    f"mean {totals.mean():.2f}, smallest {totals.min():.2f}",
                    float(totals.min()),
                    stated.value,
                    _all_or_part(over, len(totals)),
                    tolerance=stated.half_step,
                    unit="%",
                    uses=(stated, *pairs),
                    note="Rests on our reading of Algorithm 2, whose listing is lost, as is Table 6.",
                )
            )
    return found


def experimental_claims(p: Published) -> list[Finding]:
    """Compare 93.55 %, 93 %, 93.91 % and the threshold, which the text states, with Table 10."""
    identification, validation = _totals(p, "algorithm1", ("ID",)), _totals(p, "algorithm1", VALIDATION)
    both = (*identification, *validation)
    abstract, conclusion = p["abstract/experimental/total"], p["section7/experimental/total"]
    discussion, threshold = p["section6/experimental/total"], p["section6/experimental/threshold"]
    least, best = min(identification, key=lambda v: v.value), max(validation, key=lambda v: v.value)
    below = sum(v.value < abstract.value for v in validation)
    above = sum(v.value > discussion.value for v in validation)
    mean = float(np.mean([v.value for v in identification]))
    return [
        compares(
            abstract,
            f"experimental similarity is over {abstract.printed} %",
            f"smallest on ID {least.printed}, on T1 to T4 {min(v.value for v in validation):.2f}; "
            f"{below} of {len(validation)} validation totals are below {abstract.printed}",
            min(v.value for v in both),
            abstract.value,
            CONSISTENT if below == 0 and least.value >= abstract.value else IN_PART,
            tolerance=abstract.half_step,
            unit="%",
            uses=(abstract, *both),
            note="True of the identification trajectory only, where the smaller total is that number itself.",
        ),
        equals(
            conclusion,
            f"validation similarity is up to {conclusion.printed} %",
            f"largest total on T1 to T4: {best.printed}; on ID: {max(v.value for v in identification):.2f}",
            best.value,
            tolerance=conclusion.half_step + best.half_step,
            uses=(conclusion, *both),
            note="Right for the validation trajectories, of which it speaks; the identification trajectory has more.",
        ),
        compares(
            discussion,
            f"a rebuilt torque overcomes {discussion.printed} %",
            f"{above} of {len(validation)} validation totals are above {discussion.printed} %",
            above,
            len(validation),
            _all_or_part(above, len(validation)),
            tolerance=0.0,
            unit="totals",
            uses=(discussion, *validation),
        ),
        compares(
            threshold,
            f"the result passes the threshold of {threshold.printed} %",
            f"({' + '.join(v.printed for v in identification)}) / 2 = {mean:.2f} %",
            mean,
            threshold.value,
            CONSISTENT if mean > threshold.value else CONTRADICTS,
            unit="%",
            uses=(threshold, *identification),
            note="Line 27 of Algorithm 1 averages both joints; line 16 asks for more than the threshold.",
        ),
    ]


def comparison_with_least_squares(p: Published) -> list[Finding]:
    """Is Algorithm 1 better than least squares, as the abstract says?"""
    found = []
    for name, cases in (("identification", ("ID",)), ("validation", VALIDATION)):
        ours, theirs = _totals(p, "algorithm1", cases), _totals(p, "least-squares", cases)
        better = sum(a.value > b.value for a, b in zip(ours, theirs, strict=True))
        mean = [float(np.mean([v.value for v in side])) for side in (ours, theirs)]
        note = (
            "The abstract says better identification; Section V-C grants least squares joint 1 of ID, and its "
            "mean over both joints is the larger one too."
        )
        found.append(
            compares(
                (f"least-squares/{name}", "Table 10"),
                f"Algorithm 1 has the larger total on {', '.join(cases)}",
                f"{better} of {len(ours)} totals are larger; means {mean[0]:.3f} and {mean[1]:.3f} %",
                better,
                len(ours),
                _all_or_part(better, len(ours)),
                tolerance=0.0,
                unit="totals",
                uses=(*ours, *theirs),
                note=note if name == "identification" else "",
            )
        )
    return found


def coulomb_friction(p: Published) -> list[Finding]:
    """Compare the largest torques that the printed pairs of T1 and T4 permit for joint 1 with the Coulomb friction."""
    cases = ("T1", "T4")
    bounds = torque_bounds(p).set_index(["case", "joint"])["largest_mean_square"]
    largest = {case: math.sqrt(bounds[case, 1]) for case in cases}
    other = math.sqrt(bounds["T1", 2])
    least = min(largest.values())
    coupling, epsilon = p["appendix/coupling"], p["appendix/epsilon"]
    friction = 2.0 * math.sqrt(coupling.value) / epsilon.value
    ours = FreeChoices().k1
    pairs = [
        f"table10/{case}/{method}/{factor}/joint1"
        for case in cases
        for method in ("algorithm1", "least-squares")
        for factor in ("time", "frequency")
    ]
    return [
        compares(
            ("table10/coulomb-friction", "Table 10"),
            "the torque of joint 1 on T1 and T4 can overcome the largest Coulomb friction",
            f"rms torque at most {' and '.join(f'{torque:.3f}' for torque in largest.values())} N m; "
            f"2 sqrt({coupling.printed}) / {epsilon.printed} = {friction:.4f} N m of viscous and Coulomb friction, the "
            f"larger part is Coulomb friction: {0.5 * friction:.3f} to {friction:.3f} N m",
            least,
            0.5 * friction,
            CONTRADICTS if least < 0.5 * friction else QUESTIONABLE if least < friction else CONSISTENT,
            unit="N m",
            uses=(*pairs, coupling, epsilon),
            note="Assumes a time factor of the mean square in N m; Table 9 is lost. A joint that moves needs an rms "
            f"torque of about its Coulomb friction. The pairs therefore require a k1 of about {least:.2f} N m or less, "
            f"or a joint that hardly moves. A smaller k1 satisfies the appendix too; {ours:g}, the choice of this "
            f"project, satisfies the appendix only. The same bound for joint 2 on T1 is {other:.3f} N m.",
        )
    ]


def lost_table(p: Published) -> list[Finding]:
    """Compare Table 6 with the threshold of the numeric tests: it is lost."""
    stated, threshold = p["abstract/numeric/total"], p["section6/numeric/threshold"]
    return [
        remark(
            ("table06", "Table 6"),
            "the numeric totals themselves",
            f"abstract: over {stated.printed} %; threshold of the tests: {threshold.printed} %",
            OPEN,
            "Table 6 is lost with its picture, so the abstract's figure cannot be held against it.",
            (stated, threshold),
        )
    ]


#: Numbers that the paper states more than once, by what they are.
REPEATED = {
    "sampling period": (
        "section3/sampling-period",
        "section4a/sampling-period",
        "section4c/sampling-period",
        "section7/sampling-period",
    ),
    "filter coefficient": ("section4c/filter-coefficient", "table08/cf/joint1", "table08/cf/joint2"),
    "training iterations": ("section4b/iterations", "section5a/iterations"),
    "training parameter sets": ("section5a/parameter-sets", "section6/parameter-sets"),
    "image rows": ("section4a/image/rows", "section4b/input/rows", "section6/image/rows", "eq08/samples"),
    "lower end of the guesses": ("section4a/guess-low", "section4c/guess-low", "algorithm1/guess-low"),
    "upper end of the guesses": ("section4a/guess-high", "section4c/guess-high", "algorithm1/guess-high"),
    "saturation of the torque": (
        "section3/torque-high",
        "fig03/saturation/joint1",
        "fig03/saturation/joint2",
        "section5c/full-count/joint1",
        "section5c/full-count/joint2",
    ),
    "motor voltage": ("section3/motor-voltage", "section5c/power-voltage"),
    "outputs of the network": ("section4b/outputs", "section4b/loss-terms", "algorithm1/guesses"),
    "smaller total on ID": ("abstract/experimental/total", "table10/ID/algorithm1/total/joint1"),
    "larger total on validation": ("section7/experimental/total", "table10/T3/algorithm1/total/joint1"),
}


def repeated_numbers(p: Published) -> list[Finding]:
    """Check that a number stated more than once is the same each time."""
    found = []
    for what, ids in REPEATED.items():
        values = [p[i] for i in ids]
        least, most = min(v.value for v in values), max(v.value for v in values)
        found.append(
            equals(
                (f"repeated/{ids[0]}", ", ".join(dict.fromkeys(v.place for v in values))),
                f"{what}: stated {len(values)} times",
                " = ".join(v.text or v.printed for v in values),
                most,
                printed=least,
                tolerance=0.0,
                unit=values[0].unit,
                uses=ids,
            )
        )
    return found


#: id, place, what is printed, why it cannot be meant, note.
_MISPRINTS = (
    (
        "eq01/coulomb",
        "Eq. 1",
        "Coulomb friction K tanh(lambda q)",
        "friction opposes velocity: K tanh(lambda dq); Appendix A has gamma lambda lambda_K^min in the corner of R1 "
        "that multiplies ||dq||^2",
        "The dot may be lost in the extracted text, which keeps the others of the equation.",
    ),
    (
        "table04/unit-b",
        "Table 4, Table 5",
        "unit of b1 and b2: kg m^2 s",
        "b dq in N m = kg m^2/s^2, dq in 1/s, so b in kg m^2/s",
        "g and k are printed in kg m^2/s^2 = N m, as they must be.",
    ),
    (
        "section4a/image-classes",
        "Section IV-A",
        "two sentences that tell the kinds of training image apart name M_n both times",
        "M_p is labelled with zero residuals, so the first, where the parameters match, is M_p",
        "",
    ),
    (
        "section4b/relu",
        "Section IV-B",
        "ReLU and sigmoid both by Eq. 13",
        "Eq. 12 is max(z, 0), Eq. 13 the sigmoid",
        "",
    ),
    (
        "table04/caption",
        "Table 4",
        "N1 and N1 are the numeric tests 1 and 2",
        "its columns are N1 and N2",
        "",
    ),
    (
        "section6/table09",
        "Section VI",
        "Table 9 for what metr2ev shows in frequency",
        "Table 9 holds parameters; the similarities are in Table 10",
        "",
    ),
)


def misprints() -> list[Finding]:
    """List the misprints that the text itself shows."""
    return [remark((id_, place), what, why, MISPRINT, note) for id_, place, what, why, note in _MISPRINTS]
