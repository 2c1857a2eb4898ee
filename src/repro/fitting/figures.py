"""Figures of the report as PNG files in memory: parameters, torques, spectra, and the choice of the cut-off."""

import io
from collections.abc import Mapping
from itertools import islice
from typing import Any, Final

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator, StrMethodFormatter
from PIL import Image

from repro.drawing import style
from repro.drawing.markup import unit
from repro.drawing.panels import JOINTS, TIME, TORQUE
from repro.fitting.result import Curves, Parameter, Result, Signals
from repro.identification.filtering import MIN_COHERENCE, MIN_SIGNAL_TO_NOISE, Cutoff
from repro.model.parameters import Array

DPI = 200  # dots per inch: 1432 pixels for the width of a page
_COLOURS = 96  # colours of a picture; lines and their soft edges need no more, and the file is a third as large
MAX_DRAWN_LOGS = 8  # logs whose curves are drawn, so that the page stays light
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
_CLOSE_UP_PART, _MIN_CLOSE_UP_S = 1 / 8, 2.0  # the close-up shows this part of the log, but at least so many seconds
_MIN_AMPLITUDE_RATIO = 1e-4  # a spectrum is shown down to this part of its largest amplitude
_LINE = 0.17  # height of a line of the legend, inches
_MAX_DECADES = 3.0  # a frequency axis of fewer decades also names 2 and 5 of each
_CUTOFF_VIEW = 2.0  # frequencies shown of the choice of the cut-off, over the highest that could have been chosen
#: Panels by row: inertia; gravity, viscous and Coulomb friction of joint 1; the same of joint 2.
PANELS: Final = (("I1", "I2", "I3"), ("g1", "b1", "k1"), ("g2", "b2", "k2"))
#: A panel reaches this many median deviations of its points from their median; an arrow marks a point outside.
_MAX_DEVIATIONS = 12.0


def figures_of(result: Result, curves: Curves) -> dict[str, bytes]:
    """Draw all figures of the report."""
    titles = ordered_titles(result)
    best = dict(islice(titles.items(), 1))
    with style.house_style(), rc_context({"axes.titley": 1.0}):  # nothing is above the panels that a title could meet
        figures = {"parameters": _png(draw_parameters(result))}
        if curves.cutoff is not None:
            figures["cutoff"] = _png(draw_cutoff(curves.cutoff, result.simulated))
        for place, signals in enumerate(curves.signals[:MAX_DRAWN_LOGS]):
            figures[f"overlay-{place}"] = _png(draw_overlay(signals, best, result.simulated))
            figures[f"spectra-{place}"] = _png(draw_spectra(signals, best, result.simulated))
    return figures


def _png(figure: Figure) -> bytes:
    """Save with few colours, without date or version."""
    figure.set_dpi(DPI)
    canvas, small = FigureCanvasAgg(figure), io.BytesIO()
    # Once, where saving would draw once more for the layout.
    canvas.draw()  # type: ignore[no-untyped-call]
    image = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")  # type: ignore[no-untyped-call]
    image.quantize(_COLOURS, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE).save(small, "PNG", compress_level=4)
    return small.getvalue()


def ordered_titles(result: Result) -> dict[str, str]:
    """Name every method in the order of the figures: the recommended one first."""
    methods = sorted(result.methods, key=lambda method: method.method != result.recommended)
    return {method.method: method.title for method in methods}


def stroke(titles: Mapping[str, str], method: str) -> dict[str, Any]:
    """Give the line style of a method, by its place in `titles`."""
    return STROKES[list(titles).index(method) % len(STROKES)]


def label(title: str) -> str:
    """Escape a text for matplotlib: no mathematics between dollars, no leading underscore that hides it in a legend."""
    return title.replace("$", r"\$").lstrip("_")


def _figure(height: float) -> Figure:
    """Make an empty figure as wide as a page, without the automatic spacing, which takes a third of the drawing."""
    return Figure(figsize=(style.PAGE, height))


def _place(figure: Figure, left: float, below: float, above: float, across: float = 0.0, down: float = 0.0) -> None:
    """Arrange the panels: inches around all of them, and gaps as shares of a panel's width and height."""
    width, height = figure.get_size_inches()
    edges = {"left": left / width, "right": 1.0 - 0.15 / width, "bottom": below / height, "top": 1.0 - above / height}
    figure.subplots_adjust(**edges, wspace=across, hspace=down)


