"""Line figures: subsampling, motions, the torque distribution and the loss (Fig. 5, 6, 9, 10, 16)."""

from collections.abc import Mapping, Sequence

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import ConnectionPatch
from matplotlib.text import Annotation
from matplotlib.ticker import EngFormatter, MaxNLocator

from repro.exhibits import style
from repro.model.parameters import Array

#: Points (x, y) of one curve, arrays of shape (n,).
Curve = tuple[Array, Array]

TIME = "Time (s)"
TORQUE = "Torque (N·m)"
COEFFICIENT = "Coefficient (N·m)"

JOINTS = ("joint1", "joint2")

#: Axis label of each panel of a motion.
MOTION = {"position": "Position (rad)", "velocity": "Velocity (rad/s)", "acceleration": "Acceleration (rad/s²)"}


def curves_of(frame: pd.DataFrame, panels: Mapping[str, Sequence[str]]) -> dict[str, dict[str, Curve]]:
    """Curves of a long table ``panel, series, x, y``."""
    points = {key: (rows["x"].to_numpy(), rows["y"].to_numpy()) for key, rows in frame.groupby(["panel", "series"])}
    return {panel: {name: points[panel, name] for name in series} for panel, series in panels.items()}


def plot_series(axes: Axes, name: str, curve: Curve) -> None:
    """Draw one curve in the stroke and under the label of its series."""
    axes.plot(*curve, label=style.SERIES_LABELS[name], **style.STROKES[name])


def plot_panel(axes: Axes, series: Mapping[str, Curve]) -> None:
    """Draw curves one over the other in their order."""
    for name, curve in series.items():
        plot_series(axes, name, curve)
    style.few_ticks(axes)


def motion(frame: pd.DataFrame, width: float = style.COLUMN) -> Figure:
    """Position, velocity and acceleration of both joints over time (Fig. 6)."""
    curves = curves_of(frame, dict.fromkeys(MOTION, JOINTS))
    figure = style.new_figure(width, 3.9)
    panels = figure.subplots(3, 1, sharex=True)
    for axes, (panel, label) in zip(panels, MOTION.items(), strict=True):
        plot_panel(axes, curves[panel])
        axes.set_ylabel(label)
    panels[-1].set_xlabel(TIME)
    figure.align_ylabels()
    style.legend_above(figure, panels[0], 2)
    return figure


def random_motion(frame: pd.DataFrame) -> Figure:
    """Random validation trajectory (Fig. 16): as `motion`, but page wide because it turns so often."""
    return motion(frame, style.PAGE)


def torque_distribution(frame: pd.DataFrame) -> Figure:
    """Distribution of the training torques over time (Fig. 9)."""
    series = ("p05", "p25", "p50", "p75", "p95", "mean")
    curves = curves_of(frame, dict.fromkeys(JOINTS, series))
    figure = style.new_figure(style.COLUMN, 3.7)
    panels = figure.subplots(2, 1, sharex=True, sharey=True)
    for axes, joint in zip(panels, JOINTS, strict=True):
        level = curves[joint]
        x = level["p50"][0]
        axes.fill_between(x, level["p05"][1], level["p95"][1], color=style.FILL_LIGHT, lw=0, label=f"5{style.DASH}95 %")
        axes.fill_between(x, level["p25"][1], level["p75"][1], color=style.FILL_DARK, lw=0, label=f"25{style.DASH}75 %")
        plot_series(axes, "median", level["p50"])
        plot_series(axes, "mean", level["mean"])
        axes.set_title(style.SERIES_LABELS[joint])
    figure.supylabel("Torque / largest torque (dimensionless)", fontsize=style.TEXT_SIZE)
    panels[-1].set_xlabel(TIME)
    style.legend_above(figure, panels[0], 4)
    return figure


def _losses(frame: pd.DataFrame, names: tuple[str, ...], x_label: str, y_label: str) -> tuple[Figure, Axes]:
    """Losses of these series on a logarithmic axis."""
    curves = curves_of(frame, {"loss": names})["loss"]
    figure = style.new_figure(style.COLUMN, 2.3)
    axes = figure.subplots()
    for name, curve in curves.items():
        plot_series(axes, name, curve)
    axes.set_yscale("log")
    axes.set_xlabel(x_label)
    axes.set_ylabel(y_label)
    return figure, axes


def loss(frame: pd.DataFrame) -> Figure:
    """Loss on training and test images over the iterations (Fig. 10)."""
    figure, axes = _losses(frame, ("train", "test"), "Training iteration (steps)", "Loss (dimensionless)")
    axes.xaxis.set_major_formatter(EngFormatter(sep=""))
    axes.xaxis.set_major_locator(MaxNLocator(6))
    style.legend_above(figure, axes, 2)
    return figure


def held_out_losses(frame: pd.DataFrame) -> Figure:
    """Loss on held-out images over the images trained on, of the paper's schedule and of ours.

    Columns ``panel, series, x, y``; panel loss; series as in the registry of methods; x in images, y above 0.
    """
    names = ("algorithm1", "algorithm1+paper-recipe")
    figure, axes = _losses(frame, names, "Training (images)", "Held-out loss (dimensionless)")
    axes.set_xscale("log")
    axes.xaxis.set_major_formatter(EngFormatter(sep=""))
    style.legend_above(figure, axes, 2)
    return figure


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
