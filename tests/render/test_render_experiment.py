"""Figures and tables of the simulated experiment: the numbers given, called simulated, and told apart."""

import itertools
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from render_examples import (
    FRAMES,
    MOTIONS,
    RIVALS,
    TABLES,
    control_frame,
    laid_out,
    made,
    similarity_frame,
)

from repro.exhibits import style
from repro.identification.method import TABLE_METHODS

LAYOUTS = ("table08", "table09", "table10", "stability", "verdict")
COMPARED = ("fig19", "fig20", "fig23", "fig24")


def curve_of(frame: pd.DataFrame, panel: str, series: str) -> np.ndarray:
    return frame[(frame["panel"] == panel) & (frame["series"] == series)][["x", "y"]].to_numpy()


def line_named(figure: Figure, title: str, label: str) -> np.ndarray:
    axes = next(axes for axes in figure.axes if title in (axes.get_title(loc="left"), axes.get_ylabel()))
    return next(line.get_xydata() for line in axes.lines if line.get_label() == label)


@pytest.mark.parametrize("name", LAYOUTS)
def test_tables_say_that_they_are_simulated(name: str, tmp_path: Path) -> None:
    tex, md = laid_out(tmp_path, name, TABLES[name]())
    caption = re.search(r"\\caption\{(.*)\}", tex)
    assert caption is not None
    assert "simulated" in caption[1]
    assert "simulated" in md.splitlines()[0]


@pytest.mark.slow
def test_methods_look_the_same_everywhere_and_are_told_apart() -> None:
    assert tuple(style.METHODS) == TABLE_METHODS
    assert style.STROKES.keys() == style.SERIES_LABELS.keys()
    assert set(style.METHODS) <= style.MARKS.keys()
    figures = {name: made(name, FRAMES[name]()) for name in (*COMPARED, "spread")}
    for name, figure in figures.items():
        for axes, method in itertools.product(figure.axes, RIVALS):
            for line in axes.lines:
                if line.get_label() == style.SERIES_LABELS[method]:
                    assert line.get_color() == style.STROKES[method]["color"], name
    grey = {name: np.dot(to_rgb(style.STROKES[name]["color"]), (0.299, 0.587, 0.114)) for name in ("measured", *RIVALS)}
    for one, other in itertools.combinations(grey, 2):
        assert abs(grey[one] - grey[other]) > 0.15, (one, other)
        assert style.STROKES[one]["linestyle"] != style.STROKES[other]["linestyle"] or "measured" in (one, other)
    looks = {(s["color"], str(s["linestyle"])) for s in (style.STROKES[method] for method in style.METHODS)}
    assert len(looks) == len(style.METHODS)
    marks = {(m["marker"], m.get("fillstyle")) for m in (style.MARKS[method] for method in style.METHODS)}
    assert len(marks) == len(style.METHODS)


@pytest.mark.slow
@pytest.mark.parametrize("name", COMPARED)
@pytest.mark.parametrize("chosen", [("true",), ("least-squares", "algorithm1"), style.METHODS])
def test_any_methods_are_compared_in_one_order(name: str, chosen: tuple[str, ...]) -> None:
    frame = FRAMES[name]()
    measured = frame[frame["series"] == "measured"]
    others = frame[~frame["series"].isin(("measured", *RIVALS))]
    frame = pd.concat([*(measured.assign(series=method) for method in chosen), measured, others])
    figure = made(name, frame)
    legend = (*figure.legends, *(legend for part in figure.subfigs for legend in part.legends))[0]
    expected = ["Measured", *(style.SERIES_LABELS[method] for method in style.METHODS if method in chosen)]
    assert [text.get_text() for text in legend.get_texts()] == expected


def test_the_legend_of_all_methods_is_whole() -> None:
    measured = FRAMES["fig20"]().query("series == 'measured'")
    figure = made("fig20", pd.concat([measured.assign(series=name) for name in ("measured", *style.METHODS)]))
    whole = figure.get_tightbbox()
    assert whole.x0 > -0.01
    assert whole.x1 < style.PAGE + 0.01


