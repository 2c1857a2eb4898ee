"""Figures of `repro identify`: torques and spectra, measured and rebuilt, and how the cut-off was chosen."""

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator, StrMethodFormatter

from repro.exhibits import style
from repro.identification.filtering import Cutoff
from repro.model.parameters import Array
from repro.ownarm.result import Result, Signals
from repro.render.lines import JOINTS, TIME, TORQUE

#: How methods are drawn, in the order in which the figures name them: each differs from its neighbours in colour,
#: dash and mark.
STROKES: Final[tuple[dict[str, Any], ...]] = (
    {"color": "#8c1d04", "linestyle": "-", "linewidth": 1.1},
    {"color": "#00507f", "linestyle": (0, (4.0, 2.5)), "linewidth": 0.8},
    {"color": "#d98200", "linestyle": (0, (1.2, 1.6)), "linewidth": 1.1},
    {"color": "#0b5d3b", "linestyle": (0, (6.0, 1.2, 1.2, 1.2)), "linewidth": 1.0},
    {"color": "#9a6fb0", "linestyle": (0, (2.5, 1.0)), "linewidth": 1.2},
    {"color": "#3b3b3b", "linestyle": (0, (1.0, 2.0)), "linewidth": 1.1},
    {"color": "#c9a227", "linestyle": (0, (8.0, 2.0)), "linewidth": 1.1},
    {"color": "#2a9d9d", "linestyle": (0, (3.0, 1.0, 1.0, 1.0)), "linewidth": 1.1},
    {"color": "#b0476f", "linestyle": (0, (5.0, 1.0, 1.0, 1.0, 1.0, 1.0)), "linewidth": 1.1},
)
MARKS: Final = ("o", "s", "D", "^", "v", "P", "X", "*", "h")

#: The close-up shows this part of the log, but at least so many seconds.
_CLOSE_UP_PART, _CLOSE_UP_LEAST = 1 / 8, 2.0

#: A spectrum is shown down to this part of its largest amplitude.
_FLOOR = 1e-4

#: A frequency axis of fewer decades also names 2 and 5 of each.
_MOST_DECADES = 3.0

#: Frequencies shown of the choice of the cut-off, over the highest that could have been chosen.
_CUTOFF_VIEW = 2.0


def ordered_titles(result: Result) -> dict[str, str]:
    """Name every method in the order of the figures: the recommended one first."""
    methods = sorted(result.methods, key=lambda method: method.method != result.recommended)
    return {method.method: method.title for method in methods}


def stroke(titles: Mapping[str, str], method: str) -> dict[str, Any]:
    """How a method is drawn in every figure of one report: by its place in `titles`."""
    return STROKES[list(titles).index(method) % len(STROKES)]


def label(title: str) -> str:
    """Text that matplotlib shows as it is: no mathematics between dollars, not left out of a legend."""
    return title.replace("$", r"\$").lstrip("_")


def _legend(figure: Figure, axes: Axes, simulated: bool) -> None:
    """Put the legend above all panels, and over it that the log is simulated."""
    entries = len(axes.get_legend_handles_labels()[0])
    style.legend_above(figure, axes, min(entries, 4), style.SIMULATED if simulated else None)


def overlay(signals: Signals, methods: Sequence[str], titles: Mapping[str, str], simulated: bool = False) -> Figure:
    """Measured and rebuilt torque of both joints with the residual below, the whole log beside a close-up."""
    _check(signals.rebuilt, methods)
    figure = style.new_figure(style.PAGE, 5.3)
    ratios = {"height_ratios": (1.7, 1.0, 1.7, 1.0), "width_ratios": (1.6, 1.0)}
    grid = figure.subplots(4, 2, sharex="col", sharey="row", gridspec_kw=ratios)
    start, end = _close_up(signals.t)
    steps = np.diff(signals.t, prepend=signals.t[0])
    there = np.where(steps > 3.0 * np.median(steps), np.nan, 1.0)  # no line crosses a gap of the log
    inside = (signals.t >= start) & (signals.t <= end)
    for column, (shown, drawn) in enumerate(((signals.t >= signals.t[0], methods[:1]), (inside, methods))):
        t = signals.t[shown]
        for joint in range(2):
            torque, residual = grid[2 * joint, column], grid[2 * joint + 1, column]
            measured = (there * signals.tau[joint])[shown]
            torque.plot(t, measured, label="Measured", **style.STROKES["actual"])
            for method in drawn:
                rebuilt = (there * signals.rebuilt[method][joint])[shown]
                torque.plot(t, rebuilt, label=label(titles[method]), **stroke(titles, method))
                residual.plot(t, measured - rebuilt, **stroke(titles, method))
    for joint, name in enumerate(JOINTS):
        title = style.SERIES_LABELS[name]
        grid[2 * joint, 0].set_title(title)
        grid[2 * joint, 1].set_title(f"{title}, {start:.1f}{style.DASH}{end:.1f} s")
        for row, words in ((2 * joint, TORQUE), (2 * joint + 1, "Residual (N·m)")):
            grid[row, 0].set_ylabel(words)
            grid[row, 0].axvspan(start, end, color="0.92", lw=0, zorder=0)
            style.few_ticks(grid[row, 0])
    for axes in grid[-1]:
        axes.set_xlabel(TIME)
    figure.align_ylabels(grid[:, 0])
    _legend(figure, grid[0, 1], simulated)
    return figure


