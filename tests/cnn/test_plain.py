"""The plain network that reads the torque: its likelihood, what it learns, and its weights on disk."""

import numpy as np
import pytest
import torch
from scipy.stats import multivariate_normal

from repro.cnn.dataset import DataSettings, UnmodelledSettings, draw_samples, draw_torques, sample_motion
from repro.cnn.plain import (
    PlainNetwork,
    PlainSettings,
    load_plain,
    negative_log_likelihood,
    read_torque,
    save_plain,
    train_plain,
)
from repro.errors import InputError
from repro.model.dynamics import inverse_dynamics
from repro.signals.sampling import SignalSettings
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
    return train_plain(SAMPLED, DATA, QUICK, seed=3)


def test_the_loss_is_the_likelihood_of_a_normal_distribution():
    rng, n = np.random.default_rng(1), 7
    mean, beta = rng.normal(size=(2, n, 9))
    factor = np.tril(rng.normal(size=(n, 9, 9)), -1) + np.eye(9) * rng.uniform(0.5, 3.0, (n, 9, 1))
    covariance = np.linalg.inv(factor @ factor.transpose(0, 2, 1))
    expected = [-multivariate_normal(m, c).logpdf(b) for m, c, b in zip(mean, covariance, beta, strict=True)]
    found = negative_log_likelihood(*(torch.from_numpy(x) for x in (mean, factor, beta)))
    constant = 0.5 * 9 * np.log(2 * np.pi)
    assert float(found) + constant == pytest.approx(np.mean(expected), rel=1e-9)


def test_every_output_is_a_distribution():
    """The factor of the precision is lower triangular with a positive diagonal, whatever the weights."""
    torch.manual_seed(0)
    network = PlainNetwork(30, 16)
    with torch.no_grad():
        for weight in network.parameters():
            weight.normal_(0.0, 0.5)
        mean, factor = network(torch.randn(50, 60))
    assert mean.shape == (50, 9)
    assert factor.shape == (50, 9, 9)
    assert (torch.triu(factor, 1) == 0).all()
    assert (torch.diagonal(factor, dim1=1, dim2=2) > 0).all()
    assert factor[:, 5, 2].std() > 0.1  # it depends on the torque


def test_torques_are_those_of_eq_1_over_their_largest_magnitude():
    alpha, beta_bar = drawn(5, 20)
    assert alpha.shape == (20, 2, 30)
    np.testing.assert_allclose(np.abs(alpha).max((1, 2)), 1.0, rtol=1e-12)
    np.testing.assert_allclose(np.einsum("jmp,np->njm", SAMPLED.torque, beta_bar), alpha, atol=1e-12)


def test_the_image_cnn_learns_from_the_same_torques():
    """Samples of images are drawn from the same arms: the factor v of an image holds alpha."""
    alpha, beta_bar = drawn(5, 20)
    samples = draw_samples(np.random.default_rng(5), 20, SAMPLED, DATA)
    of_image = samples.v[:, :, 0] / np.abs(samples.v[:, :, 0]).max((1, 2), keepdims=True)
    np.testing.assert_allclose(of_image, alpha, atol=1e-5)
    assert samples.residual.shape == beta_bar.shape


def test_noise_is_on_the_torque_alone():
    noisy = DataSettings(unmodelled=UnmodelledSettings(noise=0.05))
    motion = sample_motion(MOTION, SIGNALS, unmodelled=True)
    alpha, beta_bar, _ = draw_torques(np.random.default_rng(5), 200, motion, noisy)
    rest = alpha - np.einsum("jmp,np->njm", motion.torque, beta_bar)
    assert 0.005 < rest.std() < 0.05  # each torque draws its level from zero to 0.05
    np.testing.assert_allclose(np.abs(alpha).max((1, 2)), 1.0, rtol=1e-12)


@pytest.mark.slow
def test_it_learns_what_the_prior_does_not_know(trained):
    """A short training reads every parameter of unseen arms better than the mean of the prior does."""
    alpha, beta_bar = drawn(11, 600)
    found = np.stack([read_torque(trained, a) for a in alpha])
    known = np.sqrt(np.mean((found - beta_bar) ** 2, axis=0))
    prior = beta_bar.std(axis=0)
    assert (known < prior).all()
    assert np.median(known / prior) < 0.75


@pytest.mark.slow
def test_its_likelihood_is_above_that_of_the_prior(trained):
    alpha, beta_bar = drawn(12, 600)
    with torch.no_grad():
        mean, factor = trained(torch.from_numpy(alpha.reshape(600, -1).astype(np.float32)))
        found = float(negative_log_likelihood(mean, factor, torch.from_numpy(beta_bar.astype(np.float32))))
    _, training = drawn(13, 4000)
    of_prior = multivariate_normal(training.mean(0), np.cov(training.T)).logpdf(beta_bar)
    prior = -of_prior.mean() - 0.5 * 9 * np.log(2 * np.pi)
    assert found < prior - 3.0


@pytest.mark.slow
def test_the_scale_of_a_torque_is_left_to_its_reader(trained):
    """An arm of twice the torque has the same alpha, and so the same parameters over the largest torque."""
    beta = np.array([0.12, 0.0026, 0.0227, 0.95, 0.078, 0.08, 0.0036, 0.45, 0.31])
    estimates = []
    for strength in (1.0, 2.0):
        tau = SAMPLED.torque @ (strength * beta)
        largest = np.abs(inverse_dynamics(MOTION.q, MOTION.dq, MOTION.ddq, strength * beta)).max()
        estimates.append(read_torque(trained, tau / np.abs(tau).max()) * largest)
    np.testing.assert_allclose(estimates[1], 2.0 * estimates[0], rtol=1e-5)
    assert estimates[0].dtype == np.float64


def test_the_seed_decides_the_network():
    brief = PlainSettings(width=8, steps=3, batch=16)
    first, again, other = (train_plain(SAMPLED, DATA, brief, seed).state_dict() for seed in (1, 1, 2))
    for name, weight in first.items():
        assert torch.equal(weight, again[name])
    assert any(not torch.equal(weight, other[name]) for name, weight in first.items())


def test_progress_is_reported_every_fifty_steps():
    told = []
    train_plain(SAMPLED, DATA, PlainSettings(width=4, steps=100, batch=4), 1, lambda *step: told.append(step))
    assert told == [(50, 100), (100, 100)]


def test_weights_come_back_from_disk(tmp_path):
    brief = PlainSettings(width=8, steps=3, batch=16)
    network = train_plain(SAMPLED, DATA, brief, 1)
    save_plain(tmp_path / "plain.safetensors", network)
    again = load_plain(tmp_path / "plain.safetensors", SIGNALS.samples, brief)
    alpha, _ = drawn(2, 5)
    for torque in alpha:
        np.testing.assert_array_equal(read_torque(again, torque), read_torque(network, torque))
    assert not any(weight.requires_grad for weight in again.parameters())


@pytest.mark.parametrize("content", [None, b"", b"not weights at all" * 40], ids=["missing", "empty", "something else"])
def test_weights_that_cannot_be_read_are_refused_in_one_line(tmp_path, content):
    path = tmp_path / "plain.safetensors"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError, match=r"weights of `save_plain`") as error:
        load_plain(path, SIGNALS.samples, QUICK)
    assert str(error.value).startswith(str(path))
    assert "\n" not in str(error.value)
