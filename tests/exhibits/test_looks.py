"""Methods and series differ in greyscale, and a figure names what it leaves out."""

import itertools
import re

import numpy as np
import pytest
from exhibit_examples import figure_numbers, made
from matplotlib.colors import to_rgb
from study_example import outcomes

from repro.drawing import style
from repro.identification.method import TABLE_METHODS
from repro_studies import analysis


def lightness(name):
    return float(np.dot(to_rgb(style.STROKES[name]["color"]), (0.299, 0.587, 0.114)))


def test_pairs_that_meet_differ_in_greyscale():
    for one, other in (("joint1", "joint2"), ("actual", "rebuilt"), ("train", "test"), ("median", "mean")):
        assert abs(lightness(one) - lightness(other)) > 0.2
        first, second = style.STROKES[one], style.STROKES[other]
        assert (first["linestyle"], first["linewidth"]) != (second["linestyle"], second["linewidth"])


def test_spectrum_says_what_it_leaves_out():
    frame = figure_numbers("fig14")
    left_out = re.search(r"Not shown: ([\d.]+) to ([\d.]+) Hz", made("fig14", frame).get_supxlabel())
    assert float(left_out[2]) == pytest.approx(frame["x"].max(), rel=1e-2)
    beyond = frame[frame["x"] > float(left_out[1]) * 1.01]
    largest = frame["y"].abs().groupby(frame["panel"]).max()
    assert (beyond["y"].abs() < 0.05 * beyond["panel"].map(largest)).all()
    assert made("fig14", frame.assign(y=1.0)).get_supxlabel() == ""


def test_methods_differ_in_lightness_line_and_mark():
    assert sorted(style.METHODS) == sorted(TABLE_METHODS)
    rivals = ("algorithm1", "algorithm1+refinement", "least-squares", "true")
    for one, other in itertools.combinations(("measured", *rivals), 2):
        assert abs(lightness(one) - lightness(other)) > 0.15, (one, other)
        assert style.STROKES[one]["linestyle"] != style.STROKES[other]["linestyle"] or "measured" in (one, other)
    looks = {(s["color"], str(s["linestyle"])) for s in (style.STROKES[method] for method in style.METHODS)}
    marks = {(m["marker"], m.get("fillstyle")) for m in (style.MARKS[method] for method in style.METHODS)}
    assert len(looks) == len(marks) == len(style.METHODS)


def test_rows_of_the_map_are_those_of_their_labels():
    whole = analysis.maps(outcomes({"wide": -0.07, "narrow": 0.03}))
    missing = (whole["method"] == "algorithm1") & (whole["prior"] == "wide") & (whole["excitation"] == "eq10")
    frame = whole[~missing][::-1]
    panels = made("study", frame).axes[:3]
    labels = [label.get_text() for label in panels[0].get_yticklabels()]
    assert labels == ["wide, Eq. 10", "wide, D-optimal", "narrow, Eq. 10", "narrow, D-optimal"]
    values = frame.set_index(["method", "opponent", "prior", "excitation", "discrepancy"])["difference"]
    pairs = (("algorithm1", "ordinary"), ("algorithm1+tracked", "consistent"), ("posterior", "consistent"))
    for panel, pair, number in zip(panels, pairs, (6, 8, 8), strict=True):
        assert len(panel.texts) == number
        for text in panel.texts:
            column, row = text.get_position()
            prior, motion = labels[int(row)].split(", ")
            level = float(panel.get_xticklabels()[int(column)].get_text()) / 100.0
            expected = values[(*pair, prior, {"Eq. 10": "eq10", "D-optimal": "optimal"}[motion], level)]
            assert text.get_text() == f"{100.0 * expected:.1f}"
    (first, *_) = made("study", frame.assign(sure=0)).axes[2].texts
    assert re.fullmatch(r"\(-?\d+\.\d\)", first.get_text())
    without_networks = made("study", whole[whole["method"] == "posterior"]).axes[:3]
    assert [len(panel.texts) for panel in without_networks] == [0, 0, 8]
