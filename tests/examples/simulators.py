"""Torques of an arm without friction by pinocchio and MuJoCo."""

import mujoco
import numpy as np
import pinocchio as pin


def torque_by_pinocchio(model, gravity):
    """Function of (q, dq, ddq), each (2,), that returns tau of a model."""
    model.gravity = pin.Motion(np.array([0.0, 0.0, -gravity, 0.0, 0.0, 0.0]))
    data = model.createData()
    return lambda *state: pin.rnea(model, data, *state).copy()


def torque_by_mujoco(text):
    """Function of (q, dq, ddq), each (2,), that returns tau of an MJCF with its own gravity."""
    model = mujoco.MjModel.from_xml_string(text)
    model.dof_damping[:] = model.dof_frictionloss[:] = 0.0
    data = mujoco.MjData(model)

    def torque(q, dq, ddq):
        data.qpos[:], data.qvel[:], data.qacc[:] = q, dq, ddq
        mujoco.mj_inverse(model, data)
        return data.qfrc_inverse.copy()

    return torque
