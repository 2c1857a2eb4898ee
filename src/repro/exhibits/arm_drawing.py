"""The two-link arm: the drawing with its symbols (Figure 1), and the small one of the set-up (Figure 18)."""

from collections.abc import Sequence
from itertools import accumulate
from math import cos, degrees, pi, radians, sin
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle, Rectangle

from repro.drawing import style
from repro.drawing.markup import formula, plain, unit

Point = tuple[float, float]

# Measures of the drawing, in; the pose is any that keeps all symbols apart.
_BASE: Point = (1.05, 3.27)
_LINKS = (1.25, 1.15)
_CENTRES = (0.66, 0.62)  # from the joint to the centre of mass
_BENDS = (radians(35.0), radians(32.0))  # q1, q2
_MEASURES = ({"lc": 0.22, "l": 0.46}, {"lc": -0.32, "l": -0.58})  # offsets from each link
_PIVOT = 0.18  # radius of the arc of a torque
_PIVOT_SPAN = (145.0, 228.0)  # degrees
_AXES: Point = (0.22, 2.35)
_GRAVITY: Point = (3.05, 3.40)
_KEY = (0.10, 1.72)  # left edges of the columns of the key
_KEY_TOP, _KEY_STEP = 0.94, 0.145

_THIN: dict[str, Any] = {"color": style.INK, "lw": 0.5}
_JOINT: dict[str, Any] = {"marker": "o", "ms": 6.0, "mfc": "white", "mec": style.INK, "mew": 0.8, "ls": "none"}
_MASS: dict[str, Any] = {**_JOINT, "ms": 5.5, "mfc": style.INK, "mfcalt": "white", "fillstyle": "left", "mew": 0.6}


