"""Long logs are fitted at a lower rate, and nothing but the cost changes."""

from dataclasses import replace

import numpy as np
import pytest
from fitting_problem import ARM, problem_of_logs, solved
from log_example import BETA, motion

from repro.fitting.evaluate import synthetic_log
from repro.fitting.prepare import load_log
from repro.identification import decimation
from repro.identification.decimation import decimated
from repro.identification.filtering import FilterSettings, estimate_delay
from repro.identification.log import Log, period, recorded_period
from repro.model.dynamics import inverse_dynamics

STEP, NOISE = 2.0 * np.pi / 8192, 0.03  # of the encoder, rad, and of the torque, N m


def ramp(n, rate, **changes):
    t = np.arange(n) / rate
    return Log(t=t, q=np.stack([t, -2.0 * t]), tau=np.stack([3.0 * t, np.ones(n)]), dq=np.ones((2, n)), **changes)


def noisy(rate, seconds, seed=0, late=0.0):
    """A log of the known arm with an encoder and torque noise; the torque is recorded so much before it acts."""
    rng, t = np.random.default_rng(seed), np.arange(round(seconds * rate)) / rate
    q, tau = motion(t)[0], inverse_dynamics(*motion(t + late), BETA)
    return Log(t=t, q=STEP * np.rint(q / STEP), tau=tau + NOISE * rng.normal(size=q.shape), name="long.csv")


@pytest.mark.parametrize(
    ("n", "rate", "block"),
    [
        (100_000, 10_000.0, 1),
        (100_001, 10_000.0, 50),
        (100_001, 1000.0, 5),
        (1_000_000, 1000.0, 10),
        (1_000_000, 250.0, 2),
        (200_001, 199.0, 1),
    ],
)
def test_the_rate_is_200_hz_or_100_hz_of_more_samples(n, rate, block):
    log = ramp(n, rate)
    short = decimated(log)
    assert (short is log) == (block == 1)
    assert (short.block, short.t.size) == (block, n // block)
    assert len(short.notes) == (block > 1)
    assert recorded_period(short) == pytest.approx(1.0 / rate)
    assert period(short) == pytest.approx(block / rate)


def test_samples_are_means_at_the_middle_of_their_blocks(monkeypatch):
    monkeypatch.setattr(decimation, "MAX_SAMPLES", 1000)
    wrong = np.zeros((2, 4003), dtype=bool)
    wrong[0, 1001], wrong[1, 3000:3003] = True, True
    short = decimated(ramp(4003, 1000.0, breaks=(2002,), left_out=wrong))
    assert short.breaks == (400,)  # 2 and 1 samples at the ends of the pieces are left out
    assert short.t[:2] == pytest.approx([0.002, 0.007]) and short.t[400] == pytest.approx(2.004)
    assert short.q == pytest.approx(np.stack([short.t, -2.0 * short.t]))
    assert short.tau[0] == pytest.approx(3.0 * short.t)
    assert short.dq == pytest.approx(np.ones((2, 800)))
    assert np.argwhere(short.left_out).tolist() == [[0, 200], [1, 599], [1, 600]]


def test_white_noise_stays_white(monkeypatch):
    monkeypatch.setattr(decimation, "MAX_SAMPLES", 1000)
    noise = np.random.default_rng(3).normal(size=(2, 200_000))
    short = decimated(replace(ramp(200_000, 1000.0), tau=noise))
    assert short.block == 10
    assert np.std(short.tau) == pytest.approx(10**-0.5, rel=0.02)
    assert abs(np.corrcoef(short.tau[0, :-1], short.tau[0, 1:])[0, 1]) < 0.03


@pytest.mark.parametrize(("rate", "seconds"), [(1000.0, 40.0), (3000.0, 16.0)])
def test_estimates_and_intervals_are_those_of_all_samples(monkeypatch, rate, seconds):
    ratios, errors, inside = [], [], []
    for seed in range(2):
        log = noisy(rate, seconds, seed)
        results = []
        for most in (10**9, 2000):
            monkeypatch.setattr(decimation, "MAX_SAMPLES", most)
            result, _ = solved(problem_of_logs(load_log(log, ARM)))
            results.append(result)
        assert "means of" in " ".join(results[1].log.notes) and results[1].log.facts == results[0].log.facts
        whole, short = (r.methods[0].parameters for r in results)
        half_width = [0.5 * (p.high - p.low) for p in whole]
        errors += [abs(a.estimate - b.estimate) / w for a, b, w in zip(whole, short, half_width, strict=True)]
        ratios += [0.5 * (p.high - p.low) / w for p, w in zip(short, half_width, strict=True)]
        inside += [p.low <= true <= p.high for p, true in zip(short, BETA, strict=True)]
        scores = np.array([r.methods[0].fit.relative_rms for r in results])
        assert scores[1] == pytest.approx(scores[0], rel=0.1)
    assert max(errors) < 0.5
    assert 0.9 < np.median(ratios) < 1.15
    assert np.mean(inside) >= 0.9


def test_a_delay_of_recorded_samples_is_expected_and_no_longer_one():
    """Two periods of 1 ms are expected of a drive without evidence, not two of 5 ms."""
    log = decimated(noisy(1000.0, 101.0))
    assert log.block == 5
    disturbed = replace(log, tau=log.tau + 0.5 * np.sin(40.0 * log.q))  # outweighs a delay of one of the means
    delay, _ = estimate_delay(replace(disturbed, tau=np.roll(disturbed.tau, -1, axis=1)), FilterSettings())
    assert delay == pytest.approx(0.002)


def test_a_log_above_the_limit_is_tested_on_itself_in_pieces():
    log = noisy(1000.0, 110.0)
    used = (log.t < 70.0) | (log.t > 71.0)
    cut = replace(log, t=log.t[used], q=log.q[:, used], tau=log.tau[:, used])
    (ready,) = problem_of_logs(load_log(cut, ARM)).logs
    assert [piece.t.size for piece in ready.loaded.log.pieces] == [14_000, 7799]
    synthetic = synthetic_log(ready, BETA, np.random.default_rng(0))
    assert synthetic.log.t.size == 14_000
    inside = slice(400, -400)
    assert synthetic.log.q[:, inside] == pytest.approx(ready.loaded.log.pieces[0].q[:, inside], abs=5.0 * STEP)


@pytest.mark.parametrize(("limit", "doubted"), [(1.0, True), (10.0, False)])
def test_the_limit_of_a_torque_is_that_of_the_recorded_samples(monkeypatch, limit, doubted):
    """A controller answers noise with torques of which six in ten are at the limit; a mean is hardly ever there."""
    monkeypatch.setattr(decimation, "MAX_SAMPLES", 2000)
    log = noisy(1000.0, 40.0)
    noise = np.array([[0.1], [1.8]]) * np.random.default_rng(4).normal(size=log.q.shape)
    tau = np.clip(log.tau + noise, [[-50.0], [-1.0]], [[50.0], [1.0]])
    log = replace(log, tau=tau, torque_limit=np.array([100.0, limit]))
    (ready,) = problem_of_logs(load_log(log, ARM)).logs
    assert ready.loaded.log.block == 10
    assert bool(ready.doubt) == doubted
