"""Least squares against NumPy's on a regressor that pinocchio builds, and its standard errors against noise."""

import numpy as np
import pinocchio as pin
import pytest
from experiment_example import CAPTURES, full_config
from hypothesis import given, settings
from scipy.stats import binom
from strategies import seeds

from repro.identify.least_squares import least_squares
from repro.model.dynamics import regressor
from repro.model.parameters import NAMES, STANDARD_GRAVITY
from repro.pipeline.experiment_runs import filtered
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
    found = least_squares(regressor(q, dq, ddq), tau)
    np.testing.assert_allclose(found.beta, reference(y, tau), rtol=1e-8, atol=1e-10)


@pytest.fixture(scope="module")
def signals():
    """Filtered signals of the stored identification run."""
    return filtered(read_recording(CAPTURES / "ID.bin", CONFIG), signal_settings(CONFIG))


def test_it_is_numpy_s_on_the_stored_identification_run(signals):
    found = least_squares(signals.regressor, signals.tau)
    y = oracle_regressor(signals.q, signals.dq, signals.ddq)
    np.testing.assert_allclose(found.beta, reference(y, signals.tau), rtol=1e-7, atol=1e-11)
    length = np.linalg.norm(y.reshape(-1, 9), axis=0)
    assert found.condition == pytest.approx(np.linalg.cond(y.reshape(-1, 9) / length), rel=1e-6)
    left = signals.tau - y @ found.beta
    assert np.abs(np.einsum("jnk,jn->k", y, left)).max() < 1e-7 * np.abs(np.einsum("jnk,jn->k", y, signals.tau)).max()


def test_exact_torques_give_the_parameters_and_no_error(signals):
    found = least_squares(signals.regressor, signals.regressor @ ARM)
    np.testing.assert_allclose(found.beta, ARM, rtol=1e-9)
    assert (found.standard_error < 1e-10).all()


def test_standard_errors_are_those_of_white_noise(signals):
    """Of 500 repetitions with fresh noise, 95 % lie within 1.96 standard errors of the truth, for each parameter."""
    y, rng, runs = signals.regressor[:, ::10], np.random.default_rng(5), 500
    z, sizes, betas = np.empty((runs, 9)), np.empty((runs, 9)), np.empty((runs, 9))
    for k in range(runs):
        found = least_squares(y, y @ ARM + rng.normal(scale=0.03, size=y.shape[:2]))
        z[k] = (found.beta - ARM) / found.standard_error
        sizes[k], betas[k] = found.standard_error, found.beta
    inside = (np.abs(z) < 1.96).sum(axis=0)
    low, high = binom.interval(0.9999, runs, 0.95)
    assert (inside >= low).all()
    assert (inside <= high).all()
    np.testing.assert_allclose(sizes.mean(axis=0), betas.std(axis=0), rtol=0.15)


def still_joint(*joints):
    """A motion in which only these joints move."""
    rng = np.random.default_rng(2)
    q, dq, ddq = (rng.normal(size=(2, 50)) for _ in range(3))
    for x in (q, dq, ddq):
        x[[j for j in (0, 1) if j not in joints]] = 0.0
    return q, dq, ddq


@pytest.mark.parametrize(("moving", "missing"), [((0,), "b2, k2"), ((1,), "I1, g1, b1, k1"), ((), ", ".join(NAMES))])
def test_a_motion_that_does_not_excite_a_parameter_is_refused_by_its_name(moving, missing):
    with pytest.raises(ValueError, match=f"does not excite {missing}\\.$"):
        least_squares(regressor(*still_joint(*moving)), np.ones((2, 50)))


def test_parameters_that_a_motion_does_not_tell_apart_are_refused():
    y = regressor(*still_joint(0, 1))
    y[..., 1] = 2.0 * y[..., 0]
    with pytest.raises(ValueError, match="tell the nine parameters apart"):
        least_squares(y, np.ones((2, 50)))


@pytest.mark.parametrize(
    ("y", "tau", "rule"),
    [
        (np.ones((2, 5, 8)), np.ones((2, 5)), "shapes"),
        (np.ones((2, 5, 9)), np.ones((2, 6)), "shapes"),
        (np.ones((3, 5, 9)), np.ones((3, 5)), "shapes"),
        (np.full((2, 5, 9), np.nan), np.ones((2, 5)), "finite"),
        (np.ones((2, 5, 9)), np.full((2, 5), np.inf), "finite"),
    ],
)
def test_wrong_arrays_are_refused(y, tau, rule):
    with pytest.raises(ValueError, match=rule):
        least_squares(y, tau)


def test_gravity_of_the_oracle_is_that_of_the_arm():
    """The one number that the oracle and the arm share: g1 and g2 are moments times g, and no column holds it."""
    q = np.array([[np.pi / 2], [0.0]])
    y = oracle_regressor(q, np.zeros((2, 1)), np.zeros((2, 1)))
    np.testing.assert_allclose(y[:, 0, 3:5], [[1.0, 1.0], [0.0, 1.0]], atol=1e-12)
    assert pytest.approx(9.80665) == STANDARD_GRAVITY
