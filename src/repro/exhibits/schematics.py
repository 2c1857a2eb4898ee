"""What the paper describes in words and pictures: Table 1, Figures 1 to 4 and 18.

The paper's own pictures are not available. The words are in ``diagrams``: each row is either stated in the text at the
place that it names, or inferred from it. Sentences are counted within their section. Formulas are in ASCII, between
backticks where they are among words; ``-`` stands for nothing. Places are in ``diagrams/layouts.yaml``.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd
import yaml
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyBboxPatch, Polygon, Rectangle

from repro.board.frames import BAUD, COUNTS_PER_TURN, PWM_LIMIT, SAMPLING_PERIOD
from repro.config.model import Configuration
from repro.drawing import style
from repro.drawing.markup import Table, Text, formula, plain
from repro.errors import InputError
from repro.exhibits.arm_drawing import Point, arrow, draw_arm, hanging_arm
from repro.exhibits.declare import ARM, Inputs, figure, table
from repro.experiments.arm import control_constants, program_settings
from repro.files import read_csv
from repro.signals.programs import MEMORY_SAMPLES

_figure = partial(figure, category="Method", inputs=("diagrams",))

DIAGRAMS = Path(__file__).parent / "diagrams"
#: Constants of the board in the words of the diagrams.
_BOARD = {"memory": MEMORY_SAMPLES, "limit": PWM_LIMIT, "period_ms": 1e3 * SAMPLING_PERIOD, "rate": 1 / SAMPLING_PERIOD}


def words(name: str, **constants: float) -> pd.DataFrame:
    """Words of a diagram, with the values of constants."""
    frame = read_csv(DIAGRAMS / f"{name}.csv").astype(str)
    return frame.map(lambda text: text.format(**_BOARD, **constants) if "{" in text else text)


_SET_APART = Text(r"$^{\dagger}$", "\N{DAGGER}")


def related_work_table(frame: pd.DataFrame) -> Table:
    """Related work of Section I-A and the article (Table 1)."""
    columns = ["reference", "robot", "dof", "method", "identified", "optimisation", "set_apart"]
    rows = []
    for reference, *cells, apart in frame.replace({"dof": {"not stated": style.DASH}})[columns].itertuples(index=False):
        work = plain(reference)
        work = Text(f"{{{work.tex}}}", work.md)  # LaTeX would read a bracket at the start of a row as an option
        rows.append((work + _SET_APART if apart == "yes" else work, *map(plain, cells)))
    caption = plain(
        "Related work and this article, rebuilt from Section I-A (the paper's own Table 1 is an image). Optimisation: "
        "whether an optimised trajectory is needed; Section I-A says so of works based on least squares (LS, weighted "
        "WLS) and of some optimisation methods, without naming these. FFNN: feed-forward, RBNN: radial basis neural "
        "network; LSTM: long short-term memory; MLP: multi-layer perceptron; KF: Kalman filter; "
        "\N{EN DASH}: not stated."
    )
    caption = caption + " " + _SET_APART + " " + plain("Set apart in Section I-A by its contributions.")
    header = [*map(plain, ("Work", "Robot", "DoF", "Method", "Identified", "Optimisation"))]
    return Table(caption, "llllll", header, [(None, rows)])


@table("Related work", related_work_table, category="Method", inputs=("diagrams",))
def table01(_: Inputs, __: Configuration) -> pd.DataFrame:
    """Related work and this article, rebuilt from Section I-A (the paper's Table 1 is an image): robot, degrees of
    freedom, method, what is identified, and whether the text says that an optimised trajectory is needed.
    """
    return words("table01")


#: From the edge of a box to its words, in.
INSET = 0.05

_FILLS = dict.fromkeys(("block", "step", "corner"), style.FILL_LIGHT) | dict.fromkeys(("outside", "end"), "white")
_FILLS |= {"decision": "#f3c77d", "frame": "0.96"}

#: Strokes of links by flow; a link that is only inferred has `_INFERRED` instead.
FLOWS: dict[str, dict[str, Any]] = {
    "downlink": {"color": style.STROKES["joint1"]["color"], "lw": 1.0},
    "uplink": {"color": style.STROKES["joint2"]["color"], "lw": 1.0, "ls": (0, (4.5, 1.5))},
    "inner": {"color": style.INK, "lw": 1.0},
}
_INFERRED: dict[str, Any] = {"color": style.INK, "lw": 0.8, "ls": (0, (1.0, 1.2))}

_WORD = re.compile(r"(?:`[^`]*`|[^\s`])+")


class Box(NamedTuple):
    """Where a box is: its rectangle, or the one around a diamond."""

    left: float
    bottom: float
    width: float
    height: float
    # a decision is a diamond, a frame a dashed rectangle behind other boxes with its words at the top; a corner has
    # two lines of words in its upper right corner and leaves room for a drawing
    shape: str = "block"


class Route(NamedTuple):
    """Where a link runs."""

    corners: Sequence[Point]  # from edge to edge
    label: Point | None = None  # where its label is; None where it has none
    side: str = "center"  # which part of the label is there
    flow: str = "inner"  # what it carries, which gives its colour
    both: bool = False  # whether it points both ways


def layout_of(name: str) -> dict[str, Any]:
    """Places of everything in a drawing: its size, the boxes (frames before what is on them), routes and the like."""
    layout: dict[str, Any] = yaml.safe_load((DIAGRAMS / "layouts.yaml").read_text(encoding="utf-8"))[name]
    boxes = {key: Box(*place) for key, place in layout.get("boxes", {}).items()}
    routes = {key: Route(**route) for key, route in layout.get("routes", {}).items()}
    usual = {"junctions": (), "legend": {}, "columns": 5, "headings": {}, "va": "center"}
    return {**usual, **layout, "boxes": boxes, "routes": routes}


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
    width = letters
    for word in _WORD.findall(label.replace(" x ", style.TIMES)):
        shown, size = _rendered(word)
        width += 1 + size
        if width > letters:
            lines.append(shown)
            width = size
        else:
            lines[-1] += f" {shown}"
    return lines


def _start(layout: Mapping[str, Any], words: Iterable[tuple[str, str, bool]], place: str) -> tuple[Figure, Axes]:
    """Draw the boxes with their words: name of the box, words (``-`` for none), and whether they are only inferred."""
    lines: dict[str, list[tuple[str, bool]]] = {name: [] for name in layout["boxes"]}
    for name, label, inferred in words:
        box = layout["boxes"][name]
        width = (0.78 if box.shape == "decision" else 1.0) * box.width - 2 * INSET  # most of a diamond in its middle
        if label != "-":
            lines[name] += [(line, inferred) for line in _wrap(label, int(width / layout["letter"]))]
        room = 2 if box.shape == "corner" else int((box.height - INSET) / layout["leading"]) - 1
        if len(lines[name]) > room:
            raise InputError.at(place.format(name), f"{len(lines[name])} lines of words", f"at most {room}")
    figure, axes = style.inches(*layout["size"])
    for name, own in lines.items():
        _draw_box(axes, layout, name, own)
    return figure, axes


def _patch(box: Box) -> FancyBboxPatch | Polygon | Rectangle:
    """Outline of a box."""
    look: dict[str, Any] = {"facecolor": _FILLS[box.shape], "edgecolor": style.INK, "lw": 0.6}
    left, bottom, width, height, shape = box
    if shape == "frame":
        return Rectangle((left, bottom), width, height, ls=(0, (3, 2)), **look)
    if shape == "decision":
        x, y = left + width / 2, bottom + height / 2
        return Polygon([(left, y), (x, bottom), (left + width, y), (x, bottom + height)], **look)
    radius = height / 2 if shape == "end" else 0.04
    return FancyBboxPatch((left, bottom), width, height, boxstyle=f"round,pad=0,rounding_size={radius}", **look)


def _draw_box(axes: Axes, layout: Mapping[str, Any], name: str, lines: Sequence[tuple[str, bool]]) -> None:
    """Draw a box, its heading in bold, and its lines; what is only inferred stands in italics."""
    box, step = layout["boxes"][name], layout["leading"]
    axes.add_patch(_patch(box))
    x, y, side = box.left + box.width / 2, box.bottom + (box.height + step * len(lines)) / 2, "center"
    if box.shape in ("frame", "corner"):
        y = box.bottom + box.height - INSET - step / 2
    if box.shape == "corner":
        x, side = box.left + box.width - INSET, "right"
    if layout["va"] == "top":
        y += step / 2
    text: dict[str, Any] = {"fontsize": layout["type_size"], "ha": side, "va": layout["va"]}
    axes.text(x, y, layout["headings"].get(name, name), weight="bold", **text)
    for row, (line, inferred) in enumerate(lines, start=1):
        axes.text(x, y - step * row, line, style="italic" if inferred else "normal", **text)


def _draw_link(axes: Axes, corners: Sequence[Point], stroke: Mapping[str, Any], both: bool = False) -> None:
    """Draw an arrow along its corners."""
    axes.plot(*zip(*corners, strict=True), **stroke)
    for start, end in [corners[-2:], corners[1::-1]][: 1 + both]:
        arrow(axes, start, end, color=stroke["color"], lw=0.0, mutation_scale=7)


def _legend(axes: Axes, layout: Mapping[str, Any], bottom: float = 0.0) -> None:
    """Say what strokes and fills mean."""
    for key, label in layout["legend"].items():
        if key in _FILLS:
            axes.add_patch(Rectangle((0, 0), 0, 0, facecolor=_FILLS[key], edgecolor=style.INK, lw=0.6, label=label))
        else:
            axes.plot((), (), label=label, **FLOWS.get(key, _INFERRED))
    place: dict[str, Any] = {"loc": "lower center", "bbox_to_anchor": (0.5, bottom), "ncols": layout["columns"]}
    axes.legend(**place, fontsize=layout["type_size"])


def draw_diagram(frame: pd.DataFrame, name: str) -> Figure:
    """Boxes and arrows (Figures 2 to 4)."""
    layout = layout_of(name)
    boxes, links = (frame[frame["element"] == kind].set_index("name") for kind in ("box", "link"))
    words = zip(boxes.index, boxes["label"], boxes["basis"] == "inferred", strict=True)
    figure, axes = _start(layout, words, "box {}: label")
    for key, route in layout["routes"].items():
        label, inferred = links.loc[key, "label"], links.loc[key, "basis"] == "inferred"
        _draw_link(axes, route.corners, _INFERRED if inferred else FLOWS[route.flow], route.both)
        if route.label is not None:
            text, slant = _rendered(label)[0], "italic" if inferred else "normal"
            x, y = route.label
            axes.text(x, y, text, ha=route.side, va="center", fontsize=layout["type_size"], style=slant)
    for place in layout["junctions"]:
        axes.add_patch(Circle(place, 0.022, color=style.INK, lw=0.0, zorder=3))
    if layout["legend"]:
        _legend(axes, layout)
    return figure


@_figure("Schematic of the arm", draw_arm)
def fig01(_: Inputs, __: Configuration) -> pd.DataFrame:
    """Schematic of the two-link arm with the symbols of Eq. 1. The paper's own picture (Fig. 1) is not available to us:
    redrawn from Section II and Eq. 1. The pose is arbitrary; q = 0 hangs straight down and q2 is measured from link 1.
    """
    return words("fig01")


@_figure("Hardware blocks of the FPGA", partial(draw_diagram, name="fig02"))
def fig02(_: Inputs, __: Configuration) -> pd.DataFrame:
    """Hardware blocks of the FPGA and the buses between them. The paper's own picture (Fig. 2) is not available to us:
    redrawn from the text of Section III; the data say for each block and bus which sentence states it. Dotted links and
    words in italics are inferred: that Read Ram reads Ram-FPGA, that the PD uses Fp ops, that the encoders sit on the
    motors, and the memory's size.
    """
    return words("fig02")


@_figure("Flow chart of the PD control", partial(draw_diagram, name="fig03"))
def fig03(_: Inputs, __: Configuration) -> pd.DataFrame:
    """Flow chart of one cycle of the PD control with its saturation. The paper's own picture (Fig. 3) is not available
    to us: redrawn from Section III, Eq. 2 and its caption, L1 = L2 = 1023. Dotted arrows and words in italics are
    inferred; L1 and L2 are read as the limits of joints 1 and 2 in both directions.
    """
    return words("fig03")


@_figure("Identification method", partial(draw_diagram, name="fig04"))
def fig04(_: Inputs, __: Configuration) -> pd.DataFrame:
    """General diagram of the identification method with its nine steps. The paper's own picture (Fig. 4) is not
    available to us: redrawn from Section IV; the way back from the decision to a new guess is that of Algorithm 1. In
    each of 100 executions Algorithm 1 repeats it until the similarity is above the threshold u of 92.37 %, or a limit
    of guesses is reached, and it returns the best set. Step 9 brings this set from units of the largest torque to those
    of the arm.
    """
    return words("fig04")


def draw_setup(frame: pd.DataFrame) -> Figure:
    """Simulated experimental set-up with its components."""
    layout = layout_of("fig18")
    words = []
    for name, label, value, si in frame[["component", "label", "value", "unit"]].itertuples(index=False):
        text = " ".join(part for part in (label, value, si.replace(" ", "·")) if part != "-")
        words.append((name, re.sub(r"\b[a-z]\d\b", r"`\g<0>`", text), False))
    figure, axes = _start(layout, words, "component {}")
    hanging_arm(axes)
    for route in layout["routes"].values():
        _draw_link(axes, route.corners, FLOWS[route.flow])
    for note in layout["notes"]:
        x, y = note["place"]
        axes.text(x, y, note["text"], fontsize=style.SMALL_SIZE, ha=note["side"], va="center")
    _legend(axes, layout, bottom=0.01)
    return figure


@figure("Experimental set-up", draw_setup, category="Experiment (simulated)", inputs=("diagrams",), sections=ARM)
def fig18(_: Inputs, config: Configuration) -> pd.DataFrame:
    """The simulated experimental set-up: the real acquisition program, the serial device it opens, the simulated FPGA
    board with its blocks, the simulated motors, and the two-link arm (Fig. 18 of the paper is a photograph of the real
    one).
    """
    geometry, (torque1, torque2) = program_settings(config).geometry, control_constants(config).full_torque
    board = {"baud": BAUD, "counts": COUNTS_PER_TURN, "torque1": torque1, "torque2": torque2}
    return words("fig18", **board, l1=geometry.l1, l2=geometry.l2)
