"""Eq. 1 against pinocchio, MuJoCo and an ODE solver, and the kinematics of both links."""

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from simulators import torque_by_mujoco, torque_by_pinocchio
from strategies import feasible_betas, links, seeds

from repro.model import dynamics
from repro.model.dynamics import forward_dynamics, inverse_dynamics, mass_matrix, rebuild_torque, regressor
from repro.model.parameters import STANDARD_GRAVITY, inertial_from_links, is_positive, is_positive_definite

# Both oracles: hinges about +y, arm along -z at q = 0, gravity along -z. The inertias about the two axes
# that a planar arm never turns about are arbitrary and differ from the one that matters.


def pinocchio_arm(arm):
    model, parent, offset = pin.Model(), 0, 0.0
    for name, mass, centre, inertia in (("upper", arm.m1, arm.lc1, arm.j1), ("lower", arm.m2, arm.lc2, arm.j2)):
        placement = pin.SE3(np.eye(3), np.array([0.0, 0.0, -offset]))
        parent = model.addJoint(parent, pin.JointModelRY(), placement, name)
        body = pin.Inertia(mass, np.array([0.0, 0.0, -centre]), np.diag([0.7 * inertia, inertia, 0.8 * inertia]))
        model.appendBodyToJoint(parent, body, pin.SE3.Identity())
        offset = arm.l1
    return torque_by_pinocchio(model, STANDARD_GRAVITY)


def mujoco_arm(arm):
    def link(mass, centre, inertia):
        moments = f"{0.7 * inertia!r} {inertia!r} {0.8 * inertia!r}"
        return f'<joint axis="0 1 0"/><inertial pos="0 0 {-centre!r}" mass="{mass!r}" diaginertia="{moments}"/>'

    return torque_by_mujoco(
        f"""<mujoco><option gravity="0 0 {-STANDARD_GRAVITY!r}"/><worldbody>
        <body>{link(arm.m1, arm.lc1, arm.j1)}<body pos="0 0 {-arm.l1!r}">{link(arm.m2, arm.lc2, arm.j2)}</body></body>
        </worldbody></mujoco>"""
    )


@pytest.mark.slow
@pytest.mark.parametrize("oracle", [pinocchio_arm, mujoco_arm])
@given(arm=links(), seed=seeds)
def test_torque_and_inertia_agree_with_a_rigid_body_library(oracle, arm, seed):
    rng = np.random.default_rng(seed)
    q, dq, ddq = rng.uniform(-6.0, 6.0, (10, 2)), rng.uniform(-8.0, 8.0, (10, 2)), rng.uniform(-40.0, 40.0, (10, 2))
    beta = np.concatenate([inertial_from_links(arm), np.zeros(4)])
    tau, unaccelerated = (np.stack([*map(oracle(arm), q, dq, each)]) for each in (ddq, 0.0 * ddq))
    np.testing.assert_allclose(inverse_dynamics(q.T, dq.T, ddq.T, beta).T, tau, rtol=0, atol=1e-10)
    inertial = (mass_matrix(q, beta) @ ddq[..., np.newaxis])[..., 0]
    np.testing.assert_allclose(inertial, tau - unaccelerated, rtol=0, atol=1e-10)


@given(beta=feasible_betas(), seed=seeds, steepness=st.floats(5.0, 60.0))
def test_forward_dynamics_inverts_inverse_dynamics(beta, seed, steepness):
    rng = np.random.default_rng(seed)
    q, dq, ddq, tau = rng.uniform(-5.0, 5.0, (4, 2, 20))
    torque = inverse_dynamics(q, dq, ddq, beta, steepness)
    np.testing.assert_allclose(forward_dynamics(q.T, dq.T, torque.T, beta, steepness).T, ddq, rtol=0, atol=1e-10)
    acceleration = forward_dynamics(q.T, dq.T, tau.T, beta, steepness).T
    np.testing.assert_allclose(inverse_dynamics(q, dq, acceleration, beta, steepness), tau, rtol=0, atol=1e-10)


def test_friction_is_viscous_plus_coulomb_tanh_of_velocity():
    dq = np.array([[-3.0, -0.05, 0.0, 0.01, 2.0], [0.0, 0.1, -0.2, 4.0, -0.03]])
    q, still = np.full_like(dq, 0.7), np.zeros_like(dq)
    beta = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.4, 0.6, 0.11, 0.07])
    expected = np.array([[0.4], [0.6]]) * dq + np.array([[0.11], [0.07]]) * np.tanh(20.0 * dq)
    np.testing.assert_allclose(inverse_dynamics(q, dq, still, beta), expected, rtol=1e-14)
    softer = np.array([[0.4], [0.6]]) * dq + np.array([[0.11], [0.07]]) * np.tanh(3.0 * dq)
    np.testing.assert_allclose(inverse_dynamics(q, dq, still, beta, 3.0), softer, rtol=1e-14)
    assert dynamics.LAMBDA == 20.0


