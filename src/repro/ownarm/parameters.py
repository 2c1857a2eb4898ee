"""Parameters of one's own arm, all methods side by side, a panel for each of the nine."""

from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from repro.exhibits import style
from repro.exhibits.markup import unit
from repro.ownarm.overlays import MARKS, label, ordered_titles, stroke
from repro.ownarm.result import Parameter, Result

#: Panels by row: inertia; gravity, viscous and Coulomb friction of joint 1; the same of joint 2.
PANELS: Final = (("I1", "I2", "I3"), ("g1", "b1", "k1"), ("g2", "b2", "k2"))

#: A panel reaches this many times the middle spread of all its points from their median; what lies beyond is an arrow.
_REACH = 12.0


def parameters(result: Result) -> Figure:
    """Estimate and 95 % interval of each parameter by each method."""
    titles = ordered_titles(result)
    found = {m.method: {parameter.name: parameter for parameter in m.parameters} for m in result.methods}
    figure = style.new_figure(style.PAGE, 1.2 + 3 * (0.35 + 0.17 * len(titles)))
    grid = figure.subplots(3, 3, sharey=True)
    for row, names in zip(grid, PANELS, strict=True):
        for axes, name in zip(row, names, strict=True):
            _panel(axes, {method: found[method][name] for method in titles}, titles)
        row[0].set_yticks(range(len(titles)), [label(title) for title in titles.values()])
    grid[0, 0].set_ylim(len(titles) - 0.5, -0.5)
    words = "Mark: estimate; bar: 95 % interval, where the method claims one"
    figure.suptitle(f"{style.SIMULATED}. {words}" if result.simulated else words, fontsize=style.TEXT_SIZE)
    return figure


def _panel(axes: Axes, found: dict[str, Parameter], titles: dict[str, str]) -> None:
    """Draw one parameter: the methods in their order from top to bottom."""
    low, high = _view(list(found.values()))
    for place, (method, parameter) in enumerate(found.items()):
        colour = stroke(titles, method)["color"]
        if low <= parameter.estimate <= high:
            filled = "full" if place == 0 else "none"
            mark: dict[str, Any] = {"marker": MARKS[place % len(MARKS)], "markersize": 4.0, "fillstyle": filled}
            axes.plot(parameter.estimate, place, color=colour, ls="none", zorder=3, **mark)
            if parameter.low is not None and parameter.high is not None:
                axes.hlines(place, max(parameter.low, low), min(parameter.high, high), color=colour, lw=1.3)
        else:
            _arrow(axes, parameter.estimate, place, parameter.estimate > high, colour)
    if low <= 0.0 <= high:
        axes.axvline(0.0, color="0.35", lw=0.6, zorder=1)
    first = next(iter(found.values()))
    axes.set_xlim(low, high)
    axes.xaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 2.5, 5, 10]))
    axes.set_xlabel(f"${first.name[0]}_{first.name[1:]}$ ({unit(first.unit).md})")
    axes.tick_params(axis="y", length=0)
    axes.grid(visible=False, axis="y")


def _arrow(axes: Axes, value: float, place: int, right: bool, colour: str) -> None:
    """Say at the edge that an estimate lies beyond it."""
    edge, inwards = (1.0, -1) if right else (0.0, 1)
    mark = ">" if right else "<"
    transform = axes.get_yaxis_transform()
    axes.plot(edge, place, mark, color=colour, ms=4.0, transform=transform, clip_on=False, zorder=3)
    axes.annotate(
        f"{value:.3g}",
        (edge, place),
        xycoords=transform,
        xytext=(6 * inwards, 0),
        textcoords="offset points",
        ha="right" if right else "left",
        va="center",
        size=style.SMALL_SIZE,
        color=colour,
    )


def _view(found: list[Parameter]) -> tuple[float, float]:
    """Limits of a panel: all intervals and estimates, but not so far that one of them squeezes the others."""
    points = np.array([p.estimate for p in found if np.isfinite(p.estimate)])
    given = [end for p in found for end in (p.low, p.high, p.estimate) if end is not None]
    ends = np.array([end for end in given if np.isfinite(end)])
    middle = float(np.median(points)) if points.size else 0.0
    bars = [p.high - p.low for p in found if p.low is not None and p.high is not None]
    widths = [width for width in bars if np.isfinite(width)]
    spread = max(float(np.median(np.abs(points - middle))), 0.5 * float(np.median(widths)) if widths else 0.0)
    reach = _REACH * (spread or 0.1 * abs(middle) or 1.0)
    inside = ends[np.abs(ends - middle) <= reach]
    low, high = float(inside.min(initial=middle)), float(inside.max(initial=middle))
    margin = 0.06 * (high - low) or 0.05 * abs(middle) or 1.0
    return low - margin, high + margin
