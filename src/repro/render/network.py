"""The network's architecture (Fig. 7), every size taken from the table it is given."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from repro.exhibits import style

KINDS = ("input", "convolution", "max pool", "fully connected", "output")

#: Layers from left to right with their activation (Eq. 12, 13).
_ACTIVATIONS = {
    "input": style.DASH,
    "conv1": "ReLU",
    "pool1": style.DASH,
    "conv2": "ReLU",
    "pool2": style.DASH,
    "conv3": "ReLU",
    "fc4": "ReLU",
    "fc5": "ReLU",
    "output": "sigmoid",
}
_FILLS = {
    "input": "white",
    "convolution": style.FILL_DARK,
    "max pool": style.FILL_LIGHT,
    "fully connected": "#f3c77d",
    "output": "#b3541e",
}

# Measures of the drawing, in.
_HEIGHT = 2.15
_LARGEST = 0.74  # side of the largest map, or length of the longest bar
_SHEET = 0.016  # shift from one map of a stack to the next
_BAR = 0.09  # width of a fully connected layer
_NARROWEST = 0.62  # room for the words below a layer
_HEADINGS = 0.66  # room for the row headings
_MARGIN = 0.06
_AXIS = 1.55  # height of the line on which all layers are centred
_ROW = 0.15  # from one row of words to the next
_FIRST_ROW = 0.88


@dataclass(frozen=True)
class _Layer:
    """One row of the table."""

    name: str
    kind: str
    height: int
    width: int
    channels: int
    kernel: str
    parameters: int

    @property
    def is_map(self) -> bool:
        """Whether the layer is drawn as a stack of maps; otherwise it is a bar."""
        return self.kind in KINDS[:3]

    @property
    def length(self) -> int:
        """What is drawn to scale: the side of a map, or the units of a bar."""
        return max(self.height, self.width) if self.is_map else self.channels

    @property
    def window(self) -> tuple[int, int]:
        """Height and width of the kernel."""
        height, width = (int(size) for size in self.kernel.split("x")[:2])
        return height, width

    @property
    def size(self) -> str:
        """Output size in words."""
        sizes = (self.height, self.width, self.channels) if self.is_map else (self.channels,)
        return style.TIMES.join(str(size) for size in sizes)


def _read(frame: pd.DataFrame) -> list[_Layer]:
    """Layers in drawing order."""
    columns = ["layer", "kind", "height", "width", "channels", "kernel", "parameters"]
    layers = [_Layer(*row) for row in frame[columns].fillna({"kernel": ""}).itertuples(index=False)]
    return sorted(layers, key=lambda layer: list(_ACTIVATIONS).index(layer.name))


class _Drawn:
    """A layer put on the page: a stack of maps from front to back, or a bar, in inches."""

    def __init__(self, axes: Axes, layer: _Layer, centre: float, scale: float) -> None:
        self.layer = layer
        sheets = layer.channels if layer.is_map else 1
        self.width = layer.width * scale if layer.is_map else _BAR
        self.height = (layer.height if layer.is_map else layer.channels) * scale
        self.depth = depth = _SHEET * (sheets - 1)
        self.left, self.bottom = centre - (self.width + depth) / 2, _AXIS - (self.height + depth) / 2
        self.right, self.top = self.left + self.width + depth, self.bottom + self.height + depth
        for sheet in reversed(range(sheets)):
            corner = (self.left + _SHEET * sheet, self.bottom + _SHEET * sheet)
            box = Rectangle(corner, self.width, self.height, facecolor=_FILLS[layer.kind], edgecolor=style.INK, lw=0.4)
            axes.add_patch(box)


def _connect(axes: Axes, before: _Drawn, after: _Drawn, scale: float) -> None:
    """Show what one output sees: a kernel window on the front map, or the whole layer."""
    line: dict[str, Any] = {"color": style.INK, "lw": 0.4, "ls": (0, (3, 1.5))}
    if after.layer.is_map:
        height, width = (size * scale for size in after.layer.window)
        x, y = before.left + 0.7 * before.width - width / 2, before.bottom + 0.6 * before.height
        axes.add_patch(Rectangle((x, y), width, height, facecolor="none", edgecolor=style.INK, lw=0.6))
        target = (after.left + 0.3 * after.width, after.bottom + 0.6 * after.height + height / 2)
        for corner in (y, y + height):
            axes.plot((x + width, target[0]), (corner, target[1]), **line)
    else:
        axes.plot((before.right, after.left), (before.top, after.top), **line)
        axes.plot((before.right, after.left), (before.bottom + before.depth, after.bottom), **line)


def network(frame: pd.DataFrame) -> Figure:
    """Architecture of the network with every size (Fig. 7)."""
    layers = _read(frame)
    figure = style.new_figure(style.PAGE, _HEIGHT)
    figure.set_layout_engine("none")  # everything is placed in inches
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(0.0, style.PAGE), ylim=(0.0, _HEIGHT))
    axes.set_axis_off()
    scale = _LARGEST / max(layer.length for layer in layers)

    sheets = [layer.channels if layer.is_map else 1 for layer in layers]
    columns = [
        max(_NARROWEST, (layer.width * scale if layer.is_map else _BAR) + _SHEET * (n - 1))
        for layer, n in zip(layers, sheets, strict=True)
    ]
    gap = (style.PAGE - _HEADINGS - _MARGIN - sum(columns)) / len(columns)
    headings = ("Layer", "Kernel", "Activation", "Output", "Parameters")
    for row, heading in enumerate(headings):
        axes.text(_MARGIN, _FIRST_ROW - _ROW * row, heading, fontsize=style.SMALL_SIZE, style="italic")
    drawn: list[_Drawn] = []
    x = _HEADINGS
    for layer, column in zip(layers, columns, strict=True):
        centre = x + (gap + column) / 2
        x += gap + column
        drawn.append(_Drawn(axes, layer, centre, scale))
        kernel = layer.kernel.replace("x", style.TIMES) or style.DASH
        words = (layer.name, kernel, _ACTIVATIONS[layer.name], layer.size, f"{layer.parameters:,}")
        for row, word in enumerate(words):
            axes.text(centre, _FIRST_ROW - _ROW * row, word, fontsize=style.SMALL_SIZE, ha="center")
    for before, after in pairwise(drawn):
        _connect(axes, before, after, scale)
    for kind in KINDS:
        axes.add_patch(Rectangle((0, 0), 0, 0, facecolor=_FILLS[kind], edgecolor=style.INK, lw=0.4, label=kind))
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 0.0), ncols=len(KINDS), fontsize=style.SMALL_SIZE)
    return figure
