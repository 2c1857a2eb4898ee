"""The published numbers: complete, as printed, and guarded against damage."""

import ast
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import repro
from repro.errors import InputError
from repro.paper.published import COLUMNS, PUBLISHED_FILE, load_published


@pytest.fixture(scope="module")
def published():
    return load_published()


def test_every_number_of_these_places_is_there(published):
    # Tables 4, 5: nine parameters, true and estimate, two arms. Table 7: six rows, four arms.
    # Table 8: two joints. Table 10: six rows, five trajectories, two methods.
    counts = {"Table 4": 9 * 4, "Table 5": 9 * 4, "Table 7": 24, "Table 8": 2, "Table 10": 60, "Abstract": 2}
    found = Counter(v.place for v in published)
    assert {place: found[place] for place in counts} == counts


@pytest.mark.parametrize(
    ("id_", "printed", "unit"),
    [
        ("table04/N1/true/I1", "0.6590", "kg m^2"),
        ("table04/N1/algorithm1/k1", "0.2244", "kg m^2/s^2"),
        ("table04/N2/algorithm1/b2", "0.0066", "kg m^2 s"),
        ("table05/N3/algorithm1/b1", "0.1200", "kg m^2 s"),
        ("table05/N3/algorithm1/I2", "1.0288", "kg m^2"),
        ("table05/N4/true/g2", "0.8523", "kg m^2/s^2"),
        ("table07/N1/total/joint1", "97.10", "%"),
        ("table07/N2/time/joint1", "97.32", "%"),
        ("table07/N4/frequency/joint2", "97.46", "%"),
        ("table08/ID/total/joint2", "99.02", "%"),
        ("table10/ID/algorithm1/total/joint1", "93.55", "%"),
        ("table10/T2/least-squares/total/joint2", "85.82", "%"),
        ("table10/T4/least-squares/time/joint1", "99.64", "%"),
        ("abstract/numeric/total", "97.38", "%"),
        ("abstract/experimental/total", "93.55", "%"),
    ],
)
def test_numbers_stand_as_the_paper_prints_them(published, id_, printed, unit):
    assert (published[id_].printed, published[id_].unit) == (printed, unit)


def test_ids_are_unique_and_start_with_their_place(published):
    assert len({v.id for v in published}) == len(published)
    for v in published:
        head = v.place.lower() if v.place == "Abstract" else f"table{int(v.place.split()[1]):02d}"
        assert v.id.split("/")[0] == head


def test_half_step_follows_the_printed_digits(published):
    assert published["table05/N3/algorithm1/b1"].half_step == pytest.approx(5e-5)
    assert published["table07/N1/total/joint1"].half_step == pytest.approx(5e-3)


def test_lookups_agree_with_the_rows(published):
    true, similarity = published.parameter_sets("true"), published.similarities("total")
    assert true.shape == (4, 9) and similarity.shape == (4, 2)
    np.testing.assert_array_equal(true[2], [0.5020, 0.9779, 0.5040, 0.4777, 0.5724, 0.0715, 0.3820, 0.0972, 0.5721])
    np.testing.assert_allclose(similarity[1], [0.9498, 0.9904])
    chosen = published.select(place="Table 10", method="least-squares", quantity="time", joint=2)
    assert [v.printed for v in chosen] == ["99.80", "99.98", "98.65", "98.17", "99.80"]
    frame = published.frame()
    assert list(frame.columns) == [*COLUMNS, "half_step"]
    assert frame["joint"].isna().sum() == 36 + 36 + 2


def test_unknown_names_are_refused(published):
    with pytest.raises(InputError, match="table99/nothing"):
        published["table99/nothing"]
    with pytest.raises(ValueError, match="no field arm"):
        published.select(arm="N1")


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("id,place,", "name,place,", "header"),
        (",0.6590\n", ",0.659o\n", "line 2: value"),
        (",0.6590\n", ",nan\n", "line 2: value"),
        (",0.6590\n", ",1e999\n", "line 2: value"),
        (",0.6590\n", "\n", "line 2"),
        (",1,,%,99.77", ",3,,%,99.77", "joint"),
        ("table04/N1/true/I2,", "table04/N1/true/I1,", "line 3: id"),
        ("I1,kg m^2,0.6590", "I1,,0.6590", "line 2: unit"),
    ],
)
def test_a_damaged_file_is_refused_in_one_line(tmp_path, old, new, expected):
    text = PUBLISHED_FILE.read_text()
    assert old in text
    path = tmp_path / "published.csv"
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(InputError) as caught:
        load_published(path)
    message = str(caught.value)
    assert "\n" not in message and str(path) in message and expected in message
    assert "found" in message and "expected" in message


@pytest.mark.parametrize("content", [None, b"", b"\xff\xfe\x00", (",".join(COLUMNS) + "\n").encode()])
def test_a_missing_or_empty_file_is_refused_in_one_line(tmp_path, content):
    path = tmp_path / "published.csv"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        load_published(path)
    assert "\n" not in str(caught.value) and str(path) in str(caught.value)


def test_nothing_that_makes_results_reads_the_published_numbers():
    root = Path(repro.__file__).parent
    rooms = ("model", "signals", "cnn", "identify", "pipeline", "render")
    files = [p for room in rooms for p in (root / room).rglob("*.py") if p.name != "metric_stage.py"]
    assert len(files) > 30
    for path in files:
        for node in ast.walk(ast.parse(path.read_text())):
            names = [a.name for a in node.names] if isinstance(node, ast.Import | ast.ImportFrom) else []
            module = getattr(node, "module", None) or ""
            assert not any(f"{module}.{n}".strip(".").startswith("repro.paper") for n in names), path
