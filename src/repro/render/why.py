"""Two causes crossed: the motions of the training and the motion of line 18. Table and figure."""

import pandas as pd
from matplotlib.figure import Figure

from repro.exhibits import style
from repro.exhibits.markup import Table, number, plain

#: Levels of the two factors in words.
TRAINING = {"ideal": "Eq. 10", "tracked": "closed-loop motions"}
IMAGE_MOTION = {"measured": "measured", "desired": "desired"}
#: Effects in words.
EFFECTS = {
    "image_motion": "desired instead of measured motion in line 18",
    "training": "closed-loop motions instead of Eq. 10 in training",
    "both": "interaction (half the difference of the differences)",
}
RESPONSES = {"id": "ID", "validation": "T1 to T4"}


def table(frame: pd.DataFrame) -> Table:
    """Similarity in the four cells, then the effects.

    Columns ``row, training, image_motion, response, value, spread, seeds``.
    """
    blocks = []
    for heading, kind in (("Mean total of both joints (%)", "cell"), ("Effect (points)", "effect")):
        of_kind = frame[frame["row"] == kind].fillna(
            {"image_motion": ""}
        )  # an effect has none, which a CSV leaves empty
        cells = []
        for key, rows in of_kind.groupby(["training", "image_motion"], sort=False):
            training, motion = map(str, key)
            words = [EFFECTS[training], ""] if kind == "effect" else [TRAINING[training], IMAGE_MOTION[motion]]
            by = rows.set_index("response")[["value", "spread"]].astype(float).T.to_dict()
            values = [number(100.0 * by[r]["value"], 1, 100.0 * by[r]["spread"]) for r in RESPONSES]
            cells.append([*map(plain, words), *values])
        blocks.append((plain(heading), cells))
    seeds = int(frame["seeds"].min())
    caption = plain(
        "Algorithm 1 on the simulated arm with the motions of the training and the motion of line 18 crossed: mean "
        f"over {seeds} seeds of guesses ± their standard deviation, one network for each kind of training."
    )
    names = ("Trained on", "f of line 18 on", *RESPONSES.values())
    return Table("Why", "tab:why", caption, "llrr", [plain(name) for name in names], blocks)


def figure(frame: pd.DataFrame) -> Figure:
    """Mean total against the motion of line 18, a line for each kind of training: every seed a mark.

    Columns ``training, image_motion, seed, response, value``.
    """
    drawn = style.new_figure(style.COLUMN, 2.6)
    panels = drawn.subplots(1, 2, sharey=True)
    looks = {"ideal": "algorithm1", "tracked": "algorithm1+tracked"}
    for axes, (response, title) in zip(panels, RESPONSES.items(), strict=True):
        for training, look in looks.items():
            rows = frame[(frame["response"] == response) & (frame["training"] == training)]
            at = rows["image_motion"].map({name: k for k, name in enumerate(IMAGE_MOTION)})
            colour = style.STROKES[look]["color"]
            axes.plot(at, 100.0 * rows["value"], ls="none", color=colour, alpha=0.55, **style.MARKS[look])
            middle = rows.groupby("image_motion")["value"].mean().reindex(list(IMAGE_MOTION))
            axes.plot([0, 1], 100.0 * middle, label=f"trained on {TRAINING[training]}", **style.STROKES[look])
        axes.set_title(title)
        axes.set_xticks([0, 1], labels=[f"f of line 18\non {name} motion" for name in IMAGE_MOTION.values()])
        axes.set_xlim(-0.3, 1.3)
        axes.set_ylabel("Total similarity (%)")
        axes.grid(visible=False, axis="x")
    style.legend_above(drawn, panels[0], 1, style.SIMULATED)
    return drawn
