"""Do the intervals of the network's estimate cover: tables and the calibration of levels."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from repro.exhibits import style
from repro.exhibits.markup import EMPTY, Table, Text, formula, number, plain
from repro.model.parameters import NAMES, UNITS
from repro.render.experiment_tables import with_unit

#: Sets of arms: those that follow Eq. 1, those that have more, and those of a generator that calibrated nothing.
ARMS = ("Eq. 1", "unmodelled", "other generator")
#: Row of the nine parameters together.
TOGETHER = "all nine"
_LOOKS = {"raw": ("least-squares", "Spread over the guesses"), "calibrated": ("algorithm1+refinement", "Calibrated")}


def table(frame: pd.DataFrame) -> Table:
    """Shares of arms that intervals cover, a row for each parameter.

    Columns ``arms, parameter, level, raw, calibrated, factor, width, contraction, warned``.
    """
    levels = sorted(set(frame["level"]))
    cells = frame.set_index(["arms", "parameter", "level"])
    widest = frame[(frame["arms"] == "unmodelled") & (frame["level"] == levels[-1])].set_index("parameter")
    last = {column: dict(widest[column].astype(float)) for column in ("width", "contraction")}
    rows = []
    for name in (*NAMES, TOGETHER):
        row = [plain(name) if name == TOGETHER else formula(name)]
        for arms, column in (("unmodelled", "raw"), *((arms, "calibrated") for arms in ARMS)):
            row += [number(100.0 * float(cells.loc[(arms, name, level), column]), 0) for level in levels]
        if name == TOGETHER:
            row += [EMPTY, EMPTY]
        else:
            removed = last["contraction"][name]
            row += [number(last["width"][name], 3), number(removed, 2) if removed > 0 else plain("none")]
        rows.append(row)
    warned = [100.0 * float(frame.loc[frame["arms"] == arms, "warned"].iloc[0]) for arms in ARMS]
    caption = plain(
        "Shares of simulated arms (%) whose true parameter lies in an interval of "
        + ", ".join(f"{100 * level:g}" for level in levels)
        + " %: in the central range of the network's estimates from random guesses (guesses), on arms with torque "
        "beyond Eq. 1; and in the calibrated interval, the median of these estimates plus and minus a multiple of "
        "their spread (split conformal), on arms of Eq. 1 alone, with torque beyond it as the arms that calibrated, "
        "and of another generator. Last row: all nine at once, in intervals stretched for that. Last columns: median "
        "half width of the widest interval over the largest torque, and contraction, the share of the parameter's "
        f"variance over the arms that the interval removes. {warned[0]:.1f}, {warned[1]:.1f} and {warned[2]:.1f} % of "
        "the three sets are warned of as unlike the training motions."
    )
    heads = [f"{100 * level:g}" for level in levels]
    header = [plain("Parameter"), *(plain(f"Guesses, {h}") for h in heads)]
    for words in ("Eq. 1", "beyond", "other"):
        header += [plain(f"{words}, {h}") for h in heads]
    header += [plain("Width"), plain("Contraction")]
    return Table("Coverage", "tab:coverage", caption, "l" + "r" * (len(header) - 1), header, [(None, rows)])


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
    """Levels at which intervals reach the truth: their distribution minus a uniform one, zero where levels are right.

    Columns ``arms, parameter, level, number, known, raw, calibrated``.
    """
    chosen = frame[frame["arms"] == "unmodelled"]
    # The arms that are ranked scatter, and so do those that they are ranked among: both samples count (Kolmogorov and
    # Smirnov, two samples). The band contains the whole curve in 95 % of the cases.
    band = 135.8 * np.sqrt(1.0 / chosen["number"].max() + 1.0 / chosen["known"].max())
    drawn = style.new_figure(style.COLUMN, 3.7)
    panels = drawn.subplots(3, 3, sharex=True, sharey=True)
    for axes, name in zip(panels.flat, NAMES, strict=True):
        rows = chosen[chosen["parameter"] == name].sort_values("level")
        level = 100.0 * rows["level"].to_numpy()
        axes.axhspan(-band, band, color=style.FILL_LIGHT, lw=0.0, zorder=0.0)
        for column, (look, label) in _LOOKS.items():
            stroke = style.STROKES[look]
            axes.plot(
                level,
                100.0 * rows[column].to_numpy() - level,
                color=stroke["color"],
                linestyle=stroke["linestyle"],
                linewidth=1.0,
                label=label,
            )
        axes.set_title(rf"${name[0]}_{name[1]}$")
        axes.set_xlim(0.0, 100.0)
        axes.set_xticks([0, 50, 100])
    drawn.supxlabel("Level of the interval (%)", fontsize=style.TEXT_SIZE)
    drawn.supylabel("Arms covered minus level (points)", fontsize=style.TEXT_SIZE)
    style.legend_above(drawn, panels[0, 0], 2, style.SIMULATED)
    return drawn