def _check(curves: Mapping[str, Array], methods: Sequence[str]) -> None:
    if not methods:
        raise ValueError("methods: at least one must be drawn.")
    for method in methods:
        if method not in curves:
            raise ValueError(f"methods: there is no curve of {method!r}, only of {', '.join(curves) or 'none'}.")


def _close_up(t: Array) -> tuple[float, float]:
    """Start and end of the close-up: the middle of the log, s."""
    length = float(t[-1] - t[0])
    part = min(max(_CLOSE_UP_PART * length, _CLOSE_UP_LEAST), length)
    start = float(np.clip(np.median(t) - 0.5 * part, t[0], t[-1] - part))
    return start, start + part


def spectra(signals: Signals, methods: Sequence[str], titles: Mapping[str, str], simulated: bool = False) -> Figure:
    """Amplitude spectra of the measured and the rebuilt torque.

    Frequencies above the last at which any curve of either joint reaches a thousandth of its largest amplitude are left
    out.
    """
    _check(signals.rebuilt_spectrum, methods)
    figure = style.new_figure(style.PAGE, 2.5)
    panels = figure.subplots(1, 2, sharex=True, sharey=True)
    curves = np.stack([signals.tau_spectrum, *(signals.rebuilt_spectrum[method] for method in methods)])
    largest = float(curves.max()) or 1.0
    loud = (curves >= 10 * _FLOOR * largest).any(axis=(0, 1))
    last = float(signals.frequency[loud].max(initial=signals.frequency[1]))
    shown = (signals.frequency > 0.0) & (signals.frequency <= last)
    f = signals.frequency[shown]
    for joint, axes in enumerate(panels):
        axes.plot(f, _above_zero(signals.tau_spectrum[joint, shown]), label="Measured", **style.STROKES["actual"])
        for method in methods:
            values = _above_zero(signals.rebuilt_spectrum[method][joint, shown])
            axes.plot(f, values, label=label(titles[method]), **stroke(titles, method))
        axes.set_title(style.SERIES_LABELS[JOINTS[joint]])
        axes.set_xlabel("Frequency (Hz)")
    _logarithmic(panels[0])
    panels[0].set_ylim(_FLOOR * largest, 2.0 * largest)
    panels[0].set_ylabel("Amplitude (N·m)")
    _legend(figure, panels[0], simulated)
    return figure


def _above_zero(values: Array) -> Array:
    """Values that a logarithmic axis can show; others become gaps."""
    return np.where(values > 0.0, values, np.nan)


def _logarithmic(axes: Axes) -> None:
    """Make both axes logarithmic, with plain numbers of hertz where the axis spans few decades."""
    axes.set_xscale("log")
    axes.set_yscale("log")
    first, last = axes.get_xlim()
    steps = (1.0, 2.0, 5.0) if np.log10(last / first) < _MOST_DECADES else (1.0,)
    axes.xaxis.set_major_locator(LogLocator(subs=steps))
    axes.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_minor_locator(LogLocator(subs=(2.0, 5.0)))


def cutoff(curve: Cutoff, simulated: bool = False) -> Figure:
    """The two curves that the cut-off is chosen by."""
    figure = style.new_figure(style.PAGE, 2.4)
    panels = figure.subplots(1, 2, sharex=True)
    shown = (curve.frequency > 0.0) & (curve.frequency <= _CUTOFF_VIEW * curve.highest)
    f = curve.frequency[shown]
    drawn = ((curve.position, curve.above_noise), (curve.coherence, curve.explained))
    for axes, (values, limit) in zip(panels, drawn, strict=True):
        for joint, name in enumerate(("joint1", "joint2")):
            axes.plot(f, _above_zero(values[joint, shown]), label=style.SERIES_LABELS[name], **style.STROKES[name])
        axes.axhline(limit, label="Least that is kept", color="0.35", ls=(0, (1.2, 1.2)), lw=1.2)
        axes.axvline(curve.hertz, label=f"Cut-off, {curve.hertz:.3g} Hz", color="#8c1d04", ls=(0, (5, 2)), lw=1.2)
        axes.axvspan(f[0], curve.hertz, color=style.FILL_LIGHT, lw=0, alpha=0.5, zorder=0, label="Kept")
        axes.set_xlabel("Frequency (Hz)")
    _logarithmic(panels[0])
    panels[0].set_ylabel("Position over its noise (1)")
    panels[1].set_ylim(0.0, 1.05)
    panels[1].set_ylabel("Torque explained by Eq. 1 (1)")
    _legend(figure, panels[0], simulated)
    return figure
