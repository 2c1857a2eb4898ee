"""Where a learned method pays: maps of differences over the conditions, claims of the paper, means, calibration."""

from collections.abc import Callable
from functools import partial

import numpy as np
import pandas as pd
from matplotlib.colors import SymLogNorm
from matplotlib.figure import Figure

from repro.config.model import Configuration
from repro.drawing import style
from repro.drawing.markup import Cell, Column, Table, digits, grid, layout, plain, words
from repro.drawing.panels import plot_deviation
from repro.exhibits.declare import Inputs, figure, table
from repro.exhibits.result_tables import percent_interval
from repro.experiments.monte_carlo import EQUIVALENT
from repro.files import read_csv
from repro_studies import analysis
from repro_studies.design import ALGORITHM1, FLOW, KEYS, POSTERIOR, RANKS, TRACKED, TRAINED_ON

_table, _figure = (
    partial(kind, category="Ablation", inputs=("study",), trained="all", optional=True) for kind in (table, figure)
)

#: Methods of the study in words.
TITLES = {
    ALGORITHM1: "Algorithm 1",
    TRACKED: "Algorithm 1, both extensions",
    POSTERIOR: "Amortised posterior",
    FLOW: "Amortised posterior, flow",
    "ordinary": "Least squares",
    "robust": "Least squares, robust",
    "bounded": "Least squares, bounded",
    "consistent": "Least squares, consistent",
    "generalised": "Least squares, generalised",
    "generalised+prior": "Least squares, generalised, with prior",
    "true": "True parameters",
}
#: Lines of methods that claim a distribution, as those of other figures.
_LOOKS = {
    ALGORITHM1: "algorithm1",
    TRACKED: "algorithm1+tracked",
    POSTERIOR: "algorithm1+refinement",
    FLOW: "differential-evolution",
    "ordinary": "least-squares",
    "generalised": "bounded",
    "generalised+prior": "consistent",
}
_MOTIONS = {"eq10": "Eq. 10", "slow": "Eq. 10, slow", "random": "random", "optimal": "D-optimal"}
#: Pairs of the map, and where its colours end, points.
_SHOWN = ((ALGORITHM1, "ordinary"), (TRACKED, "consistent"), (POSTERIOR, "consistent"))
_LIMIT, _DARK = 100.0, 15.0


def _outcomes(inputs: Inputs) -> pd.DataFrame:
    """Outcomes of all jobs."""
    columns = (*KEYS, "id", "validation", "torque_error", "parameter_error", "position_error", "contraction", "nearer")
    parts = [read_csv(path, (*columns, *RANKS)) for path in inputs["outcomes"]]
    return pd.concat(parts, ignore_index=True)


