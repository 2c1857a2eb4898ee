"""Methods of the study without a network of Algorithm 1, and their claimed distributions compared with the truth."""

import dataclasses
from unittest.mock import Mock

import numpy as np
import pytest
from experiment_example import CAPTURES, MOTIONS, changed, full_config
from scipy import stats

from repro.cnn.priors import ListedPrior
from repro.experiments.arm import Recording, read_recordings, true_parameters
from repro.files import read_tensors, write_tensors
from repro.identification.algorithm1.preprocessing import PreparedSignals
from repro.signals.dct import dct2sub
from repro.streams import Stream, stream
from repro_studies.arms import Specimen, draw_law, excitation_program
from repro_studies.design import ALGORITHM1, RANKS
from repro_studies.methods import MethodEstimate, Methods, make_arms, run_job, train_reader
from repro_studies.plain import PlainNetwork, save_posterior

CONFIG, N = full_config(), 9


def methods(tmp_path, *kept):
    training, weights = tmp_path / "training.safetensors", tmp_path / "posterior.safetensors"
    write_tensors(training, dict(zip(("error_covariance", "prior_mean", "prior_covariance"), kept, strict=True)))
    save_posterior(weights, PlainNetwork(100, CONFIG.study.posterior.width))
    return Methods(training, {"posterior": weights}, CONFIG, CONFIG.signals)


def test_generalised_least_squares_is_what_statistics_says(tmp_path):
    """Against the closed form with the full covariance, in another order of operations."""
    rng, unit = np.random.default_rng(2), 1.7
    half = rng.normal(size=(200, 200))
    covariance = half @ half.T / 200 + np.eye(200)
    y, beta = rng.normal(size=(2, 100, N)), rng.normal(size=N)
    alpha = (y.reshape(-1, N) @ beta + np.linalg.cholesky(covariance) @ rng.normal(size=200)).reshape(2, 100)
    mean, spread = beta + 0.5, np.diag(np.linspace(0.01, 2.0, N))
    prepared = PreparedSignals(None, 1.0, unit, alpha, y, y)  # of which only the subsampled torque counts
    plain, with_prior = methods(tmp_path, covariance, mean, spread)._generalised(prepared)
    inverse, rows, torque = np.linalg.inv(covariance), y.reshape(-1, N), alpha.reshape(-1)
    information = rows.T @ inverse @ rows
    expected = np.linalg.solve(information, rows.T @ inverse @ torque)
    error = torque - rows @ expected
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
    judge = methods(tmp_path, np.eye(200), np.zeros(N), np.eye(N)).judge
    centres = rng.normal(size=(400, N))
    truths = centres + rng.multivariate_normal(np.zeros(N), covariance, 400)
    estimates = [MethodEstimate("x", centre, width**2 * covariance) for centre in centres]
    claims = [judge(estimate, truth, unit, rng) for estimate, truth in zip(estimates, truths, strict=True)]
    for share in (RANKS[4], "nearer"):
        assert (stats.kstest([claim[share] for claim in claims], "uniform").pvalue > 0.01) == (width == 1.0)
    assert claims[0]["contraction"] == pytest.approx(np.mean(1.0 - width**2 * np.diag(covariance) / unit**2))


def test_samples_are_judged_as_their_distribution(tmp_path):
    judge = methods(tmp_path, np.eye(200), np.zeros(N), np.eye(N)).judge
    rng = np.random.default_rng(9)
    samples = rng.normal(3.0, 0.2, (20_000, N))
    truth = np.full(N, 3.0) + 0.2 * np.linspace(-2, 2, N)
    claim = judge(MethodEstimate("x", samples.mean(0), samples=samples), truth, 1.0, rng)
    below = [claim[name] for name in RANKS]
    np.testing.assert_allclose(below, stats.norm.cdf(np.linspace(-2, 2, N)), atol=0.02)
    assert np.isnan([*judge(MethodEstimate("x", truth), truth, 1.0, rng).values()]).all()


def test_shares_of_a_claim_do_not_depend_on_the_unit(tmp_path):
    judge = methods(tmp_path, np.eye(200), np.full(N, 0.8), np.eye(N)).judge
    truth, samples = np.linspace(0.1, 1.7, N), np.random.default_rng(8).normal(0.9, 0.5, (500, N))
    claims = {unit: MethodEstimate("x", unit * samples.mean(0), samples=unit * samples) for unit in (1.0, 3.5)}
    one, other = (judge(claim, u * truth, u, np.random.default_rng(2)) for u, claim in claims.items())
    assert one == pytest.approx(other) and 0.1 < one["nearer"] < 0.9