def arrow(axes: Axes, start: Point, end: Point, **look: object) -> None:
    """Draw an arrow."""
    head: dict[str, Any] = {"arrowstyle": "-|>", "mutation_scale": 6, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", end, start, arrowprops={**head, "color": style.INK, "lw": 0.6, **look})


def _beyond(point: Point, angle: float, along: float, aside: float = 0.0) -> Point:
    """Point `along` a direction and `aside` from it; an angle of 0 points down, and then aside is to the right."""
    x, y = point
    return x + along * sin(angle) + aside * cos(angle), y - along * cos(angle) + aside * sin(angle)


def _write(axes: Axes, place: Point, symbols: Sequence[str], side: str = "center") -> None:
    """Write symbols, separated by commas."""
    axes.text(*place, ", ".join(formula(s).tex for s in symbols), ha=side, va="center", fontsize=style.TEXT_SIZE)


def _measure(axes: Axes, joint: Point, angle: float, length: float, offset: float, symbol: str) -> None:
    """Draw a length next to a link, with its extension lines."""
    for along in (0.0, length):
        axes.plot(*zip(*(_beyond(joint, angle, along, part * offset) for part in (0.0, 1.12)), strict=True), **_THIN)
    ends = (_beyond(joint, angle, 0.0, offset), _beyond(joint, angle, length, offset))
    arrow(axes, *ends, arrowstyle="<|-|>")
    _write(axes, _beyond(joint, angle, 0.5 * length, offset + (0.11 if offset > 0 else -0.11)), (symbol,))


def _link(axes: Axes, index: int, joint: Point, before: float, angle: float) -> None:
    """Draw link `index` (from 0) with everything that carries its number."""
    number = index + 1
    axes.plot(*zip(joint, _beyond(joint, angle, _LINKS[index]), strict=True), color=style.FILL_DARK, lw=6.0)
    for name, length in (("lc", _CENTRES[index]), ("l", _LINKS[index])):
        _measure(axes, joint, angle, length, _MEASURES[index][name], f"{name}{number}")
    axes.plot(*zip(joint, _beyond(joint, before, 0.47), strict=True), **_THIN, ls=(0, (4, 2)))
    span = {"theta1": degrees(before) - 90.0, "theta2": degrees(angle) - 90.0}
    axes.add_patch(Arc(joint, 0.76, 0.76, **span, lw=0.6, color=style.INK))
    tip = _beyond(joint, angle, 0.38)
    arrow(axes, _beyond(tip, angle - pi / 2, 0.01), tip)
    _write(axes, _beyond(joint, (before + angle) / 2, 0.49), (f"q{number}",))
    axes.plot(*joint, **_JOINT, zorder=4)
    centre = _beyond(joint, angle, _CENTRES[index])
    axes.plot(*centre, **_MASS, zorder=4)
    _write(axes, _beyond(centre, angle, 0.0, -0.3 if index == 0 else 0.2), (f"m{number}", f"J{number}"))


def _motor(axes: Axes, joint: Point, number: int, lower: float) -> None:
    """Draw the torque at a joint and name it with the joint's friction."""
    first, last = _PIVOT_SPAN
    axes.add_patch(Arc(joint, 2 * _PIVOT, 2 * _PIVOT, theta1=first, theta2=last, lw=1.0, color=style.INK, zorder=3))
    out = radians(last) + pi / 2  # direction from the joint to the end of the arc, as `_beyond` counts
    tip = _beyond(joint, out, _PIVOT)
    arrow(axes, _beyond(tip, out + pi / 2, -0.01), tip)
    _write(axes, (joint[0] - 0.25, joint[1] - lower), (f"tau{number}", f"b{number}", f"k{number}"), "right")


def _key(axes: Axes, table: pd.DataFrame) -> None:
    """Say what the symbols mean: those of one meaning share a line, in two columns."""
    meanings = table.groupby(["description", "unit"], sort=False)["symbol"]
    rows = (meanings.ngroups + 1) // 2
    for place, ((description, si), symbols) in enumerate(meanings):
        column, row = divmod(place, rows)
        shown = ", ".join(formula(symbol).tex for symbol in symbols)
        words = f"{shown}  {plain(str(description)).md} ({unit(str(si)).md})"
        axes.text(_KEY[column], _KEY_TOP - _KEY_STEP * row, words, fontsize=style.SMALL_SIZE, ha="left", va="center")


def draw_arm(frame: pd.DataFrame) -> Figure:
    """Two-link arm with its symbols (Fig. 1)."""
    figure, axes = style.inches(style.COLUMN, 3.72)
    x, y = _BASE
    mount = Rectangle((x - 0.2, y + 0.29), 0.4, 0.08, facecolor="white", hatch="/////", lw=0.0, ec=style.INK)
    mount.set_hatch_linewidth(0.5)
    axes.add_patch(mount)
    axes.plot((x - 0.2, x + 0.2), (y + 0.29, y + 0.29), color=style.INK, lw=0.8)
    axes.plot((x, x), (y, y + 0.29), color=style.INK, lw=2.0)
    angles = tuple(accumulate(_BENDS))
    elbow = _beyond(_BASE, angles[0], _LINKS[0])
    _link(axes, 1, elbow, angles[0], angles[1])
    _link(axes, 0, _BASE, 0.0, angles[0])
    axes.plot(*elbow, **_JOINT, zorder=5)
    _motor(axes, _BASE, 1, lower=0.02)
    _motor(axes, elbow, 2, lower=0.04)
    for symbol, end in (("x", (_AXES[0] + 0.42, _AXES[1])), ("y", (_AXES[0], _AXES[1] + 0.42))):
        arrow(axes, _AXES, end)
        _write(axes, (end[0] + 0.07, end[1]), (symbol,))
    arrow(axes, _GRAVITY, (_GRAVITY[0], _GRAVITY[1] - 0.5), lw=1.2, mutation_scale=9)
    _write(axes, (_GRAVITY[0] + 0.1, _GRAVITY[1] - 0.25), ("g",))
    _key(axes, frame)
    axes.plot((), (), **_JOINT, label="Joint with its motor")
    axes.plot((), (), **_MASS, label="Centre of mass")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 0.0), ncols=2, fontsize=style.SMALL_SIZE)
    return figure


#: The arm in its box: base and length of a link, in, q1 and q2 in degrees.
_SETUP_BASE, _SETUP_LINK, _SETUP_BENDS = (6.04, 1.24), 0.44, (30.0, 32.0)


def hanging_arm(axes: Axes) -> None:
    """Draw the two links hanging from the base with the symbols of Eq. 1."""
    joint, before = _SETUP_BASE, 0.0
    for index, bend in enumerate(_SETUP_BENDS, start=1):
        angle = before + radians(bend)
        end = _beyond(joint, angle, _SETUP_LINK)
        axes.plot(*zip(joint, end, strict=True), color=style.FILL_DARK, lw=4.0, zorder=2)
        axes.plot(*zip(joint, _beyond(joint, before, 0.3), strict=True), color=style.INK, lw=0.5, ls=(0, (3, 2)))
        start = degrees(before) - 90.0
        axes.add_patch(Arc(joint, 0.46, 0.46, theta1=start, theta2=start + bend, lw=0.6, zorder=3))
        axes.add_patch(Circle(joint, 0.03, facecolor="white", edgecolor=style.INK, lw=0.6, zorder=4))
        q = _beyond(_beyond(joint, before, 0.2), before - pi / 2, 0.09)
        length = _beyond(_beyond(joint, angle, _SETUP_LINK / 2), angle + pi / 2, 0.11)
        for symbol, (x, y) in (("q", q), ("l", length)):
            axes.text(x, y, f"${symbol}_{index}$", fontsize=style.SMALL_SIZE, ha="center", va="center")
        joint, before = end, angle
