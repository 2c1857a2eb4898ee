"""The network and its training: Table 3, Figures 7 to 11."""

from collections.abc import Hashable, Mapping, Sequence
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from repro.cnn.architecture import HISTORY_COLUMNS, read_weights
from repro.cnn.dataset import sample_motion
from repro.cnn.image import assemble, colours, image_factors
from repro.cnn.priors import sample_beta
from repro.config.model import Configuration
from repro.config.sections import data_settings
from repro.drawing import style
from repro.drawing.markup import layout, words
from repro.drawing.panels import JOINTS, TIME, curves_of, draw_losses, long_table, plot_series
from repro.exhibits.declare import Inputs, figure, table
from repro.experiments.stored_networks import architecture
from repro.files import read_csv
from repro.model.dynamics import rebuild_torque
from repro.model.parameters import Array
from repro.signals.trajectories import identification_trajectory
from repro.streams import Stream, stream

_model = partial(figure, category="Model")
_training_data = partial(figure, category="Data", sections=("signals", "data", "image", "training"))
#: Sections of the configuration that the network depends on.
_NETWORK = ("signals", "network")


@table(
    "Characteristics of the network",
    layout(
        "Characteristics of the convolutional neural network.",
        ("Feature", "l", words("feature")),
        ("Value", "l", words("value")),
    ),
    category="Model",
    sections=(*_NETWORK, "training"),
)
def table03(_: Inputs, config: Configuration) -> pd.DataFrame:
    """Features of the CNN as Section IV-B describes it, and of its training in this workflow (the paper's Table 3 is an
    image). The paper trains by 500,000 iterations on 10,000 fixed images (target paper_recipe); its text does not have
    the widths of layers 4 and 5.
    """
    network, training = config.network, config.training
    layers = architecture(network)
    rows = [("Input", f"{network.image_size} x {network.image_size} x 2"), ("Output", "9 parametric residuals")]
    for row in layers[layers["kind"] != "input"].to_dict("records"):
        number = "6" if row["layer"] == "output" else row["layer"][-1]
        size = f"{row['height']} x {row['width']} x {row['channels']}"
        values = {"convolution": f"kernels {row['kernel']}, output {size}", "max pool": f"window 2 x 2, output {size}"}
        kind = row["kind"] if row["kind"] in values else "fully connected"
        rows.append((f"Layer {number}, {kind}", values.get(kind, f"{row['channels']} units")))
    rows += [
        ("Activation, layers 1 to 5", "ReLU (Eq. 12)"),
        ("Activation, layer 6", f"sigmoid (Eq. 13), c = {network.sigmoid_gain:g}"),
        ("Parameters", str(int(layers["parameters"].sum()))),
        ("Loss", "half mean square error of sigmoids"),
        ("Training images", {"streamed": "new at every iteration"}.get(training.recipe, "fixed")),
        ("Training iterations", str(training.steps)),
        ("Images in an iteration", str(training.batch)),
    ]
    return pd.DataFrame(rows, columns=["feature", "value"])


KINDS = ("input", "convolution", "max pool", "fully connected", "output")
#: Activation of each layer (Eq. 12, 13); the others have none.
_ACTIVATIONS = {**dict.fromkeys(("conv1", "conv2", "conv3", "fc4", "fc5"), "ReLU"), "output": "sigmoid"}
_FILLS = dict(zip(KINDS, ("white", style.FILL_DARK, style.FILL_LIGHT, "#f3c77d", "#b3541e"), strict=True))
# Measures of the drawing, in.
_LARGEST = 0.74  # side of the largest map, or length of the longest bar
_SHEET = 0.016  # shift from one map of a stack to the next
_BAR = 0.09  # width of a fully connected layer
_NARROWEST = 0.62  # room for the words below a layer
_HEADINGS = 0.66  # room for the row headings
_MARGIN = 0.06
_AXIS = 1.55  # height of the line on which all layers are centred
_ROW = 0.15  # from one row of words to the next
_FIRST_ROW = 0.88


