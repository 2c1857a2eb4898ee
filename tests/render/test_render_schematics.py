"""Figures 1 to 4: what is drawn is what the table says, where boxes and arrows belong, with its source."""

import itertools
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from render_examples import FRAMES, drawn, made, refused, shown_texts, words_of

from repro.exhibits.diagram import Box, Layout
from repro.fpga.frames import FRAME_BYTES, RADIANS_PER_COUNT, SAMPLING_PERIOD

LAYOUTS = {name: Layout.read(name) for name in ("fig02", "fig03", "fig04")}
SCHEMATICS = ["fig01", *LAYOUTS]


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


def solid(layout: Layout) -> dict[str, Box]:
    return {name: box for name, box in layout.boxes.items() if box.shape != "frame"}


def links(name: str) -> pd.DataFrame:
    frame = FRAMES[name]()
    return frame[frame["element"] == "link"]


def test_arrows_run_from_edge_to_edge_and_through_no_box(name: str) -> None:
    layout = LAYOUTS[name]
    ways = links(name).set_index("name")
    for key, route in layout.routes.items():
        assert on_edge(route.corners[0], layout.boxes[ways["start"][key]]), route
        assert on_edge(route.corners[-1], layout.boxes[ways["end"][key]]), route
        for one, other in itertools.pairwise(route.corners):
            assert one[0] == other[0] or one[1] == other[1], route
            for part in np.linspace(0.0, 1.0, 101):
                point = (1 - part) * np.array(one) + part * np.array(other)
                assert not any(inside(point, box, 0.01) for box in solid(layout).values()), route


def test_boxes_stand_apart_and_within_the_figure(name: str) -> None:
    layout = LAYOUTS[name]
    for box in layout.boxes.values():
        assert min(box.left, box.bottom) > 0.03
        assert box.left + box.width < layout.size[0] - 0.03
        assert box.bottom + box.height < layout.size[1] - 0.03
    for one, other in itertools.combinations(solid(layout).values(), 2):
        apart = max(
            one.left - other.left - other.width,
            other.left - one.left - one.width,
            one.bottom - other.bottom - other.height,
            other.bottom - one.bottom - one.height,
        )
        assert apart > 0.05, (one, other)


def test_what_the_table_names_is_what_the_layout_places(name: str) -> None:
    frame, layout = FRAMES[name](), LAYOUTS[name]
    assert set(frame.loc[frame["element"] == "box", "name"]) == set(layout.boxes)
    assert list(links(name)["name"].sort_values()) == sorted(layout.routes)


@pytest.mark.slow
def test_words_stay_within_their_box(name: str) -> None:
    figure = made(name, FRAMES[name]())
    FigureCanvasAgg(figure).draw()
    to_inches = figure.dpi_scale_trans.inverted()
    boxes = solid(LAYOUTS[name])
    held = set()
    for text, extent in shown_texts(figure):
        corners = to_inches.transform(extent.corners())
        centre = corners.mean(axis=0)
        for key, box in boxes.items():
            if not inside(centre, box, 0.0):
                continue
            held.add(key)
            assert all(inside(corner, box, 0.015) for corner in corners), text.get_text()
            if box.shape == "decision":
                middle = np.array([box.left + box.width / 2, box.bottom + box.height / 2])
                far = np.abs(corners - middle) / (box.width / 2, box.height / 2)
                assert far.sum(axis=1).max() < 1.0, text.get_text()
    assert held == boxes.keys()


@pytest.mark.slow
def test_no_label_of_an_arrow_lies_on_a_line(name: str) -> None:
    layout = LAYOUTS[name]
    figure = made(name, FRAMES[name]())
    FigureCanvasAgg(figure).draw()
    to_inches = figure.dpi_scale_trans.inverted()
    points = [
        (1 - part) * np.array(one) + part * np.array(other)
        for route in layout.routes.values()
        for one, other in itertools.pairwise(route.corners)
        for part in np.linspace(0.0, 1.0, 201)
    ]
    for text, extent in shown_texts(figure):
        (left, bottom), (right, top) = to_inches.transform(extent.get_points())
        held = Box(left, bottom, right - left, top - bottom)
        assert not any(inside(point, held, 0.004) for point in points), text.get_text()


