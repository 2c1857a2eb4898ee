"""Least squares against NumPy's on a regressor that pinocchio builds."""

import numpy as np
import pinocchio as pin
import pytest
from experiment_example import CAPTURES, full_config
from hypothesis import given, settings
from strategies import seeds

from repro.identification.solve import solve
from repro.model.dynamics import regressor
from repro.model.parameters import STANDARD_GRAVITY
from repro.pipeline.recordings import read_recording
from repro.settings import signal_settings

CONFIG = full_config()
ARM = np.array(CONFIG["arm"]["parameters"])
#: Of the oracle alone: its columns must not depend on it.
LENGTH = 0.37
# Places in pinocchio's ten numbers of a body: first moment along z, and inertia about the hinge's axis y.
MOMENT, INERTIA = 3, 6


def oracle_model():
    """Two bodies on hinges about y, link 1 along -z, gravity along -z."""
    model, parent = pin.Model(), 0
    for number, offset in enumerate((0.0, LENGTH)):
        parent = model.addJoint(
            parent, pin.JointModelRY(), pin.SE3(np.eye(3), np.array([0.0, 0.0, -offset])), f"joint{number}"
        )
        body = pin.Inertia(1.0, np.array([0.0, 0.0, -0.1]), np.diag([0.1, 0.1, 0.1]))
        model.appendBodyToJoint(parent, body, pin.SE3.Identity())
    return model


def oracle_regressor(q, dq, ddq):
    """Columns of I1, I2, I3, g1, g2 by pinocchio, those of friction written out; shape (2, N, 9)."""
    model = oracle_model()
    data = model.createData()

    def columns(gravity):
        model.gravity = pin.Motion(np.array([0.0, 0.0, -gravity, 0.0, 0.0, 0.0]))
        rows = [
            pin.computeJointTorqueRegressor(model, data, *state).copy() for state in zip(q.T, dq.T, ddq.T, strict=True)
        ]
        return np.stack(rows, axis=1).reshape(2, -1, 2, 10)  # joint, sample, body, number

    free, weighing = columns(0.0), columns(1.0)
    weight = weighing - free
    y = np.zeros((2, q.shape[1], 9))
    y[..., 0] = free[..., 0, INERTIA]  # J1 moves joint 1 alone, as all of I1 does
    y[..., 1] = -free[..., 1, MOMENT] / (2.0 * LENGTH)  # I2 = 2 l1 times the first moment of link 2, along -z
    y[..., 2] = free[..., 1, INERTIA] - free[..., 0, INERTIA]  # J2 is part of I1 and of I3
    y[..., 3] = -weight[..., 0, MOMENT]  # g1 is in N m: a moment times g
    y[..., 4] = -weight[..., 1, MOMENT]
    for j in (0, 1):
        y[j, :, 5 + j] = dq[j]
        y[j, :, 7 + j] = np.tanh(20.0 * dq[j])
    return y


def reference(y, tau):
    return np.linalg.lstsq(y.reshape(-1, 9), tau.reshape(-1))[0]


@settings(max_examples=40)
@given(seeds)
def test_it_is_numpy_s_on_pinocchio_s_regressor_for_random_motions(seed):
    rng = np.random.default_rng(seed)
    q, dq, ddq = (rng.uniform(-s, s, (2, 200)) for s in (3.0, 6.0, 30.0))
    tau = rng.normal(size=(2, 200))  # what no arm explains
    y = oracle_regressor(q, dq, ddq)
    np.testing.assert_allclose(regressor(q, dq, ddq), y, rtol=0, atol=1e-10)
    found = solve(regressor(q, dq, ddq), tau)
    np.testing.assert_allclose(found, reference(y, tau), rtol=1e-8, atol=1e-10)


@pytest.fixture(scope="module")
def signals():
    """Filtered signals of the stored identification run."""
    return read_recording(CAPTURES / "ID.bin", CONFIG).regression(signal_settings(CONFIG))


def test_it_is_numpy_s_on_the_stored_identification_run(signals):
    found = solve(signals.y, signals.tau)
    y = oracle_regressor(signals.q, signals.dq, signals.ddq)
    np.testing.assert_allclose(found, reference(y, signals.tau), rtol=1e-7, atol=1e-11)
    left = signals.tau - y @ found
    assert np.abs(np.einsum("jnk,jn->k", y, left)).max() < 1e-7 * np.abs(np.einsum("jnk,jn->k", y, signals.tau)).max()


def test_exact_torques_give_the_parameters(signals):
    np.testing.assert_allclose(solve(signals.y, signals.y @ ARM), ARM, rtol=1e-9)


def test_gravity_of_the_oracle_is_that_of_the_arm():
    """The one number that the oracle and the arm share: g1 and g2 are moments times g, and no column holds it."""
    q = np.array([[np.pi / 2], [0.0]])
    y = oracle_regressor(q, np.zeros((2, 1)), np.zeros((2, 1)))
    np.testing.assert_allclose(y[:, 0, 3:5], [[1.0, 1.0], [0.0, 1.0]], atol=1e-12)
    assert pytest.approx(9.80665) == STANDARD_GRAVITY
