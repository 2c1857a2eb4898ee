"""Experiments that the printed numbers do not rule out: what they settle, and Algorithm 1 over them by its guesses."""

from collections.abc import Hashable, Mapping
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from scipy.stats import binomtest

from repro.config.model import Configuration
from repro.drawing import style
from repro.drawing.markup import Block, Column, Table, Text, digits, grid, layout, number, plain
from repro.exhibits.declare import Inputs, figure, table
from repro.exhibits.result_tables import heading_of, methods_of
from repro.experiments.accepted import GUESSES, SETTINGS
from repro.files import read_csv
from repro.paper.published import load_published
from repro.signals.programs import PROGRAMS, SPAN

_matching = partial(table, category="Ablation", inputs=("matching",), optional=True)
_table, _figure = (
    partial(kind, category="Ablation", inputs=("accepted",), trained="all", optional=True) for kind in (table, figure)
)

#: Shares of experiments below and above a range.
TAILS = (0.025, 0.975)
MEAN = "T1 to T4"
#: Hypotheses in words.
UNITS = {"index": "band number", "rad_per_s": "rad/s"}
BACK_EMF = {True: "in b", False: "further"}
HYPOTHESIS = ("unit", "back_emf_in_b", "tracking")
#: Units of unknowns by the beginning of their names.
SI = {
    **{"duration": "s", "l1": "m", "viscous": "N m s/rad", "stribeck_velocity": "rad/s", "ripple1": "N m"},
    **{"ripple2": "N m", "ripple_cycles": "1/turn", "t4_amplitude": "rad", "t4_frequency": "Hz", "I": "kg m^2"},
    **{"g": "N m", "b": "N m s/rad", "k": "N m"},
}


def hypotheses_layout(frame: pd.DataFrame) -> Table:
    """One row for each hypothesis."""
    columns: list[Column] = [
        ("Omega", "l", lambda row: plain(UNITS[row["unit"]])),
        ("Back-EMF", "l", lambda row: plain(BACK_EMF[row["back_emf_in_b"]])),
        ("Tracking", "l", lambda row: plain(row["tracking"])),
        ("Starts", "r", digits("starts", 0)),
        ("Accepted", "r", digits("accepted", 0)),
        ("Smallest misfit", "r", digits("smallest", 1)),
        ("Median", "r", digits("median", 1)),
    ]
    caption = (
        "History matching: hypotheses on the unit of omega, on whether the b of Appendix A has the back-EMF, and on "
        "the order of the joints in the tracking of Table 8; starts of the search, those that end in an accepted "
        "experiment, and the sum of squares of the 52 terms of the misfit."
    )
    return grid(caption, columns, [(None, frame)])


