"""The headline numbers under other interpretations of the paper."""

from functools import partial
from typing import Any, cast

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from repro.cnn.architecture import HISTORY_COLUMNS
from repro.config.model import Configuration
from repro.documents import read_json
from repro.drawing import style
from repro.drawing.markup import Text, digits, layout, plain, several, words
from repro.exhibits.declare import Inputs, figure, table
from repro.files import read_csv
from repro.signals.programs import SPAN
from repro_studies import interpretations

_table, _figure = (partial(kind, category="Ablation", trained="all", optional=True) for kind in (table, figure))

#: Question under which the reading stands that every other one is compared with.
DEFAULT = "default"


def grouped(frame: pd.DataFrame) -> list[tuple[str, pd.DataFrame]]:
    """Rows of each question in the order of the file, the default reading first."""
    groups = [(str(question), rows) for question, rows in frame.groupby("question", sort=False)]
    return sorted(groups, key=lambda group: group[0] != DEFAULT)


_HEADLINES = ("ID mean", "ID lowest", "Val. mean", "Arm ID", "Arm val.", "Arm refined", "Arm LS", "Arm true")
_LOSS = Text(r"Loss~($10^{-4}$)", "Loss (10\N{SUPERSCRIPT MINUS}\N{SUPERSCRIPT FOUR})")


