"""Why Algorithm 1 does worse on the arm: motions of the training and of line 18 crossed."""

from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from repro.config.model import Configuration
from repro.drawing import style
from repro.drawing.markup import Table, Text, number, plain
from repro.exhibits.declare import Inputs, figure, table
from repro.experiments.identifications import CASE, SCORES, read_scores

_why_table, _why_figure = (
    partial(kind, category="Experiment (simulated)", inputs=("arm",), trained="all") for kind in (table, figure)
)

#: Variants of Algorithm 1 by the motions of their training and the motion of line 18.
CAUSES = {
    "algorithm1": ("ideal", "measured"),
    "algorithm1+desired": ("ideal", "desired"),
    "algorithm1+tracked-measured": ("tracked", "measured"),
    "algorithm1+tracked": ("tracked", "desired"),
}
#: Each effect in words, and the weights of the four cells in this order.
_EFFECTS = {
    "image_motion": ("desired instead of measured motion in line 18", (-0.5, 0.5, -0.5, 0.5)),
    "training": ("closed-loop motions instead of Eq. 10 in training", (-0.5, -0.5, 0.5, 0.5)),
    "both": ("interaction (half the difference of the differences)", (0.5, -0.5, -0.5, 0.5)),
}
#: Levels of the two factors in words.
_TRAINING = {"ideal": "Eq. 10", "tracked": "closed-loop motions"}
_MOTIONS = ("measured", "desired")
RESPONSES = {"id": "ID", "validation": "T1 to T4"}


def crossed(scores: pd.DataFrame) -> pd.DataFrame:
    """Mean total of each seed in the four cells: columns ``training, image_motion, seed, response, value``."""
    of_causes = scores[scores["method"].isin(CAUSES)]
    on_id = of_causes["case"].eq(CASE).map({True: "id", False: "validation"}).rename("response")
    means = of_causes.groupby(["method", "seed", on_id])["total"].mean().rename("value").reset_index()
    levels = pd.DataFrame(means["method"].map(CAUSES).tolist(), columns=["training", "image_motion"], index=means.index)
    return pd.concat([levels, means[["seed", "response", "value"]]], axis=1)


def cells_and_effects(cells: pd.DataFrame) -> pd.DataFrame:
    """Mean and spread over the seeds of the cells of `crossed` and of the effects, named under ``training``."""
    values = cells.pivot(index=["response", "seed"], columns=["training", "image_motion"], values="value")
    values = values[list(CAUSES.values())]
    table: dict[tuple[str, ...], Any] = {("cell", *cell): values[cell] for cell in values.columns}
    table |= {("effect", name, ""): values @ np.array(weights) for name, (_, weights) in _EFFECTS.items()}
    rows = [
        (*row, response, of_seeds.mean(), of_seeds.std(ddof=1), len(of_seeds))
        for row, own in table.items()
        for response, of_seeds in own.groupby("response")
    ]
    columns = ["row", "training", "image_motion", "response", "value", "spread", "seeds"]
    return pd.DataFrame(rows, columns=columns).fillna({"spread": 0.0})


def why_layout(frame: pd.DataFrame) -> Table:
    """Similarity in the four cells, then the effects."""
    levels, blocks = _TRAINING | {name: text for name, (text, _) in _EFFECTS.items()}, []
    for heading, kind in (("Mean total of both joints (%)", "cell"), ("Effect (points)", "effect")):
        cells: dict[tuple[str, str], list[Text]] = {}
        own = frame[frame["row"] == kind].fillna({"image_motion": ""})  # an effect has none, which a CSV leaves empty
        for row in own.sort_values("response", kind="stable").to_dict("records"):
            key = (levels[row["training"]], row["image_motion"])
            cells.setdefault(key, [*map(plain, key)]).append(number(100.0 * row["value"], 1, 100.0 * row["spread"]))
        blocks.append((plain(heading), list(cells.values())))
    seeds = int(frame["seeds"].min())
    caption = plain(
        "Algorithm 1 on the simulated arm with the motions of the training and the motion of line 18 crossed: mean "
        f"over {seeds} seeds of guesses ± their standard deviation (Table 10: median), one network for each training."
    )
    header = [*map(plain, ("Trained on", "f of line 18 on", *RESPONSES.values()))]
    return Table(caption, "llrr", header, blocks)


def draw_why(frame: pd.DataFrame) -> Figure:
    """Mean total against the motion of line 18, a line for each kind of training: every seed a mark."""
    drawn, panels = style.new_panels(style.COLUMN, 2.6, 1, 2, sharey=True)
    looks = {"ideal": "algorithm1", "tracked": "algorithm1+tracked"}
    for axes, (response, title) in zip(panels, RESPONSES.items(), strict=True):
        for training, look in looks.items():
            rows = frame[(frame["response"] == response) & (frame["training"] == training)]
            at = rows["image_motion"].map({name: k for k, name in enumerate(_MOTIONS)})
            colour = style.STROKES[look]["color"]
            axes.plot(at, 100.0 * rows["value"], ls="none", color=colour, alpha=0.55, **style.MARKS[look])
            middle = rows.groupby("image_motion")["value"].mean().reindex(list(_MOTIONS))
            axes.plot([0, 1], 100.0 * middle, label=f"trained on {_TRAINING[training]}", **style.STROKES[look])
        axes.set_xticks([0, 1], labels=[f"f of line 18\non {name} motion" for name in _MOTIONS])
        axes.set(title=title, xlim=(-0.3, 1.3), ylabel="Total similarity (%)")
        axes.grid(visible=False, axis="x")
    return style.legend_above(drawn, panels[0], 1, style.SIMULATED)


@_why_table("Motions of the training and of line 18, crossed", why_layout)
def why_table(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """Algorithm 1 on the simulated arm with two factors crossed: the motions that the network is trained on, and the
    motion on which line 18 takes f of the image.
    """
    return cells_and_effects(crossed(read_scores(inputs["scores"], SCORES)))


@_why_figure("Motions of the training and of line 18, crossed", draw_why)
def why_figure(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """Algorithm 1 on the simulated arm with two factors crossed: the motions that the network is trained on, and the
    motion on which line 18 computes f, the torque of a guess. A mark is a seed of guesses, a line joins their means;
    each training has one network.
    """
    return crossed(read_scores(inputs["scores"], SCORES))
