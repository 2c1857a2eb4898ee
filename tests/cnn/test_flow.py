"""The flow that reads the torque: density and draws belong together, what it learns, its weights on disk."""

from functools import partial

import numpy as np
import pytest
import torch
from scipy.stats import multivariate_normal, norm

from repro.cnn.dataset import DataSettings, draw_torques, sample_motion
from repro.cnn.flow import Flow
from repro.cnn.plain import PlainSettings, load_posterior, save_posterior, train_posterior
from repro.signals.dct import SignalSettings
from repro.signals.trajectories import identification_trajectory

SIGNALS = SignalSettings(h=0.02, samples=30)
SAMPLED = sample_motion(identification_trajectory(SIGNALS.duration, SIGNALS.h), SIGNALS)
QUICK = PlainSettings(width=48, steps=150, batch=96, learning_rate=3e-3)
DATA = DataSettings()


def drawn(seed, n):
    alpha, beta_bar, _ = draw_torques(np.random.default_rng(seed), n, SAMPLED, DATA)
    return alpha, beta_bar


PRIOR = drawn(13, 4000)[1]
MOMENTS = (PRIOR.mean(axis=0), np.cov(PRIOR.T))


@pytest.fixture(scope="module")
def trained():
    mean, covariance = MOMENTS
    return train_posterior(partial(Flow, mean=mean, covariance=covariance), SAMPLED, DATA, QUICK, 3)


def test_draws_have_the_density_of_the_loss(trained):
    """By the change of variables, with the Jacobian of the draws by differences."""
    (alpha, *_), normal = drawn(5, 3)[0], np.random.default_rng(8).standard_normal(9)
    steps = 0.02 * np.eye(9)
    ahead, behind = (trained.sample(alpha, normal + sign * steps) for sign in (1, -1))
    jacobian = (ahead - behind) / 0.04 / np.sqrt(np.diag(MOMENTS[1]))  # in units of the prior, as the loss is
    expected = norm.logpdf(normal).sum() - np.linalg.slogdet(jacobian)[1]
    point = torch.from_numpy(trained.sample(alpha, normal[np.newaxis]).astype(np.float32))
    found = -float(trained.loss(torch.from_numpy(alpha.reshape(1, -1).astype(np.float32)), point))
    assert found == pytest.approx(expected, abs=0.05)


def test_its_likelihood_is_above_that_of_the_prior(trained):
    alpha, beta_bar = drawn(12, 600)
    torques = torch.from_numpy(alpha.reshape(600, -1).astype(np.float32))
    found = float(trained.loss(torques, torch.from_numpy(beta_bar.astype(np.float32))))
    of_prior = multivariate_normal(*MOMENTS).logpdf(beta_bar).mean() + 0.5 * np.log(np.diag(MOMENTS[1])).sum()
    assert found < -of_prior - 3.0


def test_weights_come_back_from_disk(tmp_path, trained):
    save_posterior(tmp_path / "flow.safetensors", trained)
    new = Flow(SIGNALS.samples, QUICK.width, np.zeros(9), np.eye(9))
    again = load_posterior(tmp_path / "flow.safetensors", new)
    normal = np.random.default_rng(1).standard_normal((4, 9))
    for torque in drawn(2, 3)[0]:
        np.testing.assert_array_equal(again.sample(torque, normal), trained.sample(torque, normal))
    assert not any(weight.requires_grad for weight in again.parameters())