@_table(
    "Headline numbers under other interpretations",
    layout(
        "Readings of what the paper leaves open: mean total similarity (%). N1 to N4: literal Algorithm 1, median "
        "of the seeds, on the identification (ID) and the validation (val.) trajectory; lowest is the lowest of the"
        " eight torques. Simulated arm: literal Algorithm 1 on its identification run (arm ID) and its mean over "
        f"{SPAN} (arm val.), medians of the seeds; the same mean for the refined Algorithm 1 (refined), least "
        "squares (LS) and the true parameters (true). A reading that needs no network of its own has the default's. "
        "Held-out losses under different labels or images do not compare.",
        ("Reading", "l", words("reading")),
        ("Steps", "r", digits("steps", 0)),
        (_LOSS, "r", digits("held_out_loss", 2, 1e4)),
        *several(_HEADLINES, ("id_mean", "id_lowest", "validation_mean", *interpretations.ARM), 2, 100.0),
        blocks=lambda frame: [
            (plain(name.capitalize() if name == DEFAULT else name), rows) for name, rows in grouped(frame)
        ],
    ),
    inputs=("readings",),
)
def ablation_table(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """Headline numbers under each reading of what the paper leaves open: the literal Algorithm 1 on N1 to N4 and on the
    simulated arm (medians of the seeds), and the mean over T1 to T4 of the simulated arm for the refined Algorithm 1,
    least squares and the true parameters. Losses under different labels or images do not compare with each other.
    """
    histories = [read_csv(path, HISTORY_COLUMNS) for path in inputs["losses"]]
    results = [cast("dict[str, Any]", read_json(path)) for path in inputs["results"]]
    return interpretations.ablation_table(results, histories)


_ID, _VALIDATION = ("Identification trajectory", "joint1"), (f"Validation trajectory, or mean over {SPAN}", "joint2")
#: By panel: its title and its quantities, each with what it is called and whose look it has.
_PANELS = {
    "Numeric arms N1 to N4, Algorithm 1": {"id_mean": _ID, "validation_mean": _VALIDATION},
    "Simulated arm, Algorithm 1": {"arm_id": _ID, "arm_validation": _VALIDATION},
    f"Simulated arm, mean over {SPAN}": {
        "arm_refined": ("Algorithm 1 + refinement", "algorithm1+refinement"),
        "arm_least_squares": ("Least squares", "least-squares"),
        "arm_true": ("True parameters", "true"),
    },
}
_MARKS = {
    "joint1": {"marker": "o", "markersize": 3.4, "markeredgewidth": 0.0},
    "joint2": {"marker": "s", "markersize": 3.2, "fillstyle": "none", "markeredgewidth": 0.8},
    **style.MARKS,
}
#: Width of one value written out, and of its mark, as a share of the panel.
_WRITTEN, _SIGN = 0.17, 0.03


def draw_readings(frame: pd.DataFrame) -> Figure:
    """Headline numbers under each reading of the paper, beside those of the default reading."""
    labels: dict[float, str] = {}
    headings, rows, place = [], {}, 0.0
    for question, chosen in grouped(frame):
        wide = 100.0 * chosen.pivot(index="reading", columns="quantity", values="value")
        if question != DEFAULT:
            place += 0.35  # rows
            headings.append(len(labels))
            labels[place] = question
            place += 1.0
        for reading in dict.fromkeys(chosen["reading"]):
            rows[place] = wide.loc[reading]
            labels[place] = f"Default: {reading}" if question == DEFAULT else str(reading)
            place += 1.0
    values = pd.DataFrame(rows).T
    drawn, panels = style.new_panels(style.PAGE, 1.0 + 0.14 * place, 1, len(_PANELS), sharey=True)
    for axes, (title, quantities) in zip(panels, _PANELS.items(), strict=True):
        _plot_panel(axes, values[list(quantities)], quantities)
        axes.set(title=title, xlabel="Total similarity (%)")
        axes.grid(visible=False, axis="y")
        axes.tick_params(axis="y", length=0.0)
    panels[0].set_yticks(list(labels), labels=list(labels.values()), parse_math=False)
    panels[0].set_ylim(place - 0.4, -0.6)
    for heading in headings:
        panels[0].get_yticklabels()[heading].set_style("italic")
    handles = {line.get_label(): line for axes in panels for line in axes.get_legend_handles_labels()[0]}
    (default,) = panels[0].plot([], [], color=style.INK, lw=0.8, label="Lines: the default reading")
    drawn.legend(handles=[*handles.values(), default], loc="outside upper center", ncols=3)
    return drawn


def _plot_panel(axes: Axes, values: pd.DataFrame, quantities: dict[str, tuple[str, str]]) -> None:
    """Draw the values of each row, those of the first as lines; what lies far below them is written out."""
    shown = values >= values.iloc[0].min() - 10.0  # points of a percent below the lowest of the default
    low, high = float(values[shown].min().min()), float(values[shown].max().max())
    margin = 0.06 * max(high - low, 1.0)
    low, high = low - margin, min(high + margin, 100.0 + margin)
    strip = _WRITTEN * int((~shown).sum(axis=1).max())
    left = low - strip / (1.0 - strip) * (high - low)
    axes.set_xlim(left, high)
    ticks = MaxNLocator(4, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high)
    first = low + margin if strip > 0.0 else low  # clear of the word below the strip
    axes.set_xticks([tick for tick in ticks if first <= tick <= min(high, 100.0)])
    if strip > 0.0:
        axes.axvspan(left, low, color="0.94", lw=0.0, zorder=0.0)
        axes.set_xticks([(left + low) / 2], labels=["lower"], minor=True)
        axes.tick_params(axis="x", which="minor", length=0.0, pad=6.0)
    axes.hlines(values.index.to_numpy(), left, high, color="0.90", lw=0.4, zorder=0.4)
    offsets = dict(zip(quantities, np.linspace(-0.2, 0.2, len(quantities)), strict=True))
    for name, (label, look) in quantities.items():
        stroke = style.STROKES[look]
        axes.axvline(values[name].iloc[0], color=stroke["color"], linestyle=stroke["linestyle"], lw=0.8, zorder=0.5)
        here = shown[name].to_numpy()
        heights = values.index.to_numpy(dtype=np.float64)[here] + offsets[name]
        axes.plot(values[name].to_numpy()[here], heights, ls="none", color=stroke["color"], label=label, **_MARKS[look])
    across = axes.get_yaxis_transform()  # x as a share of the panel, y by row
    for place, row, known in zip(values.index, values.to_numpy(), shown.to_numpy(), strict=True):
        cells = zip(row, quantities.values(), known, strict=True)
        far = [(value, look) for value, (_, look), near in cells if not near]
        for k, (value, look) in enumerate(far):
            x = _WRITTEN * k + _SIGN
            axes.plot(x, place, transform=across, ls="none", color=style.STROKES[look]["color"], **_MARKS[look])
            words = axes.text(x + 0.8 * _SIGN, place, f"{value:.2f}", transform=across, color=style.INK)
            words.set(fontsize=style.SMALL_SIZE, va="center_baseline")


@_figure("Headline numbers by reading", draw_readings, inputs=("ablation",))
def ablation_figure(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """Mean total similarity under each reading of what the paper leaves open: the literal Algorithm 1 on N1 to N4
    (left), on the simulated arm's identification run and on the validation motions (middle), and on the validation
    motions the refined Algorithm 1, least squares and the true parameters (right). Vertical lines are the default
    reading. Values far below it stand as numbers in the grey strip.
    """
    table = read_csv(inputs["table"][0], ("question", "reading", *interpretations.HEADLINES))
    return interpretations.ablation_figure(table)