@_matching("Hypotheses on the experiment", hypotheses_layout)
def hypotheses(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """Hypotheses on the experiment that were tried with each other, by how many starts of the search end in an
    experiment that the printed numbers of least squares, the torque bounds and the tracking do not rule out.
    """
    starts = read_csv(inputs["starts"][0], (*HYPOTHESIS, "accepted", "misfit"))
    each = starts.groupby(list(HYPOTHESIS), sort=False)
    found = {"starts": each.size(), "accepted": each["accepted"].sum()}
    return pd.DataFrame({**found, "smallest": each["misfit"].min(), "median": each["misfit"].median()}).reset_index()


def unknowns_layout(frame: pd.DataFrame) -> Table:
    """One row for each unknown."""
    return layout(
        "Unknowns of the experiments that the printed numbers do not rule out: smallest, median and largest value.",
        ("Unknown", "l", lambda row: plain(f"{row['unknown']}, {row['si']}" if row["si"] else row["unknown"])),
        ("Smallest", "r", digits("low", 3)),
        ("Median", "r", digits("median", 3)),
        ("Largest", "r", digits("high", 3)),
    )(frame.fillna({"si": ""}))


@_matching("Unknowns of the accepted experiments", unknowns_layout)
def unknowns(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """What the printed numbers determine of the experiment, and what they leave open: the unknowns over all accepted
    experiments.
    """
    accepted = read_csv(inputs["experiments"][0], ("experiment", *SETTINGS))
    left_out = ("experiment", "misfit", *HYPOTHESIS, "seed", "ripple_phase1", "ripple_phase2")
    numbers = accepted.drop(columns=list(left_out))
    si = {name: next((u for start, u in SI.items() if name.startswith(start)), "") for name in map(str, numbers)}
    values = {"low": numbers.min(), "median": numbers.median(), "high": numbers.max()}
    return pd.DataFrame({"si": pd.Series(si), **values}).rename_axis("unknown").reset_index()


def _scores(inputs: Inputs) -> pd.DataFrame:
    return pd.concat([read_csv(path, GUESSES) for path in inputs["scores"]], ignore_index=True)


def by_experiment(scores: pd.DataFrame) -> pd.DataFrame:
    """Total of each cell, and of `MEAN` over both joints, of each experiment: the median of its seeds."""
    keys = ["unit", "method", "guesses", "experiment"]
    validated = scores[scores["case"] != "ID"]
    mean = validated.groupby([*keys, "seed"], sort=False)["total"].mean().reset_index().assign(case=MEAN, joint=0)
    both = pd.concat([scores, mean])
    return both.groupby([*keys, "case", "joint"], sort=False)["total"].median().reset_index()


def _published(method: str, case: str, joint: int) -> float:
    """Published total of a cell, as a fraction, of `MEAN` over its cells: of least squares, or of Algorithm 1."""
    numbers, kind = load_published(), "least-squares" if method == "least-squares" else "algorithm1"
    cells = [(case, joint)] if case != MEAN else [(each, j) for each in PROGRAMS[1:] for j in (1, 2)]
    return float(np.mean([numbers[f"table10/{each}/{kind}/total/joint{j}"].value / 100.0 for each, j in cells]))


def _cells(scores: pd.DataFrame) -> pd.DataFrame:
    """Each cell of each method within each budget: median and range over the experiments, of all and of each unit."""
    totals, rows = by_experiment(scores), []
    for unit in ("all", *UNITS):
        of_unit = totals if unit == "all" else totals[totals["unit"] == unit]
        for key, own in of_unit.groupby(["method", "guesses", "case", "joint"], sort=False):
            method, guesses, case, joint = str(key[0]), key[1], str(key[2]), int(str(key[3]))
            low, middle, high = np.quantile(own["total"], [TAILS[0], 0.5, TAILS[1]])
            published = _published(method, case, joint)
            inside = bool(low <= published <= high)
            values = {"median": middle, "low": low, "high": high, "published": published, "inside": inside}
            labels = {"unit": unit, "method": method, "guesses": guesses, "experiments": len(own)}
            rows.append({**labels, "case": case, "joint": joint, **values})
    return pd.DataFrame(rows)


def _name(row: Mapping[Hashable, Any]) -> Text:
    """Method with its guesses."""
    return heading_of(row["method"]) + (plain(f", {row['guesses']:,} guesses") if row["guesses"] else "")


def _range(row: Mapping[Hashable, Any], name: str) -> Text:
    median, low, high = (100.0 * row[f"{name}_{end}"] for end in ("median", "low", "high"))
    return number(median, 1) + plain(f" ({low:.1f} to {high:.1f})")


def accepted_layout(frame: pd.DataFrame) -> Table:
    """One row for each method and budget, over all experiments; the CSV has those of each unit of omega, too."""
    columns: list[Column] = [
        ("Method", "l", _name),
        ("Experiments", "r", digits("experiments", 0)),
        ("ID, joint 1", "r", partial(_range, name="id1")),
        ("ID, joint 2", "r", partial(_range, name="id2")),
        (MEAN, "r", partial(_range, name="mean")),
        ("Inside", "r", lambda row: plain(f"{row['inside']:.0f} of {row['cells']:.0f}")),
        ("Above LS", "r", _wins),
        ("Met", "r", digits("met", 1)),
    ]
    order = {method: place for place, method in enumerate(methods_of(frame))}
    rows = frame[frame["unit"] == "all"].assign(place=lambda own: own["method"].map(order))
    caption = (
        "Similarity (%) over the simulated experiments that the printed numbers do not rule out: median and central "
        f"95 % range of the total on ID and of the mean over {SPAN} and both joints. Published, Algorithm 1: 93.55, "
        "94.51 and 91.74. Inside: cells of Table 10 whose published total is within the range. Above LS: experiments "
        f"whose mean over {SPAN} is above that of plain least squares, with the 95 % interval of the share (Clopper "
        "and Pearson). Met: estimates over the threshold."
    )
    return grid(caption, columns, [(None, rows.sort_values(["place", "guesses"], kind="stable"))])


def _wins(row: Mapping[Hashable, Any]) -> Text:
    """Cell of a share with its interval."""
    low, high = 100.0 * row["wins_low"], 100.0 * row["wins_high"]
    return plain(f"{row['wins']:.0f} of {row['experiments']:.0f} ({low:.0f} to {high:.0f} %)")


@_table("Algorithm 1 over the accepted experiments", accepted_layout)
def accepted_table(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """Algorithm 1 by its number of guesses, and least squares, over the experiments that the printed numbers do not
    rule out: whether the published totals are within what these experiments give, and in how many of them Algorithm 1
    is above plain least squares on T1 to T4.
    """
    scores = _scores(inputs)
    totals, cells = by_experiment(scores), _cells(scores)
    means = totals[totals["case"] == MEAN]
    level = means[means["method"] == "least-squares"].set_index("experiment")["total"]
    above = means.assign(above=means["total"] > means["experiment"].map(level))
    met = scores.drop_duplicates(["experiment", "method", "guesses", "seed"])
    rows = []
    for (unit, method, guesses), own in cells.groupby(["unit", "method", "guesses"], sort=False):
        shown = {"id1": ("ID", 1), "id2": ("ID", 2), "mean": (MEAN, 0)}
        values = {
            f"{short}_{end}": own.loc[(own["case"] == case) & (own["joint"] == joint), end].iloc[0]
            for short, (case, joint) in shown.items()
            for end in ("median", "low", "high")
        }
        wins, ends = (
            of[(of["method"] == method) & (of["guesses"] == guesses) & ((unit == "all") | (of["unit"] == unit))]
            for of in (above, met)
        )
        inside = own.loc[own["case"] != MEAN, "inside"]
        counts = {"inside": int(inside.sum()), "cells": len(inside), "wins": int(wins["above"].sum())}
        share = binomtest(counts["wins"], len(wins)).proportion_ci()
        interval = {"wins_low": share.low, "wins_high": share.high}
        labels = {"unit": unit, "method": method, "guesses": guesses, "experiments": len(wins)}
        rows.append({**labels, **values, **counts, **interval, "met": float(ends["met"].mean())})
    return pd.DataFrame(rows)


def cells_layout(frame: pd.DataFrame) -> Table:
    """One row for each cell of Table 10, a block for each method and budget."""
    columns: list[Column] = [
        ("Cell", "l", lambda row: plain(row["case"] if row["joint"] == 0 else f"{row['case']}, joint {row['joint']}")),
        ("Published", "r", digits("published", 2, 100.0)),
        ("Median", "r", digits("median", 2, 100.0)),
        ("Range", "r", lambda row: plain(f"{100.0 * row['low']:.2f} to {100.0 * row['high']:.2f}")),
        ("Published inside", "l", lambda row: plain("yes" if row["inside"] else "no")),
    ]
    order = {method: place for place, method in enumerate(methods_of(frame))}
    ordered = frame.assign(place=frame["method"].map(order)).sort_values(["place", "guesses"], kind="stable")
    blocks: list[Block] = [
        (_name(own.iloc[0].to_dict()) + plain(f" ({own['experiments'].max()} experiments)"), own)
        for _, own in ordered.groupby(["place", "guesses"], sort=False)
    ]
    caption = (
        "Totals (%) over the simulated experiments that the printed numbers do not rule out, for each cell of Table "
        "10: median and central 95 % range, and whether the published total of Algorithm 1 (of least squares in its "
        "own block) is within the range."
    )
    return grid(caption, columns, blocks)


@_table("Cells of Table 10 over the accepted experiments", cells_layout)
def accepted_cells(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """Each cell of Table 10 over the experiments that the printed numbers do not rule out: median and range of each
    method within each budget of guesses, next to the published total.
    """
    cells = _cells(_scores(inputs))
    return cells[cells["unit"] == "all"].drop(columns="unit")


#: The method in the figure, and what a row of its numbers is of.
SEARCHED = "algorithm1"
EACH, MEDIAN, RUN, PRINTED = "experiment", "median", "run", "published"


def draw_guesses(frame: pd.DataFrame) -> Figure:
    """Distance to least squares against the number of guesses: a line for each experiment, and medians."""
    drawn, panels = style.new_panels(style.PAGE, 3.0, 1, 2)
    titles = {MEAN: f"Mean over {SPAN}", "ID": "ID, mean of both joints"}
    median_look = {**style.STROKES[SEARCHED], **style.MARKS[SEARCHED]}
    for axes, (case, title) in zip(panels, titles.items(), strict=True):
        own = dict(iter(frame[frame["case"] == case].groupby("of")))
        for kind, look, label in (
            (EACH, {"color": "0.7", "ls": "-"}, f"{style.SERIES_LABELS[SEARCHED]}, each experiment"),
            (RUN, {"color": "0.4", "ls": ":"}, f"one run, {own[RUN]['experiment'].nunique()} of them"),
        ):
            for place, (_, line) in enumerate(own[kind].groupby("experiment")):
                axes.plot(line["guesses"], 100.0 * line["above"], lw=0.7, label="" if place else label, **look)
        median = own[MEDIAN]
        label = f"median of {median['experiments'].max():.0f}"
        axes.plot(median["guesses"], 100.0 * median["above"], label=label, **median_look)
        axes.axhline(100.0 * own[PRINTED]["above"].iloc[0], label="Published (real arm)", color=style.INK, lw=1.6)
        axes.axhline(0.0, label="Least squares, same experiment", **style.STROKES["least-squares"])
        axes.set(title=title, xscale="log", xlabel="Guesses (number)")
        axes.set_ylim(top=0.1 * -axes.get_ylim()[0])
    panels[0].set_ylabel("Similarity minus that of\nleast squares (points)")
    return style.legend_above(drawn, panels[0], 3, style.SIMULATED)


def medians(above: pd.DataFrame) -> pd.DataFrame:
    """Rows of each experiment, and their medians, where every experiment has the budget."""
    size = above.groupby(["guesses", "case"])["above"].transform("size")
    whole: pd.DataFrame = above[size == size.max()]
    of_all = whole.groupby(["guesses", "case"])["above"].agg(above="median", experiments="size").reset_index()
    return pd.concat([whole.assign(of=EACH), of_all.assign(of=MEDIAN)], ignore_index=True)


@_figure("Algorithm 1 minus least squares by the number of guesses", draw_guesses)
def guesses(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """Similarity of Algorithm 1 minus that of least squares in the same experiment, against the number of guesses, on
    T1 to T4 and on ID. Thin lines: medians of five runs in each experiment that the printed numbers do not rule out.
    Their median is drawn up to the most guesses that all experiments have. Dotted: one run with more guesses in the
    experiments that fit the printed numbers best. Black: the difference that the paper prints, without the number of
    guesses. The vertical axes differ.
    """
    scores = _scores(inputs)
    each = medians(_above(scores))
    longest = scores[(scores["method"] == SEARCHED) & (scores["guesses"] == scores["guesses"].max())]
    runs = scores.merge(longest[["experiment", "seed"]].drop_duplicates())
    runs = runs[runs["guesses"] >= each["guesses"].max()]
    levels = scores[scores["method"] == "least-squares"]
    printed = [
        {"of": PRINTED, "case": case, "above": _published_mean(SEARCHED, case) - _published_mean("least-squares", case)}
        for case in ("ID", MEAN)
    ]
    return pd.concat([each, _above(pd.concat([runs, levels])).assign(of=RUN), pd.DataFrame(printed)], ignore_index=True)


def _published_mean(method: str, case: str) -> float:
    """Published total of both joints, or of `MEAN`."""
    return float(np.mean([_published(method, case, joint) for joint in ((1, 2) if case == "ID" else (0,))]))


def _above(scores: pd.DataFrame) -> pd.DataFrame:
    """How far Algorithm 1 is above least squares: mean of both joints on ID, and `MEAN`, of each experiment."""
    totals = by_experiment(scores[scores["method"].isin([SEARCHED, "least-squares"])])
    totals = totals[totals["case"].isin(["ID", MEAN])]
    cell = ["experiment", "case"]
    means = totals.groupby(["method", "guesses", *cell], sort=False)["total"].mean().reset_index()
    level = means[means["method"] == "least-squares"].set_index(cell)["total"].rename("level")
    own = means[means["method"] == SEARCHED].join(level, on=cell)
    return own.assign(above=own["total"] - own["level"])[[*cell, "guesses", "total", "above"]]
