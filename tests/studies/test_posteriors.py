"""The networks that read the torque: their likelihood and draws, what they learn, and their weights on disk."""

from functools import partial

import numpy as np
import pytest
import torch
from scipy.stats import multivariate_normal, norm

from repro.cnn.dataset import DataSettings, draw_torques, sample_motion
from repro.signals.dct import SignalSettings
from repro.signals.trajectories import identification_trajectory
from repro_studies.plain import Flow, PlainNetwork, PlainSettings, load_posterior, save_posterior, train_posterior

SIGNALS = SignalSettings(sampling_period_s=0.02, image_samples=30)
SAMPLED = sample_motion(identification_trajectory(SIGNALS.duration_s, SIGNALS.sampling_period_s), SIGNALS)
DATA = DataSettings()
WIDTH = 48


def drawn(seed, n):
    alpha, beta_bar, _ = draw_torques(np.random.default_rng(seed), n, SAMPLED, DATA)
    return alpha, beta_bar


PRIOR = drawn(13, 4000)[1]
MEAN, COVARIANCE = PRIOR.mean(axis=0), np.cov(PRIOR.T)
#: What the logarithm of each network's likelihood leaves out, and the steps of its training.
NETWORKS = {
    "plain": (PlainNetwork, 0.5 * 9 * np.log(2 * np.pi), 150),
    "flow": (partial(Flow, mean=MEAN, covariance=COVARIANCE), 0.5 * np.log(np.diag(COVARIANCE)).sum(), 80),
}


def trained(kind):
    make, _, steps = NETWORKS[kind]
    return train_posterior(make, SAMPLED, DATA, PlainSettings(WIDTH, steps, batch=96, learning_rate=3e-3), 3)


@pytest.fixture(scope="module")
def flow():
    return trained("flow")


def loss(network, alpha, beta_bar):
    return float(network.loss(*(torch.from_numpy(x.reshape(len(x), -1).astype(np.float32)) for x in (alpha, beta_bar))))


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


def test_draws_of_the_flow_have_the_density_of_its_loss(flow):
    """By the change of variables, with the Jacobian of the draws by differences.

    A longer step errs by 0.2 across the knots of the splines, a shorter one by 0.01 in float32; this one by 0.005.
    """
    alpha, normal = drawn(5, 3)[0][:1], np.random.default_rng(8).standard_normal(9)
    steps = 0.004 * np.eye(9)
    ahead, behind = (flow.sample(alpha, normal + sign * steps) for sign in (1, -1))
    jacobian = (ahead - behind) / 0.008 / np.sqrt(np.diag(COVARIANCE))  # in units of the prior, as the loss is
    expected = norm.logpdf(normal).sum() - np.linalg.slogdet(jacobian)[1]
    found = -loss(flow, alpha, flow.sample(alpha, normal[np.newaxis]))
    assert found == pytest.approx(expected, abs=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("kind", NETWORKS)
def test_a_trained_network_is_likelier_than_the_prior(flow, kind):
    alpha, beta_bar = drawn(12, 600)
    network = flow if kind == "flow" else trained(kind)
    of_prior = multivariate_normal(MEAN, COVARIANCE).logpdf(beta_bar).mean() + NETWORKS[kind][1]
    assert -loss(network, alpha, beta_bar) > of_prior + 3.0


def test_the_first_step_of_a_weight_is_the_learning_rate():
    one = (PlainSettings(width=8, steps=1, batch=16, learning_rate=rate) for rate in (0.0, 1e-3))
    before, after = (train_posterior(PlainNetwork, SAMPLED, DATA, each, 1).parameters() for each in one)
    longest = max(float((a - b).abs().max()) for a, b in zip(before, after, strict=True))
    assert longest == pytest.approx(1e-3, rel=1e-2)


def test_weights_come_back_from_disk(tmp_path, flow):
    """Also the range of the splines, which is no weight."""
    save_posterior(tmp_path / "flow.safetensors", flow)
    again = load_posterior(tmp_path / "flow.safetensors", Flow(SIGNALS.image_samples, WIDTH, np.zeros(9), np.eye(9)))
    normal = np.random.default_rng(1).standard_normal((4, 9))
    for torque in drawn(2, 3)[0]:
        np.testing.assert_array_equal(again.sample(torque, normal), flow.sample(torque, normal))
    assert not any(weight.requires_grad for weight in again.parameters())
