"""Where the boxes and arrows of a diagram stand, in inches from its lower left corner."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from repro.render import style

Point = tuple[float, float]
Shape = Literal["block", "outside", "step", "decision", "end", "frame"]
Side = Literal["left", "center", "right"]
Flow = Literal["downlink", "uplink", "inner"]

#: From the edge of a box to its words, in.
INSET = 0.05


@dataclass(frozen=True)
class Box:
    """Where a box stands.

    Attributes
    ----------
    left, bottom, width, height : float
        Its rectangle, or the one around a diamond.
    shape : Shape
        A decision is a diamond, a frame a dashed rectangle behind others with its words at the top.
    """

    left: float
    bottom: float
    width: float
    height: float
    shape: Shape = "block"

    @property
    def room(self) -> tuple[float, float]:
        """Width and height left to words; a diamond gives a line in its middle most of its width."""
        part = 0.78 if self.shape == "decision" else 1.0
        return part * self.width - 2 * INSET, self.height - INSET


@dataclass(frozen=True)
class Route:
    """Where a link runs.

    Attributes
    ----------
    start, end : str
        Boxes it leaves and reaches.
    corners : tuple of Point
        From edge to edge, in.
    label : Point or None
        Where its label stands, in; None where it has none.
    side : Side
        Which part of the label stands there.
    flow : Flow
        What it carries, which gives its colour.
    both : bool
        Whether it points both ways.
    """

    start: str
    end: str
    corners: tuple[Point, ...]
    label: Point | None = None
    side: Side = "center"
    flow: Flow = "inner"
    both: bool = False


@dataclass(frozen=True)
class Layout:
    """Places of everything in a diagram.

    Attributes
    ----------
    width, height : float
        Of the figure, in.
    boxes : mapping of str to Box
        By name; frames come before what stands on them.
    routes : mapping of str to Route
        By name.
    type_size : float
        Points.
    junctions : tuple of Point
        Where a link branches off another.
    legend : tuple of (key, label)
        Entries of the legend: a flow, a shape, or ``inferred``; empty for no legend.
    columns : int
        Of the legend.
    """

    width: float
    height: float
    boxes: Mapping[str, Box]
    routes: Mapping[str, Route]
    type_size: float = style.TEXT_SIZE
    junctions: tuple[Point, ...] = ()
    legend: tuple[tuple[str, str], ...] = ()
    columns: int = 5