class _Drawn:
    """A layer on the page: a stack of maps from front to back, or a bar as long as its units, in inches."""

    def __init__(self, layer: Mapping[Hashable, Any], scale: float) -> None:
        self.layer = layer
        self.is_map = layer["kind"] in KINDS[:3]
        self.sheets = layer["channels"] if self.is_map else 1
        self.width = layer["width"] * scale if self.is_map else _BAR
        self.height = (layer["height"] if self.is_map else layer["channels"]) * scale
        self.depth = _SHEET * (self.sheets - 1)
        self.column = max(_NARROWEST, self.width + self.depth)

    def put(self, axes: Axes, centre: float) -> None:
        """Draw the layer, and below it its words."""
        layer = self.layer
        self.left, self.bottom = centre - (self.width + self.depth) / 2, _AXIS - (self.height + self.depth) / 2
        self.right, self.top = self.left + self.width + self.depth, self.bottom + self.height + self.depth
        for sheet in reversed(range(self.sheets)):
            corner = (self.left + _SHEET * sheet, self.bottom + _SHEET * sheet)
            axes.add_patch(Rectangle(corner, self.width, self.height, fc=_FILLS[layer["kind"]], ec=style.INK, lw=0.4))
        size = style.TIMES.join(str(layer[name]) for name in ("height", "width", "channels")[0 if self.is_map else 2 :])
        kernel = layer["kernel"].replace("x", style.TIMES) or style.DASH
        activation = _ACTIVATIONS.get(layer["layer"], style.DASH)
        for row, word in enumerate((layer["layer"], kernel, activation, size, f"{layer['parameters']:,}")):
            axes.text(centre, _FIRST_ROW - _ROW * row, word, fontsize=style.SMALL_SIZE, ha="center")


def _connect(axes: Axes, before: _Drawn, after: _Drawn, scale: float) -> None:
    """Show what one output sees: a kernel window on the front map, or the whole layer."""
    line: dict[str, Any] = {"color": style.INK, "lw": 0.4, "ls": (0, (3, 1.5))}
    if after.is_map:
        height, width = (int(size) * scale for size in after.layer["kernel"].split("x")[:2])
        x, y = before.left + 0.7 * before.width - width / 2, before.bottom + 0.6 * before.height
        axes.add_patch(Rectangle((x, y), width, height, facecolor="none", edgecolor=style.INK, lw=0.6))
        target = (after.left + 0.3 * after.width, after.bottom + 0.6 * after.height + height / 2)
        for corner in (y, y + height):
            axes.plot((x + width, target[0]), (corner, target[1]), **line)
    else:
        for ends in ((before.top, after.top), (before.bottom + before.depth, after.bottom)):
            axes.plot((before.right, after.left), ends, **line)


def draw_network(frame: pd.DataFrame) -> Figure:
    """Architecture of the network with every size (Fig. 7)."""
    layers = frame.fillna({"kernel": ""})
    is_map = layers["kind"].isin(KINDS[:3])
    scale = _LARGEST / layers["channels"].where(~is_map, layers[["height", "width"]].max(axis=1)).max()
    figure, axes = style.inches(style.PAGE, 2.15)
    for row, heading in enumerate(("Layer", "Kernel", "Activation", "Output", "Parameters")):
        axes.text(_MARGIN, _FIRST_ROW - _ROW * row, heading, fontsize=style.SMALL_SIZE, style="italic")
    drawn = [_Drawn(layer, scale) for layer in layers.to_dict("records")]
    gap = (style.PAGE - _HEADINGS - _MARGIN - sum(each.column for each in drawn)) / len(drawn)
    x = _HEADINGS
    for each in drawn:
        each.put(axes, x + (gap + each.column) / 2)
        x += gap + each.column
    for before, after in pairwise(drawn):
        _connect(axes, before, after, scale)
    for kind in KINDS:
        axes.add_patch(Rectangle((0, 0), 0, 0, facecolor=_FILLS[kind], edgecolor=style.INK, lw=0.4, label=kind))
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 0.0), ncols=len(KINDS), fontsize=style.SMALL_SIZE)
    return figure


