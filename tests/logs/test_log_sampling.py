"""Sampling: jitter, gaps, rounded times, encoder steps and saturation."""

import dataclasses
import re

import numpy as np
import pytest
from experiment_example import refused
from hypothesis import given, settings
from hypothesis import strategies as st
from log_example import RATE, assert_same, log_of, motion, recording
from strategies import seeds

from repro.fitting.prepare import load_log
from repro.identification.armfile import Arm
from repro.identification.log import uniform
from repro.logs.diagnostics import describe, left_out_torque
from repro.logs.torque_limits import quantisation_step, saturated, unreliable_torque

GOOD = recording()


@settings(max_examples=20)
@given(seed=seeds, jitter=st.floats(0.01, 0.4), pause=st.sampled_from([0.0, 1.2345]))
def test_jitter_is_interpolated_away_in_each_piece(seed, jitter, pause):
    rng = np.random.default_rng(seed)
    t = (np.arange(2400) + jitter * rng.uniform(-1, 1, 2400)) / RATE
    t[1000:] += pause
    log = uniform(log_of(recording(t)))
    assert len(log.pieces) == (2 if pause else 1)
    for piece in log.pieces:
        assert np.ptp(np.diff(piece.t)) < 1e-9
    np.testing.assert_allclose(log.t[1], 1 / RATE, rtol=0.1)
    truth = recording(t[0] + log.t)
    assert_same(log, dataclasses.replace(truth, t=log.t), q=2e-5, dq=1e-2, tau=0.2)
    assert np.sqrt(np.mean((log.tau - truth.tau) ** 2)) < 0.01
    assert uniform(log) is log


def test_rounded_times_are_no_jitter():
    even = recording(np.arange(3000) / 300)
    rounded = log_of(dataclasses.replace(even, t=np.round(even.t, 3)))
    log = uniform(rounded)
    assert len(log.notes) == 1 and {"0.001", "300"} <= set(log.notes[0].split())
    np.testing.assert_array_equal(log.q, even.q)
    np.testing.assert_allclose(log.t, even.t, atol=1e-4)
    assert describe(rounded, Arm()).warnings == ()


def test_a_torque_that_jumps_is_resampled_within_its_values():
    t = GOOD.t + 0.4 / RATE * np.sin(np.arange(GOOD.t.size))
    log = uniform(log_of(dataclasses.replace(recording(t), tau=np.sign(motion(t)[1]))))
    assert np.abs(log.tau).max() <= 1.0


def without(begin, end):
    return log_of(recording(np.delete(GOOD.t, slice(begin, end))))


def test_short_gaps_are_bridged_with_a_note():
    log = uniform(without(1000, 1005))
    assert any(note.startswith("5 ") for note in log.notes)
    np.testing.assert_allclose(log.t, GOOD.t, atol=1e-9)
    np.testing.assert_allclose(log.q, GOOD.q, atol=1e-5)
    gaps = dict(describe(without(1000, 1005), Arm()).facts)["gaps"]
    assert re.findall(r"\d+", gaps) == ["1", "5", "30"]  # gap, samples, ms


def test_a_long_gap_splits_the_log_and_pieces_that_are_too_short_are_left_out():
    log = uniform(without(1000, 1010))
    assert [re.findall(r"[\d.]+\d|\d", note) for note in log.notes] == [["1", "0.055", "2", "4.995", "6.945"]]
    assert_same(log, recording(np.delete(GOOD.t, slice(1000, 1010))))
    assert [piece.t.size for piece in log.pieces] == [1000, 1390]
    assert log.longest.t[0] == GOOD.t[1010]
    assert uniform(log) is log
    log = uniform(without(300, 1000))
    assert [re.findall(r"[\d.]+\d|\d", note) for note in log.notes] == [["1", "3.5", "1", "6.995", "1"]]
    assert log.breaks == ()
    np.testing.assert_allclose(log.t, GOOD.t[1000:], atol=1e-9)
    np.testing.assert_allclose(log.tau, GOOD.tau[:, 1000:], atol=1e-12)
    thin = log_of(recording(np.r_[0.0:3.0:0.02, 4.0:14.0:0.02]))
    assert uniform(thin).t.size == 500  # 150 samples are too few, though they last 3 s
    error = refused(uniform, without(300, 2000))
    assert error.place == "log.csv: time" and re.findall(r"\d+\.\d+", error.found)[:2] == ["8.5", "1.99"]