def test_curves_are_the_numbers_given() -> None:
    frame = FRAMES["fig19"]()
    figure = made("fig19", frame)
    np.testing.assert_array_equal(
        line_named(figure, "Joint 2", "Least squares"), curve_of(frame, "torque2", "least-squares")
    )
    np.testing.assert_array_equal(
        line_named(figure, "Position (rad)", "Desired, joint 2"), curve_of(frame, "position", "desired2")
    )
    frame = FRAMES["fig23"]()
    figure = made("fig23", frame)
    for case, joint, method in itertools.product(MOTIONS, (1, 2), RIVALS):
        line = line_named(figure, f"{case}, joint {joint}", style.SERIES_LABELS[method])
        np.testing.assert_array_equal(line, curve_of(frame, f"{case} torque{joint}", method))
    frame = FRAMES["fig22"]()
    figure = made("fig22", frame)
    for (row, panel), (column, case) in itertools.product(
        enumerate(("position", "velocity", "acceleration")), enumerate(MOTIONS)
    ):
        lines = {line.get_label(): line.get_xydata() for line in figure.axes[4 * row + column].lines}
        assert len(lines) == (4 if row == 0 else 2)
        np.testing.assert_array_equal(lines["Joint 1"], curve_of(frame, f"{case} {panel}", "joint1"))


def test_paths_keep_their_shape() -> None:
    frame = FRAMES["fig21"]()
    figure = made("fig21", frame)
    assert [axes.get_title(loc="left") for axes in figure.axes] == list(MOTIONS)
    for axes in figure.axes:
        assert axes.get_aspect() == 1.0
        np.testing.assert_array_equal(
            axes.lines[1].get_xydata(), curve_of(frame, axes.get_title(loc="left"), "desired")
        )


def test_each_motion_has_its_own_band_and_nothing_large_is_left_out() -> None:
    frame = FRAMES["fig24"]()
    slow = frame["panel"].str.startswith("T2")
    frame.loc[slow, "y"] *= np.exp(-frame.loc[slow, "x"] * 4)
    figure = made("fig24", frame)
    assert "Not shown: from the end of each row to 10.6 Hz" in figure.get_supxlabel()
    ends = {axes.get_title(loc="left"): axes.lines[0].get_xdata()[-1] for axes in figure.axes}
    assert ends["T2, joint 1"] == ends["T2, joint 2"] < 0.5 * ends["T1, joint 1"]
    for (panel,), rows in frame.groupby(["panel"]):
        case, joint = panel.split(" torque")
        beyond = rows[rows["x"] > ends[f"{case}, joint {joint}"]]
        assert (beyond["y"].abs() < 0.05 * rows["y"].abs().max()).all()


@pytest.mark.slow
def test_spread_shows_every_run_its_median_and_what_was_published() -> None:
    frame = FRAMES["spread"]()
    figure = made("spread", frame)
    for axes, (joint, case) in zip(figure.axes, itertools.product((1, 2), ("ID", *MOTIONS)), strict=True):
        assert axes.get_title(loc="left") == f"{case}, joint {joint}"
        rows = frame[(frame["case"] == case) & (frame["joint"] == joint)]
        runs = rows[rows["seed"].notna()]
        shown = sorted(y for line in axes.lines if line.get_linestyle() == "None" for y in line.get_ydata())
        np.testing.assert_allclose(shown, sorted(100 * runs["total"]))
        bars = sorted(bar.get_segments()[0][0][1] for bar in axes.collections)
        np.testing.assert_allclose(bars, sorted(100 * runs.groupby(["method", "duration"])["total"].median()))
        published = [line.get_ydata()[0] for line in axes.lines if "published" in str(line.get_label())]
        assert published == [93.0, 93.0]
    alone = frame[frame["seed"].notna()]
    assert not any("published" in text.get_text() for text in made("spread", alone).legends[0].get_texts())


