"""Boxes and arrows (Figures 2 to 4): words from a table, places from ``diagrams/layouts.yaml``."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd
import yaml
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyBboxPatch, Polygon, Rectangle

from repro.errors import InputError
from repro.exhibits import style
from repro.exhibits.markup import formula, plain

#: Words and layouts of the drawings.
DIAGRAMS = Path(__file__).parent / "diagrams"

Point = tuple[float, float]

#: From the edge of a box to its words, in.
INSET = 0.05

_FILLS: Mapping[str, str] = {
    "block": style.FILL_LIGHT,
    "outside": "white",
    "step": style.FILL_LIGHT,
    "decision": "#f3c77d",
    "end": "white",
    "frame": "0.96",
}

#: Strokes of links by flow; a link that is only inferred has `_INFERRED` instead.
FLOWS: Mapping[str, Mapping[str, Any]] = {
    "downlink": {"color": style.STROKES["joint1"]["color"], "lw": 1.0},
    "uplink": {"color": style.STROKES["joint2"]["color"], "lw": 1.0, "ls": (0, (4.5, 1.5))},
    "inner": {"color": style.INK, "lw": 1.0},
}
_INFERRED: Mapping[str, Any] = {"color": style.INK, "lw": 0.8, "ls": (0, (1.0, 1.2))}

_LEADING = 0.0175  # from one line of words to the next, in for each point of type
_LETTER = 0.0061  # mean width of a letter, in for each point of type
_WORD = re.compile(r"(?:`[^`]*`|[^\s`])+")


def layout_of(name: str) -> dict[str, Any]:
    """Places of everything in a drawing, in inches from its lower left corner."""
    layout: dict[str, Any] = yaml.safe_load((DIAGRAMS / "layouts.yaml").read_text(encoding="utf-8"))[name]
    return layout


@dataclass(frozen=True)
class Box:
    """Where a box is: its rectangle, or the one around a diamond."""

    left: float
    bottom: float
    width: float
    height: float
    # a decision is a diamond, a frame a dashed rectangle behind other boxes with its words at the top
    shape: str = "block"

    @property
    def room(self) -> tuple[float, float]:
        """Width and height for words; a diamond gives a line in its middle most of its width."""
        part = 0.78 if self.shape == "decision" else 1.0
        return part * self.width - 2 * INSET, self.height - INSET


@dataclass(frozen=True)
class Route:
    """Where a link runs."""

    corners: Sequence[Point]  # from edge to edge
    label: Point | None = None  # where its label is; None where it has none
    side: str = "center"  # which part of the label is there
    flow: str = "inner"  # what it carries, which gives its colour
    both: bool = False  # whether it points both ways


@dataclass(frozen=True)
class Layout:
    """Places of everything in a diagram of boxes and arrows."""

    size: tuple[float, float]  # of the figure
    type_size: float  # points
    boxes: Mapping[str, Box]  # frames come before what is on them
    routes: Mapping[str, Route]
    junctions: Sequence[Point] = ()  # where a link branches off another
    legend: Mapping[str, str] | None = None  # texts by a flow, a shape, or ``inferred``
    columns: int = 5  # of the legend

    @classmethod
    def read(cls, name: str) -> "Layout":
        """Read the layout of a figure."""
        content = layout_of(name)
        boxes = {key: Box(*place) for key, place in content.pop("boxes").items()}
        routes = {key: Route(**route) for key, route in content.pop("routes").items()}
        return cls(boxes=boxes, routes=routes, **content)


def _rendered(word: str) -> tuple[str, int]:
    """A word with its formulas in maths, and how many letters wide it is."""
    shown, letters = "", 0
    for place, part in enumerate(word.split("`")):
        text = formula(part) if place % 2 else plain(part)
        shown += text.tex if place % 2 else part.replace("$", r"\$")
        letters += len(text.md)
    return shown, letters


def _wrap(label: str, letters: int) -> list[str]:
    """Break a label into lines of so many letters; a formula between backticks stays whole."""
    lines: list[str] = []
    width = letters + 1
    for word in _WORD.findall(label.replace(" x ", style.TIMES)):
        shown, size = _rendered(word)
        if width + 1 + size > letters:
            lines.append(shown)
            width = size
        else:
            lines[-1] += f" {shown}"
            width += 1 + size
    return lines


def _read(frame: pd.DataFrame, layout: Layout) -> tuple[dict[str, list[tuple[str, bool]]], dict[str, tuple[str, bool]]]:
    """Lines of each box and label of each link, each with whether it is only inferred; ``-`` stands for nothing."""
    of_boxes, of_links = (frame[frame["element"] == kind] for kind in ("box", "link"))
    lines: dict[str, list[tuple[str, bool]]] = {name: [] for name in layout.boxes}
    for name, label, basis in of_boxes[["name", "label", "basis"]].itertuples(index=False):
        width, height = layout.boxes[name].room
        if label != "-":
            wrapped = _wrap(label, int(width / (_LETTER * layout.type_size)))
            lines[name] += [(line, basis == "inferred") for line in wrapped]
        room = int(height / (_LEADING * layout.type_size)) - 1
        if len(lines[name]) > room:
            raise InputError.at(f"box {name}: label", f"{len(lines[name])} lines of words", f"at most {room}")
    rows = of_links[["name", "label", "basis"]].itertuples(index=False)
    return lines, {name: (" ".join(_wrap(label, len(label))), basis == "inferred") for name, label, basis in rows}


def _patch(box: Box) -> FancyBboxPatch | Polygon | Rectangle:
    """Outline of a box."""
    look: dict[str, Any] = {"facecolor": _FILLS[box.shape], "edgecolor": style.INK, "lw": 0.6}
    corner, width, height = (box.left, box.bottom), box.width, box.height
    if box.shape == "frame":
        return Rectangle(corner, width, height, ls=(0, (3, 2)), **look)
    if box.shape == "decision":
        x, y = box.left + width / 2, box.bottom + height / 2
        return Polygon([(box.left, y), (x, box.bottom), (box.left + width, y), (x, box.bottom + height)], **look)
    radius = height / 2 if box.shape == "end" else 0.04
    return FancyBboxPatch(corner, width, height, boxstyle=f"round,pad=0,rounding_size={radius}", **look)


def _draw_box(axes: Axes, name: str, box: Box, lines: Sequence[tuple[str, bool]], size: float) -> None:
    """Draw a box, its name in bold, and its lines; what is only inferred stands in italics."""
    axes.add_patch(_patch(box))
    step = _LEADING * size
    x, y = box.left + box.width / 2, box.bottom + (box.height + step * len(lines)) / 2
    if box.shape == "frame":
        y = box.bottom + box.height - INSET - step / 2
    text: dict[str, Any] = {"fontsize": size, "ha": "center", "va": "center"}
    axes.text(x, y, name, weight="bold", **text)
    for row, (line, inferred) in enumerate(lines, start=1):
        axes.text(x, y - step * row, line, style="italic" if inferred else "normal", **text)


def _draw_link(axes: Axes, route: Route, label: str, inferred: bool, size: float) -> None:
    """Draw an arrow along its route with its label."""
    stroke = _INFERRED if inferred else FLOWS[route.flow]
    axes.plot(*zip(*route.corners, strict=True), **stroke)
    head = {"arrowstyle": "-|>", "color": stroke["color"], "shrinkA": 0, "shrinkB": 0, "lw": 0.0, "mutation_scale": 7}
    axes.annotate("", route.corners[-1], route.corners[-2], arrowprops=head)
    if route.both:
        axes.annotate("", route.corners[0], route.corners[1], arrowprops=head)
    if route.label is not None:
        look = "italic" if inferred else "normal"
        axes.text(*route.label, label, fontsize=size, ha=route.side, va="center", style=look)


def draw_diagram(frame: pd.DataFrame, target: str) -> Figure:
    """Draw the diagram of a figure."""
    layout = Layout.read(target)
    lines, links = _read(frame, layout)
    figure, axes = style.inches(*layout.size)
    for name, box in layout.boxes.items():
        _draw_box(axes, name, box, lines[name], layout.type_size)
    for name, route in layout.routes.items():
        _draw_link(axes, route, *links[name], layout.type_size)
    for place in layout.junctions:
        axes.add_patch(Circle(place, 0.022, color=style.INK, lw=0.0, zorder=3))
    for key, label in (layout.legend or {}).items():
        if key in _FILLS:
            axes.add_patch(Rectangle((0, 0), 0, 0, facecolor=_FILLS[key], edgecolor=style.INK, lw=0.6, label=label))
        else:
            axes.plot((), (), label=label, **FLOWS.get(key, _INFERRED))
    if layout.legend:
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 0.0), ncols=layout.columns, fontsize=layout.type_size)
    return figure
