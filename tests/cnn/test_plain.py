"""The plain network that reads the torque: its likelihood, what it learns, and its weights on disk."""

import numpy as np
import pytest
import torch
from scipy.stats import multivariate_normal

from repro.cnn.dataset import DataSettings, draw_torques, sample_motion
from repro.cnn.plain import (
    PlainNetwork,
    PlainSettings,
    load_posterior,
    read_torque,
    save_posterior,
    train_posterior,
)
from repro.signals.dct import SignalSettings
from repro.signals.trajectories import identification_trajectory

SIGNALS = SignalSettings(h=0.02, samples=30)
MOTION = identification_trajectory(SIGNALS.duration, SIGNALS.h)
SAMPLED = sample_motion(MOTION, SIGNALS)
QUICK = PlainSettings(width=48, steps=300, batch=96, learning_rate=3e-3)
DATA = DataSettings()


def drawn(seed, n, data=DATA):
    alpha, beta_bar, _ = draw_torques(np.random.default_rng(seed), n, SAMPLED, data)
    return alpha, beta_bar


@pytest.fixture(scope="module")
def trained():
    return train_posterior(PlainNetwork, SAMPLED, DATA, QUICK, seed=3)


def test_the_loss_is_the_likelihood_of_a_normal_distribution():
    rng, n = np.random.default_rng(1), 7
    mean, beta = rng.normal(size=(2, n, 9))
    factor = np.tril(rng.normal(size=(n, 9, 9)), -1) + np.eye(9) * rng.uniform(0.5, 3.0, (n, 9, 1))
    covariance = np.linalg.inv(factor @ factor.transpose(0, 2, 1))
    expected = [-multivariate_normal(m, c).logpdf(b) for m, c, b in zip(mean, covariance, beta, strict=True)]
    claimed = (torch.from_numpy(mean), torch.from_numpy(factor))
    found = PlainNetwork.loss(lambda _: claimed, torch.zeros(n, 200), torch.from_numpy(beta))
    constant = 0.5 * 9 * np.log(2 * np.pi)
    assert float(found) + constant == pytest.approx(np.mean(expected), rel=1e-9)


@pytest.mark.slow
def test_its_likelihood_is_above_that_of_the_prior(trained):
    alpha, beta_bar = drawn(12, 600)
    with torch.no_grad():
        torques = torch.from_numpy(alpha.reshape(600, -1).astype(np.float32))
        found = float(trained.loss(torques, torch.from_numpy(beta_bar.astype(np.float32))))
    _, training = drawn(13, 4000)
    of_prior = multivariate_normal(training.mean(0), np.cov(training.T)).logpdf(beta_bar)
    prior = -of_prior.mean() - 0.5 * 9 * np.log(2 * np.pi)
    assert found < prior - 3.0


def test_the_first_step_of_a_weight_is_the_learning_rate():
    one = (PlainSettings(width=8, steps=1, batch=16, learning_rate=rate) for rate in (0.0, 1e-3))
    before, after = (train_posterior(PlainNetwork, SAMPLED, DATA, each, 1).parameters() for each in one)
    longest = max(float((a - b).abs().max()) for a, b in zip(before, after, strict=True))
    assert longest == pytest.approx(1e-3, rel=1e-2)


def test_weights_come_back_from_disk(tmp_path):
    brief = PlainSettings(width=8, steps=3, batch=16)
    network = train_posterior(PlainNetwork, SAMPLED, DATA, brief, 1)
    save_posterior(tmp_path / "plain.safetensors", network)
    again = load_posterior(tmp_path / "plain.safetensors", PlainNetwork(SIGNALS.samples, brief.width))
    alpha, _ = drawn(2, 5)
    for torque in alpha:
        np.testing.assert_array_equal(read_torque(again, torque)[0], read_torque(network, torque)[0])
    assert not any(weight.requires_grad for weight in again.parameters())
