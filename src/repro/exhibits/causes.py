"""Why Algorithm 1 does worse on the arm: training and motion of line 18 crossed, and the factorial of six causes."""

from collections.abc import Hashable, Mapping
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from repro.exhibits import style
from repro.exhibits.declare import ABLATION, EXPERIMENT, Inputs, figure, table
from repro.exhibits.markup import EMPTY, Column, Table, Text, digits, grid, number, plain
from repro.files import read_csv
from repro.pipeline.factorial import COLUMNS, cell_means, effects
from repro.pipeline.identifications import CASE, SCORES, read_scores
from repro.pipeline.job import Config

_why_table, _why_figure = (
    partial(kind, category=EXPERIMENT, inputs=("arm",), trained="all") for kind in (table, figure)
)
_factorial_table, _factorial_figure = (
    partial(kind, category=ABLATION, inputs=("factorial",), trained="all", optional=True) for kind in (table, figure)
)

#: Variants of Algorithm 1 by the motions of their training and the motion of line 18.
CAUSES = {
    "algorithm1": ("ideal", "measured"),
    "algorithm1+desired": ("ideal", "desired"),
    "algorithm1+tracked-measured": ("tracked", "measured"),
    "algorithm1+tracked": ("tracked", "desired"),
}
#: Weights of the four cells, in this order, in each effect.
_EFFECT_WEIGHTS = {
    "image_motion": (-0.5, 0.5, -0.5, 0.5),
    "training": (-0.5, -0.5, 0.5, 0.5),
    "both": (0.5, -0.5, -0.5, 0.5),
}
#: Levels of the two factors, and effects, in words.
_TRAINING = {"ideal": "Eq. 10", "tracked": "closed-loop motions"}
_MOTIONS = ("measured", "desired")
_EFFECT_TEXTS = {
    "image_motion": "desired instead of measured motion in line 18",
    "training": "closed-loop motions instead of Eq. 10 in training",
    "both": "interaction (half the difference of the differences)",
}
RESPONSES = {"id": "ID", "validation": "T1 to T4"}


def crossed(scores: pd.DataFrame) -> pd.DataFrame:
    """Mean total of each seed in the four cells.

    Columns ``training, image_motion, seed, response, value``, the response being ``id`` or ``validation``.
    """
    of_causes = scores[scores["method"].isin(CAUSES)]
    on_id = of_causes["case"].eq(CASE).map({True: "id", False: "validation"}).rename("response")
    means = of_causes.groupby(["method", "seed", on_id])["total"].mean().rename("value").reset_index()
    levels = pd.DataFrame(means["method"].map(CAUSES).tolist(), columns=["training", "image_motion"], index=means.index)
    return pd.concat([levels, means[["seed", "response", "value"]]], axis=1)


def why_table(cells: pd.DataFrame) -> pd.DataFrame:
    """Mean and spread over the seeds of the four cells and of the effects, from `crossed`.

    Columns ``row, training, image_motion, response, value, spread, seeds``; an effect has its name under ``training``.
    """
    values = cells.pivot(index=["response", "seed"], columns=["training", "image_motion"], values="value")
    values = values[list(CAUSES.values())]
    table: dict[tuple[str, ...], Any] = {("cell", *cell): values[cell] for cell in values.columns}
    table |= {("effect", name, ""): values @ np.array(weights) for name, weights in _EFFECT_WEIGHTS.items()}
    rows = [
        (*row, response, of_seeds.mean(), of_seeds.std(ddof=1), len(of_seeds))
        for row, own in table.items()
        for response, of_seeds in own.groupby("response")
    ]
    columns = ["row", "training", "image_motion", "response", "value", "spread", "seeds"]
    return pd.DataFrame(rows, columns=columns).fillna({"spread": 0.0})


def why_layout(frame: pd.DataFrame) -> Table:
    """Similarity in the four cells, then the effects."""
    blocks = []
    for heading, kind in (("Mean total of both joints (%)", "cell"), ("Effect (points)", "effect")):
        cells: dict[tuple[str, str], list[Text]] = {}
        own = frame[frame["row"] == kind].fillna({"image_motion": ""})  # an effect has none, which a CSV leaves empty
        for row in own.sort_values("response", kind="stable").to_dict("records"):
            key = ({**_TRAINING, **_EFFECT_TEXTS}[row["training"]], row["image_motion"])
            cells.setdefault(key, [*map(plain, key)]).append(number(100.0 * row["value"], 1, 100.0 * row["spread"]))
        blocks.append((plain(heading), list(cells.values())))
    seeds = int(frame["seeds"].min())
    caption = plain(
        "Algorithm 1 on the simulated arm with the motions of the training and the motion of line 18 crossed: mean "
        f"over {seeds} seeds of guesses ± their standard deviation, one network for each kind of training."
    )
    names = ("Trained on", "f of line 18 on", *RESPONSES.values())
    return Table(caption, "llrr", [plain(name) for name in names], blocks)


