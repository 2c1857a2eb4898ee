"""Tables and figures of the causes: cells and marks are the numbers given, in points of per cent."""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from factorial_example import MAIN, PAIRS, READER, READER_PAIRS
from matplotlib.figure import Figure
from render_examples import FIGURES, FRAMES, TABLES, laid_out

from repro.exhibits import style
from repro.exhibits.causes import FACTORS

pytestmark = pytest.mark.slow


def made(name: str, frame: pd.DataFrame) -> Figure:
    with style.house_style():
        return FIGURES[name](frame)


def cells_of(md: str, start: str) -> list[str]:
    """Cells of the first row of a table that starts with some text."""
    line = next(line for line in md.splitlines() if line.startswith(f"| {start} |"))
    return [cell.strip() for cell in line.removeprefix("|").removesuffix("|").split("|")][1:]


def test_the_2_x_2_shows_cells_and_effects_with_their_spread(tmp_path: Path) -> None:
    frame = pd.DataFrame(
        [
            ("cell", "ideal", "measured", "id", 0.6512, 0.0213, 5),
            ("cell", "ideal", "measured", "validation", 0.4, 0.0, 5),
            ("cell", "ideal", "desired", "id", 0.92, 0.01, 5),
            ("cell", "ideal", "desired", "validation", 0.5, 0.01, 5),
            ("cell", "tracked", "measured", "id", 0.61, 0.01, 5),
            ("cell", "tracked", "measured", "validation", 0.45, 0.01, 5),
            ("cell", "tracked", "desired", "id", 0.96, 0.01, 5),
            ("cell", "tracked", "desired", "validation", 0.85, 0.01, 5),
            ("effect", "image_motion", "", "id", 0.31, 0.07, 5),
            ("effect", "image_motion", "", "validation", 0.25, 0.01, 5),
            ("effect", "training", "", "id", -0.004, 0.07, 5),
            ("effect", "training", "", "validation", 0.2, 0.01, 5),
            ("effect", "both", "", "id", 0.04, 0.07, 5),
            ("effect", "both", "", "validation", 0.15, 0.01, 5),
        ],
        columns=["row", "training", "image_motion", "response", "value", "spread", "seeds"],
    )
    tex, md = laid_out(tmp_path, "why", frame)
    assert "| Eq. 10 | measured | 65.1 ± 2.1 | 40.0 ± 0.0 |" in md
    assert "| closed-loop motions | desired | 96.0 ± 1.0 | 85.0 ± 1.0 |" in md
    assert r"$65.1 \pm 2.1$" in tex
    effects = {
        "desired instead of measured motion in line 18": ("31.0 ± 7.0", "25.0 ± 1.0"),
        "closed-loop motions instead of Eq. 10 in training": ("-0.4 ± 7.0", "20.0 ± 1.0"),
        "interaction (half the difference of the differences)": ("4.0 ± 7.0", "15.0 ± 1.0"),
    }
    for words, (on_id, others) in effects.items():
        assert cells_of(md, words)[-2:] == [on_id, others]
    assert "5 seeds" in md


def test_the_2_x_2_figure_shows_every_seed_and_a_line_through_the_means() -> None:
    frame = FRAMES["why"]()
    figure = made("why", frame)
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["ID", "T1 to T4"]
    for axes, response in zip(figure.axes, ("id", "validation"), strict=True):
        rows = frame[frame["response"] == response]
        shown = sorted(y for line in axes.lines if line.get_linestyle() == "None" for y in line.get_ydata())
        np.testing.assert_allclose(shown, sorted(100 * rows["value"]))
        lines = {line.get_label(): line.get_ydata() for line in axes.lines if line.get_linestyle() != "None"}
        for training, label in (("ideal", "trained on Eq. 10"), ("tracked", "trained on closed-loop motions")):
            means = rows[rows["training"] == training].groupby("image_motion")["value"].mean()
            np.testing.assert_allclose(lines[label], 100 * means[["measured", "desired"]])


