"""Sampling: jitter, gaps, rounded times, encoder steps and saturation."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from log_example import RATE, assert_same, log_of, recording

from repro.errors import InputError
from repro.logs.armfile import Arm
from repro.logs.diagnostics import describe, quantisation_step, saturated_fraction
from repro.logs.log import uniform

GOOD = recording()
SIGNALS = ("q", "dq", "tau")


@settings(max_examples=20)
@given(seed=st.integers(0, 2**32 - 1), jitter=st.floats(0.01, 0.4))
def test_jitter_is_interpolated_away(seed, jitter):
    rng = np.random.default_rng(seed)
    t = (np.arange(2400) + jitter * rng.uniform(-1, 1, 2400)) / RATE
    log = uniform(log_of(recording(t)))
    assert np.ptp(np.diff(log.t)) < 1e-9
    h = log.t[1]
    np.testing.assert_allclose(h, 1 / RATE, rtol=0.1)
    truth = recording(t[0] + log.t)
    assert_same(log, dataclasses.replace(truth, t=log.t), q=2e-5, dq=1e-2, tau=0.2)
    assert np.sqrt(np.mean((log.tau - truth.tau) ** 2)) < 0.01
    assert log.notes[-1].startswith("resampled to an even ")
    assert uniform(log) is log


def test_rounded_times_are_no_jitter():
    even = recording(np.arange(3000) / 300)
    log = uniform(log_of(dataclasses.replace(even, t=np.round(even.t, 3))))
    assert log.notes == ("times are rounded to 0.001 s; samples are taken as evenly spaced at 300 Hz",)
    np.testing.assert_array_equal(log.q, even.q)
    np.testing.assert_allclose(log.t, even.t, atol=1e-4)
    assert describe(log_of(dataclasses.replace(even, t=np.round(even.t, 3))), Arm()).warnings == ()


def without(begin, end):
    """The good recording without some samples."""
    keep = np.r_[0:begin, end:2400]
    return log_of(recording(GOOD.t[keep]))


def test_short_gaps_are_bridged_and_told():
    log = uniform(without(1000, 1005))
    assert "5 missing samples are bridged by interpolation" in log.notes
    np.testing.assert_allclose(log.t, GOOD.t, atol=1e-9)
    np.testing.assert_allclose(log.q, GOOD.q, atol=1e-5)
    assert dict(describe(without(1000, 1005), Arm()).facts)["gaps"] == "1, 5 samples missing, the longest 30 ms"


def test_a_long_gap_splits_the_log():
    log = uniform(without(1000, 1010))
    assert log.notes == ("1 gap of up to 0.055 s: the log is used in 2 pieces of 4.995, 6.945 s",)
    keep = np.r_[0:1000, 1010:2400]
    assert_same(log, dataclasses.replace(GOOD, t=GOOD.t[keep], **{k: getattr(GOOD, k)[:, keep] for k in SIGNALS}))
    assert [piece.t.size for piece in log.pieces] == [1000, 1390]
    assert log.longest.t[0] == GOOD.t[1010]
    assert uniform(log) is log


def test_pieces_that_are_too_short_are_left_out():
    log = uniform(without(300, 1000))
    assert log.notes == ("1 gap of up to 3.5 s: the log is used in 1 piece of 6.995 s; 1 too short, left out",)
    assert log.breaks == ()
    np.testing.assert_allclose(log.t, GOOD.t[1000:], atol=1e-9)
    np.testing.assert_allclose(log.tau, GOOD.tau[:, 1000:], atol=1e-12)
    thin = log_of(recording(np.r_[0.0:3.0:0.02, 4.0:14.0:0.02]))
    assert uniform(thin).t.size == 500  # 150 samples are too few, though they last 3 s
    with pytest.raises(InputError, match=r"log\.csv: time: found 1 gap of up to 8\.5 s, 1\.99 s"):
        uniform(without(300, 2000))


def test_samples_close_together_do_no_harm():
    t = np.sort(np.r_[GOOD.t, GOOD.t[500:520] + 1e-6])
    r = recording(t)
    noisy = dataclasses.replace(r, q=np.round(r.q / 7.5e-4) * 7.5e-4)  # two readings of a step of the encoder
    log = uniform(log_of(noisy))
    assert "20 samples less than 1.2 ms after another are left out" in log.notes
    np.testing.assert_allclose(log.q, GOOD.q, atol=1e-3)


def test_each_piece_is_made_even_on_its_own():
    t = GOOD.t + np.where(np.arange(2400) < 1000, 0.0, 1.2345)  # the clock goes on while nothing is recorded
    t += 0.001 * np.random.default_rng(0).uniform(-1, 1, t.size)
    log = uniform(log_of(recording(t)))
    assert "resampled to an even" in log.notes[-1]
    truth = recording(t[0] + log.t)
    for piece in log.pieces:
        assert np.ptp(np.diff(piece.t)) < 1e-9
    assert_same(log, dataclasses.replace(truth, t=log.t), q=2e-5, dq=1e-2, tau=0.2)


def test_rounding_of_the_last_bits_is_no_step():
    walk = 0.25 * np.cumsum(np.random.default_rng(1).integers(-2, 3, 2000))
    noise = 1e-14 * np.random.default_rng(2).standard_normal(2000)
    assert quantisation_step(walk + noise) == pytest.approx(0.25)


@pytest.mark.parametrize("limit", [1.0, 2.0, 3.0])
def test_saturation_is_measured(limit):
    tau = np.clip(GOOD.tau, -limit, limit)
    truth = np.mean(np.abs(GOOD.tau) >= limit, axis=1)
    known = np.array([limit, limit])
    np.testing.assert_allclose(saturated_fraction(dataclasses.replace(log_of(GOOD), tau=tau)), truth, atol=1e-9)
    np.testing.assert_allclose(saturated_fraction(log_of(GOOD, torque_limit=known)), truth, atol=0.002)
