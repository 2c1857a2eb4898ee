"""The numeric tests N1 to N4: Tables 2 and 4 to 7, Figures 5, 6 and 12 to 17, and the paper's own training."""

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import ConnectionPatch
from matplotlib.text import Annotation

from repro.cnn.architecture import HISTORY_COLUMNS
from repro.config.model import Configuration
from repro.config.sections import changed, plain
from repro.drawing import panels, style
from repro.drawing.markup import formula, layout, unit, words
from repro.exhibits.declare import Declaration, Inputs, Trained, figure, table
from repro.exhibits.result_tables import parameters, similarities
from repro.experiments.identifications import SCORES, motion_of, read_identifications, read_scores
from repro.experiments.summary import median_cells, median_seeds, parameter_table
from repro.files import read_csv
from repro.model.dynamics import inverse_dynamics, rebuild_torque, regressor
from repro.model.parameters import DESCRIPTIONS, EXPRESSIONS, NAMES, UNITS
from repro.signals.dct import dct2sub, spectrum
from repro.signals.metric import metr2ev
from repro.signals.programs import PROGRAMS, SPAN
from repro.signals.trajectories import Motion, identification_trajectory

_NUMERIC = ("signals", "numeric")
_ALL = ("N1", "N2", "N3", "N4")


@table(
    "Dynamic parameters",
    layout(
        "Dynamic parameters of the arm.",
        ("Parameter", "l", lambda row: formula(row["parameter"])),
        ("Description", "l", words("description")),
        ("Expression", "l", lambda row: formula(row["expression"])),
        ("Unit", "l", lambda row: unit(row["unit"])),
    ),
    category="Model",
)
def table02(_: Inputs, __: Configuration) -> pd.DataFrame:
    """The nine dynamic parameters, rebuilt from Eq. 1 (the paper's Table 2 is an image)."""
    return pd.DataFrame({"parameter": NAMES, "description": DESCRIPTIONS, "expression": EXPRESSIONS, "unit": UNITS})


#: Height of the row of boxes, in panel heights.
_BOX_ROW = 1.16


def _steps(figure: Figure, axes: Sequence[Axes], names: Sequence[str], operations: Sequence[str]) -> None:
    """Name what each panel shows in a box above it; arrows lead from box to box, each with its operation above it."""
    place: dict[str, Any] = {"xycoords": "axes fraction", "ha": "center", "va": "center"}
    look = {"boxstyle": "round,pad=0.35", "facecolor": style.FILL_LIGHT, "edgecolor": style.INK, "linewidth": 0.6}
    middle = (0.5, _BOX_ROW)
    boxes = [panel.annotate(name, middle, bbox=look, **place) for panel, name in zip(axes, names, strict=True)]
    for k, operation in enumerate(operations):
        ends: dict[str, Any] = {"axesA": axes[k], "axesB": axes[k + 1], "arrowstyle": "-|>", "mutation_scale": 8}
        ends |= {"patchA": boxes[k].get_bbox_patch(), "patchB": boxes[k + 1].get_bbox_patch()}
        arrow = ConnectionPatch(middle, middle, "axes fraction", linewidth=0.9, color=style.INK, **ends)
        above: dict[str, Any] = {"xycoords": arrow, "textcoords": "offset points", "ha": "center"}
        for artist in (arrow, Annotation(operation, (0.5, 1.0), xytext=(0, 3), **above)):
            artist.set_in_layout(False)
            figure.add_artist(artist)
    for box in boxes:
        box.set_in_layout(False)  # their row is kept free already