def test_samples_close_together_do_no_harm():
    r = recording(np.sort(np.r_[GOOD.t, GOOD.t[500:520] + 1e-6]))
    noisy = dataclasses.replace(r, q=np.round(r.q / 7.5e-4) * 7.5e-4)  # two readings of a step of the encoder
    log = uniform(log_of(noisy))
    assert any(note.startswith("20 samples") for note in log.notes)
    np.testing.assert_allclose(log.q, GOOD.q, atol=1e-3)


def test_rounding_of_the_last_bits_is_no_step():
    walk = 0.25 * np.cumsum(np.random.default_rng(1).integers(-2, 3, 2000))
    noise = 1e-14 * np.random.default_rng(2).standard_normal(2000)
    assert quantisation_step(walk + noise) == pytest.approx(0.25)


@pytest.mark.parametrize("limit", [1.0, 2.0, 3.0])
def test_saturation_is_measured(limit):
    limits = np.array([limit, 0.6 * limit])
    tau = np.clip(GOOD.tau.T, -limits, limits).T
    truth = np.mean(np.abs(GOOD.tau.T) >= limits, axis=0)
    known = log_of(GOOD, torque_limit=limits)
    np.testing.assert_allclose(saturated(dataclasses.replace(log_of(GOOD), tau=tau)).mean(axis=1), truth, atol=1e-9)
    np.testing.assert_allclose(saturated(known).mean(axis=1), truth, atol=0.002)


#: Torques with noise of the sensor, 0.01 N m.
NOISY = GOOD.tau + 0.01 * np.random.default_rng(7).normal(size=GOOD.tau.shape)
SAMPLE = np.arange(2400)


def with_torque(first=NOISY[0], second=NOISY[1]):
    return log_of(dataclasses.replace(GOOD, tau=np.stack([first, second])))


@pytest.mark.parametrize(
    ("log", "joint", "samples"),
    [
        (with_torque(first=np.minimum(NOISY[0], 2.5)), 1, NOISY[0] >= 2.5),
        (with_torque(second=np.maximum(NOISY[1], -0.9)), 2, NOISY[1] <= -0.9),
        (with_torque(second=np.where(SAMPLE // 80 == 12, NOISY[1, 960], NOISY[1])), 2, SAMPLE // 80 == 12),
        (with_torque(first=np.where(SAMPLE // 60 == 9, 1e-9, NOISY[0])), 1, SAMPLE // 60 == 9),
        (with_torque(first=np.where(SAMPLE >= 1700, NOISY[0, 1700], NOISY[0])), 1, SAMPLE >= 1700),
    ],
    ids=["limit", "lower limit", "stuck", "lost", "stuck to the end"],
)
def test_a_torque_that_the_motion_contradicts_is_left_out(log, joint, samples):
    loaded = load_log(log, Arm())
    np.testing.assert_array_equal(loaded.log.left_out[joint - 1], samples)
    assert not loaded.log.left_out[2 - joint].any()
    (warning,) = left_out_torque(loaded.log)
    assert {f"{joint}", f"{samples.sum()}"} <= set(warning.split()) and warning in loaded.description.warnings


def in_steps(size):
    return with_torque(size * np.rint(NOISY[0] / size), 0.5 * size * np.rint(NOISY[1] / (0.5 * size)))


@pytest.mark.parametrize(
    "log",
    [
        *map(in_steps, (0.02, 0.1, 0.4)),
        *(with_torque(*NOISY[:, SAMPLE // n * n]) for n in (4, 20)),  # updated every n samples
        with_torque(*np.where(SAMPLE >= 1600, 0.0, NOISY)),  # drives that are off at the end
        log_of(GOOD, torque_limit=np.array([2.5, 9.0])),  # a drive that reports the limit at which it acts
    ],
    ids=["steps 0.02", "steps 0.1", "steps 0.4", "updated every 4", "updated every 20", "off", "known limit"],
)
def test_a_torque_that_moves_the_arm_is_neither_at_a_limit_nor_stuck(log):
    assert not unreliable_torque(log).any()


def test_left_out_samples_go_with_their_pieces():
    left_out = np.zeros((2, 2400), dtype=bool)
    left_out[1, 1195:1210] = True
    log = log_of(GOOD, left_out=left_out, breaks=(1200,))
    assert [piece.left_out.sum(axis=1).tolist() for piece in log.pieces] == [[0, 5], [0, 10]]
    assert uniform(log) is log
    error = refused(log_of, GOOD, left_out=left_out[:, :7])
    assert error.place == "log.csv: left_out" and "(2, 7)" in error.found