def test_control_table(tmp_path: Path) -> None:
    tex, md = laid_out(tmp_path, "table08", control_frame())
    assert r"$q_{2}$ & $96.99 \pm 0.42$ & $30.6819$ & $102.2730$ & $1$ & $1 \times 10^{-4}$ \\" in tex
    assert "| q₁ | 97.00 ± 0.42 | 180.4817 | 1270.7266 | 1 | 1\N{MULTIPLICATION SIGN}10⁻⁴ |" in md
    assert "±" not in laid_out(tmp_path, "table08", control_frame(1))[1]


def test_arm_parameters_stand_beside_the_truth(tmp_path: Path) -> None:
    frame = TABLES["table09"]()
    _, md = laid_out(tmp_path, "table09", frame)
    heading = "| Parameter | True | Algorithm 1 | Algorithm 1 + refinement (extension) | Least squares |"
    assert heading in md
    for name, rows in frame.groupby("parameter"):
        by_method = rows.set_index("method")["estimate"]
        cells = [f"{rows['true'].iloc[0]:.4f}"]
        cells += [f"{by_method[m]:.4f} ± 0.0030" for m in ("algorithm1", "algorithm1+refinement", "least-squares")]
        line = next(line for line in md.splitlines() if line.startswith(f"| {name[0]}{'₀₁₂₃'[int(name[1])]} "))
        assert line.endswith("| " + " | ".join(cells) + " |")


def test_table_9_shows_what_fits_a_page_and_says_what_it_left_out(tmp_path):
    frame = TABLES["table09"]()
    more = frame[frame["method"] == "algorithm1"].assign(method="algorithm1+paper-recipe")
    _, md = laid_out(tmp_path, "table09", pd.concat([frame, more], ignore_index=True))
    assert "1 further methods are in the CSV" in md
    assert "own training" not in md


def test_similarities_of_the_experiment(tmp_path: Path) -> None:
    frame = similarity_frame(5, ("ID", *MOTIONS), tuple(reversed(RIVALS)))
    _, md = laid_out(tmp_path, "table10", frame)
    assert "| metr2ev (%) | ID | T1 | T2 | T3 | T4 |" in md
    headings = re.findall(r"^\| \*\*(.*?)\*\*", md, flags=re.MULTILINE)
    assert headings == ["Algorithm 1", "Algorithm 1 + refinement (extension)", "Least squares", "True parameters"]
    first = frame[(frame["method"] == "algorithm1") & (frame["joint"] == 2)].set_index("case")["frequency"]
    assert "| Freq. τ₂ | " + " | ".join(f"{100 * first[case]:.2f}" for case in ("ID", *MOTIONS)) + " |" in md


def test_stability_and_verdict_tables(tmp_path: Path) -> None:
    tex, md = laid_out(tmp_path, "stability", TABLES["stability"]())
    assert r"Condition 0 & $\rho \,\lambda _{Q}^{\min}$ & $7.2000 \times 10^{-3}$ & $0$ & yes \\" in tex
    assert "7.1236\N{MULTIPLICATION SIGN}10⁻⁸ | 1.3659\N{MULTIPLICATION SIGN}10⁻⁷ | no |" in md
    frame = TABLES["verdict"]()
    _, md = laid_out(tmp_path, "verdict", frame)
    assert "| Algorithm 1 | 9.42 s | 9 | -2.00 | -3.12 to -1.00 | 0.046 | worse |" in md.replace("\N{MINUS SIGN}", "-")
    headings = re.findall(r"^\| \*\*(.*?)\*\*", md, flags=re.MULTILINE)
    assert headings[:2] == [
        "Against: Least squares (14 arms, all)",
        "Against: Least squares (11 arms, without chatter)",
    ]
    assert headings[2].startswith("Against: Least squares, no parameter below zero")
    both = pd.concat([frame.assign(method=method) for method in ("algorithm1+refinement", "algorithm1")])
    _, md = laid_out(tmp_path, "verdict", both)
    assert len(re.findall(r"^\| Algorithm 1 \+ refinement", md, flags=re.MULTILINE)) == 8
