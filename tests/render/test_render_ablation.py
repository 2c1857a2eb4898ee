"""Readings of the paper: the numbers given, beside the default's, and what lies far below them written out."""

from pathlib import Path

import numpy as np
import pytest
from render_examples import FRAMES, TABLES, laid_out, made

SHOWN = {
    "id_mean": "Identification trajectory",
    "validation_mean": "Validation trajectory",
    "arm_id": "ID",
    "arm_validation": "Mean over T1 to T4",
    "arm_refined": "Algorithm 1 + refinement",
    "arm_least_squares": "Least squares",
    "arm_true": "True parameters",
}


@pytest.mark.slow
def test_marks_and_written_numbers_are_the_values_given() -> None:
    frame = FRAMES["ablation"]()
    figure = made("ablation", frame)
    marked = {line.get_label(): line.get_xdata() for axes in figure.axes for line in axes.lines}
    written = {float(text.get_text()) for axes in figure.axes for text in axes.texts}
    far = frame["value"] < 0.8
    for quantity, label in SHOWN.items():
        rows = frame[(frame["quantity"] == quantity) & ~far]
        np.testing.assert_allclose(marked[label], 100.0 * rows["value"])
    assert written == {round(100.0 * value, 2) for value in frame["value"][far]}
    assert len(written) == 3
    assert all(axes.get_xlim()[0] > 80.0 for axes in figure.axes)


def test_lines_stand_at_the_default_reading_wherever_it_is() -> None:
    frame = FRAMES["ablation"]().iloc[::-1]
    figure = made("ablation", frame)
    default = frame[frame["question"] == "default"].set_index("quantity")["value"]
    lines = [line.get_xdata()[0] for axes in figure.axes for line in axes.lines if list(line.get_ydata()) == [0, 1]]
    assert sorted(lines) == pytest.approx(sorted(100.0 * default))
    assert figure.axes[0].get_yticklabels()[0].get_text() == "Default: as configured"
    assert figure.axes[0].get_ylim()[0] > figure.axes[0].get_ylim()[1]


def test_no_strip_where_nothing_lies_far_below() -> None:
    frame = FRAMES["ablation"]()
    figure = made("ablation", frame.assign(value=frame["value"].clip(lower=0.9)))
    assert not [text for axes in figure.axes for text in axes.texts]
    assert not [label for axes in figure.axes for label in axes.get_xticklabels(minor=True)]


def test_table_holds_the_numbers_by_question(tmp_path: Path) -> None:
    frame = TABLES["ablation"]()
    tex, md = laid_out(tmp_path, "ablation", frame.iloc[::-1])
    for row in frame.itertuples():
        cells = [f"{row.steps}", f"{1e4 * row.held_out_loss:.2f}", *(f"{100 * value:.2f}" for value in row[5:])]
        assert f"| {row.reading} | " + " | ".join(cells) + " |" in md
        assert f"{row.reading} & " + " & ".join(f"${cell}$" for cell in cells) in tex
    rows = [line for line in md.splitlines() if line.startswith("|")][2:]
    assert rows[0].startswith("| **Default**")
    assert rows[1].startswith("| as configured |")
    assert sum("**" in row for row in rows) == frame["question"].nunique()
    caption = md.splitlines()[0]
    for words in ("literal Algorithm 1", "median of the seeds", "Simulated arm", "no network of its own"):
        assert words in caption
