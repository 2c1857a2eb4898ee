"""Readers without a network of Algorithm 1: generalised least squares, and how a claim stands to the truth."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from experiment_example import full_config
from scipy import stats

from repro.cnn.plain import PlainNetwork, save_posterior
from repro.files import write_tensors
from repro.identification.algorithm1.preprocessing import PreparedSignals
from repro.pipeline.experiment import read_recordings
from repro.settings import signal_settings
from repro.study.design import RANKS
from repro.study.readers import Readers, Reading

CONFIG, N = full_config(), 9


def readers(tmp_path, error_covariance, prior_mean, prior_covariance):
    training = tmp_path / "training.safetensors"
    kept = {"error_covariance": error_covariance, "prior_mean": prior_mean, "prior_covariance": prior_covariance}
    write_tensors(training, kept)
    weights = tmp_path / "posterior.safetensors"
    save_posterior(weights, PlainNetwork(100, CONFIG["study"]["posterior"]["width"]))
    return Readers(training, {"posterior": weights}, CONFIG, signal_settings(CONFIG))


def test_generalised_least_squares_is_what_statistics_says(tmp_path):
    """Against the closed form with the full covariance, in another order of operations."""
    rng, unit = np.random.default_rng(2), 1.7
    half = rng.normal(size=(200, 200))
    covariance = half @ half.T / 200 + np.eye(200)
    y, beta = rng.normal(size=(2, 100, N)), rng.normal(size=N)
    alpha = (y.reshape(-1, N) @ beta + np.linalg.cholesky(covariance) @ rng.normal(size=200)).reshape(2, 100)
    mean, spread = beta + 0.5, np.diag(np.linspace(0.01, 2.0, N))
    prepared = PreparedSignals(None, 1.0, unit, alpha, y, y)  # of which only the subsampled torque counts
    plain, with_prior = readers(tmp_path, covariance, mean, spread)._generalised(prepared)
    inverse, rows = np.linalg.inv(covariance), y.reshape(-1, N)
    information = rows.T @ inverse @ rows
    expected = np.linalg.solve(information, rows.T @ inverse @ alpha.reshape(-1))
    error = alpha.reshape(-1) - rows @ expected
    variance = error @ inverse @ error / (200 - N)
    np.testing.assert_allclose(plain.beta, unit * expected, rtol=1e-9)
    np.testing.assert_allclose(plain.covariance, unit**2 * variance * np.linalg.inv(information), rtol=1e-8)
    # The prior adds its precision, and pulls to its mean what the torque does not determine.
    precision = information / variance + np.linalg.inv(spread)
    pulled = np.linalg.solve(precision, information @ expected / variance + np.linalg.inv(spread) @ mean)
    np.testing.assert_allclose(with_prior.beta, unit * pulled, rtol=1e-8)
    assert (np.diag(with_prior.covariance) < np.diag(plain.covariance)).all()


@pytest.mark.parametrize("width", [0.4, 1.0])
def test_ranks_are_uniform_if_a_claim_is_right_and_not_if_it_is_narrow(tmp_path, width):
    """Truths are drawn from a normal distribution; its claim has a standard deviation of `width` times that."""
    rng, unit = np.random.default_rng(6), 2.5
    half = rng.normal(size=(N, N))
    covariance = half @ half.T / N + 0.1 * np.eye(N)
    judge = readers(tmp_path, np.eye(200), np.zeros(N), np.eye(N)).judge
    claims = []
    for _ in range(400):
        centre = rng.normal(size=N)
        truth = rng.multivariate_normal(centre, covariance)
        claims.append(judge(Reading("x", centre, width**2 * covariance), truth, unit, rng))
    p_each = stats.kstest([claim[RANKS[4]] for claim in claims], "uniform").pvalue
    p_together = stats.kstest([claim["nearer"] for claim in claims], "uniform").pvalue
    assert (p_each > 0.01) == (width == 1.0)
    assert (p_together > 0.01) == (width == 1.0)
    assert claims[0]["contraction"] == pytest.approx(np.mean(1.0 - width**2 * np.diag(covariance) / unit**2))


def test_samples_are_judged_as_their_distribution(tmp_path):
    judge = readers(tmp_path, np.eye(200), np.zeros(N), np.eye(N)).judge
    rng = np.random.default_rng(9)
    samples = rng.normal(3.0, 0.2, (20_000, N))
    truth = np.full(N, 3.0) + 0.2 * np.linspace(-2, 2, N)
    claim = judge(Reading("x", samples.mean(0), samples=samples), truth, 1.0, rng)
    below = [claim[name] for name in RANKS]
    np.testing.assert_allclose(below, stats.norm.cdf(np.linspace(-2, 2, N)), atol=0.02)
    assert np.isnan([*judge(Reading("x", truth), truth, 1.0, rng).values()]).all()


def test_shares_of_a_claim_do_not_depend_on_the_unit(tmp_path):
    judge = readers(tmp_path, np.eye(200), np.full(N, 0.8), np.eye(N)).judge
    truth, samples = np.linspace(0.1, 1.7, N), np.random.default_rng(8).normal(0.9, 0.5, (500, N))
    claims = [Reading("x", unit * samples.mean(0), samples=unit * samples) for unit in (1.0, 3.5)]
    one, other = (judge(c, u * truth, u, np.random.default_rng(2)) for c, u in zip(claims, (1.0, 3.5), strict=True))
    assert one == pytest.approx(other) and 0.1 < one["nearer"] < 0.9


def test_a_claim_of_the_posterior_is_in_units_of_the_torque(tmp_path):
    """At twice the torque the same image of it gives twice the parameters, with four times their covariance."""
    files = [f"data/captures/ID.{kind}" for kind in ("bin", "json")]
    (recording,) = read_recordings(map(Path, files), CONFIG)
    read = readers(tmp_path, np.eye(200), np.zeros(N), np.eye(N)).read
    strong = dataclasses.replace(recording, tau=2.0 * recording.tau)
    one, other = (
        next(found for found in read(each, False, np.random.default_rng(0)) if found.method == "posterior")
        for each in (recording, strong)
    )
    np.testing.assert_allclose(other.beta, 2.0 * one.beta, rtol=1e-4)
    np.testing.assert_allclose(other.covariance, 4.0 * one.covariance, rtol=1e-4)
