"""The numeric experiment: a network that reads images perfectly finds the arms."""

import literal
import numpy as np
import torch
from experiment_example import changed, full_config

from repro.cnn import reader
from repro.cnn.dataset import DataSettings
from repro.cnn.image import ImageSettings
from repro.experiments.identifications import identify_arms, least_squares_of_arms, mean_training_torque
from repro.identification.algorithm1.refinement import Algorithm1, RefinementSettings
from repro.identification.algorithm1.search import SearchSettings
from repro.signals.dct import image_regressor
from repro.signals.trajectories import identification_trajectory

ARMS = {name: literal.ARMS[name] for name in ("N1", "N4")}
CONFIG = changed(full_config(), numeric={"validation_samples": 3770})
CONFIG = CONFIG.model_copy(update={"numeric": CONFIG.numeric.model_copy(update={"arms": ARMS.items()})})
SIGNALS = CONFIG.signals
AWARE = ImageSettings("constant", 4.0)


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


def identify(network):
    search, refinement = SearchSettings(executions=4, inner_limit=3), RefinementSettings(restarts=5, keep=9, passes=2)
    algorithm1 = Algorithm1("tracked", network, AWARE, search, refinement)
    tau_mean = mean_training_torque(SIGNALS, DataSettings(), 1)
    return identify_arms(algorithm1, CONFIG, tau_mean, 1)["arms"]


def test_the_mean_torque_is_that_of_the_seed_s_arms():
    first, again, other = (mean_training_torque(SIGNALS, DataSettings(), seed) for seed in (4, 4, 7))
    assert (first == again).all() and (first != other).all()


def test_a_perfect_network_finds_every_arm(monkeypatch):
    """It uses the model of the exact trajectory, so the filter's error remains."""
    monkeypatch.setattr(reader, "Reader", lambda network, v: lambda u: network(u, v[None]))
    motion = identification_trajectory(SIGNALS.duration_s, SIGNALS.sampling_period_s)
    network = PerfectNetwork(image_regressor(motion.q, motion.dq, motion.ddq, SIGNALS), AWARE.constant)
    found = identify(network)
    for name, beta in ARMS.items():
        arm = found[name]
        np.testing.assert_array_equal(arm["true"], beta)
        for method in ("algorithm1+tracked", "algorithm1+refinement+tracked"):
            # What is left is the filter's: it rounds the torque's steps, and f of the image does not. Its band 100 is
            # at 5 Hz here, and I1 of N1 is off by 0.042.
            np.testing.assert_allclose(arm["methods"][method]["beta"], beta, atol=0.05)
            assert arm["methods"][method]["similarity"] > 0.99
        assert arm["executions_over_threshold"] == 4


def test_least_squares_finds_the_arms_from_the_signals_of_algorithm_1(monkeypatch):
    seen = []

    def run(_, prepared, *streams):
        seen.append((prepared.regression, *(stream.random() for stream in streams)))
        return {}, 0

    monkeypatch.setattr(Algorithm1, "run", run)
    identify(None)
    assert len({number for _, *numbers in seen for number in numbers}) == 2 * 3  # each arm has its own streams
    found = least_squares_of_arms(CONFIG)["arms"]
    for (name, true), (r, *_numbers) in zip(ARMS.items(), seen, strict=True):
        np.testing.assert_array_equal(found[name]["true"], true)
        assert list(found[name]["methods"]) == ["least-squares", "bounded"]
        expected = np.linalg.lstsq(r.y.reshape(-1, 9), r.tau.ravel(), rcond=None)[0]
        np.testing.assert_allclose(found[name]["methods"]["least-squares"]["beta"], expected, rtol=1e-8)
        for estimate in found[name]["methods"].values():
            # The filter rounds the torque's steps, which biases least squares.
            np.testing.assert_allclose(estimate["beta"], true, atol=0.02)
