"""Figures one by one: curves are the numbers given."""

import re
from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from render_examples import FIGURES, FRAMES, candidates_frame, case_panels, drawn, kernels_frame, long_table

from repro.exhibits import style


def test_pairs_that_meet_differ_in_greyscale() -> None:
    def lightness(name: str) -> float:
        return float(np.dot(to_rgb(style.STROKES[name]["color"]), (0.299, 0.587, 0.114)))

    for one, other in (("joint1", "joint2"), ("actual", "rebuilt"), ("train", "test"), ("median", "mean")):
        assert abs(lightness(one) - lightness(other)) > 0.2
        first, second = style.STROKES[one], style.STROKES[other]
        assert (first["linestyle"], first["linewidth"]) != (second["linestyle"], second["linewidth"])


def test_curves_are_the_numbers_given() -> None:
    frame = FRAMES["fig12"]().sample(frac=1.0, random_state=0).sort_values(["panel", "x"], kind="stable")
    with style.house_style():
        made = FIGURES["fig12"](frame)
    panels = dict(zip(case_panels("N1", "N2"), made.axes, strict=True))
    for (panel, name), rows in frame.groupby(["panel", "series"]):
        line = panels[panel].lines[("actual", "rebuilt").index(name)]
        np.testing.assert_array_equal(line.get_xdata(), rows["x"])
        np.testing.assert_array_equal(line.get_ydata(), rows["y"])


def test_spectrum_says_what_it_leaves_out() -> None:
    frame = FRAMES["fig14"]()
    with style.house_style():
        made = FIGURES["fig14"](frame)
    left_out = re.search(r"Not shown: ([\d.]+) to ([\d.]+) Hz", made.get_supxlabel())
    assert left_out is not None
    assert float(left_out[2]) == pytest.approx(frame["x"].max(), rel=1e-2)
    beyond = frame[frame["x"] > float(left_out[1]) * 1.01]
    largest = frame["y"].abs().groupby(frame["panel"]).max()
    assert (beyond["y"].abs() < 0.05 * beyond["panel"].map(largest)).all()
    with style.house_style():
        assert FIGURES["fig17"](FRAMES["fig17"]()).get_supxlabel() == ""


def test_kernels_stand_at_their_maps() -> None:
    frame = kernels_frame()
    with style.house_style():
        made = FIGURES["fig11"](frame)
    picture = made.axes[0].images[0]
    array, (left, right, bottom, top) = np.ma.getdata(picture.get_array()), picture.get_extent()
    one = frame.query("layer == 'conv1' and input == 1 and output == 7 and row == 4 and column == 4")["power"].item()
    row = int((7 - top) / (bottom - top) * array.shape[0])
    column = int((1 - left) / (right - left) * array.shape[1])
    assert array[row, column] == pytest.approx(one)


def test_a_chosen_candidate_is_shown_whatever_its_rank() -> None:
    with style.house_style():
        made = FIGURES["metric_search"](candidates_frame())
    names = [[tick.get_text() for tick in axes.get_yticklabels()] for axes in made.axes]
    assert [len(shown) for shown in names] == [12, 13]
    assert names[1][-1] == "frequency candidate 17"


@pytest.mark.slow
def test_long_lines_stay_light(tmp_path: Path) -> None:
    t = np.arange(3770) * 2.5e-3
    frame = long_table(case_panels("N1", "N2"), t, lambda i: np.sin(t + i))
    pdf, _ = drawn(tmp_path, "fig12", frame)
    assert len(pdf) < 60_000
