"""Curves in panels: long tables ``panel, series, x, y``, torques and spectra next to what was rebuilt."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from math import ceil
from typing import Literal, cast

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure, FigureBase
from matplotlib.ticker import EngFormatter, MaxNLocator

from repro.drawing import style
from repro.model.parameters import Array

#: Points (x, y) of one curve, arrays of shape (n,).
Points = tuple[Array, Array]
#: Panel, series, x and y of one curve of a long table.
Curve = tuple[str, str, Array, Array]
TIME = "Time (s)"
TORQUE = "Torque (N·m)"
COEFFICIENT = "Coefficient (N·m)"
JOINTS = ("joint1", "joint2")
#: Axis label of each panel of a motion.
MOTION = {"position": "Position (rad)", "velocity": "Velocity (rad/s)", "acceleration": "Acceleration (rad/s²)"}


def similarity_of(panel: str) -> str:
    """Panel of a long table that has the similarities of the series of another panel, fractions at x = 0."""
    return f"similarity of {panel}"


def long_table(parts: Iterable[Curve]) -> pd.DataFrame:
    """Tidy table of curves: columns ``panel, series, x, y``."""
    frames = [pd.DataFrame({"panel": p, "series": s, "x": x, "y": y}) for p, s, x, y in parts]
    return pd.concat(frames, ignore_index=True)


def curves_of(frame: pd.DataFrame) -> dict[str, dict[str, Points]]:
    """Curves of a long table ``panel, series, x, y`` by panel and series, in its order."""
    curves: dict[str, dict[str, Points]] = {}
    for key, rows in frame.groupby(["panel", "series"], sort=False):
        panel, series = map(str, key)
        curves.setdefault(panel, {})[series] = (rows["x"].to_numpy(), rows["y"].to_numpy())
    return curves


def plot_series(axes: Axes, name: str, curve: Points) -> None:
    """Draw one curve in the stroke and under the label of its series."""
    axes.plot(*curve, label=style.SERIES_LABELS[name], **style.STROKES[name])


def plot_deviation(axes: Axes, level: pd.Series, share: pd.Series, look: str, label: str) -> None:
    """Draw by how many points a share deviates from its level, in the colour and dashes of another series."""
    x = 100.0 * level.to_numpy()
    axes.plot(x, 100.0 * share.to_numpy() - x, label=label, **{**style.STROKES[look], "linewidth": 1.0})


def plot_panel(axes: Axes, series: Mapping[str, Points]) -> None:
    """Draw curves one over the other in their order."""
    for name, curve in series.items():
        plot_series(axes, name, curve)
    style.few_ticks(axes)


def draw_motion(
    frame: pd.DataFrame,
    width: float = style.COLUMN,
    height: float = 3.9,
    cases: Collection[str] = ("",),
    legend_title: str | None = None,
) -> Figure:
    """Position, velocity and acceleration of both joints over time, a column for each case."""
    curves = curves_of(frame)
    figure = style.new_figure(width, height)
    grid = figure.subplots(len(MOTION), len(cases), sharex="col", squeeze=False)
    for column, case in zip(grid.T, cases, strict=True):
        for axes, panel in zip(column, MOTION, strict=True):
            plot_panel(axes, curves[f"{case} {panel}".strip()])
        column[0].set_title(case)
        column[-1].set_xlabel(TIME)
    for axes, label in zip(grid[:, 0], MOTION.values(), strict=True):
        axes.set_ylabel(label)
    figure.align_ylabels()
    return style.legend_above(figure, grid[0, 0], len(grid[0, 0].lines), legend_title)


def draw_losses(
    frame: pd.DataFrame, x_label: str, y_label: str, columns: int, xscale: Literal["linear", "log"] = "linear"
) -> Figure:
    """Losses on a logarithmic axis, with so many columns in the legend."""
    figure = style.new_figure(style.COLUMN, 2.3)
    axes = figure.subplots()
    for name, curve in curves_of(frame)["loss"].items():
        plot_series(axes, name, curve)
    axes.set(xscale=xscale, yscale="log", xlabel=x_label, ylabel=y_label)
    axes.xaxis.set_major_formatter(EngFormatter(sep=""))
    if xscale == "linear":
        axes.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    return style.legend_above(figure, axes, columns)


#: The view of a spectrum ends with the last band that reaches this part of its panel's largest coefficient.
_BAND_IN_VIEW = 0.05
#: Curves of one panel by series: first the reference, then whatever is compared with it.
Compared = Mapping[str, Points]


def _plot_lines(axes: Axes, series: Compared) -> None:
    """Draw curves, thin and dark, over their reference, wide and light."""
    plot_panel(axes, series)
    for name, line in zip(series, axes.lines, strict=True):
        turns = np.count_nonzero(np.diff(np.sign(np.diff(line.get_ydata()))))
        if name == "rebuilt" and turns > 40:  # dashes would look like stripes
            line.set_linestyle("-")


def _plot_stems(axes: Axes, series: Compared) -> None:
    """Draw coefficients as marks over those of the reference as stems; a difference has no mark."""
    (reference, (x, y)), *others = ((name, curve) for name, curve in series.items() if name != "difference")
    stroke = style.STROKES[reference]
    axes.vlines(x, 0.0, y, color=stroke["color"], lw=stroke["linewidth"], label=style.SERIES_LABELS[reference])
    for name, curve in others:
        marks = {"linestyle": "none", "color": style.STROKES[name]["color"], **style.MARKS[name]}
        axes.plot(*curve, label=style.SERIES_LABELS[name], **marks)
    style.few_ticks(axes)


def _in_view(curves: Mapping[str, Compared], groups: Sequence[Sequence[str]]) -> tuple[dict[str, Compared], str]:
    """Bands of each panel up to the last one that reaches `_BAND_IN_VIEW` in its group, and a note on the rest."""
    end = max(float(x[-1]) for group in groups for panel in group for x, _ in curves[panel].values())
    seen: dict[str, Compared] = {}
    lasts = []
    for group in groups:
        last = 0.0
        for series in (curves[panel] for panel in group):
            least = _BAND_IN_VIEW * max(float(np.abs(y).max()) for _, y in series.values())
            last = max(last, *(float(x[np.abs(y) >= least].max(initial=0.0)) for x, y in series.values()))
        lasts.append(end if last > 0.9 * end else last)
        for panel in group:
            seen[panel] = {name: (x[x <= lasts[-1]], y[x <= lasts[-1]]) for name, (x, y) in curves[panel].items()}
    if min(lasts) == end:
        return seen, ""
    first = f"{lasts[0]:.3g}" if len(lasts) == 1 else "from the end of each row"
    share = f"under {100 * _BAND_IN_VIEW:g} % of the panel's largest"
    return seen, f"Not shown: {first} to {end:.3g} Hz, where every coefficient is {share}."


def compare(
    frame: pd.DataFrame,
    titles: Mapping[str, str],
    spectra: bool = False,
    by_row: bool = False,  # whether the axes end where each row does
    legend_title: str | None = None,
    figure: FigureBase | None = None,
    end: float | None = None,  # of the view of torques, s
) -> Figure:
    """Draw torques over time, or their spectra, two panels in a row, on a page-wide figure or in this one."""
    rows = ceil(len(titles) / 2)
    whole = style.new_figure(style.PAGE, 0.75 + 1.3 * rows) if figure is None else figure
    curves: Mapping[str, Compared] = curves_of(frame)
    names, plot, labels, note = list(titles), _plot_lines, (TIME, TORQUE), ""
    if spectra:
        curves, note = _in_view(curves, [names[i : i + 2] for i in range(0, len(names), 2)] if by_row else [names])
        labels = ("Frequency (Hz)", COEFFICIENT)
        if max(x.size for series in curves.values() for x, _ in series.values()) <= 90:  # room for stems and marks
            plot = _plot_stems
    elif end is not None:
        last = max(float(x[-1]) for panel in names for x, _ in curves[panel].values())
        seen = {panel: {name: (x[x <= end], y[x <= end]) for name, (x, y) in curves[panel].items()} for panel in names}
        curves, note = {**curves, **seen}, f"Not shown: {end:g} to {last:.0f} s."
    grid = whole.subplots(rows, 2, sharex="row" if by_row else "all", squeeze=False, gridspec_kw={"wspace": 0.04})
    for axes, (panel, title) in zip(grid.flat, titles.items(), strict=True):
        plot(axes, curves[panel])
        totals = [f"{100.0 * float(y[0]):.0f}" for _, y in curves.get(similarity_of(panel), {}).values()]
        axes.set(title=f"{title} ({' and '.join(totals)} %)" if totals else title, ylabel=labels[1])
    for axes in grid[-1]:
        axes.set_xlabel(labels[0])
    whole.align_ylabels()
    entries = len(grid[0, 0].get_legend_handles_labels()[0])
    columns = entries if entries <= 5 else 3  # long names come with the many
    style.legend_above(whole, grid[0, 0], columns, legend_title)
    if note:
        whole.supxlabel(note, fontsize=style.SMALL_SIZE)
    return cast("Figure", whole)
