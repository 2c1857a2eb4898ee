"""Torques and their spectra, actual against rebuilt, for several tests (Fig. 12-15, 17)."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from repro.render import style
from repro.render.contract import Curve, read_curves
from repro.render.lines import COEFFICIENT, JOINTS, TIME, TORQUE, plot_series

_PAIR = ("actual", "rebuilt")

#: A curve that turns more often is drawn without dashes, which would look like stripes.
_MOST_TURNS_DASHED = 40

#: The view of a spectrum ends with the last band that reaches this part of its panel's largest coefficient.
_BAND_IN_VIEW = 0.05

#: Up to this many bands a spectrum is drawn as stems and dots, above it as lines.
_MOST_STEMS = 90


def _case_grid(cases: Sequence[str], x_label: str, y_label: str) -> tuple[Figure, dict[str, Axes]]:
    """Lay out a page-wide grid, a row for each case and a column for each joint; axes by panel name."""
    figure = style.new_figure(style.PAGE, 0.75 + 1.3 * len(cases))
    grid = figure.subplots(len(cases), 2, sharex=True, gridspec_kw={"wspace": 0.04})
    panels: dict[str, Axes] = {}
    for row, case in enumerate(cases):
        for column, joint in enumerate(JOINTS):
            axes = grid[row, column]
            axes.set_title(f"{case}, {style.SERIES_LABELS[joint].lower()}")
            axes.set_ylabel(y_label)
            style.few_ticks(axes)
            panels[f"{case}/{joint}"] = axes
    for axes in grid[-1]:
        axes.set_xlabel(x_label)
    figure.align_ylabels()
    return figure, panels


def _plot_pair(axes: Axes, pair: Mapping[str, Curve]) -> None:
    """Draw a rebuilt signal, thin and dark, over the actual one, wide and light."""
    plot_series(axes, "actual", pair["actual"])
    plot_series(axes, "rebuilt", pair["rebuilt"])
    turns = np.count_nonzero(np.diff(np.sign(np.diff(pair["rebuilt"][1]))))
    if turns > _MOST_TURNS_DASHED:
        axes.lines[-1].set_linestyle("-")


def _torques(frame: pd.DataFrame, cases: Sequence[str]) -> Figure:
    """Actual and rebuilt torque over time, a row for each case."""
    figure, panels = _case_grid(cases, TIME, TORQUE)
    curves = read_curves(frame, dict.fromkeys(panels, _PAIR))
    for panel, axes in panels.items():
        _plot_pair(axes, curves[panel])
    style.legend_above(figure, panels[f"{cases[0]}/joint1"], 2)
    return figure


def _last_frequency(curves: Mapping[str, Mapping[str, Curve]]) -> float:
    """Highest frequency at which any coefficient reaches `_BAND_IN_VIEW` of its panel's largest."""
    last = 0.0
    for pair in curves.values():
        largest = max(float(np.abs(y).max()) for _, y in pair.values())
        for x, y in pair.values():
            last = max(last, float(x[np.abs(y) >= _BAND_IN_VIEW * largest].max(initial=0.0)))
    return last


def _spectra(frame: pd.DataFrame, cases: Sequence[str]) -> Figure:
    """Actual and rebuilt DCT-II over frequency, a row for each case.

    Bands above the last one that reaches `_BAND_IN_VIEW` in any panel are left out, and the figure says so.
    """
    figure, panels = _case_grid(cases, "Frequency (Hz)", COEFFICIENT)
    curves = read_curves(frame, dict.fromkeys(panels, _PAIR))
    end = max(float(x[-1]) for pair in curves.values() for x, _ in pair.values())
    last = _last_frequency(curves)
    last = end if last > 0.9 * end else last
    for panel, axes in panels.items():
        seen = {name: (x[x <= last], y[x <= last]) for name, (x, y) in curves[panel].items()}
        if max(x.size for x, _ in seen.values()) > _MOST_STEMS:
            _plot_pair(axes, seen)
        else:
            _plot_stems(axes, seen)
    if last < end:
        share = f"under {100 * _BAND_IN_VIEW:g} % of the panel's largest"
        note = f"Not shown: {last:.3g} to {end:.3g} Hz, where every coefficient is {share}."
        figure.supxlabel(note, fontsize=style.SMALL_SIZE)
    style.legend_above(figure, panels[f"{cases[0]}/joint1"], 2)
    return figure


def _plot_stems(axes: Axes, pair: Mapping[str, Curve]) -> None:
    """Draw the rebuilt coefficients as dots over the actual ones as stems."""
    (x, y), stroke = pair["actual"], style.STROKES["actual"]
    axes.vlines(x, 0.0, y, color=stroke["color"], lw=stroke["linewidth"], label=style.SERIES_LABELS["actual"])
    dots: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 2.2, "markeredgewidth": 0.0}
    axes.plot(*pair["rebuilt"], color=style.STROKES["rebuilt"]["color"], label=style.SERIES_LABELS["rebuilt"], **dots)


def torques_12(frame: pd.DataFrame) -> Figure:
    """Numeric torques and the rebuilt ones, tests N1 and N2 (Fig. 12).

    Parameters
    ----------
    frame : DataFrame
        ``panel, series, x, y``; panels N1/joint1 ... N2/joint2; series actual, rebuilt; x in s, y in N m.

    Returns
    -------
    Figure
        A row for each test, a column for each joint, page wide.

    Raises
    ------
    InputError
        If the table is not as described.
    """
    return _torques(frame, ("N1", "N2"))


def torques_34(frame: pd.DataFrame) -> Figure:
    """Numeric torques and the rebuilt ones, tests N3 and N4 (Fig. 13).

    Parameters
    ----------
    frame : DataFrame
        As for `torques_12`, panels N3/joint1 ... N4/joint2.

    Returns
    -------
    Figure
        A row for each test, a column for each joint, page wide.

    Raises
    ------
    InputError
        If the table is not as described.
    """
    return _torques(frame, ("N3", "N4"))


def torques_all(frame: pd.DataFrame) -> Figure:
    """Validation torques and the rebuilt ones, tests N1 to N4 (Fig. 15).

    Parameters
    ----------
    frame : DataFrame
        As for `torques_12`, panels N1/joint1 ... N4/joint2.

    Returns
    -------
    Figure
        A row for each test, a column for each joint, page wide.

    Raises
    ------
    InputError
        If the table is not as described.
    """
    return _torques(frame, ("N1", "N2", "N3", "N4"))


def spectra_all(frame: pd.DataFrame) -> Figure:
    """DCT-II of the torques and of the rebuilt ones, tests N1 to N4 (Fig. 14, 17).

    Parameters
    ----------
    frame : DataFrame
        ``panel, series, x, y``; panels N1/joint1 ... N4/joint2; series actual, rebuilt; x in Hz, y in N m.

    Returns
    -------
    Figure
        A row for each test, a column for each joint, page wide.

    Raises
    ------
    InputError
        If the table is not as described.
    """
    return _spectra(frame, ("N1", "N2", "N3", "N4"))
