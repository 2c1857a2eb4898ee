"""A table of nothing but numbers is read at once, with the same result as cell by cell."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from log_example import columns, recording, text, write

from repro.errors import InputError
from repro.logs.plain_numbers import plain_numbers
from repro.logs.table import read_table

GOOD = columns(recording(np.arange(12) / 100.0))
NAMES = ("time", "q1", "q2", "dq1")
TOKENS = st.floats(allow_nan=False, allow_infinity=False).map(repr) | st.integers(-(2**70), 2**70).map(str)
NOT_PLAIN = ["nan", "-NaN", " 1.5", "1 5", '"2.5"', "# 3", "1_000", "0x10", "inf", "12:00:01.5", "4,5", "N/A", "\r"]
UNUSUAL = ["", "+.5", "5.", "1e5", "1E-3", ".", "-", "e", "1e", "1e400", "--1", "1.2.3", "5e-324", "1e-400"]
ODD = st.sampled_from([*NOT_PLAIN, *UNUSUAL, "\N{ARABIC-INDIC DIGIT ONE}"])


def outcome(table, picked):
    """Bytes of the values, lines and notes of a table, or its error."""
    try:
        values, lines, notes = table.numbers(picked)
    except InputError as error:
        return str(error)
    return values.tobytes(), values.shape, lines.tolist(), notes


@settings(max_examples=300, suppress_health_check=[HealthCheck.too_slow])
@given(
    rows=st.lists(st.lists(TOKENS, min_size=4, max_size=4), min_size=1, max_size=6),
    odd=st.lists(st.tuples(st.integers(0, 5), st.integers(0, 3), ODD), max_size=2),
    above=st.sampled_from(["", "# a comment\n\n", "# one\r\n", "\ufeff"]),
    below=st.sampled_from(["", "s,rad,rad,rad/s\n"]),
    separator=st.sampled_from([",", ";", "\t", " "]),
    end=st.sampled_from(["\n", "\r\n", "\r"]),
    last=st.booleans(),
    picked=st.permutations(range(4)).flatmap(lambda order: st.integers(1, 4).map(lambda k: order[:k])),
)
def test_all_at_once_is_cell_by_cell(tmp_path_factory, rows, odd, above, below, separator, end, last, picked):
    for row, column, cell in odd:
        rows[row % len(rows)][column] = cell
    body = f"{','.join(NAMES)}\n{below}".replace(",", separator) + "\n".join(map(separator.join, rows)) + "\n" * last
    path = write(tmp_path_factory.mktemp("plain"), (above + body.replace("\n", end)).encode())
    try:
        table = read_table(path)
    except InputError:
        return
    assert outcome(table, picked) == outcome(replace(table, at_once=lambda _: None), picked)


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_a_plain_table_is_read_at_once(tmp_path, end):
    path = write(tmp_path, text(GOOD, 17).replace("\n", end))
    values, lines = plain_numbers(path, 2, ",", 7, [6, 0])
    assert values.tobytes() == np.stack([GOOD["tau2"], GOOD["time"]]).tobytes()
    assert lines.tolist() == list(range(2, 14))


@pytest.mark.parametrize("first", ['"0.03"', "0.03 ", "nan", "0.03,", "1e999", "0.03\n0.03"])
def test_another_table_is_left_to_be_read_cell_by_cell(tmp_path, first):
    content = text(GOOD).replace("\n0.03,", f"\n{first},")
    assert content != text(GOOD)
    assert plain_numbers(write(tmp_path, content), 2, ",", 7, [0, 1]) is None
