"""Dates, counters that wrap, and signals at instants of their own."""

import datetime

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from repro.logs.instants import continued, merged, seconds_of, unwrapped


@given(st.datetimes(datetime.datetime(1970, 1, 2), datetime.datetime(2199, 1, 1)), st.sampled_from([" ", "T", "  "]))
def test_a_date_is_seconds_since_1970(moment, between):
    expected = moment.replace(tzinfo=datetime.UTC).timestamp()
    text = f"{moment:%Y-%m-%d}{between}{moment:%H:%M:%S.%f}"
    assert seconds_of(text) == pytest.approx(expected, abs=2e-6)
    assert seconds_of(f"{text}Z") == seconds_of(f"{text}+02:00") == seconds_of(text)


@given(st.datetimes(datetime.datetime(1970, 1, 2), datetime.datetime(2199, 1, 1)))
def test_other_forms_of_a_date_are_the_same_moment(moment):
    expected = pytest.approx(moment.replace(tzinfo=datetime.UTC).timestamp(), abs=2e-6)
    forms = ["%d.%m.%Y %H:%M:%S,%f", "%d/%m/%Y %I:%M:%S.%f %p", "[%Y-%m-%d %H:%M:%S.%f]", "%Y%m%dT%H%M%S.%f"]
    forms += ["%m/%d/%Y, %I:%M:%S.%f%p"] if moment.day > 12 else []
    assert [seconds_of(moment.strftime(form)) for form in forms] == [expected] * len(forms)


@pytest.mark.parametrize(
    "text", ["", "12", "24-05-30 10:00:00", "1:2", "2024-02-30 10:00:00", "2024-05-30", "a:bb:cc", "1:02:03:04"]
)
def test_what_is_no_moment_is_none(text):
    assert seconds_of(text) is None


def test_a_clock_time_is_seconds_since_midnight():
    assert [seconds_of(text) for text in ("00:00:01.5", "15:33:54,25", "15:33:54:250")] == [1.5] + 2 * [56034.25]


@pytest.mark.parametrize(
    ("modulus", "step", "name"),
    [
        (2**32, 10_000, "32 bits"), (2**32 * 1e-6, 0.01, "32 bits"), (2**16, 7, "16 bits"),
        (2**16 * 1e-3, 0.004, "16 bits"), (86400.0, 0.02, "midnight"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("lowest", [0.0, -0.5])  # of a signed counter, in moduli
def test_a_counter_that_wraps_goes_on(modulus, step, name, lowest):
    true = modulus - 50 * step + step * np.arange(130) + lowest * modulus
    time, said = continued((true - lowest * modulus) % modulus + lowest * modulus)
    np.testing.assert_allclose(time, true, rtol=0, atol=1e-6 * step + 1e-9 * modulus)
    assert name in said
    assert continued(true)[1] == ""


@pytest.mark.parametrize(("modulus", "lowest"), [(1024, 0), (10_000, 0), (65_536, -32_768), (2**32, 0)])
def test_counts_that_begin_again_go_on(modulus, lowest):
    true = np.rint(1.3 * modulus + 0.9 * modulus * np.sin(0.05 * np.arange(400)))
    counts, at = unwrapped((true - lowest) % modulus + lowest)
    assert at == modulus
    np.testing.assert_array_equal(counts - counts[0], true - true[0])
    assert unwrapped(true)[1] == 0


def test_two_runs_in_one_file_are_no_wrap():
    time = np.concatenate([np.arange(100.0), np.arange(50.0)])
    assert continued(time)[1] == ""


def test_rows_of_one_instant_are_one_row():
    time = np.repeat(np.arange(6.0), 2)
    q, tau = np.full(12, np.nan), np.full(12, np.nan)
    q[::2], tau[1::2] = np.arange(6.0), 10.0 + np.arange(6.0)
    values, rows, said = merged(np.stack([time, q, tau]), np.array([True, True, True]), 0)
    np.testing.assert_array_equal(values, [np.arange(6.0), np.arange(6.0), 10.0 + np.arange(6.0)])
    assert rows.tolist() == [0, 2, 4, 6, 8, 10] and "merged" in said


def test_signals_at_different_instants_are_interpolated():
    time = np.sort(np.concatenate([0.01 * np.arange(300), 0.0013 + 0.02 * np.arange(150)]))
    of_torque = np.isclose((time - 0.0013) % 0.02, 0.0, atol=1e-9) | np.isclose((time - 0.0013) % 0.02, 0.02, atol=1e-9)
    q, tau = np.where(of_torque, np.nan, 3.0 * time), np.where(of_torque, 5.0 - time, np.nan)
    values, rows, said = merged(np.stack([time, q, tau]), np.array([True, True, True]), 0)
    np.testing.assert_allclose(values[1], 3.0 * values[0], atol=1e-12)
    np.testing.assert_allclose(values[2], 5.0 - values[0], atol=1e-12)
    assert values.shape[1] == 150 and of_torque[rows].all() and "different instants" in said


def test_full_rows_stay_and_so_does_what_is_never_there():
    values = np.stack([np.arange(9.0), np.arange(9.0), np.full(9, np.nan)])
    needed = np.array([True, True, False])
    assert merged(values, needed, 0)[2] == ""
    nothing = values.copy()
    nothing[1] = np.nan
    assert merged(nothing, needed, 0)[2] == ""
