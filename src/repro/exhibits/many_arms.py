"""Many arms: coverage of the network's intervals; over the accepted experiments, spread and verdict on the methods."""

from functools import partial

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from repro.config.model import Configuration
from repro.drawing import style
from repro.drawing.markup import Block, Column, Table, digits, formula, grid, number, plain, with_unit, words
from repro.drawing.panels import plot_deviation
from repro.exhibits.declare import Inputs, figure, table
from repro.exhibits.result_tables import heading_of, methods_of, percent_interval
from repro.experiments.monte_carlo import comparisons
from repro.files import read_csv
from repro.identification.method import BASELINES
from repro.model.parameters import NAMES, UNITS
from repro.signals.programs import PROGRAMS, SPAN

_table, _figure = (partial(kind, category="Experiment (simulated)", trained="all") for kind in (table, figure))

RANKS = ("arms", "parameter", "level", "number", "known", "raw", "calibrated")
COVERAGE = ("arms", "parameter", "level", "raw", "calibrated", "factor", "width", "contraction", "warned")
INTERVALS = ("parameter", "true", "centre", "low", "high", "level", "warned")
#: Sets of arms in words: those of Eq. 1, those that have more, and those of a generator that calibrated nothing.
ARMS = {"Eq. 1": "Eq. 1", "unmodelled": "beyond", "other generator": "other"}
#: Row of the nine parameters together.
TOGETHER = "all nine"
_LOOKS = {"raw": ("least-squares", "Spread over the guesses"), "calibrated": ("algorithm1+refinement", "Calibrated")}


def coverage_layout(frame: pd.DataFrame) -> Table:
    """Shares of arms that intervals cover, a row for each parameter."""
    levels = sorted(set(frame["level"]))
    heads = [f"{100 * level:g}" for level in levels]
    wide = frame.pivot(index="parameter", columns=["arms", "level"]).loc[[*NAMES, TOGETHER]].rename_axis("name")
    last = ("unmodelled", levels[-1])
    gain = ("contraction", *last)
    shown = (("Guesses", "raw", "unmodelled"), *((name, "calibrated", arms) for arms, name in ARMS.items()))

    columns: list[Column] = [
        ("Parameter", "l", lambda row: (formula if row["name"] in NAMES else plain)(row["name"])),
        *(
            (f"{name}, {head}", "r", digits((column, arms, level), 0, 100.0))
            for name, column, arms in shown
            for level, head in zip(levels, heads, strict=True)
        ),
        ("Width", "r", digits(("width", *last), 3)),
        ("Contraction", "r", lambda row: plain("none") if row[gain] <= 0 else digits(gain, 2)(row)),
    ]
    warned = [100.0 * float(frame.loc[frame["arms"] == arms, "warned"].iloc[0]) for arms in ARMS]
    caption = (
        f"Shares of simulated arms (%) whose true parameter lies in an interval of {', '.join(heads)} %: in the "
        "central range of the network's estimates from random guesses (guesses), on arms with torque beyond Eq. 1; "
        "and in the calibrated interval, the median of these estimates plus and minus a multiple of their spread "
        "(split conformal), on arms of Eq. 1 alone, with torque beyond it as the arms that calibrated, and of another "
        "generator. Last row: all nine at once, in intervals stretched for that. Last columns: median half width of "
        "the widest interval over the largest torque, and contraction, the share of the parameter's "
        f"variance over the arms that the interval removes. {warned[0]:.1f}, {warned[1]:.1f} and {warned[2]:.1f} % of "
        "the three sets are warned of as unlike the training motions."
    )
    return grid(caption, columns, [(None, wide.set_axis(wide.columns.to_flat_index(), axis=1).reset_index())])