@_model("Architecture of the CNN", draw_network, sections=_NETWORK)
def fig07(_: Inputs, config: Configuration) -> pd.DataFrame:
    """Architecture of the CNN with every size (Fig. 7). The widths of layers 4 and 5 are not in the paper's text; ours
    are in the configuration.
    """
    return architecture(config.network)


_LETTERS = "abcdefghi"
_COLOURS = ("red", "green", "blue")
_KINDS = {"Mp": "$M_p$: the parameters match the torque", "Mn": "$M_n$: they do not match"}


def _dense(table: pd.DataFrame, axes: Sequence[str], values: Sequence[str]) -> Array:
    """A long table with integer indices as an array."""
    index = table[list(axes)].to_numpy(dtype=np.intp)
    array = np.full((*(index.max(axis=0) + 1), len(values)), np.nan)
    array[tuple(index.T)] = table[list(values)]
    return array


def draw_examples(frame: pd.DataFrame) -> Figure:
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
        for axes, name in zip(grid.flat, _LETTERS, strict=True):
            pixels = _dense(pictures[pictures["image"] == name], ("row", "column"), _COLOURS)
            axes.imshow(pixels, interpolation="none")
            axes.set_title(f"{name})", pad=1.5)
            axes.grid(visible=False)
            axes.set(xticks=(0, pixels.shape[1] - 1), yticks=(0, pixels.shape[0] - 1))
    return figure


@_training_data("Images of the training data", draw_examples)
def fig08(_: Inputs, config: Configuration) -> pd.DataFrame:
    """Signal images whose guess is right (Mp) and wrong (Mn), in the colours of Eq. 16: the first channel is grey, the
    second adds blue and a little red, clipped to the displayable range (Fig. 8). Axes are the torque α and ψ = 2α
    minus the torque of the guess (Eq. 9): a right guess gives a symmetric image. Images with the same letter share
    their torque.
    """
    signals, data = config.signals, data_settings(config)
    rng, count = stream(config.training.seed, Stream.EXAMPLES), len(_LETTERS)
    motion = sample_motion(identification_trajectory(signals.duration_s, signals.sampling_period_s), signals)
    beta = sample_beta(rng, count, data.prior)
    tau = rebuild_torque(motion.torque, beta)
    largest = np.abs(tau).max((-2, -1), keepdims=True)
    alpha = tau / largest
    guesses = {"Mp": beta / largest[:, 0], "Mn": rng.uniform(data.guess_low, data.guess_high, (count, 9))}
    row, column = np.indices((signals.image_samples, signals.image_samples)).reshape(2, -1)
    frames = []
    for kind, guess in guesses.items():
        u, v = image_factors(alpha, 2 * alpha - rebuild_torque(motion.model, guess), data.image)
        for letter, rgb in zip(_LETTERS, colours(assemble(u, v)).reshape(count, -1, 3), strict=True):
            pixels = {"kind": kind, "image": letter, "row": row, "column": column}
            pixels |= dict(zip(_COLOURS, np.round(rgb.T, 4), strict=True))
            frames.append(pd.DataFrame(pixels))
    return pd.concat(frames, ignore_index=True)


def draw_torque_distribution(frame: pd.DataFrame) -> Figure:
    """Distribution of the training torques over time (Fig. 9)."""
    curves = curves_of(frame)
    figure, panels = style.new_panels(style.COLUMN, 3.7, 2, 1, sharex=True, sharey=True)
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
    return style.legend_above(figure, panels[0], 4)


