"""Do the intervals of the network's estimate cover: tables and rank histograms."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.patches import StepPatch

from repro.model.parameters import NAMES, UNITS
from repro.render import style
from repro.render.experiment_tables import with_unit
from repro.render.markup import Table, Text, formula, number, plain

#: What arms are called that follow Eq. 1, and those that have more.
ARMS = ("Eq. 1", "unmodelled")
_LOOKS = {"raw": ("least-squares", "Spread over the guesses"), "calibrated": ("algorithm1+refinement", "Calibrated")}


def table(frame: pd.DataFrame) -> Table:
    """Shares of arms that intervals cover, a row for each parameter.

    Columns ``arms, parameter, level, raw, calibrated, factor, width, warned``.
    """
    levels = sorted(set(frame["level"]))
    cells = frame.set_index(["arms", "parameter", "level"])
    rows = []
    for name in NAMES:
        row = [formula(name)]
        for arms, column in (("unmodelled", "raw"), ("Eq. 1", "calibrated"), ("unmodelled", "calibrated")):
            row += [number(100.0 * float(cells.loc[(arms, name, level), column]), 0) for level in levels]
        rows.append([*row, number(float(cells.loc[("unmodelled", name, levels[-1]), "width"]), 3)])
    warned = [100.0 * float(frame.loc[frame["arms"] == arms, "warned"].iloc[0]) for arms in ARMS]
    caption = plain(
        "Shares of simulated arms (%) whose true parameter lies in an interval of "
        + ", ".join(f"{100 * level:g}" for level in levels)
        + " %: in the central range of the network's estimates from random guesses (guesses), on arms with torque "
        "beyond Eq. 1; and in the calibrated interval, the median of these estimates plus and minus a multiple of "
        "their spread that covers arms of known parameters, on arms of Eq. 1 alone and with torque beyond it. Last: "
        "median half width of the widest of these, over the largest torque. "
        f"{warned[0]:.1f} % of the arms of Eq. 1 and {warned[1]:.1f} % of the others are warned of as unlike the "
        "training motions."
    )
    heads = [f"{100 * level:g}" for level in levels]
    header = [plain("Parameter"), *(plain(f"Guesses, {h}") for h in heads)]
    header += [plain(f"Calibrated, Eq. 1, {h}") for h in heads] + [plain(f"Calibrated, beyond, {h}") for h in heads]
    columns = "l" + "r" * (3 * len(heads) + 1)
    return Table("Coverage", "tab:coverage", caption, columns, [*header, plain("Width")], [(None, rows)])


def intervals(frame: pd.DataFrame) -> Table:
    """The recorded arm's parameters with their intervals.

    Columns ``parameter, true, centre, low, high, level, warned``.
    """
    rows = [
        [
            with_unit(formula(row["parameter"]), UNITS[NAMES.index(row["parameter"])]),
            number(row["true"], 4),
            number(row["centre"], 4),
            number(row["low"], 4) + Text(" to ", " to ") + number(row["high"], 4),
            plain("yes" if row["low"] <= row["true"] <= row["high"] else "no"),
        ]
        for row in frame.to_dict("records")
    ]
    like = "unlike the training motions" if frame["warned"].max() else "like the training motions"
    caption = plain(
        f"Parameters of the simulated arm from its recording of ID, which is {like}: median of the network's estimates "
        f"from random guesses, and its calibrated {100 * frame['level'].max():g} % interval."
    )
    names = ("Parameter", "True", "Estimate", "Interval", "Covered")
    return Table("Intervals", "tab:intervals", caption, "lrrrr", [plain(name) for name in names], [(None, rows)])


def figure(frame: pd.DataFrame) -> Figure:
    """Arms with torque beyond Eq. 1 by the level at which an interval reaches the truth: flat where levels are right.

    Columns ``arms, parameter, bin, number, known, raw, calibrated``.
    """
    chosen = frame[frame["arms"] == "unmodelled"]
    bins = int(chosen["bin"].max()) + 1
    edges = np.linspace(0.0, 100.0, bins + 1)
    expected = 100.0 / bins
    # The arms that are ranked scatter, and so do those that they are ranked among.
    scatter = 1.0 / chosen["number"].max() + 1.0 / chosen["known"].max()
    band = 196.0 * np.sqrt((1 / bins) * (1 - 1 / bins) * scatter)
    drawn = style.new_figure(style.COLUMN, 3.7)
    panels = drawn.subplots(3, 3, sharex=True, sharey=True)
    for axes, name in zip(panels.flat, NAMES, strict=True):
        rows = chosen[chosen["parameter"] == name].sort_values("bin")
        axes.axhspan(expected - band, expected + band, color=style.FILL_LIGHT, lw=0.0, zorder=0.0)
        for column, (look, label) in _LOOKS.items():
            stroke = style.STROKES[look]
            steps = StepPatch(100.0 * rows[column].to_numpy(), edges, fill=False, label=label)
            steps.set(edgecolor=stroke["color"], linestyle=stroke["linestyle"], linewidth=1.0)
            axes.add_patch(steps)
        axes.set_title(rf"${name[0]}_{name[1]}$")
        axes.set_xlim(0.0, 100.0)
        axes.set_ylim(0.0, max(30.0, 105.0 * float(chosen[["raw", "calibrated"]].to_numpy().max())))
        axes.set_xticks([0, 50, 100])
    drawn.supxlabel("Level at which the interval reaches the truth (%)", fontsize=style.TEXT_SIZE)
    drawn.supylabel("Arms (%)", fontsize=style.TEXT_SIZE)
    style.legend_above(drawn, panels[0, 0], 2, style.SIMULATED)
    return drawn