def _legend(figure: Figure, axes: Axes, simulated: bool) -> float:
    """Put the legend above all panels, and over it that the log is simulated; return its height in inches."""
    entries = len(axes.get_legend_handles_labels()[0])
    style.legend_above(figure, axes, min(entries, 4), style.SIMULATED if simulated else None)
    return _LINE * (-(-entries // 4) + simulated)


def draw_overlay(signals: Signals, titles: Mapping[str, str], simulated: bool = False) -> Figure:
    """Draw measured and rebuilt torque of both joints with the residual below, the whole log next to a close-up."""
    figure = _figure(5.3)
    ratios = {"height_ratios": (1.7, 1.0, 1.7, 1.0), "width_ratios": (1.6, 1.0)}
    grid, methods = figure.subplots(4, 2, sharex="col", sharey="row", gridspec_kw=ratios), list(titles)
    length = float(signals.t[-1] - signals.t[0])
    part = min(max(_CLOSE_UP_PART * length, _MIN_CLOSE_UP_S), length)
    start = float(np.clip(np.median(signals.t) - 0.5 * part, signals.t[0], signals.t[-1] - part))
    end = start + part
    steps = np.diff(signals.t, prepend=signals.t[0])
    mask = np.where(steps > 3.0 * np.median(steps), np.nan, 1.0)  # no line crosses a gap of the log
    inside = (signals.t >= start) & (signals.t <= end)
    for joint, name in enumerate(JOINTS):
        for column, shown in enumerate((signals.t >= signals.t[0], inside)):
            t, (torque, residual) = signals.t[shown], grid[2 * joint : 2 * joint + 2, column]
            measured = (mask * signals.tau[joint])[shown]
            torque.plot(t, measured, label="Measured", **style.STROKES["actual"])
            for method in methods:
                rebuilt = (mask * signals.rebuilt[method][joint])[shown]
                torque.plot(t, rebuilt, label=label(titles[method]), **stroke(titles, method))
                residual.plot(t, measured - rebuilt, **stroke(titles, method))
        title = style.SERIES_LABELS[name]
        grid[2 * joint, 0].set_title(title)
        grid[2 * joint, 1].set_title(f"{title}, {start:.1f}{style.DASH}{end:.1f} s")
        for row, label_text in ((2 * joint, TORQUE), (2 * joint + 1, "Residual (N·m)")):
            grid[row, 0].set_ylabel(label_text)
            grid[row, 0].axvspan(start, end, color="0.92", lw=0, zorder=0)
            style.few_ticks(grid[row, 0])
    for axes in grid[-1]:
        axes.set_xlabel(TIME)
    figure.align_ylabels(grid[:, 0])
    _place(figure, 0.7, 0.32, 0.26 + _legend(figure, grid[0, 1], simulated), 0.04, 0.22)
    return figure


def draw_spectra(signals: Signals, titles: Mapping[str, str], simulated: bool = False) -> Figure:
    """Draw amplitude spectra of both torques, up to the last frequency with a thousandth of the largest amplitude."""
    figure = _figure(2.5)
    panels = figure.subplots(1, 2, sharex=True, sharey=True)
    curves = np.stack([signals.tau_spectrum, *(signals.rebuilt_spectrum[method] for method in titles)])
    largest = float(curves.max()) or 1.0
    loud = (curves >= 10 * _MIN_AMPLITUDE_RATIO * largest).any(axis=(0, 1))
    last = float(signals.frequency[loud].max(initial=signals.frequency[1]))
    shown = (signals.frequency > 0.0) & (signals.frequency <= last)
    f = signals.frequency[shown]
    for joint, axes in enumerate(panels):
        axes.plot(f, _above_zero(signals.tau_spectrum[joint, shown]), label="Measured", **style.STROKES["actual"])
        for method in titles:
            values = _above_zero(signals.rebuilt_spectrum[method][joint, shown])
            axes.plot(f, values, label=label(titles[method]), **stroke(titles, method))
        axes.set_title(style.SERIES_LABELS[JOINTS[joint]])
        axes.set_xlabel("Frequency (Hz)")
    _logarithmic(panels[0])
    panels[0].set_ylim(_MIN_AMPLITUDE_RATIO * largest, 2.0 * largest)
    panels[0].set_ylabel("Amplitude (N·m)")
    _place(figure, 0.55, 0.32, 0.26 + _legend(figure, panels[0], simulated), 0.04)
    return figure


def _above_zero(values: Array) -> Array:
    """Replace values that a logarithmic axis cannot show by gaps."""
    return np.where(values > 0.0, values, np.nan)


def _logarithmic(axes: Axes) -> None:
    """Make both axes logarithmic, with plain numbers of hertz where the axis spans few decades."""
    axes.set_xscale("log")
    axes.set_yscale("log")
    first, last = axes.get_xlim()
    steps = (1.0, 2.0, 5.0) if np.log10(last / first) < _MAX_DECADES else (1.0,)
    axes.xaxis.set_major_locator(LogLocator(subs=steps))
    axes.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.yaxis.set_minor_locator(NullLocator())


def draw_cutoff(curve: Cutoff, simulated: bool = False) -> Figure:
    """Draw the two curves that decide the cut-off."""
    figure = _figure(2.4)
    panels = figure.subplots(1, 2, sharex=True)
    shown = (curve.frequency > 0.0) & (curve.frequency <= _CUTOFF_VIEW * curve.highest)
    f = curve.frequency[shown]
    drawn = ((curve.position, MIN_SIGNAL_TO_NOISE), (curve.coherence, MIN_COHERENCE))
    for axes, (values, limit) in zip(panels, drawn, strict=True):
        for joint, name in enumerate(JOINTS):
            axes.plot(f, _above_zero(values[joint, shown]), label=style.SERIES_LABELS[name], **style.STROKES[name])
        axes.axhline(limit, label="Least that is kept", color="0.35", ls=(0, (1.2, 1.2)), lw=1.2)
        axes.axvline(curve.hertz, label=f"Cut-off, {curve.hertz:.3g} Hz", color="#8c1d04", ls=(0, (5, 2)), lw=1.2)
        axes.axvspan(f[0], curve.hertz, color=style.FILL_LIGHT, lw=0, alpha=0.5, zorder=0, label="Kept")
        axes.set_xlabel("Frequency (Hz)")
    _logarithmic(panels[0])
    panels[0].set_ylabel("Position over its noise (1)")
    panels[1].set_ylim(0.0, 1.05)
    panels[1].set_ylabel("Torque explained by Eq. 1 (1)")
    _place(figure, 0.55, 0.32, 0.1 + _legend(figure, panels[0], simulated), 0.16)
    return figure


def draw_parameters(result: Result) -> Figure:
    """Draw estimate and 95 % interval of each parameter by each method, one panel a parameter."""
    titles = ordered_titles(result)
    estimates = {m.method: {parameter.name: parameter for parameter in m.parameters} for m in result.methods}
    panel = 0.17 * len(titles)
    figure = _figure(0.4 + 3 * (panel + 0.4))
    grid = figure.subplots(3, 3, sharey=True)
    for row, names in zip(grid, PANELS, strict=True):
        for axes, name in zip(row, names, strict=True):
            _panel(axes, {method: estimates[method][name] for method in titles}, titles)
        row[0].set_yticks(range(len(titles)), [label(title) for title in titles.values()])
    grid[0, 0].set_ylim(len(titles) - 0.5, -0.5)
    legend = "Mark: estimate; bar: 95 % interval, where the method claims one"
    figure.suptitle(f"{style.SIMULATED}. {legend}" if result.simulated else legend, fontsize=style.TEXT_SIZE)
    longest = max(len(label(title)) for title in titles.values())
    _place(figure, 0.1 + 0.045 * longest, 0.4, 0.3, 0.08, 0.4 / panel)
    return figure


def _panel(axes: Axes, estimates: dict[str, Parameter], titles: dict[str, str]) -> None:
    """Draw one parameter: the methods in their order from top to bottom."""
    low, high = _view(list(estimates.values()))
    for place, (method, parameter) in enumerate(estimates.items()):
        colour = stroke(titles, method)["color"]
        if low <= parameter.estimate <= high:
            mark, fill = MARKS[place % len(MARKS)], "none" if place else "full"
            axes.plot(parameter.estimate, place, mark, color=colour, fillstyle=fill, ms=4.0, zorder=3)
            if parameter.low is not None and parameter.high is not None:
                ends = max(parameter.low, low), min(parameter.high, high)
                axes.plot(ends, (place, place), color=colour, lw=1.3, solid_capstyle="butt")
        else:
            _arrow(axes, parameter.estimate, place, parameter.estimate > high, colour)
    if low <= 0.0 <= high:
        axes.axvline(0.0, color="0.35", lw=0.6, zorder=1)
    first = next(iter(estimates.values()))
    axes.set_xlim(low, high)
    axes.xaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 2.5, 5, 10]))
    axes.set_xlabel(f"{first.name} ({unit(first.unit).md})")
    axes.tick_params(axis="y", length=0)
    axes.grid(visible=False, axis="y")


