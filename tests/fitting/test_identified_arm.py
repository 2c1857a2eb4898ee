"""The identified arm predicts what its logs recorded: with terms beyond Eq. 1, and with calibration errors."""

import time

import numpy as np
import pytest
from experiment_example import refused
from hypothesis import given
from strategies import seeds

import repro
from repro.identification.extra_terms import ExtraTerm
from repro.identification.identified_arm import IdentifiedArm
from repro.identification.log import Log
from repro.model.dynamics import inverse_dynamics, regressor

BETA = np.array([0.14, 0.065, 0.028, 3.4, 1.05, 0.05, 0.03, 0.15, 0.10])
T = 0.005 * np.arange(4000)


def motion(seed=3):
    rng = np.random.default_rng(seed)
    omega = 2 * np.pi * np.array([0.15, 0.35, 0.6, 0.95])[:, np.newaxis]
    q, dq, ddq = (np.zeros((2, T.size)) for _ in range(3))
    for joint in range(2):
        size, phase = rng.uniform(0.2, 0.5, (4, 1)), rng.uniform(0, 2 * np.pi, (4, 1))
        q[joint] = (size * np.sin(omega * T + phase)).sum(0)
        dq[joint] = (size * omega * np.cos(omega * T + phase)).sum(0)
        ddq[joint] = -(size * omega**2 * np.sin(omega * T + phase)).sum(0)
    return q, dq, ddq


def off(predicted, recorded):
    """Relative RMS of each joint away from the ends."""
    inner = np.s_[:, 100:-100]
    return np.sqrt(np.mean((predicted - recorded)[inner] ** 2, 1) / np.mean(recorded[inner] ** 2, 1))


def test_friction_in_proportion_to_the_load_is_predicted():
    q, dq, ddq = motion()
    load = regressor(q, dq, ddq)[..., :5] @ BETA[:5]
    tau = inverse_dynamics(q, dq, ddq, BETA) + 0.3 * np.abs(load) * np.tanh(20.0 * dq)
    result = repro.identify(Log(t=T, q=q, tau=tau, name="loaded"), method="bounded", friction=True)
    assert {term.name for term in result.details.terms if term.taken} >= {"load1", "load2"}
    error = result.errors.query("part == 'fit'")["relative_rms"].to_numpy()
    assert (off(result.predict(q, dq, ddq), tau) < error + 0.02).all()
    assert (off(inverse_dynamics(q, dq, ddq, result.beta), tau) > 0.05).any()


def test_stribeck_friction_is_predicted_with_its_speed():
    q, dq, ddq = motion(4)
    tau = inverse_dynamics(q, dq, ddq, BETA)
    tau[0] += 0.6 * BETA[7] * np.tanh(20.0 * dq[0]) * np.exp(-((dq[0] / 0.2) ** 2))
    result = repro.identify(Log(t=T, q=q, tau=tau, name="stiction"), method="bounded")
    assert [term.name for term in result.details.terms if term.taken] == ["stribeck1"]
    assert result.details.preparation.stribeck_speed == pytest.approx(0.2)
    assert (off(result.predict(q, dq, ddq), tau) < 0.02).all()
    assert off(result.predict(q, dq, ddq), tau)[0] < 0.3 * off(inverse_dynamics(q, dq, ddq, result.beta), tau)[0]


def test_a_wrong_zero_is_predicted_as_its_log_records_it():
    q, dq, ddq = motion(5)
    tau, shifted = inverse_dynamics(q, dq, ddq, BETA), q - np.array([[0.1], [0.0]])
    result = repro.identify(Log(t=T, q=shifted, tau=tau, name="shifted"), method="bounded")
    assert "zero1" in [error.name for error in result.details.calibration_errors[0]]
    assert (off(result.predict(shifted, dq, ddq, log=0), tau) < 0.02).all()
    assert (off(result.predict(q, dq, ddq), tau) < 0.02).all()  # in the angles of Eq. 1
    assert (off(result.predict(shifted, dq, ddq), tau) > 0.03).any()
    assert refused(result.predict, q, dq, ddq, log=1).place == "log"


def test_a_torque_offset_and_a_scale_are_the_logs():
    q, dq, ddq = motion(7)
    true = inverse_dynamics(q, dq, ddq, BETA)
    tau = true * np.array([[1.0], [1.3]]) + np.array([[0.4], [0.0]])
    result = repro.identify(Log(t=T, q=q, tau=tau, name="offset"), method="bounded")
    assert {error.name for error in result.details.calibration_errors[0]} == {"offset1", "scale2"}
    assert (off(result.predict(q, dq, ddq, log=0), tau) < 0.02).all()
    assert (off(result.predict(q, dq, ddq), true) < 0.02).all()


TERMS = [
    ExtraTerm("load1", 0.21, 0.01, 0.4, True),
    ExtraTerm("load2", 0.34, 0.01, 0.3, True),
    ExtraTerm("stribeck1", 0.08, 0.01, 0.3, True),
    ExtraTerm("rotor2", 0.012, 0.001, 0.2, True),
]


@given(seeds)
def test_the_acceleration_under_a_torque_needs_that_torque(seed):
    rng = np.random.default_rng(seed)
    arm = IdentifiedArm(BETA, 20.0, TERMS, load=1.03 * BETA, stribeck_speed=0.27)
    state, tau = rng.normal(size=(2, 2)) * np.array([[1.5], [2.0]]), 3.0 * rng.normal(size=2)
    t = np.array([0.0, 1e-6])
    _, dq = arm.simulate(t, np.stack([tau, tau], axis=1), *state)
    ddq = np.diff(dq, axis=1)[:, 0] / 1e-6
    assert arm.torque(*(x[:, np.newaxis] for x in (*state, ddq)))[:, 0] == pytest.approx(tau, abs=5e-3)


def test_one_late_instant_does_not_slow_the_simulation():
    result = repro.identify(Log(t=T, q=motion()[0], tau=inverse_dynamics(*motion(), BETA)), method="bounded")
    t = np.append(0.0025 * np.arange(401), 2.0)
    began = time.process_time()
    q, _ = result.simulate(t, np.zeros((2, t.size)), [0.3, 0.0], [0.0, 0.0])
    assert time.process_time() - began < 10.0  # the steps of the longest span for all took 46 s
    assert np.isfinite(q).all()


@pytest.mark.parametrize("shape", [(2, 5), (3, 2, 5)])
def test_many_motions_at_once(shape):
    result = repro.identify(Log(t=T, q=motion()[0], tau=inverse_dynamics(*motion(), BETA)), method="bounded")
    x = np.random.default_rng(1).normal(size=(3, *shape))
    assert result.predict(*x).shape == shape
