"""Where the boxes and arrows of a diagram stand, in inches from its lower left corner."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from repro.exhibits import style

Point = tuple[float, float]
Shape = Literal["block", "outside", "step", "decision", "end", "frame"]
Side = Literal["left", "center", "right"]
Flow = Literal["downlink", "uplink", "inner"]

#: From the edge of a box to its words, in.
INSET = 0.05


@dataclass(frozen=True)
class Box:
    """Where a box stands."""

    left: float  # of its rectangle, or the one around a diamond, and so below
    bottom: float
    width: float
    height: float
    # a decision is a diamond, a frame a dashed rectangle behind others with its words at the top
    shape: Shape = "block"

    @property
    def room(self) -> tuple[float, float]:
        """Width and height left to words; a diamond gives a line in its middle most of its width."""
        part = 0.78 if self.shape == "decision" else 1.0
        return part * self.width - 2 * INSET, self.height - INSET


@dataclass(frozen=True)
class Route:
    """Where a link runs."""

    start: str  # box it leaves; then the one it reaches
    end: str
    corners: tuple[Point, ...]  # from edge to edge, in
    label: Point | None = None  # where its label stands, in; None where it has none
    side: Side = "center"  # which part of the label stands there
    flow: Flow = "inner"  # what it carries, which gives its colour
    both: bool = False  # whether it points both ways


@dataclass(frozen=True)
class Layout:
    """Places of everything in a diagram."""

    width: float  # of the figure, in
    height: float
    boxes: Mapping[str, Box]  # by name; frames come before what stands on them
    routes: Mapping[str, Route]  # by name
    type_size: float = style.TEXT_SIZE  # points
    junctions: tuple[Point, ...] = ()  # where a link branches off another
    # entries of the legend: a flow, a shape, or ``inferred``; empty for no legend
    legend: tuple[tuple[str, str], ...] = ()
    columns: int = 5  # of the legend
