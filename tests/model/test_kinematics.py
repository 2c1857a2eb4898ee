"""Forward and inverse kinematics of the two-link arm."""

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from repro.model.dynamics import ArmGeometry, forward_kinematics, inverse_kinematics

ARM = ArmGeometry(0.165, 0.150)
lengths = st.floats(0.05, 2.0)
angles = st.floats(-np.pi, np.pi)


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
    elbow, tip = forward_kinematics(q, ARM)
    for k in range(q.shape[1]):
        data.qpos[:] = q[:, k]
        mujoco.mj_kinematics(model, data)
        np.testing.assert_allclose(data.xpos[2][[0, 2]], elbow[:, k], rtol=0, atol=1e-14)
        np.testing.assert_allclose(data.site_xpos[0][[0, 2]], tip[:, k], rtol=0, atol=1e-14)


@given(l1=lengths, l2=lengths, share=st.floats(0.0, 1.0), direction=angles)
def test_the_tip_lands_on_the_point(l1, l2, share, direction):
    arm = ArmGeometry(l1, l2)
    r = abs(l1 - l2) + share * (l1 + l2 - abs(l1 - l2))  # to both edges of the workspace
    p = r * column(np.cos(direction), np.sin(direction))
    q = inverse_kinematics(p, arm)
    np.testing.assert_allclose(forward_kinematics(q, arm)[1], p, rtol=0, atol=2e-12 * arm.reach)
    assert -np.pi < q[0, 0] <= np.pi
    assert q[1, 0] >= 0


@given(q1=angles, tiny=st.floats(0.0, 1e-6))
def test_a_nearly_straight_arm_keeps_its_digits(q1, tiny):
    """The tip fixes q2 only to the root of the rounding there, but it comes back to the tip exactly."""
    tip = forward_kinematics(column(q1, tiny), ARM)[1]
    back = inverse_kinematics(tip, ARM)
    np.testing.assert_allclose(forward_kinematics(back, ARM)[1], tip, rtol=0, atol=1e-15)


def test_batches_of_paths():
    q = np.random.default_rng(1).uniform(0.2, 1.5, (3, 4, 2, 7))
    elbow, tip = forward_kinematics(q, ARM)
    assert elbow.shape == tip.shape == q.shape
    np.testing.assert_allclose(inverse_kinematics(tip, ARM), q, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(tip[2, 1], forward_kinematics(q[2, 1], ARM)[1])


@pytest.mark.parametrize("radius", [0.3151, 0.0149, 0.0, 10.0])
def test_points_out_of_reach_are_refused(radius):
    path = np.array([[0.2, radius, 0.2], [0.0, 0.0, 0.1]])
    with pytest.raises(ValueError, match="from joint 1, got one at"):
        inverse_kinematics(path, ARM)