@pytest.mark.slow
def test_what_is_only_inferred_looks_different(name: str) -> None:
    frame = FRAMES[name]()
    bases = ("stated", "inferred")
    assert set(frame["basis"]) <= set(bases)
    stated, inferred = (made(name, frame.assign(basis=basis)) for basis in bases)
    count = len(LAYOUTS[name].routes)
    styles = [[line.get_linestyle() for line in figure.axes[0].lines[:count]] for figure in (stated, inferred)]
    assert "-" in styles[0]
    assert "-" not in styles[1]
    slanted = [t for t in inferred.axes[0].texts if t.get_style() == "italic"]
    assert len(slanted) > 10
    assert not [t for t in stated.axes[0].texts if t.get_style() == "italic"]


@pytest.mark.parametrize("which", SCHEMATICS)
def test_every_row_names_its_place_in_the_paper(which: str) -> None:
    frame = FRAMES[which]()
    place = (
        r"(Section (II|III|IV)(, sentences? \d+(, \d+)*|, Eq\. 1.*)|Eq\. \d|caption of Fig\. 3|Algorithm 1, lines? .*)"
    )
    assert frame["source"].str.match(place).all(), frame["source"][~frame["source"].str.match(place)]


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


@pytest.mark.slow
def test_hardware_has_the_blocks_buses_and_figures_of_the_text(tmp_path: Path) -> None:
    frame = FRAMES["fig02"]()
    blocks = set(frame.loc[frame["element"] == "box", "name"])
    stated = (
        "Write Ram",
        "Ram-FPGA",
        "Read Ram",
        "Aq time",
        "Decoder",
        "PWM gen",
        "Fp ops",
        "PD",
        "H bridge",
        "Aq uart",
    )
    assert blocks == {*stated, "FPGA", "PC", "Motors", "Encoders"}
    words = words_of(drawn(tmp_path, "fig02", frame)[0]).replace(" ", "")
    for word in ("ctrlv", "tryd", "bst", "tau", "32-bit", "64-bit", "16bit", "11bit", "2.5ms", "100MHz", "400Hz"):
        assert word in words
    for word in ("6683of22320", "29.94%", "87%", "EP4CE22F17C6", "131.25", "UART"):
        assert word in words
    assert round(6683 / 22320, 4) == 0.2994
    assert 8 + 2 * 16 + 2 * 11 <= 8 * FRAME_BYTES == 64
    assert round(1e3 * RADIANS_PER_COUNT, 3) == 0.748
    assert round(1 / SAMPLING_PERIOD) == 400


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
    steps = [box for box in LAYOUTS["fig04"].boxes if box[0].isdigit()]
    assert [step[0] for step in steps] == list("123456789")
    pairs = set(zip(ways["start"], ways["end"], strict=True))
    assert set(itertools.pairwise(steps)) <= pairs
    out = ways[ways["start"] == "8 Decision"].set_index("end")["label"]
    assert out["9 Adjustment"] == "yes"
    assert out["1 Initialise"].startswith("no")
    assert {"2 Image", "6 Torque", "7 Similarity", "9 Adjustment"} == set(ways.loc[ways["start"] == "Signals", "end"])


def change(row: int, column: str, value: str) -> Callable[[pd.DataFrame], pd.DataFrame]:
    def changed(frame: pd.DataFrame) -> pd.DataFrame:
        frame = frame.copy()
        frame.loc[row if row >= 0 else len(frame) + row, column] = value
        return frame

    return changed


def test_a_label_too_long_for_its_box_is_refused(tmp_path: Path) -> None:
    frame = change(9, "label", "word " * 40)(FRAMES["fig02"]())
    assert "lines of words" in refused(drawn, tmp_path, "fig02", frame)


def test_a_dollar_in_a_label_stays_a_dollar() -> None:
    frame = change(1, "label", "5 $ and `tau_j`$")(FRAMES["fig03"]())
    figure = made("fig03", frame)
    FigureCanvasAgg(figure).draw()
    assert any(text.get_text().startswith(r"5 \$ and $\tau") for text in figure.axes[0].texts)
