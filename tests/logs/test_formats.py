"""Formats of tables: whatever separates cells and decimals, and with rows twice or empty, the same log is read."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from log_example import RATE, assert_same, columns, recording

from repro.identification.armfile import Arm
from repro.logs.load import read_log
from repro.logs.table import list_lines

GOOD = recording(np.arange(450) / RATE)
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


@settings(max_examples=40)
@given(
    separator=st.sampled_from(list(NAMES)),
    comma=st.booleans(),
    header=st.sampled_from(["", "# "]),
    twice=st.sets(st.integers(1, 450), max_size=5),
    empty=st.sampled_from(["", "NaN", "-nan", "null", "N/A"]),
    holes=st.sets(st.integers(1, 450), max_size=5),
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
    decimals, unit = "numbers have a decimal comma", "the header states no unit"
    expected = [(separator != ",", f"columns are separated by {NAMES[separator]}"), (comma, decimals), (True, unit)]
    expected += [(holes, f"{len(holes)} row"), (twice, f"{len(twice)} row")]
    beginnings = [beginning for there, beginning in expected if there]
    assert len(log.notes) == len(beginnings)
    assert all(map(str.startswith, log.notes, beginnings))


@pytest.mark.parametrize("separator", [",", "|"])
def test_comments_rules_and_separators_at_the_end_do_not_matter(file, separator):
    header, *rows = lines(separator)
    rows[3] += separator
    comments = {100: "% resumed", 200: "# resumed", 300: "// resumed, after a pause, of 0, s, or 1, 2, 3"}
    rows = [line for k, row in enumerate(rows) for line in ([comments[k], row] if k in comments else [row])]
    assert_same(read(file, ["// of 2024", header, separator.join(["---"] * len(TABLE)), *rows]), GOOD)


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
