"""Table 1: every cited work of Section I-A once, answers that follow its sentences, damage told in one line."""

import re
from pathlib import Path

import pytest
from render_examples import TABLES, laid_out, refused

from repro.errors import InputError
from repro.paper.related_work import COLUMNS, NOT_STATED, REFERENCES, RELATED_WORK_FILE, load_related_work

#: Widths of Times in thousandths of the type size, and its mean letter for what is not listed.
NARROW = dict.fromkeys("ijltf.,;:()[]/I -", 320)


@pytest.fixture(scope="module")
def works():
    return load_related_work()


def test_every_work_is_there_once_and_in_order(works):
    assert tuple(works["reference"]) == REFERENCES
    assert [r for r in REFERENCES if r.startswith("[")] == [f"[{n}]" for n in range(11, 29)]
    assert list(works.columns) == list(COLUMNS)
    assert not works.isna().to_numpy().any()


def test_answers_follow_the_sentences_of_section_i_a(works):
    by_work = works.set_index("reference")
    by_squares = {f"[{n}]" for n in (16, 18, 19, 20, 23, 24, 26, 27, 28)}
    assert set(by_work.index[by_work["optimisation"] == "yes"]) == by_squares
    assert list(by_work.index[by_work["optimisation"] == "no"]) == ["this article"]
    assert set(by_work.index[by_work["set_apart"] == "yes"]) == {"[14]", "[15]", "[18]", "[25]"}
    six = {f"[{n}]" for n in (13, 15, 16, 18, 19, 20, 21, 23, 24, 27, 28)}
    assert set(by_work.index[by_work["dof"] == "6"]) == six
    assert by_work.loc[["[12]", "[14]", "[22]", "this article"], "dof"].tolist() == ["2, 5", "1", "8", "2"]
    assert set(by_work.index[by_work["dof"] == NOT_STATED]) == {"[11]", "[17]", "[25]", "[26]"}


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


def test_layout_refuses_an_unknown_answer(tmp_path):
    frame = TABLES["table01"]()
    frame.loc[3, "optimisation"] = "perhaps"
    assert "line 5: optimisation: found 'perhaps'" in refused(laid_out, tmp_path, "table01", frame)


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("reference,robot,dof", "reference,robot,joints", "no column dof"),
        ("[12],two robots", "[12],", "line 3: robot"),
        ("[13],", "[12],", "[12]"),
        ("UR5e,6,", "UR5e,six,", "line 7: dof: found 'six'"),
        ("parameters,yes,yes", "parameters,yes,maybe", "line 9: set_apart"),
        ("two-link arm,2,", "two-link arm,2.5,", "dof"),
        ("whale and genetic optimisation", "LS", "line 12: optimisation: found 'not stated'"),
    ],
)
def test_a_damaged_file_is_refused_in_one_line(tmp_path, old, new, expected):
    text = RELATED_WORK_FILE.read_text(encoding="utf-8")
    assert old in text
    path = tmp_path / "related_work.csv"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_related_work(path)
    message = str(caught.value)
    assert "\n" not in message and str(path) in message and expected in message
    assert "found" in message and "expected" in message


def test_a_missing_row_or_file_is_refused(tmp_path):
    lines = RELATED_WORK_FILE.read_text(encoding="utf-8").splitlines()
    path = tmp_path / "related_work.csv"
    path.write_text("\n".join(lines[:-1]) + "\n", encoding="utf-8")
    with pytest.raises(InputError, match="18 rows"):
        load_related_work(path)
    with pytest.raises(InputError, match="nowhere"):
        load_related_work(Path(tmp_path / "nowhere.csv"))
