"""What comes from outside is shown, not obeyed."""

import numpy as np
import pandas as pd
import pytest
from experiment_example import refused
from hypothesis import given
from hypothesis import strategies as st

import repro
from repro.errors import InputError, one_of, shown

HOSTILE = ["\x1b[31mred", "a\nb", "\u202edesrever", "bell\x07", "\x9b2J", "\u2028line", "\r\x1b]0;title\x07"]


@given(st.text())
def test_what_is_shown_can_be_printed_and_words_stay(text):
    assert shown(text).isprintable()
    assert shown(shown(text)) == shown(text)
    assert str(InputError(text)) == shown(text)


@pytest.mark.parametrize("text", HOSTILE)
def test_names_of_columns_arms_and_files_reach_no_terminal_as_they_are(tmp_path, text):
    refused(repro.Arm, name=text)
    t = 0.01 * np.arange(500)
    frame = pd.DataFrame(
        {"time": t, text: t, "q1": np.sin(t), "q2": np.cos(t), "tau1": np.cos(3 * t), "tau2": np.sin(t)}
    )
    assert all(note.isprintable() for note in repro.read_log(frame).notes)
    assert str(refused(repro.read_log, frame.rename(columns={"q1": f"q1{text}"}))).isprintable()
    if "/" not in text:
        path = tmp_path / f"{text}.csv"
        frame.drop(columns=text).to_csv(path, index=False)
        log = repro.read_log(path)
        assert log.name.isprintable()
        assert str(repro.identify(path, method="bounded")).replace("\n", "").isprintable()


@pytest.mark.parametrize(
    ("found", "expected"),
    [
        ("zeros", "zero, or one of 2 others"),
        ("ls", "least-squares, or one of 2 others"),
        ("red", "one of zero, sign, least-squares"),
        (3, "one of zero, sign, least-squares"),
    ],
)
def test_the_name_that_was_meant_is_proposed(found, expected):
    assert one_of(["zero", "sign", "least-squares"], found) == expected
