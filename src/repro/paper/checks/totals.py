"""The Totals of Tables 7 and 10 against the factors printed with them."""

from repro.paper.checks.finding import CONTRADICTS, Finding, agreement
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
