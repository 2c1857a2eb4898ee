"""Formats of tables: whatever separates cells and decimals, and with rows twice or empty, the same log is read."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from log_example import RATE, assert_same, columns, recording

from repro.cli import main
from repro.logs.armfile import Arm
from repro.logs.load import read_log
from repro.logs.table import list_lines

GOOD = recording(np.arange(600) / RATE)
TABLE = columns(GOOD)
NAMES = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars", " ": "blanks"}


def lines(separator=",", comma=False):
    """Lines of the good log; a decimal comma in cells that commas separate is quoted."""
    cells = [[f"{x:.15g}" for x in row] for row in zip(*TABLE.values(), strict=True)]
    if comma:
        cells = [[x.replace(".", ",") for x in row] for row in cells]
    if comma and separator == ",":
        cells = [[f'"{x}"' for x in row] for row in cells]
    return [separator.join(row) for row in (list(TABLE), *cells)]


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    return tmp_path_factory.mktemp("formats") / "log.csv"


def read(file, written):
    file.write_text("\n".join(written) + "\n", encoding="utf-8")
    return read_log(file, Arm())


@settings(max_examples=60, deadline=None)
@given(
    separator=st.sampled_from(list(NAMES)),
    comma=st.booleans(),
    header=st.sampled_from(["", "# "]),
    twice=st.sets(st.integers(1, 600), max_size=5),
    empty=st.sampled_from(["", "NaN", "-nan", "null", "N/A"]),
    holes=st.sets(st.integers(1, 600), max_size=5),
)
def test_the_format_does_not_matter(file, separator, comma, header, twice, empty, holes):
    plain = lines(separator, comma)
    written = [header + plain[0]]
    for number, line in enumerate(plain[1:], 1):
        written += [line] * (2 if number in twice else 1)
        if number in holes:  # a row without torque, half a period after the other
            cells = [f"{TABLE['time'][number - 1] + 0.5 / RATE:.15g}", *["0"] * 5, empty or '""']
            cells = [cell.replace(".", ",") if comma else cell for cell in cells]
            written.append(separator.join(f'"{cell}"' if comma and "," in cell else cell for cell in cells))
    log = read(file, written)
    assert_same(log, GOOD)
    told = [note for note in log.notes if "assumed" not in note]
    assert told == [
        *([f"columns are separated by {NAMES[separator]}"] if separator != "," else []),
        *(["numbers have a decimal comma"] if comma else []),
        *([note for note in told if note.startswith(f"{len(holes)} row") and "empty cells" in note] if holes else []),
        *(
            [note for note in told if note.startswith(f"{len(twice)} row") and "the one before" in note]
            if twice
            else []
        ),
    ]


def test_commas_that_may_group_digits_are_decimal_next_to_commas_that_cannot(file):
    log = read(file, ["time;q1;q2;tau1;tau2", *(f"{k}e-2;1,{k:03d};0,5;0,{k};0,7{k}" for k in range(300))])
    np.testing.assert_allclose(log.q[0], 1.0 + 1e-3 * np.arange(300), atol=1e-12)


def test_rows_left_out_are_reported_by_line(file):
    written = lines()
    for number in (4, 5, 6, 9):
        written[number - 1] = written[number - 1].rpartition(",")[0] + ","
    written.insert(20, written[19])
    log = read(file, written)
    assert log.notes[1:] == (
        "4 rows with empty cells left out: lines 4 to 6, 9",
        "1 row equal to the one before left out: line 21",
    )
    assert_same(log, recording(np.delete(GOOD.t, [2, 3, 4, 7])))
    assert list_lines(range(1, 30, 2)) == "lines 1, 3, 5, 7, 9 and 10 more places"


def test_the_same_time_with_other_values_is_refused(file, tmp_path, capsys):
    written = lines(";")
    cells = written[50].split(";")
    written.insert(51, ";".join([cells[0], "0.5", *cells[2:]]))
    file.write_text("\n".join(written), encoding="utf-8")
    assert main(["identify", str(file), "-o", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err.strip().splitlines()
    assert len(said) == 1
    assert "line 52, time: found 0.245 s twice, expected time that increases" in said[0]
    assert not (tmp_path / "out").exists()


def test_without_the_extra_one_line_says_what_to_install(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("repro.errors.find_spec", lambda package: None)
    (tmp_path / "arm.mcap").write_bytes(b"")
    assert main(["identify", str(tmp_path / "arm.mcap"), "--method", "ordinary", "-o", str(tmp_path / "out")]) == 2
    (said,) = capsys.readouterr().err.strip().splitlines()
    assert "found no package rosbags, expected the extra bags: python -m pip install -e '.[bags]'" in said
