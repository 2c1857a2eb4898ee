"""The words for what an estimate is worth."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from repro.ownarm.text import COMBINED, NOT_EXCITED, verdict


def within(share, estimate=2.0, excited=True, at_bound=False):
    """Verdict on an estimate whose interval reaches this share of it to either side."""
    reach = share * abs(estimate)
    return verdict(estimate, estimate - reach, estimate + reach, excited, at_bound)


@pytest.mark.parametrize("estimate", [2.0, -2.0, 1e-6])
@pytest.mark.parametrize(
    ("share", "words"),
    [
        (0.0, "known to 0.1 %"),
        (0.0004, "known to 0.1 %"),
        (0.004, "known to 0.4 %"),
        (0.00401, "known to 0.5 %"),
        (0.0099, "known to 1 %"),
        (0.00991, "known to 1 %"),
        (0.01, "known to 1 %"),
        (0.0101, "known to 2 %"),
        (0.03, "known to 3 %"),
        (0.0301, "known to 4 %"),
        (0.12, "known to 12 %"),
        (0.49, "known to 49 %"),
        (0.4999, "known to 50 %"),
        (0.51, "sign known, size only roughly"),
        (0.99, "sign known, size only roughly"),
        (1.01, "cannot be distinguished from zero"),
        (30.0, "cannot be distinguished from zero"),
    ],
)
def test_words_at_their_limits(share, words, estimate):
    assert within(share, estimate) == words


def test_words_without_a_number():
    assert verdict(2.0, -0.1, 4.1, excited=False, at_bound=False) == NOT_EXCITED == "not excited by this motion"
    assert verdict(2.0, None, None, excited=False, at_bound=False) == NOT_EXCITED
    assert verdict(0.0, None, None, excited=True, at_bound=True) == "held at zero: the log alone would make it negative"
    assert verdict(2.0, None, None, excited=True, at_bound=False) == "the method claims no interval"
    assert verdict(2.0, -0.1, 4.1, excited=True, at_bound=False) == "cannot be distinguished from zero"
    assert verdict(-2.0, -4.0, 0.0, excited=True, at_bound=False) == "cannot be distinguished from zero"
    assert verdict(0.0, -0.1, 0.1, excited=True, at_bound=False) == "cannot be distinguished from zero"
    assert verdict(0.1, 0.05, 4.0, excited=True, at_bound=False) == "sign known, size only roughly"


@pytest.mark.parametrize(("share", "words"), [(0.03, "known to 3 %"), (0.7, "sign known, size only roughly")])
def test_a_parameter_that_is_told_from_zero_is_known_however_little_torque_it_moves(share, words):
    assert within(share, 1e-7, excited=False) == within(share, 1e-7, excited=True) == words


def test_of_a_combination_no_parameter_is_known():
    for low, high, held in ((1.99, 2.01, False), (None, None, False), (None, None, True), (-1.0, 5.0, False)):
        assert verdict(2.0, low, high, excited=True, at_bound=held, determined=False) == COMBINED
        assert verdict(2.0, low, high, excited=False, at_bound=held, determined=False) == NOT_EXCITED
    assert "combination" in COMBINED
    assert "base parameters" in COMBINED


@given(st.floats(0.0, 0.4999), st.floats(1e-9, 1e9))
def test_percents_are_never_optimistic_and_at_most_a_digit_too_large(share, estimate):
    told = float(re.fullmatch(r"known to ([0-9.]+) %", within(share, estimate))[1])
    actual = 50.0 * ((estimate + share * estimate) - (estimate - share * estimate)) / estimate
    assert told >= actual - 1e-7
    assert told <= max(actual + (1.0 if told > 1.0 else 0.1), 0.1) + 1e-7
