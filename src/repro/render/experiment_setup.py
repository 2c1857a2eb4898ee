"""The simulated experimental set-up: program, serial line, board and arm, with their figures (Fig. 18)."""

import re
from collections.abc import Sequence
from math import cos, degrees, pi, radians, sin
from textwrap import wrap
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle, FancyBboxPatch, Rectangle

from repro.errors import InputError
from repro.exhibits import style

# Measures of the drawing, in.
_HEIGHT = 3.12
_LINE = 0.125  # from one line of words to the next
_INSET = 0.05  # from the edge of a box to its words
_LETTER = 0.044  # mean width of a letter

#: Heading and box (left, bottom, width, height) of each component; the columns of the board are 0.92 wide.
_BOXES = {
    "pc": ("PC", (0.06, 0.45, 0.92, 2.35)),
    "serial": ("Serial device", (1.22, 0.45, 0.92, 2.35)),
    "write-ram": ("Write RAM", (2.46, 2.18, 0.92, 0.62)),
    "ram": ("RAM", (3.54, 2.18, 0.92, 0.62)),
    "pd": ("PD control", (3.54, 1.32, 0.92, 0.62)),
    "pwm": ("PWM", (4.62, 1.32, 0.92, 0.62)),
    "decoder": ("Decoder", (3.54, 0.45, 0.92, 0.62)),
    "uplink": ("Uplink", (2.46, 0.45, 0.92, 0.62)),
    "motors": ("H bridges and motors", (5.84, 1.62, 1.26, 1.18)),
    "arm": ("Two-link arm", (5.84, 0.34, 1.26, 1.02)),
}
_REAL = ("pc",)

#: The arm in its box: base, length of a link, q1 and q2 in degrees.
_BASE = (6.04, 1.24)
_LINK = 0.44
_BENDS = (30.0, 32.0)

_BOARD = (2.38, 0.34, 3.24, 2.72)

_LINKS = {
    "downlink": {"color": style.STROKES["joint1"]["color"]},
    "uplink": {"color": style.STROKES["joint2"]["color"], "ls": (0, (4.5, 1.5))},
    "inner": {"color": style.INK},
}

_LINK_LABELS = {
    "downlink": "Downlink: gains, trajectory, start",
    "uplink": "Uplink: position, torque",
    "inner": "Inside the simulation",
}

#: Signals: link, corners of the line from source to target.
_SIGNALS: tuple[tuple[str, tuple[tuple[float, float], ...]], ...] = (
    ("downlink", ((0.98, 2.49), (1.22, 2.49))),
    ("downlink", ((2.14, 2.49), (2.46, 2.49))),
    ("uplink", ((1.22, 0.76), (0.98, 0.76))),
    ("uplink", ((2.46, 0.76), (2.14, 0.76))),
    ("inner", ((3.38, 2.49), (3.54, 2.49))),
    ("inner", ((4.00, 2.18), (4.00, 1.94))),
    ("inner", ((4.46, 1.63), (4.62, 1.63))),
    ("inner", ((5.54, 1.73), (5.84, 1.73))),
    ("inner", ((6.47, 1.62), (6.47, 1.36))),
    ("inner", ((5.84, 0.76), (4.46, 0.76))),
    ("inner", ((4.00, 1.07), (4.00, 1.32))),
    ("inner", ((3.54, 0.76), (3.38, 0.76))),
    ("inner", ((3.54, 1.63), (2.92, 1.63), (2.92, 1.07))),
)

#: What flows where there is room to say it: text, place, horizontal alignment.
_NOTES = (
    (r"$K_p, K_v, q_d$", (4.04, 2.06), "left"),
    (r"$q$", (4.04, 1.195), "left"),
    (r"$\tau$", (3.2, 1.69), "center"),
    (r"$q$ (encoder counts)", (5.08, 0.83), "center"),
    (r"$\tau_1, \tau_2$", (6.51, 1.49), "left"),
)


def _read(frame: pd.DataFrame) -> dict[str, list[str]]:
    """Lines of words of each component."""
    lines: dict[str, list[str]] = {name: [] for name in _BOXES}
    for name, label, value, unit in frame[["component", "label", "value", "unit"]].itertuples(index=False):
        words = [part for part in (label, value, unit.replace(" ", "·")) if part != "-"]
        text = " ".join(words).replace(" x ", style.TIMES)
        _, (_, _, width, height) = _BOXES[name]
        lines[name] += wrap(text, int((width - 2 * _INSET) / _LETTER))
        room = 2 if name == "arm" else int((height - _INSET) / _LINE) - 1
        if len(lines[name]) > room:
            raise InputError.at(f"component {name}", f"{len(lines[name])} lines of words", f"at most {room}")
    return lines


