"""The search for the metric's formula: how well each candidate explains the published table."""

import pandas as pd
from matplotlib.figure import Figure

from repro.render import style

#: Candidates shown of each factor; the chosen one is added if it is not among them.
_SHOWN = 12


def metric_search(frame: pd.DataFrame) -> Figure:
    """Best candidate formulas of each factor of the similarity metric."""
    factors = list(dict.fromkeys(frame["factor"]))
    shown = []
    for factor in factors:
        ranked = frame[frame["factor"] == factor].sort_values("rms_log_error", kind="stable").reset_index(drop=True)
        shown.append(ranked[(ranked.index < _SHOWN) | ranked["chosen"]])
    figure = style.new_figure(style.PAGE, 0.8 + 0.165 * max(len(rows) for rows in shown))
    panels = figure.subplots(1, len(factors), squeeze=False)[0]
    for axes, factor, rows in zip(panels, factors, shown, strict=True):
        place = range(len(rows))
        axes.hlines(place, 0.0, rows["rms_log_error"], color="0.80", lw=0.6)
        for mark, chosen in (("Candidate", False), ("Chosen", True)):
            fill, marker, size = (style.INK, "D", 5.0) if chosen else ("white", "o", 4.0)
            here = (rows["chosen"] == chosen).to_numpy()
            axes.plot(
                rows["rms_log_error"][here],
                [y for y, wanted in zip(place, here, strict=True) if wanted],
                ls="none",
                marker=marker,
                ms=size,
                mfc=fill,
                mec=style.INK,
                mew=0.8,
                label=mark,
            )
        axes.set_title(f"{factor[:1].upper()}{factor[1:]} factor")
        axes.set_yticks(place, labels=rows["candidate"], parse_math=False)
        axes.set_ylim(len(rows) - 0.5, -0.5)
        axes.set_xlim(0.0, 1.05 * float(rows["rms_log_error"].max()))
        axes.grid(visible=False, axis="y")
        axes.set_xlabel("RMS log error (dimensionless)")
    style.legend_above(figure, panels[0], 2)
    return figure
