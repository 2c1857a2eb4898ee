"""Table 1 and Figures 1 to 4: what is drawn is what the words say, where boxes and arrows belong, with its source."""

import itertools
import re

import numpy as np
import pytest
from exhibit_examples import drawn, figure_numbers, made
from experiment_example import refused

from repro.exhibits.schematics import layout_of, words


def links(name):
    frame = figure_numbers(name)
    return frame[frame["element"] == "link"]


def reach(point, box, diamond=False):
    """Distance of a point from the middle of a box: 1 on its edge, less inside."""
    middle = np.array([box.left + box.width / 2, box.bottom + box.height / 2])
    far = np.abs(np.array(point) - middle) / (box.width / 2, box.height / 2)
    return float(far.sum() if diamond else far.max())


@pytest.mark.parametrize("name", ["fig02", "fig03", "fig04"])
def test_arrows_of_the_table_run_from_edge_to_edge_and_through_no_box(name):
    layout, ways = layout_of(name), links(name).set_index("name")
    assert set(ways.index) == set(layout["routes"])
    for key, route in layout["routes"].items():
        for corner, end in zip((route.corners[0], route.corners[-1]), ways.loc[key, ["start", "end"]], strict=True):
            box = layout["boxes"][end]
            assert reach(corner, box, box.shape == "decision") == pytest.approx(1.0, abs=0.02), route
        solid = [box for box in layout["boxes"].values() if box.shape != "frame"]
        for one, other in itertools.pairwise(route.corners):
            assert one[0] == other[0] or one[1] == other[1], route
            assert all(reach(point, box) > 0.97 for point in np.linspace(one, other, 101) for box in solid), route


def test_arm_shows_every_symbol_in_the_drawing_and_in_the_key():
    figure = made("fig01", figure_numbers("fig01"))
    words = [text.get_text() for text in figure.axes[0].texts]
    for symbol in figure_numbers("fig01")["symbol"]:
        name, index = re.fullmatch(r"([a-zA-Z]+?)(c?\d?)", symbol).groups()
        tex = rf"\${'.tau' if name == 'tau' else name}(_\{{{index}\}})?\s*\$"
        found = [word for word in words if re.search(tex, word)]
        assert len(found) == 2, symbol
    used = {"m1", "lc1", "J1", "m2", "l1", "lc2", "J2", "g", "b1", "b2", "k1", "k2"}  # by the last lines of Eq. 1
    assert used <= set(figure_numbers("fig01")["symbol"])


@pytest.mark.parametrize(
    ("torque", "visited"),
    [(5000, ["Upper limit"]), (1024, ["Upper limit"]), (1023, []), (-1023, []), (-1024, ["Lower limit"])],
)
def test_control_chart_saturates_and_comes_back_to_its_start(torque, visited):
    ways = links("fig03")
    answers = {"Upper check": torque > 1023, "Lower check": torque < -1023}
    place, path = "Sample i", []
    for _ in range(20):
        out = ways[ways["start"] == place]
        if place in answers:
            assert sorted(out["label"]) == ["no", "yes"]
            out = out[out["label"] == ("yes" if answers[place] else "no")]
        place = out["end"].iloc[0]
        path.append(place)
        if place == "Sample i":
            break
    assert path[-3:] == ["Output", "Keep", "Sample i"]
    assert [step for step in path if "limit" in step] == visited
    assert {"Position error", "Velocity difference"} == set(ways.loc[ways["end"] == "Torque", "start"])


def test_method_runs_through_its_nine_steps_and_back():
    ways = links("fig04")
    steps = [box for box in layout_of("fig04")["boxes"] if box[0].isdigit()]
    assert [step[0] for step in steps] == list("123456789")
    pairs = set(zip(ways["start"], ways["end"], strict=True))
    assert set(itertools.pairwise(steps)) <= pairs
    out = ways[ways["start"] == "8 Decision"].set_index("end")["label"]
    assert out["9 Adjustment"] == "yes" and out["1 Initialise"].startswith("no")
    assert {"2 Image", "6 Torque", "7 Similarity", "9 Adjustment"} == set(ways.loc[ways["start"] == "Signals", "end"])


def test_a_label_too_long_for_its_box_is_refused(tmp_path):
    frame = figure_numbers("fig02")
    frame.loc[9, "label"] = "word " * 40
    assert re.search(r"fig02\.csv.*lines of words", str(refused(drawn, tmp_path, "fig02", frame)))


def test_answers_follow_the_sentences_of_section_i_a():
    by_work = words("table01").set_index("reference")
    assert list(by_work.index) == [*(f"[{number}]" for number in range(11, 29)), "this article"]
    by_squares = {f"[{n}]" for n in (16, 18, 19, 20, 23, 24, 26, 27, 28)}
    assert set(by_work.index[by_work["optimisation"] == "yes"]) == by_squares
    assert by_squares >= set(by_work.index[by_work["method"].str.contains(r"\bW?LS\b")])
    assert list(by_work.index[by_work["optimisation"] == "no"]) == ["this article"]
    assert set(by_work.index[by_work["set_apart"] == "yes"]) == {"[14]", "[15]", "[18]", "[25]"}
    six = {f"[{n}]" for n in (13, 15, 16, 18, 19, 20, 21, 23, 24, 27, 28)}
    assert set(by_work.index[by_work["dof"] == "6"]) == six
    assert by_work.loc[["[12]", "[14]", "[22]", "this article"], "dof"].tolist() == ["2, 5", "1", "8", "2"]
    assert set(by_work.index[by_work["dof"] == "not stated"]) == {"[11]", "[17]", "[25]", "[26]"}
