"""Torques and their spectra against what was rebuilt from parameters, as panels and for N1-N4 (Fig. 12-15, 17)."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from math import ceil
from typing import Literal

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure, FigureBase

from repro.exhibits import style
from repro.render.lines import COEFFICIENT, JOINTS, TIME, TORQUE, Curve, curves_of, plot_panel

_PAIR = ("actual", "rebuilt")

#: A curve alone over its reference that turns more often is drawn without dashes, which would look like stripes.
_MOST_TURNS_DASHED = 40

#: The view of a spectrum ends with the last band that reaches this part of its panel's largest coefficient.
_BAND_IN_VIEW = 0.05

#: Up to this many bands a spectrum is drawn as stems and marks, above it as lines.
_MOST_STEMS = 90

#: Up to this many entries the legend is one row.
_MOST_ABREAST = 5

#: Curves of one panel by series: first the reference, then whatever is compared with it.
Compared = Mapping[str, Curve]


def page(panels: int) -> Figure:
    """Make a page-wide figure for this many panels, two in a row."""
    return style.new_figure(style.PAGE, 0.75 + 1.3 * ceil(panels / 2))


def _compare(
    figure: FigureBase,
    curves: Mapping[str, Compared],
    titles: Mapping[str, str],
    labels: tuple[str, str],
    plot: Callable[[Axes, Compared], None],
    legend_title: str | None,
    share_x: Literal["all", "row"] = "all",
) -> None:
    """Plot the panels of `titles` in a grid, two in a row, under one legend."""
    rows = ceil(len(titles) / 2)
    grid = figure.subplots(rows, 2, sharex=share_x, squeeze=False, gridspec_kw={"wspace": 0.04})
    for axes, (panel, title) in zip(grid.flat, titles.items(), strict=True):
        plot(axes, curves[panel])
        axes.set_title(title)
        axes.set_ylabel(labels[1])
    for axes in grid[-1]:
        axes.set_xlabel(labels[0])
    figure.align_ylabels()
    entries = len(grid[0, 0].get_legend_handles_labels()[0])
    columns = entries if entries <= _MOST_ABREAST else 3  # long names come with the many
    style.legend_above(figure, grid[0, 0], columns, legend_title)


def _plot_lines(axes: Axes, series: Compared) -> None:
    """Draw curves, thin and dark, over their reference, wide and light."""
    plot_panel(axes, series)
    turns = np.count_nonzero(np.diff(np.sign(np.diff(axes.lines[-1].get_ydata()))))
    if len(series) == len(_PAIR) and turns > _MOST_TURNS_DASHED:
        axes.lines[-1].set_linestyle("-")


def _plot_stems(axes: Axes, series: Compared) -> None:
    """Draw coefficients as marks over those of the reference as stems."""
    (reference, (x, y)), *others = series.items()
    stroke = style.STROKES[reference]
    axes.vlines(x, 0.0, y, color=stroke["color"], lw=stroke["linewidth"], label=style.SERIES_LABELS[reference])
    for name, curve in others:
        marks = {"linestyle": "none", "color": style.STROKES[name]["color"], **style.MARKS[name]}
        axes.plot(*curve, label=style.SERIES_LABELS[name], **marks)
    style.few_ticks(axes)


def torque_panels(
    figure: FigureBase,
    curves: Mapping[str, Compared],
    titles: Mapping[str, str],
    legend_title: str | None = None,
) -> None:
    """Draw torques over time, two panels in a row."""
    _compare(figure, curves, titles, (TIME, TORQUE), _plot_lines, legend_title)


def _last_frequency(curves: Iterable[Compared]) -> float:
    """Highest frequency at which any coefficient reaches `_BAND_IN_VIEW` of its panel's largest."""
    last = 0.0
    for series in curves:
        largest = max(float(np.abs(y).max()) for _, y in series.values())
        for x, y in series.values():
            last = max(last, float(x[np.abs(y) >= _BAND_IN_VIEW * largest].max(initial=0.0)))
    return last


def spectrum_panels(
    figure: FigureBase,
    curves: Mapping[str, Compared],
    titles: Mapping[str, str],
    legend_title: str | None = None,
    by_row: bool = False,
) -> None:
    """Draw spectra, two panels in a row.

    Bands above the last one that reaches `_BAND_IN_VIEW` in any panel are left out, and the figure says so.
    """
    names = list(titles)
    groups = [names[i : i + 2] for i in range(0, len(names), 2)] if by_row else [names]
    end = max(float(x[-1]) for panel in names for x, _ in curves[panel].values())
    seen: dict[str, Compared] = {}
    lasts = []
    for group in groups:
        last = _last_frequency([curves[panel] for panel in group])
        lasts.append(end if last > 0.9 * end else last)
        for panel in group:
            seen[panel] = {name: (x[x <= lasts[-1]], y[x <= lasts[-1]]) for name, (x, y) in curves[panel].items()}
    many = max(x.size for series in seen.values() for x, _ in series.values()) > _MOST_STEMS
    plot = _plot_lines if many else _plot_stems
    _compare(figure, seen, titles, ("Frequency (Hz)", COEFFICIENT), plot, legend_title, "row" if by_row else "all")
    if min(lasts) < end:
        share = f"under {100 * _BAND_IN_VIEW:g} % of the panel's largest"
        first = f"{lasts[0]:.3g}" if len(lasts) == 1 else "from the end of each row"
        note = f"Not shown: {first} to {end:.3g} Hz, where every coefficient is {share}."
        figure.supxlabel(note, fontsize=style.SMALL_SIZE)


def _numeric(frame: pd.DataFrame, cases: Sequence[str], draw: Callable[..., None]) -> Figure:
    """Actual and rebuilt signals, a row for each case and a column for each joint."""
    titles = {f"{case}/{joint}": f"{case}, {style.SERIES_LABELS[joint].lower()}" for case in cases for joint in JOINTS}
    curves = curves_of(frame, dict.fromkeys(titles, _PAIR))
    figure = page(len(titles))
    draw(figure, curves, titles)
    return figure


def torques_12(frame: pd.DataFrame) -> Figure:
    """Numeric torques and the rebuilt ones, tests N1 and N2 (Fig. 12)."""
    return _numeric(frame, ("N1", "N2"), torque_panels)


def torques_34(frame: pd.DataFrame) -> Figure:
    """Numeric torques and the rebuilt ones, tests N3 and N4 (Fig. 13)."""
    return _numeric(frame, ("N3", "N4"), torque_panels)


def torques_all(frame: pd.DataFrame) -> Figure:
    """Validation torques and the rebuilt ones, tests N1 to N4 (Fig. 15)."""
    return _numeric(frame, ("N1", "N2", "N3", "N4"), torque_panels)


def spectra_all(frame: pd.DataFrame) -> Figure:
    """DCT-II of the torques and of the rebuilt ones, tests N1 to N4 (Fig. 14, 17)."""
    return _numeric(frame, ("N1", "N2", "N3", "N4"), spectrum_panels)
