"""The network looking at one torque: lines 17 to 21 of Algorithm 1 for many guesses."""

from dataclasses import replace

import literal
import numpy as np
import pytest

from repro.cnn.image import SCALES, ImageSettings
from repro.identification.algorithm1.preprocessing import filtered, prepare
from repro.identification.algorithm1.search import ResidualEstimator
from repro.model.dynamics import inverse_dynamics
from repro.signals.sampling import SignalSettings
from repro.signals.trajectories import identification_trajectory

SIGNALS = SignalSettings(h=0.02, samples=literal.SMALL.image_size)
MOTION = identification_trajectory(SIGNALS.duration, SIGNALS.h)
TAU = inverse_dynamics(MOTION.q, MOTION.dq, MOTION.ddq, literal.ARMS["N4"])
PREPARED = prepare(filtered(MOTION.q, TAU, SIGNALS), np.ones_like(TAU), SIGNALS)
GUESSES = np.random.default_rng(0).uniform(1e-3, 3.0, (20, 9))


def reader(scale="shared-max", prepared=PREPARED, batch=100):
    return ResidualEstimator(literal.untrained(), ImageSettings(scale), prepared, batch)


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("normalise", [False, True])
def test_estimates_are_those_of_single_images_and_the_plain_network(scale, normalise):
    prepared = prepare(
        filtered(MOTION.q, TAU, replace(SIGNALS, normalise_motion=normalise)),
        np.ones_like(TAU),
        replace(SIGNALS, normalise_motion=normalise),
    )
    found = reader(scale, prepared).estimate(GUESSES)
    motion = [
        literal.subsample(x, SIGNALS.samples)
        for x in (prepared.regression.q, prepared.regression.dq, prepared.regression.ddq)
    ]
    if normalise:
        motion = [x / np.abs(x).max(1, keepdims=True) for x in motion]
    plain = literal.plain_twin(literal.untrained())
    for guess, estimate in zip(GUESSES, found, strict=True):
        r = literal.read(plain, literal.guess_image(PREPARED.alpha, motion, guess, scale))
        np.testing.assert_allclose(estimate, guess + r, rtol=0, atol=1e-5 * max(1.0, np.abs(r).max()))
    assert found.dtype == np.float64


@pytest.mark.parametrize("batch", [1, 7, 20, 1000])
def test_size_of_the_batches_does_not_matter(batch):
    np.testing.assert_allclose(reader(batch=batch).estimate(GUESSES), reader().estimate(GUESSES), rtol=0, atol=1e-5)


def test_images_are_counted():
    ours = reader(batch=7)
    assert ours.images == 0
    ours.estimate(GUESSES)
    ours.estimate(GUESSES[:3])
    assert ours.images == 23


def test_no_guesses_give_no_estimates():
    ours = reader()
    assert ours.estimate(np.empty((0, 9))).shape == (0, 9)
    assert ours.images == 0


def test_estimate_leaves_the_guesses_alone():
    before = GUESSES.copy()
    reader().estimate(GUESSES)
    np.testing.assert_array_equal(GUESSES, before)
