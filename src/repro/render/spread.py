"""Spread of the experiment over its seeds: the total similarity of each method on each motion."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from repro.errors import InputError
from repro.render import style
from repro.render.contract import check_names, check_range, check_table
from repro.render.experiment import CASES

_CASES = ("ID", *CASES)

#: Published values, each in the colour of its method.
_PUBLISHED = {f"published {method}": method for method in ("algorithm1", "least-squares")}

#: Widths in units of one duration's group: all methods together, and the points of one of them.
_GROUP = 0.8
_SCATTER = 0.5


def _read(frame: pd.DataFrame) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Check the table; return our runs and the published values."""
    filled = frame
    if {"method", "duration", "seed"} <= set(frame.columns):
        published = frame["method"].isin(list(_PUBLISHED))
        filled = frame.assign(
            **{name: frame[name].where(~published, 0) for name in ("duration", "seed", "median") if name in frame}
        )
    table = check_table(filled, ("case", "method"), ("joint", "duration", "seed", "total", "median"))
    check_names(table["case"], _CASES, "case")
    check_names(table["joint"].map("{:g}".format), ("1", "2"), "joint")
    check_range(table, ("total", "median"), 0.0, 1.0, "a fraction of 1")
    allowed = (*style.METHODS, *_PUBLISHED)
    for name in table["method"]:
        if name not in allowed:
            raise InputError.at("method", repr(name), f"one of {', '.join(allowed)}")
    known = table["method"].isin(list(_PUBLISHED))
    if known.all():
        raise InputError.at("method", "published values alone", f"at least one of {', '.join(style.METHODS)}")
    key = ["method", "duration", "seed"]
    for values, rows in table.groupby(key, sort=False):
        if len(rows) != 2 * len(_CASES) or rows.duplicated(["case", "joint"]).any():
            place = ", ".join(f"{name} {value}" for name, value in zip(key, values, strict=True))
            raise InputError.at(place, f"{len(rows)} rows", "each case and joint once")
    return table[~known], table[known]


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
    runs, published = _read(frame)
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