@_table("Do the intervals of the network cover", coverage_layout, inputs=("coverage",))
def coverage_table(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """Shares of simulated arms whose true parameters lie in the intervals of the network of closed-loop motions, before
    and after calibration on other arms: on arms of Eq. 1, on arms with unmodelled torque, and on arms of another
    generator (other). Guesses: before calibration. The last row is for all nine parameters at once. Contraction: the
    share of the variance over the arms that an interval removes.
    """
    return read_csv(inputs["coverage"][0], COVERAGE)


def intervals_layout(frame: pd.DataFrame) -> Table:
    """The recorded arm's parameters with their intervals."""
    columns: list[Column] = [
        ("Parameter", "l", lambda row: with_unit(formula(row["parameter"]), UNITS[NAMES.index(row["parameter"])])),
        ("True", "r", digits("true", 4)),
        ("Estimate", "r", digits("centre", 4)),
        ("Interval", "r", lambda row: number(row["low"], 4) + " to " + number(row["high"], 4)),
        ("Covered", "r", lambda row: plain("yes" if row["low"] <= row["true"] <= row["high"] else "no")),
    ]
    caption = (
        f"Parameters of the simulated arm from its recording of ID, which is {'un' * bool(frame['warned'].max())}like "
        "the training motions: median of the network's estimates "
        f"from random guesses, and its calibrated {100 * frame['level'].max():g} % interval."
    )
    return grid(caption, columns, [(None, frame)])


@_table("The arm's parameters with the network's intervals", intervals_layout, inputs=("coverage",))
def intervals(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """Parameters of the simulated arm with the calibrated intervals of the network of closed-loop motions."""
    return read_csv(inputs["intervals"][0], INTERVALS)


def draw_coverage(frame: pd.DataFrame) -> Figure:
    """Levels at which intervals reach the truth: their distribution minus a uniform one."""
    chosen = frame[frame["arms"] == "unmodelled"]
    # Of calibrated intervals: the arms that are ranked scatter, and so do those that they are ranked among (Kolmogorov
    # and Smirnov, two samples). The band contains the whole curve in 95 % of the cases.
    band = 135.8 * np.sqrt(1.0 / chosen["number"].max() + 1.0 / chosen["known"].max())
    drawn, panels = style.new_panels(style.COLUMN, 3.7, 3, 3, sharex=True, sharey=True)
    for axes, name in zip(panels.flat, NAMES, strict=True):
        rows = chosen[chosen["parameter"] == name].sort_values("level")
        axes.axhspan(-band, band, color=style.FILL_LIGHT, lw=0.0, zorder=0.0)
        for column, (look, label) in _LOOKS.items():
            plot_deviation(axes, rows["level"], rows[column], look, label)
        axes.set(title=rf"${name[0]}_{name[1]}$", xlim=(0.0, 100.0), xticks=[0, 50, 100])
    drawn.supxlabel("Level of the interval (%)", fontsize=style.TEXT_SIZE)
    drawn.supylabel("Arms covered minus level (points)", fontsize=style.TEXT_SIZE)
    return style.legend_above(drawn, panels[0, 0], 2, style.SIMULATED)


@_figure("Levels at which intervals reach the truth", draw_coverage, inputs=("coverage",))
def coverage_figure(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """Calibration of the network's intervals on simulated arms with torque beyond Eq. 1: for each level, the share of
    arms whose true parameter the interval covers, minus the level. Dashed or solid lines are the range of the estimates
    from random guesses, and the interval calibrated on other arms. Zero is right, below is too narrow, above too wide.
    The band contains the whole solid line of right intervals in 95 % of the cases; that of a dashed one is narrower.
    """
    return read_csv(inputs["ranks"][0], RANKS)


SPREAD = ("case", "joint", "method", "experiment", "total")
#: Methods that the verdict compares with the baselines.
CONTENDERS = ("algorithm1", "algorithm1+tracked", "algorithm1+refinement", "algorithm1+local-search")


def verdict_layout(frame: pd.DataFrame) -> Table:
    """A block for each opponent, a row for each method; columns `COMPARISON_COLUMNS`."""
    columns: list[Column] = [
        ("Method", "l", lambda row: heading_of(row["method"])),
        ("Won", "r", digits("wins", 0)),
        ("Difference", "r", digits("difference", 2, 100.0)),
        ("Interval", "r", percent_interval),
        ("p (Holm)", "r", lambda row: plain("< 0.001") if row["p_holm"] < 5e-4 else number(row["p_holm"], 3)),
        ("Conclusion", "l", words("conclusion")),
    ]
    order = {method: place for place, method in enumerate(methods_of(frame))}
    ordered = frame.assign(place=frame["method"].map(order)).sort_values("place", kind="stable")
    blocks: list[Block] = [
        (plain("Against:") + " " + heading_of(opponent), ordered[ordered["opponent"] == opponent])
        for opponent in dict.fromkeys(frame["opponent"])
    ]
    caption = (
        f"Algorithm 1 and the field's methods: the mean total over {SPAN} and both joints, paired over "
        f"{frame['experiments'].max()} simulated experiments that the printed numbers do not rule out. "
        "Hodges-Lehmann difference in points of a percent with the interval of Wilcoxon's signed-rank test, "
        f"simultaneous over {len(frame)} pairs (95 %, Bonferroni), and the p value adjusted by Holm's method. "
        "Equivalent: the whole interval is within 0.5 points."
    )
    return grid(caption, columns, blocks)


@_table("Algorithm 1 against the field's methods", verdict_layout, inputs=("spread",))
def verdict(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """Algorithm 1, its variants and their control against least squares, plain, bounded and consistent. Each accepted
    experiment counts once, with its mean total over T1 to T4 and both joints: the number of those on which a method is
    better, the difference of the two methods with its interval, and the conclusion.
    """
    return comparisons(read_csv(inputs["scores"][0], SPREAD), CONTENDERS, tuple(BASELINES))


#: Methods of the figure.
DRAWN = ("algorithm1", "algorithm1+refinement", "least-squares", "bounded", "true")


def _plot_runs(axes: Axes, runs: pd.DataFrame, methods: list[str]) -> None:
    """Draw each experiment as a mark, side by side in their order, and a bar at the median."""
    for place, method in enumerate(methods):
        colour, chosen = style.STROKES[method]["color"], runs[runs["method"] == method].sort_values("experiment")
        totals = 100.0 * chosen["total"].to_numpy()
        offsets = np.linspace(-0.25, 0.25, totals.size) if totals.size > 1 else np.zeros(totals.size)
        marks = {"ls": "none", "color": colour, "alpha": 0.75, **style.MARKS[method], "markersize": 3.0}
        axes.plot(place + offsets, totals, label=style.SERIES_LABELS[method], **marks)
        if totals.size:
            axes.hlines(100.0 * float(chosen["median"].iloc[0]), place - 0.45, place + 0.45, color=colour, lw=1.8)


#: The scale of similarities is logarithmic in the distance from here (%).
_END = 105.0


def draw_spread(frame: pd.DataFrame) -> Figure:
    """Total similarity of every experiment, by motion, joint and method; the scale is stretched towards 100 %."""
    stretched = (lambda y: -np.log(_END - y), lambda z: _END - np.exp(-z))
    methods = [name for name in style.METHODS if name in set(frame["method"])]
    figure, grid = style.new_panels(style.PAGE, 4.2, 2, len(PROGRAMS), sharex=True, sharey=True)
    for row, joint in zip(grid, (1, 2), strict=True):
        for axes, case in zip(row, PROGRAMS, strict=True):
            _plot_runs(axes, frame[(frame["case"] == case) & (frame["joint"] == joint)], methods)
            axes.set(title=f"{case}, joint {joint}", xlim=(-0.6, len(methods) - 0.4), xticks=[])
            axes.set_yscale("function", functions=stretched)
            axes.set(ylim=(-2.0, 100.0), yticks=[0, 50, 70, 80, 90, 95, 100])
        row[0].set_ylabel("Total similarity (%)")
    return style.legend_above(figure, grid[0, 0], 3, style.SIMULATED)


@_figure("Similarity over the accepted experiments", draw_spread, inputs=("spread",))
def spread_figure(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """Total similarity on every experiment that the printed numbers do not rule out, by motion, joint and method; the
    bars are the medians. The metric ends at 0, where the error is as large as the torque; the scale is stretched
    towards 100 %.
    """
    drawn = read_csv(inputs["scores"][0], SPREAD).query("method in @DRAWN")[list(SPREAD)]
    return drawn.assign(median=drawn.groupby(["case", "joint", "method"])["total"].transform("median"))
