"""The factorial of causes: effects with their intervals, and the cells."""

from collections.abc import Hashable, Mapping
from functools import partial

import pandas as pd
from matplotlib.figure import Figure

from repro.config.model import Configuration
from repro.drawing import style
from repro.drawing.markup import Cell, Table, Text, digits, layout, number, plain
from repro.exhibits.causes import RESPONSES
from repro.exhibits.declare import Inputs, figure, table
from repro.files import read_csv
from repro_studies.factorial import COLUMNS, cell_means, effects

_factorial_table, _factorial_figure = (
    partial(kind, category="Ablation", inputs=("factorial",), trained="all", optional=True) for kind in (table, figure)
)

_FACTORS = {
    "image_motion": "desired motion",
    "training": "closed-loop training",
    "metric": "energy ratio as metric",
    "reader": "plain network",
}
_CONTRASTS = {
    "cnn": "Algorithm 1 with the image CNN",
    "reader": "Plain network instead of Algorithm 1, over both motions of line 18",
    "reader, desired motion": "Plain network instead of Algorithm 1 with f on the desired motion",
}


def _words(effect: str) -> str:
    return " \N{MULTIPLICATION SIGN} ".join(_FACTORS[name] for name in effect.split(" x "))


def _estimate(row: Mapping[Hashable, float], factor: float, decimals: int) -> Text:
    value, low, high = (number(factor * row[name], decimals) for name in ("value", "low", "high"))
    return value + " [" + low + ", " + high + "]"


def effects_layout(frame: pd.DataFrame) -> Table:
    """Effects in points of per cent with their 95 % intervals, the largest on T1 to T4 first."""
    blocks = []
    for of, rows in frame.groupby("of", sort=False):
        cells = []
        by = {key: one.iloc[0].to_dict() for key, one in rows.groupby(["effect", "response"], sort=False)}
        names = sorted(dict.fromkeys(rows["effect"]), key=lambda name: -abs(by[name, "validation"]["value"]))
        for name in names:
            points = [_estimate(by[name, response], 100.0, 1) for response in RESPONSES]
            error = _estimate(by[name, "error"], 1.0, 3) if (name, "error") in by else plain("")
            cells.append([plain(_words(name)), *points, error])
        blocks.append((plain(_CONTRASTS[str(of)]), cells))
    count, seeds = int(frame["experiments"].min()), int(frame["training_seeds"].min())
    caption = plain(
        "Factorial of causes on the accepted experiments (simulated): main effects (high minus low level) and "
        "interactions of two factors "
        "(half the difference of the differences) on the mean total of ID and of T1 to T4, in points of per cent, and "
        "on the root mean square error of single estimates over the largest torque, with 95 % intervals over "
        f"{count} experiments and {seeds} training seeds."
    )
    return Table(caption, "lrrr", [plain(name) for name in ("Effect", "ID", "T1 to T4", "Error")], blocks)


#: Levels of the factors in words, where they are not their names.
_LEVELS = {
    "cnn": "Algorithm 1",
    "plain": "plain network",
    "ordinary": "least squares",
    "bounded": "least squares, bounded",
    "true": "true parameters",
    "ideal": "Eq. 10",
    "tracked": "closed-loop",
}


def _level(factor: str) -> Cell:
    """Cells of a factor's levels, empty where it has none."""
    return lambda row: plain("" if pd.isna(row[factor]) else _LEVELS.get(row[factor], str(row[factor])))


def draw_effects(frame: pd.DataFrame) -> Figure:
    """Effects on T1 to T4 and on ID with their intervals."""
    rows = frame[frame["response"].isin(list(RESPONSES)) & frame["of"].isin(["cnn", "reader"])]
    rows = rows.assign(label=rows["effect"].map(_words))
    order = rows[rows["response"] == "validation"].sort_values("value", key=abs, ascending=False)
    names = sorted(dict.fromkeys(order["label"]), key=lambda name: name not in _FACTORS.values())  # products last
    drawn, panels = style.new_panels(style.PAGE, 0.9 + 0.17 * len(names), 1, 2, sharex=True, sharey=True)
    for axes, (response, title) in zip(panels, RESPONSES.items(), strict=True):
        own = rows[rows["response"] == response]
        at = own["label"].map(names.index).to_numpy()
        axes.hlines(at, 100.0 * own["low"], 100.0 * own["high"], color=style.INK, lw=1.0)
        axes.plot(100.0 * own["value"], at, ls="none", marker="o", ms=3.5, color=style.INK)
        axes.axvline(0.0, color="0.6", lw=0.6)
        axes.margins(x=0.05)  # no interval may seem cut
        axes.set(title=title, xlabel="Effect (points of similarity)")
        axes.grid(visible=False, axis="y")
    panels[0].set_yticks(range(len(names)), labels=names)
    panels[0].set_ylim(len(names) - 0.5, -0.5)
    drawn.suptitle(f"{frame['experiments'].min()} simulated experiments", fontsize=style.TEXT_SIZE)
    return drawn


def _factorial(inputs: Inputs) -> pd.DataFrame:
    return pd.concat([read_csv(path, COLUMNS) for path in inputs["scores"]], ignore_index=True)


@_factorial_table("Effects of the causes", effects_layout)
def factorial_table(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """Effects of four causes on the similarity that Algorithm 1 reaches on the accepted experiments, with 95 %
    intervals over experiments and training seeds.
    """
    return effects(_factorial(inputs))


@_factorial_table(
    "Similarities under each combination of the causes",
    layout(
        "Cells of the factorial on the accepted experiments (simulated): mean total (%) on ID and T1 to T4, root mean "
        "square error of single estimates over the largest torque, and executions of 100 that met the threshold.",
        ("Reader", "l", _level("reader")),
        ("Trained on", "l", _level("training")),
        ("f on", "l", _level("image_motion")),
        ("Time factor", "l", _level("metric")),
        ("ID", "r", digits("id", 1, 100.0)),
        ("T1 to T4", "r", digits("validation", 1, 100.0)),
        ("Error", "r", digits("error", 3)),
        ("Met", "r", digits("met", 1)),
    ),
    label="Factorial, cells",
)
def factorial_cells(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """Mean similarity on the accepted experiments under each combination of the causes, and of methods without a
    network.
    """
    return cell_means(_factorial(inputs), read_csv(inputs["references"][0]))


@_factorial_figure("Effects of the causes", draw_effects)
def factorial_figure(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """Effects of four causes on the similarity that Algorithm 1 reaches on the accepted experiments, with 95 %
    intervals over experiments and training seeds: each is averaged over the levels of the others. A product is how much
    one changes the effect of the other. Plain network: reads the torque instead of the image, and has no line 18, so no
    product with the desired motion of line 18. Closed-loop training: on motions that simulated arms followed. Energy
    ratio: another time factor of the similarity.
    """
    return effects(_factorial(inputs))