def test_batches_equal_one_at_a_time():
    rng = np.random.default_rng(2)
    q, dq, ddq = rng.uniform(-3.0, 3.0, (3, 4, 3, 2, 6))
    betas = rng.uniform(0.1, 2.0, (5, 2, 9))
    y = regressor(q, dq, ddq)
    assert y.shape == (4, 3, 2, 6, 9)
    np.testing.assert_array_equal(y[2, 1], regressor(q[2, 1], dq[2, 1], ddq[2, 1]))
    torque = rebuild_torque(y[2, 1], betas)
    assert torque.shape == (5, 2, 2, 6)
    assert rebuild_torque(y[2, 1, 0, 5], betas[3, 1]) == pytest.approx(torque[3, 1, 0, 5])
    np.testing.assert_allclose(torque[3, 1], inverse_dynamics(q[2, 1], dq[2, 1], ddq[2, 1], betas[3, 1]), atol=1e-12)
    shared = regressor(q[0, 0], dq, ddq)  # one position against a batch of velocities
    np.testing.assert_array_equal(shared[1, 2], regressor(q[0, 0], dq[1, 2], ddq[1, 2]))


GOOD = np.zeros((2, 5))
BETA = np.ones(9)


@pytest.mark.parametrize("place", [0, 1, 2])
@pytest.mark.parametrize(
    "bad", [np.zeros(5), np.zeros((3, 5)), np.zeros((2, 4)), GOOD + np.nan, np.where(np.arange(5) == 3, np.inf, GOOD)]
)
def test_bad_motion_is_refused(place, bad):
    signals = [GOOD, GOOD, GOOD]
    signals[place] = bad
    for call in (lambda: regressor(*signals), lambda: inverse_dynamics(*signals, BETA)):
        with pytest.raises(ValueError, match=r"^(signals?|q|dq|ddq)\b"):
            call()


@pytest.mark.parametrize("bad", [np.float64(1.0), np.ones(8), np.ones((9, 2)), np.full(9, np.nan), np.full(9, np.inf)])
@pytest.mark.parametrize(
    "call",
    [
        lambda beta: inverse_dynamics(GOOD, GOOD, GOOD, beta),
        lambda beta: rebuild_torque(regressor(GOOD, GOOD, GOOD), beta),
        lambda beta: mass_matrix(np.zeros(2), beta),
        is_positive,
        is_positive_definite,
    ],
)
def test_bad_beta_is_refused_everywhere(call, bad):
    with pytest.raises(ValueError, match=r"^beta: "):
        call(bad)


ARM = dynamics.ArmGeometry(0.165, 0.150)
lengths, angles = st.floats(0.05, 2.0), st.floats(-np.pi, np.pi)


def column(*values):
    return np.array(values, dtype=float)[:, None]


def test_forward_kinematics_agrees_with_mujoco():
    # Axis -y, so that a positive turn takes a link that hangs along -z towards +x.
    model = mujoco.MjModel.from_xml_string(
        """<mujoco><worldbody><body><joint axis="0 -1 0"/><geom type="sphere" size="0.01"/>
        <body pos="0 0 -0.165"><joint axis="0 -1 0"/><geom type="sphere" size="0.01"/><site pos="0 0 -0.150"/></body>
        </body></worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (2, 20))
    elbow, tip = dynamics.forward_kinematics(q, ARM)
    for k in range(q.shape[1]):
        data.qpos[:] = q[:, k]
        mujoco.mj_kinematics(model, data)
        np.testing.assert_allclose(data.xpos[2][[0, 2]], elbow[:, k], rtol=0, atol=1e-14)
        np.testing.assert_allclose(data.site_xpos[0][[0, 2]], tip[:, k], rtol=0, atol=1e-14)


@given(l1=lengths, l2=lengths, share=st.floats(0.0, 1.0), direction=angles)
def test_the_tip_lands_on_the_point(l1, l2, share, direction):
    arm = dynamics.ArmGeometry(l1, l2)
    r = abs(l1 - l2) + share * (l1 + l2 - abs(l1 - l2))  # to both edges of the workspace
    p = r * column(np.cos(direction), np.sin(direction))
    q = dynamics.inverse_kinematics(p, arm)
    np.testing.assert_allclose(dynamics.forward_kinematics(q, arm)[1], p, rtol=0, atol=2e-12 * arm.reach)
    assert -np.pi < q[0, 0] <= np.pi and q[1, 0] >= 0


def test_an_arm_that_points_straight_up_is_at_half_a_turn_and_not_at_minus_that():
    np.testing.assert_allclose(dynamics.inverse_kinematics(column(0.0, ARM.reach), ARM), column(np.pi, 0.0), atol=1e-7)


@given(q1=angles, tiny=st.floats(0.0, 1e-6))
def test_a_nearly_straight_arm_keeps_its_digits(q1, tiny):
    """The tip fixes q2 only to the root of the rounding there, but it comes back to the tip exactly."""
    tip = dynamics.forward_kinematics(column(q1, tiny), ARM)[1]
    back = dynamics.inverse_kinematics(tip, ARM)
    np.testing.assert_allclose(dynamics.forward_kinematics(back, ARM)[1], tip, rtol=0, atol=1e-15)


@pytest.mark.parametrize("radius", [0.3151, 0.0149, 0.0, 10.0])
def test_points_out_of_reach_are_refused(radius):
    path = np.array([[0.2, radius, 0.2], [0.0, 0.0, 0.1]])
    with pytest.raises(ValueError, match="from joint 1, got one at"):
        dynamics.inverse_kinematics(path, ARM)
