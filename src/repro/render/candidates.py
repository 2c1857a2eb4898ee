"""The search for the formula of the similarity metric: how well candidates and motions explain Table 7."""

import math

import pandas as pd
from matplotlib.figure import Figure

from repro.exhibits import style
from repro.exhibits.markup import EMPTY, Table, Text, number, plain, scientific
from repro.exhibits.markup import formula as typeset

#: Candidates of each factor in the figure; the chosen one is added if it is not among them.
_SHOWN = 12

#: Candidates of each factor in the table; the chosen one is added if it is not among them.
_LISTED = 10


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


def ranking_table(frame: pd.DataFrame) -> Table:
    """Best candidate formulas of each factor of the similarity metric."""
    columns = ["rank", "rank_low", "rank_high", "candidate", "formula", "rms_log_error_best", "samples", "bandwidth"]
    columns += ["rms_log_error_mean", "abstract_mean_total", "chosen"]
    blocks = []
    for factor in dict.fromkeys(frame["factor"]):
        ranked = frame[frame["factor"] == factor].sort_values("rank", kind="stable")
        listed = ranked[(ranked["rank"] <= _LISTED) | ranked["chosen"]]
        rows = [
            (
                number(rank, 0),
                _span(number(low, 0), number(high, 0)),
                plain(candidate),
                typeset(formula),
                number(best, 3),
                number(samples, 0),
                _significant(bandwidth),
                number(mean, 3),
                number(100 * total, 2),
                plain("yes") if chosen else EMPTY,
            )
            for rank, low, high, candidate, formula, best, samples, bandwidth, mean, total, chosen in listed[
                columns
            ].itertuples(index=False)
        ]
        blocks.append((plain(f"{factor[:1].upper()}{factor[1:]} factor"), rows))
    caption = plain(
        f"Search for the formula of metr2ev: the {_LISTED} candidates of each factor with the smallest rms log error "
        "against the published Table 7. Without an arm: smallest and largest rank if one of the four arms is left "
        "out. Best: error at the motion that suits the candidate best, with the length and the bandwidth of this "
        "motion. Mean: mean error of all motions. Eq. 10: mean total (%) of the published parameters on Eq. 10 with "
        "the chosen formula of the other factor; the abstract prints 97.38."
    )
    names = ("Rank", "Without an arm", "Candidate", "Formula", "Best", "Samples", "rad/s", "Mean", "Eq. 10", "Chosen")
    header = tuple(plain(name) for name in names)
    return Table("Metric search", "tab:metric_search", caption, "rlllrrrrrl", header, blocks)


def motion_table(frame: pd.DataFrame) -> Table:
    """Random motions of the search, compared with Table 7."""
    errors = [f"rms_log_error_{name}" for name in ("mean_square", "energy", "frequency", "pair")]
    columns = ["samples", "duration", "bandwidth", "bands", "mean_square_low", "mean_square_high", "bounds_satisfied"]
    rows = [
        (
            number(samples, 0),
            _significant(duration),
            _significant(bandwidth),
            _significant(bands),
            _span(_significant(low), _significant(high)),
            number(satisfied, 0),
            *(number(error, 3) for error in row[:-1]),
            plain("yes") if row[-1] else EMPTY,
        )
        for samples, duration, bandwidth, bands, low, high, satisfied, *row in frame[
            [*columns, *errors, "chosen"]
        ].itertuples(index=False)
    ]
    caption = plain(
        "Random motions of the search, with the bandwidth of their filter in rad/s and in bands of the DCT-II. The "
        "published c_f is 100 bands if omega is the band number. Torque: smallest and largest mean-square torque in "
        "(N m)^2 of the four arms and two joints, each the median of the repeats. Bounds: how many of the eight cells "
        "are below the largest mean-square torque that the published Table 7 permits. Last, rms log errors against "
        "Table 7 of the mean square, the energy ratio, the chosen frequency formula and both chosen formulas together."
    )
    names = ("Samples", "s", "rad/s", "Bands", "Torque", "Bounds", "Mean square", "Energy", "Frequency", "Both")
    header = tuple(plain(name) for name in (*names, "Chosen"))
    return Table("Metric motions", "tab:metric_motions", caption, "rrrrlrrrrrl", header, [(None, rows)])


def _span(low: Text, high: Text) -> Text:
    """Smallest and largest value."""
    return low if low == high else low + Text(" to ", " to ") + high


def _significant(value: float) -> Text:
    """A number with three significant digits or more, as a power of ten from 10,000 on."""
    if abs(value) >= 1e4:
        return scientific(value, 1)
    decimals = 2 - math.floor(math.log10(abs(value))) if value else 0
    return number(value, max(0, decimals))
