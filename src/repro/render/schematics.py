"""The subsampling scheme (Fig. 5)."""

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import ConnectionPatch
from matplotlib.text import Annotation

from repro.render import style
from repro.render.lines import COEFFICIENT, TIME, TORQUE, curves_of

#: Bands in view, as a multiple of the bands kept: enough of the dropped ones to see how small they are.
_VIEW = 1.5

#: Height of the row of boxes, in panel heights, and the part of the figure left to the panels.
_BOX_ROW = 1.16
_PANEL_PART = 0.83


def _box(axes: Axes, text: str) -> tuple[Axes, Annotation]:
    """Name the stage that `axes` shows in a box above it."""
    frame = {"boxstyle": "round,pad=0.35", "facecolor": style.FILL_LIGHT, "edgecolor": style.INK, "linewidth": 0.6}
    box = axes.annotate(text, (0.5, _BOX_ROW), xycoords="axes fraction", ha="center", va="center", bbox=frame)
    box.set_in_layout(False)  # its row is kept free already
    return axes, box


def _arrow(figure: Figure, left: tuple[Axes, Annotation], right: tuple[Axes, Annotation], text: str) -> None:
    """Draw an arrow from one box to the next with the operation written above it."""
    arrow = ConnectionPatch(
        (0.5, _BOX_ROW),
        (0.5, _BOX_ROW),
        "axes fraction",
        axesA=left[0],
        axesB=right[0],
        patchA=left[1].get_bbox_patch(),
        patchB=right[1].get_bbox_patch(),
        arrowstyle="-|>",
        mutation_scale=8,
        linewidth=0.9,
        color=style.INK,
    )
    arrow.set_in_layout(False)
    figure.add_artist(arrow)
    note = Annotation(text, (0.5, 1.0), xytext=(0, 3), xycoords=arrow, textcoords="offset points", ha="center")
    note.set_in_layout(False)
    figure.add_artist(note)


def subsampling(frame: pd.DataFrame) -> Figure:
    """Subsampling by the DCT-II in three steps (Fig. 5)."""
    curves = curves_of(frame, {"signal": ("x",), "spectrum": ("kept", "dropped"), "subsampled": ("xs",)})
    x, xs = curves["signal"]["x"], curves["subsampled"]["xs"]
    kept, dropped = curves["spectrum"]["kept"], curves["spectrum"]["dropped"]

    figure = style.new_figure(style.PAGE, 2.55)
    figure.set_layout_engine("constrained", rect=(0.0, 0.0, 1.0, _PANEL_PART))
    signal, spectrum, subsampled = figure.subplots(1, 3)
    blue = style.STROKES["joint1"]["color"]
    signal.plot(*x, color=blue, lw=1.0)
    subsampled.plot(*xs, color=blue, lw=0.5, marker="o", ms=1.8, mew=0)
    low, high = (f(signal.get_ylim()[i], subsampled.get_ylim()[i]) for i, f in enumerate((min, max)))
    for axes in (signal, subsampled):
        axes.set(xlabel=TIME, ylabel=TORQUE, ylim=(low, high))

    end = _VIEW * kept[0].size
    seen = dropped[0] <= end
    spectrum.vlines(*kept[:1], 0.0, kept[1], color=blue, lw=0.9, label="Kept bands")
    spectrum.vlines(dropped[0][seen], 0.0, dropped[1][seen], color=style.SET_ASIDE, lw=0.9, label="Dropped bands")
    spectrum.axvline(float(kept[0][-1] + dropped[0][0]) / 2, color=style.INK, lw=0.8, ls="--", label="Cut to $M$ bands")
    spectrum.set(xlabel="Band $k$ (index)", ylabel=COEFFICIENT, xlim=(-0.02 * end, end))
    for axes in (signal, spectrum, subsampled):
        style.few_ticks(axes)

    n = kept[0].size + dropped[0].size
    boxes = (
        _box(signal, f"Signal $x$: $N$ = {n} samples"),
        _box(spectrum, f"Spectrum $X$: $M$ = {kept[0].size} of {n} bands"),
        _box(subsampled, f"Subsampled $x_s$: {xs[0].size} samples"),
    )
    _arrow(figure, boxes[0], boxes[1], "DCT-II")
    _arrow(figure, boxes[1], boxes[2], r"iDCT-II $\times \sqrt{M/N}$")
    figure.legend(*spectrum.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure
