"""Totals against their factors, numbers that the paper states more than once, and misprints."""

from repro.paper.checks.finding import CONTRADICTS, MISPRINT, Finding, agreement, remark
from repro.paper.metric_checks import composition
from repro.paper.published import Published


def totals_against_factors(p: Published) -> list[Finding]:
    """Is each Total of Tables 7 and 10 Time x Freq.? One finding a table and one for each Total that is not."""
    checks = composition(p)
    found = []
    for place, cells in checks.groupby("place", sort=False):
        agree, all_ = int(cells["agrees"].sum()), len(cells)
        ids = tuple(i.replace("/total/", f"/{q}/") for i in cells["id"] for q in ("time", "frequency", "total"))
        found.append(
            Finding(
                f"composition/{ids[0].split('/')[0]}",
                str(place),
                "Totals that are Time x Freq. to rounding",
                f"{agree} of {all_}",
                agree,
                all_,
                0.0,
                "totals",
                agreement(agree, all_, 0.0),
                "Algorithm 2 multiplies the two similarities; its power 0.4 is in the printed factors already.",
                ids,
            )
        )
    for cell in checks[~checks["agrees"]].itertuples():
        ids = tuple(str(cell.id).replace("/total/", f"/{q}/") for q in ("time", "frequency", "total"))
        time, frequency, total = (p[i] for i in ids)
        product = time.value * frequency.value / 100.0
        found.append(
            Finding(
                f"composition/{cell.id}",
                str(cell.place),
                f"Total of {cell.case}, {cell.method}, joint {cell.joint}",
                f"{time.printed} % x {frequency.printed} % = {product:.3f} %",
                product,
                total.value,
                float(str(cell.tolerance)),
                "%",
                CONTRADICTS,
                "Which of the three numbers is wrong is not known.",
                ids,
            )
        )
    return found


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
    """Numbers stated more than once: the same each time?"""
    found = []
    for what, ids in REPEATED.items():
        values = [p[i] for i in ids]
        least, most = min(v.value for v in values), max(v.value for v in values)
        found.append(
            Finding(
                f"repeated/{ids[0]}",
                ", ".join(dict.fromkeys(v.place for v in values)),
                f"{what}: stated {len(values)} times",
                " = ".join(v.text or v.printed for v in values),
                most,
                least,
                0.0,
                values[0].unit,
                agreement(most, least, 0.0),
                "",
                ids,
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
    """Misprints that can be told from the text."""
    return [remark(id_, place, what, why, MISPRINT, note) for id_, place, what, why, note in _MISPRINTS]
