"""Sampling: jitter, gaps, rounded times, encoder steps and saturation."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from log_example import RATE, assert_same, log_of, recording

from repro.errors import InputError
from repro.logs.armfile import Arm
from repro.logs.diagnostics import describe
from repro.logs.log import uniform
from repro.logs.torque_limits import quantisation_step, saturated, unreliable_torque
from repro.ownarm.prepare import load_log

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
    np.testing.assert_allclose(saturated(dataclasses.replace(log_of(GOOD), tau=tau)).mean(axis=1), truth, atol=1e-9)
    np.testing.assert_allclose(saturated(log_of(GOOD, torque_limit=known)).mean(axis=1), truth, atol=0.002)


#: Noise of a torque sensor, 0.01 N m.
NOISE = 0.01 * np.random.default_rng(7).normal(size=GOOD.tau.shape)


def changed(**samples):
    """The good log with some torques of a joint replaced; `noise` too, unless it is False."""
    tau = GOOD.tau + NOISE
    for joint, replaced in samples.items():
        tau[int(joint[-1]) - 1] = replaced(tau[int(joint[-1]) - 1])
    return log_of(dataclasses.replace(GOOD, tau=tau))


def held_from(begin, end, value=None):
    def held(tau):
        return np.where((np.arange(tau.size) >= begin) & (np.arange(tau.size) < end), value or tau[begin], tau)

    return held


@pytest.mark.parametrize(
    ("log", "joint", "samples"),
    [
        (changed(tau1=lambda tau: np.minimum(tau, 2.5)), 1, GOOD.tau[0] + NOISE[0] >= 2.5),
        (changed(tau2=lambda tau: np.maximum(tau, -0.9)), 2, GOOD.tau[1] + NOISE[1] <= -0.9),
        (changed(tau2=held_from(1000, 1080)), 2, np.isin(np.arange(2400), np.arange(1000, 1080))),
        (changed(tau1=held_from(500, 560, 1e-9)), 1, np.isin(np.arange(2400), np.arange(500, 560))),
        (changed(tau1=held_from(1700, 2400)), 1, np.arange(2400) >= 1700),
    ],
    ids=["limit", "lower limit", "stuck", "lost", "stuck to the end"],
)
def test_a_torque_that_the_motion_contradicts_is_left_out(log, joint, samples):
    loaded = load_log(log, Arm())
    np.testing.assert_array_equal(loaded.log.left_out[joint - 1], samples)
    assert not loaded.log.left_out[2 - joint].any()
    (warning,) = (line for line in loaded.description.warnings if "leaves them out" in line)
    assert f"joint {joint} is at a limit or stuck in {samples.sum()} samples" in warning


def steps(size):
    return lambda tau: size * np.rint(tau / size)


def rarely(n):
    return lambda tau: tau[np.arange(tau.size) // n * n]


@pytest.mark.parametrize("size", [0.02, 0.1, 0.4])
def test_a_torque_in_steps_is_neither_at_a_limit_nor_stuck(size):
    assert not unreliable_torque(changed(tau1=steps(size), tau2=steps(0.5 * size))).any()


@pytest.mark.parametrize("n", [4, 20])
def test_a_torque_that_is_rarely_updated_is_neither_at_a_limit_nor_stuck(n):
    assert not unreliable_torque(changed(tau1=rarely(n), tau2=rarely(n))).any()


def test_drives_that_are_off_at_an_end_are_not_stuck():
    rest = np.arange(2400) >= 1600
    tau = np.where(rest, 0.0, GOOD.tau + NOISE)
    assert not unreliable_torque(log_of(dataclasses.replace(GOOD, tau=tau))).any()


def test_a_limit_that_acts_is_not_left_out():
    """The torque that a drive reports at its known limit is the one that moves the arm."""
    log = log_of(GOOD, torque_limit=np.array([2.5, 9.0]))
    assert saturated(log)[0].mean() > 0.05
    assert not unreliable_torque(log).any()


def test_left_out_samples_go_with_their_pieces():
    left_out = np.zeros((2, 2400), dtype=bool)
    left_out[1, 1195:1210] = True
    log = log_of(GOOD, left_out=left_out, breaks=(1200,))
    assert [piece.left_out.sum(axis=1).tolist() for piece in log.pieces] == [[0, 5], [0, 10]]
    assert uniform(log) is log
    with pytest.raises(InputError, match=r"log\.csv: left_out: found bool of shape \(2, 7\), expected bool of shape"):
        log_of(GOOD, left_out=left_out[:, :7])