def test_the_effects_are_in_order_of_size_with_their_intervals(tmp_path: Path) -> None:
    tex, md = laid_out(tmp_path, "factorial", TABLES["factorial"]())
    blocks = re.split(r"^\| \*\*.*$", md, flags=re.MULTILINE)
    of_cnn = [line.split(" | ")[0].removeprefix("| ") for line in blocks[1].splitlines() if line.startswith("|")]
    known = {name: size - READER_PAIRS.get(name, 0.0) for name, size in MAIN.items()}
    known |= {" x ".join(pair): size for pair, size in PAIRS.items()}
    by_size = sorted(known, key=lambda name: -abs(known[name]))
    words = [" x ".join(FACTORS[part] for part in name.split(" x ")) for name in by_size]
    assert of_cnn[: len(words)] == words
    assert len(of_cnn) == 5 + 10
    cells = cells_of(md, "f on the desired motion")
    assert cells == ["20.0 [20.0, 20.0]", "40.0 [40.0, 40.0]", "-0.200 [-0.200, -0.200]", "40.0", "80.0"]
    assert cells_of(md, "energy ratio")[2] == ""  # an estimate does not depend on the metric
    assert cells_of(md, "plain network")[0] == f"{100 * READER:.1f} [{100 * READER:.1f}, {100 * READER:.1f}]"
    assert "3 blocks and 2 training seeds" in md
    assert "3 blocks and 2 training seeds" in tex


def test_an_interval_is_written_from_low_to_high(tmp_path: Path) -> None:
    frame = TABLES["factorial"]()
    shown = (frame["of"] == "cnn") & (frame["effect"] == "omega") & (frame["response"] == "id")
    frame.loc[shown, ["value", "low", "high"]] = [-0.0402, -0.1238, 0.0434]
    _, md = laid_out(tmp_path, "factorial", frame)
    assert cells_of(md, "omega as DCT index")[0] == "-4.0 [-12.4, 4.3]"


def test_cells_are_written_in_words(tmp_path: Path) -> None:
    columns = ["reader", "image_motion", "training", "omega", "back_emf", "metric", "id", "validation", "error", "met"]
    rows = [
        ("cnn", "desired", "tracked", "rad_per_s", 0.34, "mean-square", 0.9876, 0.8, 0.1234, 37.5),
        ("true", "", "", "index", 0.0, "energy", 0.95, 0.94, None, None),
    ]
    _, md = laid_out(tmp_path, "factorial_cells", pd.DataFrame(rows, columns=columns))
    of_cnn = cells_of(md, "Algorithm 1")
    assert of_cnn == ["closed-loop", "desired", "rad/s", "0.34", "mean-square", "98.8", "80.0", "0.123", "37.5"]
    of_truth = cells_of(md, "true parameters")
    assert of_truth == ["", "", "index", "0.0", "energy", "95.0", "94.0", "", ""]


def test_the_figure_shows_effects_intervals_and_the_frozen_arm() -> None:
    frame = FRAMES["factorial"]()
    widen = frame["effect"] == "training"
    frame.loc[widen, "low"], frame.loc[widen, "high"] = frame["value"] - 0.01, frame["value"] + 0.03
    figure = made("factorial", frame)
    names = [text.get_text() for text in figure.axes[0].get_yticklabels()]
    assert names[0] == "f on the desired motion"
    for axes, response in zip(figure.axes, ("id", "validation"), strict=True):
        rows = frame[(frame["response"] == response) & frame["of"].isin(["cnn", "reader"])]
        marks = {line.get_label(): line.get_xydata() for line in axes.lines if line.get_linestyle() == "None"}
        assert set(marks) == {"3 blocks", "frozen arm"}
        for label, column in (("3 blocks", "value"), ("frozen arm", "confirmation")):
            np.testing.assert_allclose(marks[label][:, 0], 100 * rows[column], atol=1e-9)
            at = [names[round(y)] for y in marks[label][:, 1]]
            expected = [" x ".join(FACTORS[part] for part in effect.split(" x ")) for effect in rows["effect"]]
            assert at == expected
        (spans,) = axes.collections
        ends = np.array([segment[:, 0] for segment in spans.get_segments()])
        np.testing.assert_allclose(ends, 100 * rows[["low", "high"]], atol=1e-9)
