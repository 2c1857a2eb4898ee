"""Methods and series: told apart in greyscale, and what a figure leaves out is named."""

import itertools
import re

import numpy as np
import pytest
from exhibit_examples import FIGURES, FRAMES, RIVALS, candidates_frame, made
from matplotlib.colors import to_rgb

from repro.exhibits import style
from repro.identification.method import TABLE_METHODS


def test_pairs_that_meet_differ_in_greyscale() -> None:
    def lightness(name: str) -> float:
        return float(np.dot(to_rgb(style.STROKES[name]["color"]), (0.299, 0.587, 0.114)))

    for one, other in (("joint1", "joint2"), ("actual", "rebuilt"), ("train", "test"), ("median", "mean")):
        assert abs(lightness(one) - lightness(other)) > 0.2
        first, second = style.STROKES[one], style.STROKES[other]
        assert (first["linestyle"], first["linewidth"]) != (second["linestyle"], second["linewidth"])


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


def test_a_chosen_candidate_is_shown_whatever_its_rank() -> None:
    with style.house_style():
        made = FIGURES["metric_search"](candidates_frame())
    names = [[tick.get_text() for tick in axes.get_yticklabels()] for axes in made.axes]
    assert [len(shown) for shown in names] == [12, 13]
    assert names[1][-1] == "frequency candidate 17"


COMPARED = ("fig19", "fig20", "fig23", "fig24")


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
