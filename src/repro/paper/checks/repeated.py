"""Numbers that the paper states more than once."""

from repro.paper.checks.finding import Finding, agreement
from repro.paper.published import Published

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