@_training_data("Distribution of the training torques", draw_torque_distribution)
def fig09(_: Inputs, config: Configuration) -> pd.DataFrame:
    """Distribution of 10,000 training torques, each divided by its largest magnitude (Fig. 9)."""
    signals, data = config.signals, data_settings(config)
    rng = stream(config.training.seed, Stream.TRAINING_ARMS)
    motion = sample_motion(identification_trajectory(signals.duration_s, signals.sampling_period_s), signals)
    tau = rebuild_torque(motion.torque, sample_beta(rng, 10_000, data.prior))
    tau = tau / np.abs(tau).max((-2, -1), keepdims=True)
    time = (np.arange(signals.image_samples) + 0.5) * signals.duration_s / signals.image_samples
    levels = {f"p{p:02d}": np.percentile(tau, p, axis=0) for p in (5, 25, 50, 75, 95)}
    levels["mean"] = tau.mean(0)
    return long_table((f"joint{j + 1}", name, time, y[j]) for j in (0, 1) for name, y in levels.items())


@_model(
    "Loss over the training",
    partial(draw_losses, x_label="Training iteration (steps)", y_label="Loss (dimensionless)", columns=2),
    inputs=("history",),
    trained="all",
)
def fig10(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """Training and held-out loss of our training, which draws new images at every step (Fig. 10). The training loss is
    a mean over the steps since the last point, so it lags behind. The paper trains by 500,000 iterations on fixed
    images, to a loss of about 0.001; the figure of its training is separate.
    """
    history = read_csv(inputs["history"][0], HISTORY_COLUMNS).astype(np.float64)
    steps = history["step"].to_numpy()
    return long_table(("loss", name, steps, history[f"{name}_loss"].to_numpy()) for name in ("train", "test"))


_LAYERS = ("conv1", "conv2", "conv3")


def kernel_spectra(weights: Mapping[str, NDArray[np.floating]]) -> pd.DataFrame:
    """Figure 11: power spectrum of every convolution kernel, zero frequency in the middle."""
    frames = []
    for name in _LAYERS:
        kernels = weights[f"{name}.weight"].astype(np.float64)  # (output, input, k, k)
        power = np.abs(np.fft.fftshift(np.fft.fft2(kernels), axes=(-2, -1))) ** 2
        power /= power.max((-2, -1), keepdims=True)
        index = np.indices(power.shape).reshape(4, -1)
        columns = dict(zip(("output", "input", "row", "column"), index, strict=True))
        frames.append(pd.DataFrame({"layer": name, **columns, "power": power.ravel()}))
    return pd.concat(frames, ignore_index=True)[["layer", "input", "output", "row", "column", "power"]]


#: Pixels of one kernel in the picture, whatever its size (9, 5 and 3 divide it), and of the gap between two.
_KERNEL_PIXELS, _KERNEL_GAP = 45, 6


def _mosaic(power: Array) -> Array:
    """Set the kernels of a layer side by side."""
    height, width = (max(1, round(_KERNEL_PIXELS / k)) for k in power.shape[2:])
    gap = (_KERNEL_GAP // 2,) * 2
    cells = np.pad(np.kron(power, np.ones((1, 1, height, width))), ((0, 0), (0, 0), gap, gap), constant_values=np.nan)
    n_out, n_in, rows, columns = cells.shape
    return np.asarray(cells.transpose(0, 2, 1, 3).reshape(n_out * rows, n_in * columns), dtype=np.float64)


def draw_kernels(frame: pd.DataFrame) -> Figure:
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
        axes.set(title=f"{name}: {rows}{style.TIMES}{columns}", xlabel="Input map (index)")
        axes.set(xticks=range(n_in), yticks=range(n_out))
        axes.grid(visible=False)
        axes.spines[:].set_visible(False)
        axes.tick_params(length=0)
    panels[0].set_ylabel("Output map (index)")
    bar = figure.colorbar(ScalarMappable(norm, style.COLOUR_MAP), ax=panels, pad=0.01, aspect=30)
    bar.set_label("Normalised power (dimensionless)")
    bar.outline.set_linewidth(0.4)
    return figure


@_model("Spectra of the kernels", draw_kernels, inputs=("weights",), sections=_NETWORK, trained="all")
def fig11(inputs: Inputs, config: Configuration) -> pd.DataFrame:
    """Power spectra of the convolution kernels after training, each normalised to its largest value, zero frequency in
    the middle (Fig. 11).
    """
    return kernel_spectra(read_weights(inputs["weights"][0], config.network))