def _arrow(axes: Axes, value: float, place: int, right: bool, colour: str) -> None:
    """Mark at the edge an estimate that is outside the panel."""
    edge, inwards, mark, side = (1.0, -1, ">", "right") if right else (0.0, 1, "<", "left")
    transform = axes.get_yaxis_transform()
    axes.plot(edge, place, mark, color=colour, ms=4.0, transform=transform, clip_on=False, zorder=3)
    look: dict[str, Any] = {"ha": side, "va": "center", "size": style.SMALL_SIZE, "color": colour}
    axes.annotate(f"{value:.3g}", (edge, place), (6 * inwards, 0), transform, "offset points", **look)


def _view(estimates: list[Parameter]) -> tuple[float, float]:
    """Find the limits of a panel: all intervals and estimates but outliers, which would squeeze the others."""
    values = np.array([(p.estimate, p.low, p.high) for p in estimates], dtype=np.float64)  # NaN where there is none
    values[np.isinf(values)] = np.nan
    points, ends, widths = (x[~np.isnan(x)] for x in (values[:, 0], values, values[:, 2] - values[:, 1]))
    middle = float(np.median(points)) if points.size else 0.0
    spread = max(float(np.median(np.abs(points - middle))), 0.5 * float(np.median(widths)) if widths.size else 0.0)
    reach = _MAX_DEVIATIONS * (spread or 0.1 * abs(middle) or 1.0)
    inside = ends[np.abs(ends - middle) <= reach]
    low, high = float(inside.min(initial=middle)), float(inside.max(initial=middle))
    margin = 0.06 * (high - low) or 0.05 * abs(middle) or 1.0
    return low - margin, high + margin