def draw_subsampling(frame: pd.DataFrame) -> Figure:
    """Subsampling by the DCT-II in three steps (Fig. 5)."""
    curves = panels.curves_of(frame)
    x, xs = curves["signal"]["x"], curves["subsampled"]["xs"]
    kept, dropped = curves["spectrum"]["kept"], curves["spectrum"]["dropped"]

    figure = style.new_figure(style.PAGE, 2.55)
    figure.set_layout_engine("constrained", rect=(0.0, 0.0, 1.0, 0.83))  # the boxes have the rest
    signal, spectrum, subsampled = figure.subplots(1, 3)
    blue = style.STROKES["joint1"]["color"]
    signal.plot(*x, color=blue, lw=1.0)
    subsampled.plot(*xs, color=blue, lw=0.5, marker="o", ms=1.8, mew=0)
    (low1, high1), (low2, high2) = signal.get_ylim(), subsampled.get_ylim()
    for axes in (signal, subsampled):
        axes.set(xlabel=panels.TIME, ylabel=panels.TORQUE, ylim=(min(low1, low2), max(high1, high2)))

    end = 1.5 * kept[0].size  # enough of the dropped bands to see how small they are
    seen = dropped[0] <= end
    spectrum.vlines(*kept[:1], 0.0, kept[1], color=blue, lw=0.9, label="Kept bands")
    spectrum.vlines(dropped[0][seen], 0.0, dropped[1][seen], color=style.SET_ASIDE, lw=0.9, label="Dropped bands")
    spectrum.axvline(float(kept[0][-1] + dropped[0][0]) / 2, color=style.INK, lw=0.8, ls="--", label="Cut to $M$ bands")
    spectrum.set(xlabel="Band $k$ (index)", ylabel=panels.COEFFICIENT, xlim=(-0.02 * end, end))
    for axes in (signal, spectrum, subsampled):
        style.few_ticks(axes)

    n = kept[0].size + dropped[0].size
    names = (
        f"Signal $x$: $N$ = {n} samples",
        f"Spectrum $X$: $M$ = {kept[0].size} of {n} bands",
        f"Subsampled $x_s$: {xs[0].size} samples",
    )
    _steps(figure, (signal, spectrum, subsampled), names, ("DCT-II", r"iDCT-II $\times \sqrt{M/N}$"))
    figure.legend(*spectrum.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


@figure("Subsampling technique", draw_subsampling, category="Signals", sections=_NUMERIC)
def fig05(_: Inputs, config: Configuration) -> pd.DataFrame:
    """Subsampling with the DCT-II: the torque of joint 1 of arm N1 on the identification trajectory, its spectrum cut
    to 100 bands, and the subsampled torque (Fig. 5 of the paper). The view of the spectrum ends with half as many
    dropped bands as are kept.
    """
    signals = config.signals
    motion = identification_trajectory(signals.duration_s, signals.sampling_period_s)
    x = inverse_dynamics(motion.q, motion.dq, motion.ddq, config.numeric.arms.N1)[0]
    bands, m = spectrum(x), signals.image_samples
    k = np.arange(x.size)
    time_sub = (
        (np.arange(m) + 0.5) * x.size / m * signals.sampling_period_s
    )  # the DCT-II samples the middle of each cell
    parts = [("signal", "x", motion.time, x), ("spectrum", "kept", k[:m], bands[:m])]
    parts += [("spectrum", "dropped", k[m:], bands[m:]), ("subsampled", "xs", time_sub, dct2sub(x, m))]
    return panels.long_table(parts)


def motion_curves(motion: Motion) -> pd.DataFrame:
    """Figures 6 and 16: position, velocity and acceleration of both joints."""
    parts = {"position": motion.q, "velocity": motion.dq, "acceleration": motion.ddq}
    return panels.long_table((p, f"joint{j + 1}", motion.time, x[j]) for p, x in parts.items() for j in (0, 1))


@figure("Identification trajectory", panels.draw_motion, category="Signals", sections=("signals",))
def fig06(_: Inputs, config: Configuration) -> pd.DataFrame:
    """Identification trajectory of Eq. 10 with its exact derivatives (Fig. 6)."""
    signals = config.signals
    return motion_curves(identification_trajectory(signals.duration_s, signals.sampling_period_s))


def _parameters(inputs: Inputs, cases: Sequence[str]) -> pd.DataFrame:
    return parameter_table(read_identifications(inputs["identifications"]), read_scores(inputs["scores"]), cases)


_result_table = partial(table, inputs=("networks",), trained="claims")


def _similarity_table(title: str, category: str, of_what: str) -> Declaration:
    drawing = partial(similarities, cases=_ALL, of_what=f"{of_what}, numeric tests")
    return _result_table(title, drawing, category=category)


@_result_table("Parameters of N1 and N2", partial(parameters, cases=("N1", "N2")), category="Numeric results")
def table04(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """True and identified parameters of N1 and N2: median seed and spread over the seeds."""
    return _parameters(inputs, ("N1", "N2"))


@_result_table("Parameters of N3 and N4", partial(parameters, cases=("N3", "N4")), category="Numeric results")
def table05(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """True and identified parameters of N3 and N4: median seed and spread over the seeds."""
    return _parameters(inputs, ("N3", "N4"))


@_similarity_table("Similarity on the identification trajectory", "Numeric results", "from the identified parameters")
def table06(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """Similarity of the numeric torques and their rebuilding on the identification trajectory: the median of the seeds
    in each cell and the spread over the seeds. The refinement is an extension of ours.
    """
    return median_cells(read_scores(inputs["scores"]).query("trajectory == 'ID'"))


@_similarity_table(
    "Similarity on the validation trajectory", "Numeric validation", "on the random validation trajectory"
)
def table07(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """Similarity on the random validation trajectory: the median of the seeds in each cell and the spread over the
    seeds. The refinement is an extension of ours.
    """
    return median_cells(read_scores(inputs["scores"]).query("trajectory == 'validation'"))


def _torques(
    inputs: Inputs, config: Configuration, trajectory: str, cases: Sequence[str], in_frequency: bool = False
) -> pd.DataFrame:
    """Figures 12 to 15 and 17: actual and rebuilt torque of the median seed, and their difference."""
    signals, method = config.signals, "algorithm1"
    chosen = median_seeds(read_scores(inputs["scores"]))
    runs = {run["seed"]: run["arms"] for run in read_identifications(inputs["identifications"])}
    parts: list[panels.Curve] = []
    for case in cases:
        seed = chosen[case, method]
        motion = motion_of(trajectory, config, seed)
        y = regressor(motion.q, motion.dq, motion.ddq)
        arm = runs[seed][case]
        series = {"actual": arm["true"], "rebuilt": arm["methods"][method]["beta"]}
        for j in (0, 1):
            panel = f"{case}/joint{j + 1}"
            torques = {name: rebuild_torque(y, np.array(beta))[j] for name, beta in series.items()}
            torques["difference"] = torques["actual"] - torques["rebuilt"]
            if in_frequency:
                x = np.arange(motion.time.size) / (2 * motion.time.size * signals.sampling_period_s)
                parts += [(panel, name, x, spectrum(tau)) for name, tau in torques.items()]
            else:
                total = metr2ev(torques["actual"], torques["rebuilt"], config.metric).total
                parts.append((panels.similarity_of(panel), "rebuilt", np.zeros(1), np.array([float(total)])))
                parts += [(panel, name, motion.time, tau) for name, tau in torques.items()]
    return panels.long_table(parts)


_of_runs = partial(figure, inputs=("published",), sections=(*_NUMERIC, "metric"))


def _torque_figure(
    title: str,
    category: str,
    cases: Sequence[str],
    spectra: bool = False,
    trained: Trained = "no",
    end: float | None = None,  # of the view, s
) -> Declaration:
    """Declare a figure of actual and rebuilt signals, a row for each case and a column for each joint."""
    titles = {f"{case}/joint{j}": f"{case}, joint {j}" for case in cases for j in (1, 2)}
    draw = partial(panels.compare, titles=titles, spectra=spectra, end=end)
    return _of_runs(title, draw, category=category, trained=trained)


@_torque_figure("Torques of N1 and N2", "Numeric results", ("N1", "N2"))
def fig12(inputs: Inputs, config: Configuration) -> pd.DataFrame:
    """Torques of N1 and N2, their rebuilding from the parameters that Algorithm 1 identified, and the difference of
    both, one run, that with the median similarity (Fig. 12). In brackets its similarity; Table 6 has medians.
    """
    return _torques(inputs, config, "ID", ("N1", "N2"))


@_torque_figure("Torques of N3 and N4", "Numeric results", ("N3", "N4"))
def fig13(inputs: Inputs, config: Configuration) -> pd.DataFrame:
    """Torques of N3 and N4, their rebuilding from the parameters that Algorithm 1 identified, and the difference of
    both, one run, that with the median similarity (Fig. 13). In brackets its similarity; Table 6 has medians.
    """
    return _torques(inputs, config, "ID", ("N3", "N4"))


@_torque_figure("Spectra of the numeric torques", "Numeric results", _ALL, spectra=True, trained="all")
def fig14(inputs: Inputs, config: Configuration) -> pd.DataFrame:
    """DCT-II spectra of the torques of Fig. 12 and 13 (Fig. 14)."""
    return _torques(inputs, config, "ID", _ALL, in_frequency=True)


@_torque_figure("Validation torques", "Numeric validation", _ALL, trained="all", end=8.0)
def fig15(inputs: Inputs, config: Configuration) -> pd.DataFrame:
    """Torques on the random validation trajectory, their rebuilding, and the difference of both, one run, that with the
    median similarity on ID (Fig. 15). In brackets its similarity; Table 7 has medians.
    """
    return _torques(inputs, config, "validation", _ALL)


@_of_runs(
    "Validation trajectory", partial(panels.draw_motion, width=style.PAGE), category="Numeric validation", trained="all"
)
def fig16(inputs: Inputs, config: Configuration) -> pd.DataFrame:
    """Random validation trajectory of the seed that stands for N1 (Fig. 16)."""
    seed = median_seeds(read_scores(inputs["scores"]))["N1", "algorithm1"]
    return motion_curves(motion_of("validation", config, seed))


@_torque_figure("Spectra of the validation torques", "Numeric validation", _ALL, spectra=True, trained="all")
def fig17(inputs: Inputs, config: Configuration) -> pd.DataFrame:
    """DCT-II spectra of the validation torques, and the difference of both (Fig. 17)."""
    return _torques(inputs, config, "validation", _ALL, in_frequency=True)


#: Methods of the two exhibits below, with their networks.
_RECIPES = {"algorithm1": "published"} | {f"algorithm1+{n}": n for n in ("paper-recipe", "paper-recipe-ranges")}
_table, _figure = (
    partial(kind, category=category, label="The paper's training", optional=True)
    for kind, category in ((table, "Ablation"), (figure, "Model"))
)


@_table(
    "Literal Algorithm 1 with it",
    partial(
        similarities,
        cases=(*_ALL, *PROGRAMS),
        of_what=f"with a network trained by the paper's own schedule and with ours; ID and {SPAN} of the simulated arm",
    ),
    inputs=("paper_recipe",),
)
def paper_recipe_table(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """Similarity of the literal Algorithm 1 on N1 to N4 (identification trajectory) and on the simulated arm with a
    network trained by the paper's own schedule, 500,000 iterations of one image each, without and with the printed
    ranges of the parameters, and with ours.
    """
    numeric = read_scores(inputs["scores"]).query("trajectory == 'ID'")
    both = pd.concat([numeric, read_scores(inputs["experiment"], SCORES)], ignore_index=True)
    return median_cells(both[both["method"].isin(_RECIPES)])


@_figure(
    "Loss next to ours",
    partial(
        panels.draw_losses,
        x_label="Training (images)",
        y_label="Held-out loss (dimensionless)",
        columns=1,
        xscale="log",
    ),
    inputs=("losses",),
    sections=("training", "networks"),
    trained="all",
)
def paper_recipe_figure(inputs: Inputs, config: Configuration) -> pd.DataFrame:
    """Loss on held-out images over the number of images trained on: our training (Algorithm 1), the paper's schedule in
    full (printed schedule), and with the printed ranges, too (trained as printed). Each network is tested on images of
    the ranges that it is trained on, so the last level cannot be compared with the others.
    """
    histories = (read_csv(path, HISTORY_COLUMNS) for path in inputs["histories"])
    own = {"published": {"training": {}}, **plain(config.networks)}
    batches = {method: changed(config.training, own[name]["training"]).batch for method, name in _RECIPES.items()}
    return panels.long_table(
        ("loss", name, batches[name] * h["step"].to_numpy(dtype=np.float64), h["test_loss"].to_numpy(dtype=np.float64))
        for name, h in zip(_RECIPES, histories, strict=True)
    )