@_table(
    "Learned methods and least squares over many conditions",
    layout(
        "Means over the simulated arms and the conditions in which all methods were run: similarity (%) on the motion "
        "used for identification and on T1 to T4; relative torque error on T1 to T4 (%); root mean square error of the "
        "parameters over the largest torque; median error of position on T1, simulated again with the estimate (rad), "
        "of the runs whose estimate has a positive definite inertia matrix, which are others for each method; share of "
        "parameters in the claimed 95 % interval (%); median share of the prior's variance that the claim removes.",
        ("Method", "l", lambda row: plain(TITLES[row["method"]])),
        ("ID", "r", digits("id", 2, 100.0)),
        ("T1 to T4", "r", digits("validation", 2, 100.0)),
        ("Torque error", "r", digits("torque_error", 1, 100.0)),
        ("Parameter error", "r", digits("parameter_error", 4)),
        ("Position error", "r", digits("position_error", 4)),
        ("Covered", "r", digits("covered", 1, 100.0)),
        ("Contraction", "r", lambda row: plain("none") if row["contraction"] < 0 else digits("contraction", 2)(row)),
        blocks=lambda frame: [(plain(f"Prior: {name}"), own) for name, own in frame.groupby("prior", sort=False)],
    ),
)
def study_table(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """Similarity, errors, coverage and contraction of every method, averaged over the conditions of the study."""
    return analysis.means(_outcomes(inputs))


def _claims_layout(name: str, sentence: Cell) -> Callable[[pd.DataFrame], Table]:
    """A row for each sentence that may be true, with the difference that is positive if it is."""
    return layout(
        f"{name}s over the simulated arms of all conditions: difference of the mean totals on T1 to T4 in points, "
        f"positive if the {name.lower()} is true, with two 95 % intervals, each valid at once for all rows: over arms "
        "for these networks, and over arms and other trainings, from which the verdict follows. That something is as "
        f"good, or does not matter, holds if at most {100 * EQUIVALENT:g} points are lost. Last: in how many "
        "conditions the difference is surely positive for these networks.",
        (name, "l", sentence),
        ("Arms", "r", digits("arms", 0)),
        ("Difference", "r", digits("difference", 2, 100.0)),
        ("Over arms", "r", percent_interval),
        ("And trainings", "r", lambda row: percent_interval({"low": row["least"], "high": row["most"]})),
        ("Verdict", "l", words("verdict")),
        ("Conditions", "r", lambda row: plain(f"{row['better']:.0f} of {row['conditions']:.0f}")),
    )


@_table("Claims over many conditions", _claims_layout("Claim", words("sentence")))
def study_claims(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """Each claim of the paper over many simulated arms and conditions, with an interval and a verdict."""
    return analysis.claims(_outcomes(inputs))


@_table(
    "What was expected of the study",
    _claims_layout("Expectation", lambda row: plain(f"{row['claim']}. {row['sentence']}")),
)
def study_expectations(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """Each expectation that was written down before the study was run, with an interval and a verdict. The last one is
    about the share of parameters in intervals, in points.
    """
    return analysis.claims(_outcomes(inputs), analysis.EXPECTATIONS)


#: Factors in words.
_FACTORS = {
    "excitation": "Motion used for identification",
    "discrepancy": "Similarity of least squares on Eq. 10",
    "prior": "Prior",
    "friction": "Friction of the arms, times",
}


def levels_layout(frame: pd.DataFrame) -> Table:
    """A block for each factor with a row for each level, a column for each claim."""
    counts = zip(100.0 * frame["difference"], frame["better"], frame["worse"], frame["conditions"], strict=True)
    shown = [f"{mean:+.1f} ({true:.0f}/{false:.0f}/{of:.0f})" for mean, true, false, of in counts]
    wide = frame.assign(shown=shown, level=[_MOTIONS.get(level, str(level)) for level in frame["level"]])
    rows = wide.pivot(index=["factor", "level"], columns="claim", values="shown").fillna("").reset_index("level")
    names = list(dict.fromkeys(frame["claim"]))
    caption = (
        f"Where the claims are true that each condition can answer ({', '.join(names)}): mean difference in points, "
        "positive if the claim is true; in brackets the conditions in which it is surely positive, those in which it "
        "is surely negative, and all, by the level of each factor. Intervals hold at once in all conditions of a claim."
    )
    columns: list[Column] = [("Level", "l", words("level")), *((name, "r", words(name)) for name in names)]
    blocks = [(plain(title), rows.loc[[factor]]) for factor, title in _FACTORS.items()]
    return grid(caption, columns, blocks)


@_table("Where the claims are true", levels_layout)
def study_levels(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """Differences behind the claims by motion, discrepancy, prior and friction, with the number of conditions in which
    they are surely positive or negative.
    """
    return analysis.levels(_outcomes(inputs))


def draw_map(frame: pd.DataFrame) -> Figure:
    """One panel for each pair of methods: conditions by discrepancy, the colour is the difference."""
    figure, panels = style.new_panels(style.PAGE, 6.0, 1, len(_SHOWN), sharey=True)
    labels = {(prior, motion): f"{prior}, {name}" for prior in TRAINED_ON for motion, name in _MOTIONS.items()}
    order = [row for row in labels if row in set(zip(frame["prior"], frame["excitation"], strict=True))]
    levels = sorted(set(frame["discrepancy"]), reverse=True)
    for axes, (method, opponent) in zip(panels, _SHOWN, strict=True):
        own = frame[(frame["method"] == method) & (frame["opponent"] == opponent)]
        squares = own.drop_duplicates(["prior", "excitation", "discrepancy"])
        mean, sure, of = (
            squares.pivot(index=["prior", "excitation"], columns="discrepancy", values=name)
            .reindex(index=order, columns=levels)
            .to_numpy(dtype=np.float64)
            for name in ("mean", "sure", "of")
        )
        is_sure = sure == of
        image = axes.imshow(100.0 * mean, cmap="PuOr", norm=SymLogNorm(1.0, vmin=-_LIMIT, vmax=_LIMIT), aspect="auto")
        for (i, j), value in np.ndenumerate(100.0 * mean):
            if np.isfinite(value):
                colour = "white" if abs(value) > _DARK else "black"
                text = f"{value:z.1f}" if is_sure[i, j] else f"({value:z.1f})"
                axes.text(j, i, text, ha="center", va="center", color=colour)
        axes.set_xticks(range(len(levels)), labels=[f"{100 * level:g}" for level in levels])
        axes.set_yticks(range(len(order)), labels=[labels[row] for row in order])
        axes.set_title(f"{TITLES[method]}\nminus {TITLES[opponent].lower()}")
        axes.grid(visible=False)
        axes.patch.set(facecolor="0.92", hatch="////", edgecolor="0.75", lw=0.0)
    figure.supxlabel("Similarity of least squares on Eq. 10 (%)", fontsize=style.TEXT_SIZE)
    figure.supylabel("Condition (prior, motion used for identification)", fontsize=style.TEXT_SIZE)
    ticks = [sign * 10.0**power for sign in (-1, 1) for power in range(3)]
    label = f"Points on T1 to T4 ({style.SIMULATED.lower()})"
    figure.colorbar(image, ax=panels, label=label, ticks=[*ticks, 0.0], format="%g")
    return figure


@_figure("Where each method is better", draw_map)
def study_figure(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """Differences of the mean total on T1 to T4 between methods, by motion used for identification, prior and
    discrepancy, averaged over the levels of friction: orange is where the first method is worse, purple where it is
    better, on a scale that is linear within 1 point and logarithmic beyond. Hatched: not run. In brackets: in some of
    these conditions the interval contains zero. The prior is the range of arms that learned methods know; mismatched:
    another one than that of the tested arms. Slow is Eq. 10 at half its pace. The CSV has each condition with its
    interval, and the numbers of its square (mean, sure, of).
    """
    return analysis.maps(_outcomes(inputs))


def draw_calibration(frame: pd.DataFrame) -> Figure:
    """Distribution of the ranks minus a uniform one, a panel for each prior, a line for each method."""
    figure = style.new_figure(style.PAGE, 3.6)
    priors = list(dict.fromkeys(frame["prior"]))
    panels = figure.subplots(2, len(priors), sharex=True, sharey=True, squeeze=False)
    for column, prior in enumerate(priors):
        for axes, what in zip(panels[:, column], ("each", "together"), strict=True):
            chosen = frame[(frame["prior"] == prior) & (frame["of"] == what)]
            half = 100.0 * float(chosen["band"].max())
            axes.axhspan(-half, half, color=style.FILL_LIGHT, lw=0.0, zorder=0.0)
            for method, own in chosen.groupby("method", sort=False):
                plot_deviation(axes, own["level"], own["share"], _LOOKS[str(method)], TITLES[str(method)])
        panels[0, column].set_title(prior)
    panels[0, 0].set_ylabel("Each parameter (points)")
    panels[1, 0].set_ylabel("All nine (points)")
    figure.supylabel("Share minus level (points)", fontsize=style.TEXT_SIZE)
    figure.supxlabel("Level (%)", fontsize=style.TEXT_SIZE)
    return style.legend_above(figure, panels[0, 0], 3, style.SIMULATED)


@_figure("Are the claimed distributions right", draw_calibration)
def study_calibration(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """Simulation-based calibration. Above: distribution of the probability that a claimed distribution gives to values
    below each true parameter, minus a uniform one. Below: the same of the share of its draws that are nearer to a
    random point than the truth is (TARP). A right claim stays in the band with 95 %.
    """
    return analysis.calibration(_outcomes(inputs))
