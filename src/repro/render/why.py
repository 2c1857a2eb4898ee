"""From the ideal case to the recording, one cause at a time: table and figure."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from repro.identification.registry import METHODS
from repro.render import style
from repro.render.markup import Table, number, plain

#: What each step adds, in words of a table and of an axis.
STEPS = {
    "ideal": ("Eq. 10's motion, torque of Eq. 1", "ideal"),
    "beyond": ("+ what Eq. 1 leaves out", "+ beyond\nEq. 1"),
    "quantised": ("+ encoder and PWM in counts", "+ counts"),
    "loop": ("+ the motion as the loop tracks it", "+ loop's\nmotion"),
    "recording": ("+ velocity and acceleration from the encoder: the recording", "+ derivatives\n= recording"),
}


def _method(network: str) -> str:
    return "algorithm1" if network == "published" else f"algorithm1+{network}"


def table(frame: pd.DataFrame) -> Table:
    """Similarity and error of the literal Algorithm 1 at each step, a block for each network.

    Columns ``network, step, seeds, total1, total2, spread1, spread2, lost, error_uniform, error_near``.
    """
    blocks = []
    for network, rows in frame.groupby("network", sort=False):
        cells = [
            [
                plain(STEPS[row["step"]][0]),
                *(number(100.0 * row[f"total{j}"], 1, 100.0 * row[f"spread{j}"]) for j in (1, 2)),
                number(100.0 * row["lost"], 1),
                *(number(row[name], 3) for name in ("error_uniform", "error_near")),
            ]
            for row in rows.to_dict("records")
        ]
        blocks.append((plain(METHODS[_method(str(network))].title), cells))
    seeds = int(frame["seeds"].min())
    caption = plain(
        "From the ideal case to the simulated recording of ID, one cause at a time: total similarity (%) of the "
        f"literal Algorithm 1 on the signals of each step, median of {seeds} seeds ± their standard deviation; points "
        "of a percent that the mean of both joints loses from the step before; and the root mean square error of "
        "single estimates, over the largest torque, from guesses as Algorithm 1 draws them and from guesses near the "
        "true parameters."
    )
    names = ("Step", "Joint 1", "Joint 2", "Lost", "Error, uniform", "Error, near")
    return Table("Why", "tab:why", caption, "lrrrrr", [plain(name) for name in names], blocks)


def figure(frame: pd.DataFrame) -> Figure:
    """Total similarity at each step, a panel for each joint: every seed a mark, a line through the medians.

    Columns ``network, step, seed, total1, total2``.
    """
    drawn = style.new_figure(style.COLUMN, 3.9)
    panels = drawn.subplots(2, 1, sharex=True)
    networks = list(dict.fromkeys(frame["network"]))
    places = {step: k for k, step in enumerate(STEPS)}
    for axes, joint in zip(panels, (1, 2), strict=True):
        for offset, network in zip(np.linspace(-0.12, 0.12, len(networks)), networks, strict=True):
            rows = frame[frame["network"] == network]
            look = _method(network)
            at = rows["step"].map(places).to_numpy(dtype=np.float64) + offset
            totals = 100.0 * rows[f"total{joint}"].to_numpy()
            colour = style.STROKES[look]["color"]
            axes.plot(at, totals, ls="none", color=colour, alpha=0.55, **style.MARKS[look])
            middle = rows.groupby("step")[f"total{joint}"].median().reindex(list(STEPS))
            x = np.arange(len(STEPS)) + offset
            axes.plot(x, 100.0 * middle.to_numpy(), label=style.SERIES_LABELS[look], **style.STROKES[look])
        axes.set_title(f"Joint {joint}")
        axes.set_ylabel("Total similarity (%)")
        axes.set_ylim(-4.0, 104.0)
        axes.grid(visible=False, axis="x")
    panels[1].set_xticks(range(len(STEPS)), labels=[words for _, words in STEPS.values()])
    style.legend_above(drawn, panels[0], 1, style.SIMULATED)
    return drawn