def test_a_claim_of_the_posterior_is_in_units_of_the_torque(tmp_path):
    """At twice the torque the same image of it gives twice the parameters, with four times their covariance."""
    (recording,) = read_recordings([CAPTURES / "ID.bin"], CONFIG)
    estimate = methods(tmp_path, np.eye(200), np.zeros(N), np.eye(N)).estimate
    strong = dataclasses.replace(recording, tau=2.0 * recording.tau)
    by_method = ({each.method: each for each in estimate(r, False, None)} for r in (recording, strong))
    one, other = (estimates["posterior"] for estimates in by_method)
    np.testing.assert_allclose(other.beta, 2.0 * one.beta, rtol=1e-4)
    np.testing.assert_allclose(other.covariance, 4.0 * one.covariance, rtol=1e-4)


def test_generalised_least_squares_and_the_posterior_learn_from_the_same_torques(tmp_path, monkeypatch):
    """Noise alone makes white errors, delays errors that follow the torque's rate, ripple a larger largest torque."""
    program, law, kept = (
        excitation_program(CONFIG, "eq10"),
        draw_law("narrow", np.random.default_rng(3), 30, CONFIG),
        [],
    )
    ideal = [Recording(program, program.q, np.zeros_like(program.q))] * 5
    monkeypatch.setattr("repro_studies.methods.record", Mock(return_value=ideal))
    monkeypatch.setattr("repro_studies.methods.choose", Mock())
    monkeypatch.setattr("repro_studies.methods.read_choice", Mock(return_value=(program, {"law/narrow": law})))
    for ripple, noise, delay in ((0.0, 0.02, 0.0), (0.0, 0.002, 0.01), (0.5, 0.0, 0.0)):
        effects = {"stribeck": 0.0, "ripple": ripple, "noise": noise, "delay_s": delay}
        study = {"excitations": ["eq10"], "priors": ["narrow"], "training_arms": 5, "unmodelled": effects}
        make_arms(tmp_path, [tmp_path / "training.safetensors"], changed(CONFIG, study=study))
        kept.append(read_tensors(tmp_path / "training.safetensors", "training")[0])
    white, delayed, _ = (one["error_covariance"] for one in kept)
    np.testing.assert_allclose(white, np.eye(200), atol=0.1)
    assert np.trace(delayed) == pytest.approx(200.0)
    commonest = np.linalg.eigh(delayed)[1][:, -1]
    columns = (kept[1][name].mean(axis=0) @ law.mean(axis=0) for name in ("unmodelled/rate", "tracked/torque"))
    rate, torque = (abs(commonest @ x.reshape(-1)) / np.linalg.norm(x) for x in columns)
    assert rate > 0.9 > torque
    assert (kept[0]["prior_mean"] > 1.1 * kept[2]["prior_mean"]).all()  # in units of the largest torque


def test_networks_of_algorithm_1_learn_the_listed_arms_with_the_seed_of_the_study(tmp_path, monkeypatch):
    training, config, rng = tmp_path / "training.safetensors", changed(CONFIG, study={"seed": 7}), np.random.default_rng
    arms = draw_law("narrow", rng(3), 50, config)
    write_tensors(training, {f"ideal/{name}": np.zeros((2, 100, N)) for name in ("torque", "model")} | {"arms": arms})
    monkeypatch.setattr("repro_studies.methods.train", train := Mock(return_value=(None, None)))
    monkeypatch.setattr("repro_studies.methods.save_network", Mock())
    train_reader(ALGORITHM1, "eq10", "narrow", training, tmp_path, str(tmp_path / "none"), config)
    _, data, _, settings, *_ = train.call_args.args
    found = data.prior(rng(4), 2000)
    np.testing.assert_array_equal(np.unique(found, axis=0), np.unique(arms, axis=0))
    other = dataclasses.replace(data, prior=ListedPrior(arms[1:]))
    assert repr(data) != repr(other)  # of the fingerprint of a training
    assert settings.seed == 7


def test_a_claim_is_judged_in_the_unit_of_the_prior_with_random_numbers_of_its_own(monkeypatch):
    recordings = read_recordings([CAPTURES / f"{name}.bin" for name in MOTIONS], CONFIG)
    methods, arm = Mock(**{"estimate.return_value": [], "judge.return_value": {}}), true_parameters(CONFIG)
    values = methods, [Specimen(1, {"arm": 0}, arm, recordings)]
    for name, value in zip(("Methods", "specimens"), values, strict=True):
        monkeypatch.setattr(f"repro_studies.methods.{name}", Mock(return_value=value))
    run_job("eq10-narrow-0", None, None, [], CONFIG)
    *_, unit, rng = methods.judge.call_args.args
    assert unit == np.abs(dct2sub(recordings[0].regression(CONFIG.signals).tau, 100)).max()
    assert rng.random() == stream(1, Stream.STUDY_SEARCH, 1, 0).random()