def draw_why(frame: pd.DataFrame) -> Figure:
    """Mean total against the motion of line 18, a line for each kind of training: every seed a mark."""
    drawn = style.new_figure(style.COLUMN, 2.6)
    panels = drawn.subplots(1, 2, sharey=True)
    looks = {"ideal": "algorithm1", "tracked": "algorithm1+tracked"}
    for axes, (response, title) in zip(panels, RESPONSES.items(), strict=True):
        for training, look in looks.items():
            rows = frame[(frame["response"] == response) & (frame["training"] == training)]
            at = rows["image_motion"].map({name: k for k, name in enumerate(_MOTIONS)})
            colour = style.STROKES[look]["color"]
            axes.plot(at, 100.0 * rows["value"], ls="none", color=colour, alpha=0.55, **style.MARKS[look])
            middle = rows.groupby("image_motion")["value"].mean().reindex(list(_MOTIONS))
            axes.plot([0, 1], 100.0 * middle, label=f"trained on {_TRAINING[training]}", **style.STROKES[look])
        axes.set_title(title)
        axes.set_xticks([0, 1], labels=[f"f of line 18\non {name} motion" for name in _MOTIONS])
        axes.set_xlim(-0.3, 1.3)
        axes.set_ylabel("Total similarity (%)")
        axes.grid(visible=False, axis="x")
    style.legend_above(drawn, panels[0], 1, style.SIMULATED)
    return drawn


@_why_table("why", "Motions of the training and of line 18, crossed", why_layout)
def why_summary(inputs: Inputs, _: Config) -> pd.DataFrame:
    """Algorithm 1 on the simulated arm with two factors crossed: the motions that the network is trained on, and the
    motion on which line 18 takes f of the image.
    """
    return why_table(crossed(read_scores(inputs["scores"], SCORES)))


@_why_figure("why", "Motions of the training and of line 18, crossed", draw_why)
def why_figure(inputs: Inputs, _: Config) -> pd.DataFrame:
    """Algorithm 1 on the simulated arm with two factors crossed: the motions that the network is trained on, and the
    motion on which line 18 takes f of the image.
    """
    return crossed(read_scores(inputs["scores"], SCORES))


FACTORS = {
    "image_motion": "f on the desired motion",
    "training": "closed-loop training",
    "omega": "omega as DCT index",
    "back_emf": "back-EMF",
    "metric": "energy ratio",
    "reader": "plain network",
}


_CONTRASTS = {
    "cnn": "Algorithm 1 with the image CNN",
    "reader": "Plain network instead of Algorithm 1, over both motions of line 18",
    "reader, desired motion": "Plain network instead of Algorithm 1 with f on the desired motion",
}


def _words(effect: str) -> str:
    return " x ".join(FACTORS[name] for name in effect.split(" x "))


def _estimate(row: Mapping[Hashable, float], factor: float, decimals: int) -> Text:
    value, low, high = (number(factor * row[name], decimals) for name in ("value", "low", "high"))
    return value + Text(" [", " [") + low + Text(", ", ", ") + high + Text("]", "]")


def effects_layout(frame: pd.DataFrame) -> Table:
    """Effects in points of per cent with their 95 % intervals, the largest on T1 to T4 first."""
    blocks = []
    for of, rows in frame.groupby("of", sort=False):
        cells = []
        by = {key: one.iloc[0].to_dict() for key, one in rows.groupby(["effect", "response"], sort=False)}
        names = sorted(dict.fromkeys(rows["effect"]), key=lambda name: -abs(by[name, "validation"]["value"]))
        for name in names:
            points = [_estimate(by[name, response], 100.0, 1) for response in RESPONSES]
            error = _estimate(by[name, "error"], 1.0, 3) if (name, "error") in by else EMPTY
            held_out = [number(100.0 * by[name, response]["confirmation"], 1) for response in RESPONSES]
            cells.append([plain(_words(name)), *points, error, *held_out])
        blocks.append((plain(_CONTRASTS[str(of)]), cells))
    count, seeds = int(frame["blocks"].min()), int(frame["training_seeds"].min())
    caption = plain(
        "Factorial of causes on simulated arms: main effects (high minus low level) and interactions of two factors "
        "(half the difference of the differences) on the mean total of ID and of T1 to T4, in points of per cent, and "
        "on the root mean square error of single estimates over the largest torque, with 95 % intervals over "
        f"{count} blocks and {seeds} training seeds. Last, the same on an arm and a specimen frozen before and scored "
        "once."
    )
    header = ("Effect", "ID", "T1 to T4", "Error", "Frozen arm, ID", "Frozen arm, T1 to T4")
    return Table(caption, "lrrrrr", [plain(name) for name in header], blocks)


