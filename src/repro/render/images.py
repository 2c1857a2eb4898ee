"""Image figures: example training images (Fig. 8) and the power spectra of the kernels (Fig. 11)."""

import string
from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from repro.exhibits import style
from repro.model.parameters import Array

_KINDS = {"Mp": "$M_p$: the parameters match the torque", "Mn": "$M_n$: they do not match"}
_IMAGES = tuple(string.ascii_lowercase[:9])
_COLOURS = ("red", "green", "blue")

_LAYERS = ("conv1", "conv2", "conv3")

#: Pixels of one kernel in the picture, whatever its size (9, 5 and 3 divide it), and of the gap between two.
_CELL = 45
_GAP = 6


def _dense(table: pd.DataFrame, axes: Sequence[str], values: Sequence[str]) -> Array:
    """A long table with integer indices as an array."""
    index = table[list(axes)].to_numpy(dtype=np.intp)
    array = np.full((*(index.max(axis=0) + 1), len(values)), np.nan)
    array[tuple(index.T)] = table[list(values)]
    return array


def examples(frame: pd.DataFrame) -> Figure:
    """Nine images of each kind of training data (Fig. 8)."""
    figure = style.new_figure(style.PAGE, 3.95)
    spec = figure.add_gridspec(1, 2, wspace=0.02)
    for column, (kind, title) in enumerate(_KINDS.items()):
        half = figure.add_subfigure(spec[0, column])
        half.suptitle(title, fontsize=style.TEXT_SIZE)
        half.supxlabel(r"Sample of $\alpha$ (index)", fontsize=style.TEXT_SIZE)
        half.supylabel(r"Sample of $\psi$ (index)", fontsize=style.TEXT_SIZE)
        pictures = frame[frame["kind"] == kind]
        grid = half.subplots(3, 3, sharex=True, sharey=True)
        for axes, name in zip(grid.flat, _IMAGES, strict=True):
            pixels = _dense(pictures[pictures["image"] == name], ("row", "column"), _COLOURS)
            axes.imshow(pixels, interpolation="none")
            axes.set_title(f"{name})", pad=1.5)
            axes.grid(visible=False)
            axes.set_xticks((0, pixels.shape[1] - 1))
            axes.set_yticks((0, pixels.shape[0] - 1))
    return figure


def _mosaic(power: Array) -> Array:
    """Set the kernels of a layer side by side."""
    height, width = (max(1, round(_CELL / k)) for k in power.shape[2:])
    cells = np.kron(power, np.ones((1, 1, height, width)))
    half = _GAP // 2
    cells = np.pad(cells, ((0, 0), (0, 0), (half, half), (half, half)), constant_values=np.nan)
    n_out, n_in, rows, columns = cells.shape
    return np.asarray(cells.transpose(0, 2, 1, 3).reshape(n_out * rows, n_in * columns), dtype=np.float64)


def kernels(frame: pd.DataFrame) -> Figure:
    """Normalised power spectrum of every convolution kernel (Fig. 11)."""
    indices = ("output", "input", "row", "column")
    powers = [_dense(frame[frame["layer"] == name], indices, ("power",))[..., 0] for name in _LAYERS]
    figure = style.new_figure(style.PAGE, 3.3)
    panels = figure.subplots(1, 3, width_ratios=[power.shape[1] for power in powers])
    norm = Normalize(0.0, 1.0)
    for axes, name, power in zip(panels, _LAYERS, powers, strict=True):
        n_out, n_in, rows, columns = power.shape
        extent = (-0.5, n_in - 0.5, n_out - 0.5, -0.5)
        axes.imshow(_mosaic(power), norm=norm, cmap=style.COLOUR_MAP, interpolation="none", extent=extent)
        axes.set_title(f"{name}: {rows}{style.TIMES}{columns}")
        axes.set(xticks=range(n_in), yticks=range(n_out), xlabel="Input map (index)")
        axes.grid(visible=False)
        axes.spines[:].set_visible(False)
        axes.tick_params(length=0)
    panels[0].set_ylabel("Output map (index)")
    bar = figure.colorbar(ScalarMappable(norm, style.COLOUR_MAP), ax=panels, pad=0.01, aspect=30)
    bar.set_label("Normalised power (dimensionless)")
    bar.outline.set_linewidth(0.4)
    return figure
