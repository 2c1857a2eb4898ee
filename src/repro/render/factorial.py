"""The factorial of causes: tables of effects and of cells, figure of the effects."""

from collections.abc import Hashable, Mapping

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from repro.exhibits import style
from repro.exhibits.markup import EMPTY, Table, Text, number, plain

FACTORS = {
    "image_motion": "f on the desired motion",
    "training": "closed-loop training",
    "omega": "omega as DCT index",
    "back_emf": "back-EMF",
    "metric": "energy ratio",
    "reader": "plain network",
}
RESPONSES = {"id": "ID", "validation": "T1 to T4", "error": "Error"}
OF = {
    "cnn": "Algorithm 1 with the image CNN",
    "reader": "Plain network instead of Algorithm 1, over both motions of line 18",
    "reader, desired motion": "Plain network instead of Algorithm 1 with f on the desired motion",
}


def _words(effect: str) -> str:
    return " x ".join(FACTORS[name] for name in effect.split(" x "))


def _estimate(row: Mapping[Hashable, float], factor: float, decimals: int) -> Text:
    value, low, high = (number(factor * row[name], decimals) for name in ("value", "low", "high"))
    return value + Text(" [", " [") + low + Text(", ", ", ") + high + Text("]", "]")


def effects_table(frame: pd.DataFrame) -> Table:
    """Effects in points of per cent with their 95 % intervals, the largest on T1 to T4 first.

    Columns ``of, effect, response, value, low, high, blocks, training_seeds, confirmation``.
    """
    blocks = []
    for of, rows in frame.groupby("of", sort=False):
        cells = []
        by = {key: one.iloc[0].to_dict() for key, one in rows.groupby(["effect", "response"], sort=False)}
        names = sorted(dict.fromkeys(rows["effect"]), key=lambda name: -abs(by[name, "validation"]["value"]))
        for name in names:
            points = [_estimate(by[name, response], 100.0, 1) for response in ("id", "validation")]
            error = _estimate(by[name, "error"], 1.0, 3) if (name, "error") in by else EMPTY
            held_out = [number(100.0 * by[name, response]["confirmation"], 1) for response in ("id", "validation")]
            cells.append([plain(_words(name)), *points, error, *held_out])
        blocks.append((plain(OF[str(of)]), cells))
    count, seeds = int(frame["blocks"].min()), int(frame["training_seeds"].min())
    caption = plain(
        "Factorial of causes on simulated arms: main effects (high minus low level) and interactions of two factors "
        "(half the difference of the differences) on the mean total of ID and of T1 to T4, in points of per cent, and "
        "on the root mean square error of single estimates over the largest torque, with 95 % intervals over "
        f"{count} blocks and {seeds} training seeds. Last, the same on an arm and a specimen frozen before and scored "
        "once."
    )
    header = ("Effect", "ID", "T1 to T4", "Error", "Frozen arm, ID", "Frozen arm, T1 to T4")
    return Table("Factorial", "tab:factorial", caption, "lrrrrr", [plain(name) for name in header], blocks)


def cells_table(frame: pd.DataFrame) -> Table:
    """Means of the cells.

    Columns ``reader, image_motion, training, omega, back_emf, metric, id, validation, error, met``.
    """
    words = {
        "cnn": "Algorithm 1",
        "plain": "plain network",
        "ordinary": "least squares",
        "bounded": "least squares, bounded",
        "true": "true parameters",
        "ideal": "Eq. 10",
        "tracked": "closed-loop",
        "rad_per_s": "rad/s",
    }
    names = ["reader", "training", "image_motion", "omega", "back_emf", "metric"]
    rows = []
    told_names = frame[names].astype(object).fillna("").astype(str)
    for row in frame.assign(**{name: told_names[name] for name in names}).to_dict("records"):
        told = [plain(words.get(row[name], row[name])) for name in names]
        error = EMPTY if np.isnan(row["error"]) else number(row["error"], 3)
        met = EMPTY if np.isnan(row["met"]) else number(row["met"], 1)
        rows.append([*told, *(number(100.0 * row[name], 1) for name in ("id", "validation")), error, met])
    caption = plain(
        "Cells of the factorial on simulated arms: mean total (%) on ID and T1 to T4, root mean square error of single "
        "estimates over the largest torque, and executions of 100 that met the threshold."
    )
    header = ("Reader", "Trained on", "f on", "omega", "Back-EMF", "Time factor", "ID", "T1 to T4", "Error", "Met")
    columns = [plain(name) for name in header]
    return Table("Factorial, cells", "tab:factorial_cells", caption, "llllllrrrr", columns, [(None, rows)])


def figure(frame: pd.DataFrame) -> Figure:
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
        axes.plot(
            100.0 * own["confirmation"],
            at,
            ls="none",
            marker="D",
            ms=3.2,
            mfc="white",
            mec="#d1490a",
            label="frozen arm",
        )
        axes.axvline(0.0, color="0.6", lw=0.6)
        axes.set_title(RESPONSES[response])
        axes.set_xlabel("Effect (points of per cent)")
        axes.grid(visible=False, axis="y")
    panels[0].set_yticks(range(len(names)), labels=names)
    panels[0].set_ylim(len(names) - 0.5, -0.5)
    style.legend_above(drawn, panels[0], 2, style.SIMULATED)
    return drawn
