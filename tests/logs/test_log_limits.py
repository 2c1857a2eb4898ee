"""Logs of any size, form and damage: read a block at a time, or refused in one line without waiting."""

import os
import time
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from log_example import columns, recording, text

from repro.errors import InputError
from repro.logs import table
from repro.logs.armfile import Arm, read_arm
from repro.logs.diagnostics import describe
from repro.logs.load import read_log
from repro.logs.log import uniform

GOOD = columns(recording(np.arange(600) / 200.0))


def refusal(path, arm=None):
    began = time.process_time()
    with pytest.raises(InputError) as caught:
        read_log(path, arm or Arm())
    assert time.process_time() - began < 5.0
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.fixture
def file(tmp_path):
    def write(content):
        path = tmp_path / "log.csv"
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return path

    return write


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("", ""),
        ("\n", "\r\n"),
        ("0.", "0,"),
        ("0.005,", "0.005,é"),
        ("0.5,", "0.5_,"),
        ("1.5,", "1.5,,"),
        ("2.5,", ","),
    ],
    ids=["good", "line ends", "commas", "text", "underscore", "cell too many", "cells missing"],
)
@pytest.mark.parametrize("size", [1, 7, 64])
def test_blocks_change_nothing(file, monkeypatch, size, old, new):
    content = text(GOOD).replace(",", ";" if new == "0," else ",").replace(old or "\0", new)
    path = file(f"# a comment\n\n{content}")

    def read():
        try:
            log = read_log(path, Arm())
        except InputError as error:
            return str(error)
        return log.t.tobytes(), log.q.tobytes(), log.tau.tobytes(), log.notes

    whole = read()
    monkeypatch.setattr(table, "_BLOCK", size)
    monkeypatch.setattr(table, "LONGEST_LINE", 100 * size)
    assert read() == whole


def test_too_many_rows_are_refused(file, monkeypatch):
    monkeypatch.setattr(table, "MOST_ROWS", 599)
    assert "found more than 599 rows, expected at most 599" in refusal(file(text(GOOD)))


def test_a_hundred_thousand_columns_are_refused(file):
    names = ",".join(f"c{k}" for k in range(100_000))
    assert "header: found 100000 columns, expected at most 1000" in refusal(file(f"{names}\n{'0,' * 99_999}0\n"))


def test_a_line_without_an_end_is_refused(file):
    assert "line 2: found 1048576 bytes without a line end" in refusal(file("time,q1\n" + "1" * 3_000_000))


def test_a_file_too_large_is_refused_unread(file):
    path = file("time,q1\n")
    os.truncate(path, table.LARGEST + 1)  # takes no room on the disk
    assert f"size: found {table.LARGEST + 1} bytes" in refusal(path)


def test_missing_columns_are_found_in_the_header(file):
    path = file("time,q1,q2\n" + "0.1,0.2,0.3\n" * 2_000_000)
    tracemalloc.start()
    assert "expected a column for tau1, tau2" in refusal(path)
    assert tracemalloc.get_traced_memory()[1] < 30e6
    tracemalloc.stop()


def test_what_is_no_file_is_refused_at_once(tmp_path):
    pipe = tmp_path / "pipe.csv"
    os.mkfifo(pipe)
    capture = tmp_path / "pipe.bin"
    os.mkfifo(capture)
    for path in (pipe, capture, Path("/dev/zero"), Path("/dev/full")):
        assert refusal(path).startswith(f"{path}: found a pipe or a device")
        with pytest.raises(InputError, match="found a pipe or a device"):
            read_arm(path)


@pytest.mark.parametrize(
    ("changes", "found"),
    [
        ({"tau1": 1e-300 * GOOD["tau1"], "tau2": 1e-300 * GOOD["tau2"]}, "torque of joint 1: found "),
        ({"tau2": 1e-200 * GOOD["tau2"]}, "torque of joint 2: found "),
        ({"q1": [*GOOD["q1"][:-1], 1e308], "q2": [-1e308, *GOOD["q2"][1:]]}, "turns if it is rad"),
        ({"q1": ["\u0661\u0662", *GOOD["q1"][1:]]}, "line 2, column q1: found '\u0661\u0662'"),
    ],
    ids=["tiny torques", "one tiny torque", "huge positions", "digits of another script"],
)
@pytest.mark.filterwarnings("error")
def test_numbers_that_no_arm_gives_are_refused(file, changes, found):
    assert found in refusal(file(text(GOOD | changes)))


def test_files_that_are_not_there(tmp_path):
    with pytest.raises(InputError, match=r"log\.csv: found No such file or directory, expected a CSV table"):
        read_log(tmp_path / "log.csv", Arm())
    with pytest.raises(InputError, match="found a folder, expected a CSV table"):
        read_log(tmp_path, Arm())
    with pytest.raises(InputError, match=r"log\.bin: found No such file"):
        read_log(tmp_path / "log.bin", Arm())


@pytest.mark.slow
@settings(max_examples=60)
@given(
    seed=st.integers(0, 2**32 - 1),
    edits=st.lists(
        st.sampled_from([b"", b",", b"\n", b"-", b"1e400", b"9e99", b"nan", b"#", b'"', b"\xff", b";"]), max_size=4
    ),
)
def test_damage_never_breaks_the_reader(tmp_path_factory, seed, edits):
    rng = np.random.default_rng(seed)
    data = text(columns(recording(np.arange(300) / 100.0)), 5).encode()
    for edit in edits:
        place = int(rng.integers(len(data)))
        data = data[:place] + edit + data[place + int(rng.integers(3)) :]
    path = tmp_path_factory.mktemp("damaged") / "log.csv"
    path.write_bytes(data)
    try:
        log = read_log(path, Arm())
        describe(log, Arm())
        even = uniform(log)
    except InputError as error:
        assert "\n" not in str(error)
        assert "log.csv" in str(error)
    else:
        assert even.q.shape == even.tau.shape == (2, even.t.size)
        assert np.isfinite(even.q).all()
        assert np.isfinite(even.tau).all()
