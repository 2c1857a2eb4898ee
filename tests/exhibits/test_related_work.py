"""Table 1: every cited work of Section I-A once, answers that follow its sentences."""

import re

import pytest
from render_examples import TABLES, laid_out

from repro.exhibits.schematics import words

REFERENCES = (*(f"[{number}]" for number in range(11, 29)), "this article")
COLUMNS = ("reference", "robot", "dof", "method", "identified", "optimisation", "set_apart")

#: Widths of Times in thousandths of the type size, and its mean letter for what is not listed.
NARROW = dict.fromkeys("ijltf.,;:()[]/I -", 320)


@pytest.fixture(scope="module")
def works():
    return words("table01")


def test_every_work_is_there_once_and_in_order(works):
    assert tuple(works["reference"]) == REFERENCES
    assert list(works.columns) == list(COLUMNS)
    assert not works.isin(("", "nan")).to_numpy().any()
    assert works["dof"].str.fullmatch(r"[1-9]\d*(, [1-9]\d*)*|not stated").all()
    assert set(works["optimisation"]) == {"yes", "no", "not stated"}
    assert set(works["set_apart"]) == {"yes", "no"}


def test_answers_follow_the_sentences_of_section_i_a(works):
    by_work = works.set_index("reference")
    by_squares = {f"[{n}]" for n in (16, 18, 19, 20, 23, 24, 26, 27, 28)}
    assert set(by_work.index[by_work["optimisation"] == "yes"]) == by_squares
    assert by_squares >= set(by_work.index[by_work["method"].str.contains(r"\bW?LS\b")])
    assert list(by_work.index[by_work["optimisation"] == "no"]) == ["this article"]
    assert set(by_work.index[by_work["set_apart"] == "yes"]) == {"[14]", "[15]", "[18]", "[25]"}
    six = {f"[{n}]" for n in (13, 15, 16, 18, 19, 20, 21, 23, 24, 27, 28)}
    assert set(by_work.index[by_work["dof"] == "6"]) == six
    assert by_work.loc[["[12]", "[14]", "[22]", "this article"], "dof"].tolist() == ["2, 5", "1", "8", "2"]
    assert set(by_work.index[by_work["dof"] == "not stated"]) == {"[11]", "[17]", "[25]", "[26]"}


def test_table_fits_the_page_and_no_row_begins_with_a_bracket(tmp_path, works):
    tex, md = laid_out(tmp_path, "table01", TABLES["table01"]())
    rows = [line for line in tex.splitlines() if line.endswith(r"\\")]
    assert len(rows) == len(REFERENCES) + 1
    assert not [row for row in rows if row.lstrip().startswith(("[", "*"))]
    assert tex.count(r"$^{\dagger}$") == md.count("\N{DAGGER}") == 4 + 1  # the works and the caption
    cells = [re.sub(r"\$.*?\$|[{}\\]", "", row).split("&") for row in rows]
    widths = [
        max(sum(NARROW.get(c, 520) for c in cell.strip()) for cell in column) for column in zip(*cells, strict=True)
    ]
    points = 8.0 * sum(widths) / 1000.0 + 2 * 4.5 * (len(widths) - 1)
    assert points < 7.16 * 72.27
    assert "rebuilt from Section I-A" in tex
    assert "is an image" in tex
