"""Logs of any size, form and damage: read a block at a time, or refused in one line without waiting."""

import os
import time
import tracemalloc
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from experiment_example import refused
from hypothesis import given, settings
from hypothesis import strategies as st
from log_example import columns, recording, text, write

from repro.errors import InputError
from repro.identification.armfile import Arm, read_arm
from repro.identification.log import uniform
from repro.logs import plain_text, table
from repro.logs.diagnostics import describe
from repro.logs.load import read_log

GOOD = columns(recording(np.arange(600) / 200.0))


def refusal(path):
    began = time.process_time()
    error = refused(read_log, path, Arm())
    assert time.process_time() - began < 5.0
    return error


@pytest.fixture
def file(tmp_path):
    return partial(write, tmp_path)


@pytest.mark.parametrize(
    ("old", "new"),
    [("", ""), ("\n", "\r\n"), ("0.", "0,"), ("0.01,", "0.01,é"), ("0.5,", "0.5_,"), ("1.5,", "1.5,,"), ("2.5,", ",")],
    ids=["good", "line ends", "commas", "text", "underscore", "cell too many", "cells missing"],
)
@pytest.mark.parametrize("size", [1, 7, 64])
def test_blocks_change_nothing(file, monkeypatch, size, old, new):
    content = text(GOOD).replace(",", ";" if new == "0," else ",").replace(old or "\0", new)
    path = file(f"# a comment\n\n{content} \n")  # the blank keeps the table from being read at once

    def read():
        try:
            log = read_log(path, Arm())
        except InputError as error:
            return str(error)
        return log.t.tobytes(), log.q.tobytes(), log.tau.tobytes(), log.notes

    whole = read()
    monkeypatch.setattr(table, "_LINES_PER_BLOCK", size)
    monkeypatch.setattr(plain_text, "MAX_LINE_BYTES", 100 * size)
    assert read() == whole


def test_a_file_too_large_is_refused_unread(file):
    path = file("time,q1\n")
    os.truncate(path, plain_text.MAX_FILE_BYTES + 1)  # takes no room on the disk
    error = refusal(path)
    assert error.place == f"{path}: size" and error.found.startswith(str(plain_text.MAX_FILE_BYTES + 1))


def test_missing_columns_are_found_in_the_header(file):
    path = file("time,q1,q2\n" + "0.1,0.2,0.3\n" * 2_000_000)
    tracemalloc.start()
    assert "tau1, tau2" in refusal(path).expected
    assert tracemalloc.get_traced_memory()[1] < 30e6
    tracemalloc.stop()


def test_what_is_no_file_is_refused_at_once(tmp_path):
    for name in ("pipe.csv", "pipe.bin"):
        os.mkfifo(tmp_path / name)
    for path in (tmp_path / "pipe.csv", tmp_path / "pipe.bin", Path("/dev/zero"), Path("/dev/full")):
        assert refused(read_arm, path).place == str(path)
        assert refusal(path).place == str(path)
    for path in (tmp_path / "log.csv", tmp_path / "log.bin", tmp_path):
        assert refusal(path).place == str(path)


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
    path = write(tmp_path_factory.mktemp("damaged"), data)
    try:
        log = read_log(path, Arm())
        describe(log, Arm())
        even = uniform(log)
    except InputError as error:
        assert "\n" not in str(error) and "log.csv" in str(error)
    else:
        assert even.q.shape == even.tau.shape == (2, even.t.size)
        assert np.isfinite([even.q, even.tau]).all()
