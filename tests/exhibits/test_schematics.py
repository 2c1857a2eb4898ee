"""Table 1 and Figures 1 to 4: what is drawn is what the words say, where boxes and arrows belong, with its source."""

import itertools
import re
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from exhibit_examples import FRAMES, drawn, made, refused

from repro.exhibits.schematics import Box, layout_of, words

LAYOUTS = {name: layout_of(name) for name in ("fig02", "fig03", "fig04")}


@pytest.fixture(params=list(LAYOUTS))
def name(request: pytest.FixtureRequest) -> str:
    return request.param


def on_edge(point: tuple[float, float], box: Box) -> bool:
    x, y = point[0] - box.left - box.width / 2, point[1] - box.bottom - box.height / 2
    across, up = abs(x) / (box.width / 2), abs(y) / (box.height / 2)
    far = across + up if box.shape == "decision" else max(across, up)
    return bool(np.isclose(far, 1.0, atol=0.02))


def inside(point: np.ndarray, box: Box, margin: float) -> bool:
    low, high = np.array([box.left, box.bottom]), np.array([box.left + box.width, box.bottom + box.height])
    return bool((point > low + margin).all() and (point < high - margin).all())


def solid(layout: dict[str, Any]) -> dict[str, Box]:
    return {name: box for name, box in layout["boxes"].items() if box.shape != "frame"}


def links(name: str) -> pd.DataFrame:
    frame = FRAMES[name]()
    return frame[frame["element"] == "link"]


def test_arrows_run_from_edge_to_edge_and_through_no_box(name: str) -> None:
    layout = LAYOUTS[name]
    ways = links(name).set_index("name")
    for key, route in layout["routes"].items():
        assert on_edge(route.corners[0], layout["boxes"][ways["start"][key]]), route
        assert on_edge(route.corners[-1], layout["boxes"][ways["end"][key]]), route
        for one, other in itertools.pairwise(route.corners):
            assert one[0] == other[0] or one[1] == other[1], route
            for part in np.linspace(0.0, 1.0, 101):
                point = (1 - part) * np.array(one) + part * np.array(other)
                assert not any(inside(point, box, 0.01) for box in solid(layout).values()), route


def test_what_the_table_names_is_what_the_layout_places(name: str) -> None:
    frame, layout = FRAMES[name](), LAYOUTS[name]
    assert set(frame.loc[frame["element"] == "box", "name"]) == set(layout["boxes"])
    assert list(links(name)["name"].sort_values()) == sorted(layout["routes"])


def test_arm_shows_every_symbol_in_the_drawing_and_in_the_key() -> None:
    figure = made("fig01", FRAMES["fig01"]())
    words = [text.get_text() for text in figure.axes[0].texts]
    for symbol in FRAMES["fig01"]()["symbol"]:
        name, index = re.fullmatch(r"([a-zA-Z]+?)(c?\d?)", symbol).groups()
        tex = rf"\${'.tau' if name == 'tau' else name}(_\{{{index}\}})?\s*\$"
        found = [word for word in words if re.search(tex, word)]
        assert len(found) == 2, symbol
    used = {"m1", "lc1", "J1", "m2", "l1", "lc2", "J2", "g", "b1", "b2", "k1", "k2"}  # by the last lines of Eq. 1
    assert used <= set(FRAMES["fig01"]()["symbol"])


@pytest.mark.parametrize(
    ("torque", "visited"),
    [(5000, ["Upper limit"]), (1024, ["Upper limit"]), (1023, []), (-1023, []), (-1024, ["Lower limit"])],
)
def test_control_chart_saturates_and_comes_back_to_its_start(torque: int, visited: list[str]) -> None:
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


def test_method_runs_through_its_nine_steps_and_back() -> None:
    ways = links("fig04")
    steps = [box for box in LAYOUTS["fig04"]["boxes"] if box[0].isdigit()]
    assert [step[0] for step in steps] == list("123456789")
    pairs = set(zip(ways["start"], ways["end"], strict=True))
    assert set(itertools.pairwise(steps)) <= pairs
    out = ways[ways["start"] == "8 Decision"].set_index("end")["label"]
    assert out["9 Adjustment"] == "yes"
    assert out["1 Initialise"].startswith("no")
    assert {"2 Image", "6 Torque", "7 Similarity", "9 Adjustment"} == set(ways.loc[ways["start"] == "Signals", "end"])


def test_a_label_too_long_for_its_box_is_refused(tmp_path: Path) -> None:
    frame = FRAMES["fig02"]()
    frame.loc[9, "label"] = "word " * 40
    assert "lines of words" in refused(drawn, tmp_path, "fig02", frame)


def test_answers_follow_the_sentences_of_section_i_a() -> None:
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