#: Levels of the factors in words, where they are not their names.
_LEVELS = {
    "cnn": "Algorithm 1",
    "plain": "plain network",
    "ordinary": "least squares",
    "bounded": "least squares, bounded",
    "true": "true parameters",
    "ideal": "Eq. 10",
    "tracked": "closed-loop",
    "rad_per_s": "rad/s",
}


def _level(column: str, row: Mapping[Hashable, Any]) -> Text:
    level = row[column]
    return EMPTY if pd.isna(level) else plain(_LEVELS.get(level, str(level)))


def cells_layout(frame: pd.DataFrame) -> Table:
    """Means of the cells."""
    names = ("Reader", "Trained on", "f on", "omega", "Back-EMF", "Time factor")
    factors = ("reader", "training", "image_motion", "omega", "back_emf", "metric")
    columns: list[Column] = [
        *((name, "l", partial(_level, column)) for name, column in zip(names, factors, strict=True)),
        ("ID", "r", digits("id", 1, 100.0)),
        ("T1 to T4", "r", digits("validation", 1, 100.0)),
        ("Error", "r", digits("error", 3)),
        ("Met", "r", digits("met", 1)),
    ]
    caption = (
        "Cells of the factorial on simulated arms: mean total (%) on ID and T1 to T4, root mean square error of single "
        "estimates over the largest torque, and executions of 100 that met the threshold."
    )
    return grid(caption, columns, [(None, frame)])


def draw_effects(frame: pd.DataFrame) -> Figure:
    """Effects on T1 to T4 and on ID with their intervals, and the frozen arm's."""
    rows = frame[frame["response"].isin(["id", "validation"]) & frame["of"].isin(["cnn", "reader"])]
    label = rows["effect"].map(_words)
    order = rows[rows["response"] == "validation"].assign(label=label, size=lambda f: f["value"].abs())
    names = list(dict.fromkeys(order.sort_values("size", ascending=False)["label"]))
    drawn = style.new_figure(style.PAGE, 0.9 + 0.17 * len(names))
    panels = drawn.subplots(1, 2, sharey=True)
    blocks = f"{frame['blocks'].min()} blocks"
    for axes, response in zip(panels, ("id", "validation"), strict=True):
        own = rows[rows["response"] == response].assign(label=label)
        at = own["label"].map(names.index).to_numpy()
        axes.hlines(at, 100.0 * own["low"], 100.0 * own["high"], color=style.INK, lw=1.0)
        axes.plot(100.0 * own["value"], at, ls="none", marker="o", ms=3.5, color=style.INK, label=blocks)
        frozen = {"marker": "D", "ms": 3.2, "mfc": "white", "mec": "#d1490a", "label": "frozen arm"}
        axes.plot(100.0 * own["confirmation"], at, ls="none", **frozen)
        axes.axvline(0.0, color="0.6", lw=0.6)
        axes.set_title(RESPONSES[response])
        axes.set_xlabel("Effect (points of per cent)")
        axes.grid(visible=False, axis="y")
    panels[0].set_yticks(range(len(names)), labels=names)
    panels[0].set_ylim(len(names) - 0.5, -0.5)
    style.legend_above(drawn, panels[0], 2, style.SIMULATED)
    return drawn


def _factorial(inputs: Inputs) -> pd.DataFrame:
    return pd.concat([read_csv(path, COLUMNS) for path in inputs["scores"]], ignore_index=True)


@_factorial_table("factorial", "Effects of the causes", effects_layout)
def factorial_table(inputs: Inputs, _: Config) -> pd.DataFrame:
    """Effects of six causes on the similarity that Algorithm 1 reaches on simulated arms, with 95 % intervals over
    blocks and training seeds, and the same effects on an arm that was frozen before.
    """
    return effects(_factorial(inputs))


@_factorial_table(
    "factorial_cells",
    "Similarities under each combination of the causes",
    cells_layout,
    label="Factorial, cells",
    target="factorial_cells",
)
def factorial_cells(inputs: Inputs, _: Config) -> pd.DataFrame:
    """Mean similarity on simulated arms under each combination of the causes, with methods that need no network."""
    return cell_means(_factorial(inputs), read_csv(inputs["references"][0]))


@_factorial_figure("factorial", "Effects of the causes", draw_effects)
def factorial_figure(inputs: Inputs, _: Config) -> pd.DataFrame:
    """Effects of six causes on the similarity that Algorithm 1 reaches on simulated arms, with 95 % intervals over
    blocks and training seeds, and the same effects on an arm that was frozen before.
    """
    return effects(_factorial(inputs))