def _box(axes: Axes, name: str, words: Sequence[str]) -> None:
    """Draw a component with its heading and its lines of words."""
    heading, (left, bottom, width, height) = _BOXES[name]
    fill = "white" if name in _REAL else style.FILL_LIGHT
    shape = "round,pad=0,rounding_size=0.04"
    box = FancyBboxPatch((left, bottom), width, height, boxstyle=shape, facecolor=fill, edgecolor=style.INK, lw=0.6)
    axes.add_patch(box)
    x, y = left + width / 2, bottom + (height + _LINE * (len(words) + 1)) / 2
    if name == "arm":  # its words leave room for the drawing
        x, y = left + width - _INSET, bottom + height - _INSET
    text: dict[str, Any] = {"fontsize": style.SMALL_SIZE, "ha": "right" if name == "arm" else "center", "va": "top"}
    axes.text(x, y, heading, weight="bold", **text)
    for row, line in enumerate(words, start=1):
        axes.text(x, y - _LINE * row, re.sub(r"\b([a-z])(\d)\b", r"$\1_\2$", line.replace("$", r"\$")), **text)


def _beyond(point: tuple[float, float], angle: float, length: float) -> tuple[float, float]:
    """Point at a distance from another; an angle of 0 points down and grows to the right."""
    return point[0] + length * sin(angle), point[1] - length * cos(angle)


def _draw_arm(axes: Axes) -> None:
    """Draw the two links hanging from the base with the symbols of Eq. 1."""
    joint, before = _BASE, 0.0
    for index, bend in enumerate(_BENDS, start=1):
        angle = before + radians(bend)
        end = _beyond(joint, angle, _LINK)
        axes.plot(*zip(joint, end, strict=True), color=style.FILL_DARK, lw=4.0, zorder=2)
        axes.plot(*zip(joint, _beyond(joint, before, 0.3), strict=True), color=style.INK, lw=0.5, ls=(0, (3, 2)))
        start = degrees(before) - 90.0
        axes.add_patch(Arc(joint, 0.46, 0.46, theta1=start, theta2=start + bend, lw=0.6, zorder=3))
        axes.add_patch(Circle(joint, 0.03, facecolor="white", edgecolor=style.INK, lw=0.6, zorder=4))
        q = _beyond(_beyond(joint, before, 0.2), before - pi / 2, 0.09)
        length = _beyond(_beyond(joint, angle, _LINK / 2), angle + pi / 2, 0.11)
        for symbol, (x, y) in (("q", q), ("l", length)):
            axes.text(x, y, f"${symbol}_{index}$", fontsize=style.SMALL_SIZE, ha="center", va="center")
        joint, before = end, angle


def setup(frame: pd.DataFrame) -> Figure:
    """Simulated experimental set-up with its components (Fig. 18)."""
    lines = _read(frame)
    figure = style.new_figure(style.PAGE, _HEIGHT)
    figure.set_layout_engine("none")  # everything is placed in inches
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(0.0, style.PAGE), ylim=(0.0, _HEIGHT))
    axes.set_axis_off()
    left, bottom, width, height = _BOARD
    board = Rectangle((left, bottom), width, height, facecolor="0.96", edgecolor=style.INK, lw=0.6, ls=(0, (3, 2)))
    axes.add_patch(board)
    heading: dict[str, Any] = {"fontsize": style.SMALL_SIZE, "weight": "bold", "ha": "center", "va": "top"}
    axes.text(left + width / 2, bottom + height - _INSET, "Simulated FPGA board", **heading)
    for name, words in lines.items():
        _box(axes, name, words)
    _draw_arm(axes)
    for link, corners in _SIGNALS:
        axes.plot(*zip(*corners, strict=True), lw=1.0, **_LINKS[link])
        head = {"arrowstyle": "-|>", "color": _LINKS[link]["color"], "shrinkA": 0, "shrinkB": 0, "lw": 0.0}
        axes.annotate("", corners[-1], corners[-2], arrowprops={**head, "mutation_scale": 7})
    for text, place, side in _NOTES:
        axes.text(*place, text, fontsize=style.SMALL_SIZE, ha=side, va="center")
    for link, label in _LINK_LABELS.items():
        axes.plot((), (), lw=1.0, label=label, **_LINKS[link])
    for fill, label in (("white", "Real program"), (style.FILL_LIGHT, "Simulated set-up")):
        axes.add_patch(Rectangle((0, 0), 0, 0, facecolor=fill, edgecolor=style.INK, lw=0.6, label=label))
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 0.01), ncols=5, fontsize=style.SMALL_SIZE)
    return figure
