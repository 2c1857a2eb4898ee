"""The numeric experiment: scores mean what they say, and a network that reads images perfectly finds the arms."""

import numpy as np
import pytest
import torch
from experiment_example import full_config

from repro.cnn.dataset import DataSettings
from repro.cnn.image import ImageSettings
from repro.identification.algorithm1.refinement import Algorithm1, RefinementSettings
from repro.identification.algorithm1.search import SearchSettings
from repro.model.dynamics import inverse_dynamics
from repro.pipeline.identifications import (
    identify_arms,
    least_squares_of_arms,
    mean_training_torque,
    motion_of,
    score_estimates,
)
from repro.settings import signal_settings
from repro.signals.dct import image_regressor
from repro.signals.metric import MetricSettings, metr2ev
from repro.signals.trajectories import identification_trajectory

ARMS = {
    "N1": np.array([0.6590, 0.4156, 0.5578, 0.9296, 0.1349, 0.3850, 0.4875, 0.1472, 0.1044]),
    "N4": np.array([0.6944, 0.5271, 0.3408, 0.3536, 0.8523, 0.5325, 0.4714, 0.1361, 0.2451]),
}


def with_arms(arms):
    """The configuration with other numeric arms, and a short validation."""
    config = full_config()
    config["numeric"] |= {"arms": {name: beta.tolist() for name, beta in arms.items()}, "validation_samples": 3770}
    return config


CONFIG = with_arms(ARMS)
SIGNALS = signal_settings(CONFIG)
METRIC = MetricSettings()
AWARE = ImageSettings("constant", 4.0)


def run_of(seed, estimates):
    """Identification result with the given estimates of N1 by method."""
    methods = {method: {"beta": np.asarray(beta).tolist()} for method, beta in estimates.items()}
    return {"variant": "published", "seed": seed, "arms": {"N1": {"true": ARMS["N1"].tolist(), "methods": methods}}}


@pytest.mark.parametrize("factor", [0.5, 0.9, 1.3])
def test_a_common_factor_is_seen_in_time_and_not_in_frequency(factor):
    energy = MetricSettings("energy")
    scores = score_estimates([run_of(1, {"algorithm1": factor * ARMS["N1"]})], CONFIG, energy)
    np.testing.assert_allclose(scores["time"], (1 - (1 - factor) ** 2) ** 0.4, rtol=1e-9)
    np.testing.assert_allclose(scores["frequency"], 1.0, atol=1e-6)
    np.testing.assert_allclose(scores["total"], scores["time"] * scores["frequency"], rtol=1e-12)


def test_each_row_compares_the_torques_of_its_own_trajectory_seed_and_joint():
    estimate = ARMS["N1"] * np.linspace(0.97, 1.03, 9)
    scores = score_estimates([run_of(s, {"algorithm1": estimate}) for s in (1, 2)], CONFIG, METRIC)
    assert list(scores.columns) == ["case", "method", "seed", "trajectory", "joint", "time", "frequency", "total"]
    for row in scores.itertuples():
        motion = motion_of(row.trajectory, CONFIG, row.seed)
        tau, rebuilt = (inverse_dynamics(motion.q, motion.dq, motion.ddq, b) for b in (ARMS["N1"], estimate))
        expected = metr2ev(tau[row.joint - 1], rebuilt[row.joint - 1])
        assert row.time == pytest.approx(float(expected.time), rel=1e-12)
        assert row.frequency == pytest.approx(float(expected.frequency), rel=1e-12)
    on_id = scores[scores["trajectory"] == "ID"].groupby("joint")["total"].nunique()
    on_validation = scores[scores["trajectory"] == "validation"].groupby("joint")["total"].nunique()
    assert (on_id == 1).all()  # the same motion for every seed
    assert (on_validation == 2).all()


class PerfectNetwork:
    """Solves for the residual instead of having learnt it; Z1 divided by a constant shows psi to a known factor.

    alpha = Y beta_bar and 2 alpha - psi = Y beta_n are linear in what is sought.
    """

    def __init__(self, model, constant):
        self._inverse = np.linalg.pinv(model.reshape(-1, 9))
        self._constant = constant

    def __call__(self, u, v):
        alpha = v.numpy()[0, :, 0].astype(np.float64)  # (2, S)
        psi = self._constant * u.numpy()[:, :, 0].astype(np.float64)  # (n, 2, S)
        guess = (2 * alpha - psi).reshape(len(psi), -1) @ self._inverse.T
        right = self._inverse @ alpha.ravel()
        return torch.from_numpy((right - guess).astype(np.float32))


def identify(network, arms):
    search, refinement = SearchSettings(executions=4, inner_limit=3), RefinementSettings(restarts=5, keep=9, passes=2)
    algorithm1 = Algorithm1("tracked", network, AWARE, search, refinement)
    tau_mean = mean_training_torque(SIGNALS, DataSettings(), 1)
    return identify_arms(algorithm1, with_arms(arms), tau_mean, 1)["arms"]


def test_a_perfect_network_finds_every_arm():
    """It uses the model of the exact trajectory, so the filter's error remains."""
    motion = identification_trajectory(SIGNALS.duration, SIGNALS.h)
    network = PerfectNetwork(image_regressor(motion.q, motion.dq, motion.ddq, SIGNALS), AWARE.constant)
    found = identify(network, ARMS)
    for name, beta in ARMS.items():
        arm = found[name]
        np.testing.assert_array_equal(arm["true"], beta)
        for method in ("algorithm1+tracked", "algorithm1+refinement+tracked"):
            # What is left is the filter's: it rounds the torque's steps, and f of the image does not.
            np.testing.assert_allclose(arm["methods"][method]["beta"], beta, atol=0.04)
            assert arm["methods"][method]["similarity"] > 0.99
        assert arm["executions_over_threshold"] == 4


LEAST_SQUARES = least_squares_of_arms(CONFIG)["arms"]


@pytest.mark.parametrize("name", ARMS)
def test_least_squares_finds_the_arms_from_the_signals_of_algorithm_1(name, monkeypatch):
    arm = LEAST_SQUARES[name]
    np.testing.assert_array_equal(arm["true"], ARMS[name])
    assert list(arm["methods"]) == ["least-squares", "bounded"]
    seen = []
    monkeypatch.setattr(Algorithm1, "run", lambda _, prepared, *__: (seen.append(prepared.regression) or {}, 0))
    identify(None, {name: ARMS[name]})
    (r,) = seen
    expected, *_ = np.linalg.lstsq(r.y.reshape(-1, 9), r.tau.ravel(), rcond=None)
    np.testing.assert_allclose(arm["methods"]["least-squares"]["beta"], expected, rtol=1e-8)
    for estimate in arm["methods"].values():
        # The filter rounds the torque's steps, which biases least squares.
        np.testing.assert_allclose(estimate["beta"], ARMS[name], atol=0.02)
