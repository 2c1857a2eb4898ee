"""Spread of the experiment over its seeds: the total similarity of each method on each motion."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from repro.exhibits import style
from repro.render.experiment import CASES

_CASES = ("ID", *CASES)

#: Published values, each in the colour of its method.
_PUBLISHED = {f"published {method}": method for method in ("algorithm1", "least-squares")}

#: Widths in units of one duration's group: all methods together, and the points of one of them.
_GROUP = 0.8
_SCATTER = 0.5


def _plot_runs(axes: Axes, runs: pd.DataFrame, methods: list[str], durations: list[float]) -> None:
    """Draw each run as a mark, side by side in the order of the seeds, and a bar at the median."""
    step = _GROUP / len(methods)
    for place, method in enumerate(methods):
        colour = style.STROKES[method]["color"]
        label = style.SERIES_LABELS[method]
        for group, duration in enumerate(durations):
            chosen = runs[(runs["method"] == method) & (runs["duration"] == duration)].sort_values("seed")
            totals = 100.0 * chosen["total"].to_numpy()
            centre = group + (place - (len(methods) - 1) / 2) * step
            offsets = np.linspace(-0.5, 0.5, totals.size) if totals.size > 1 else np.zeros(totals.size)
            marks = {"ls": "none", "color": colour, "alpha": 0.75, **style.MARKS[method], "markersize": 2.6}
            axes.plot(centre + _SCATTER * step * offsets, totals, label=label, **marks)
            if totals.size:
                middle = 100.0 * float(chosen["median"].iloc[0])
                axes.hlines(middle, centre - 0.45 * step, centre + 0.45 * step, color=colour, lw=1.8)
            label = "_"  # one entry in the legend


def _plot_published(axes: Axes, known: pd.DataFrame) -> None:
    """Draw a line across the panel at each published value."""
    for name, method in _PUBLISHED.items():
        for total in known["total"][known["method"] == name].to_numpy(dtype=np.float64):
            stroke = {key: style.STROKES[method][key] for key in ("color", "linestyle")}
            label = f"{style.SERIES_LABELS[method]}, published (real arm)"
            axes.axhline(100.0 * total, lw=0.9, label=label, zorder=0.5, **stroke)


def spread(frame: pd.DataFrame) -> Figure:
    """Total similarity of every run of the experiment, by motion, joint, method and ID duration."""
    is_published = frame["method"].isin(list(_PUBLISHED))
    runs, published = frame[~is_published], frame[is_published]
    methods = [name for name in style.METHODS if name in set(runs["method"])]
    durations = sorted(set(runs["duration"]))
    figure = style.new_figure(style.PAGE, 4.2)
    grid = figure.subplots(2, len(_CASES), sharex=True)
    for row, joint in zip(grid, (1, 2), strict=True):
        for axes, case in zip(row, _CASES, strict=True):
            _plot_runs(axes, runs[(runs["case"] == case) & (runs["joint"] == joint)], methods, durations)
            known = published[(published["case"] == case) & (published["joint"] == joint)]
            _plot_published(axes, known)
            axes.set_title(f"{case}, joint {joint}")
            axes.set_xticks(range(len(durations)), labels=[f"{value:.3g}" for value in durations])
            axes.set_xlim(-0.55, len(durations) - 0.45)
            axes.grid(visible=False, axis="x")
            style.few_ticks(axes)
        row[0].set_ylabel("Total similarity (%)")
    figure.supxlabel("Duration of the identification trajectory (s)", fontsize=style.TEXT_SIZE)
    figure.align_ylabels()
    style.legend_above(figure, grid[0, 0], 3, style.SIMULATED)
    return figure
