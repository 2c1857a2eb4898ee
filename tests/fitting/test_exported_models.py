"""Models of a fit, in pinocchio and MuJoCo, need the torque that the recorded arm needed, up to the printed error."""

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from log_example import BETA, motion
from simulators import torque_by_mujoco, torque_by_pinocchio

import repro
from repro.identification.log import Log
from repro.model.dynamics import LAMBDA, inverse_dynamics

T = np.arange(0.0, 20.0, 0.005)


def moved(speed):
    """The motion of the known arm at another speed, with exact derivatives."""
    q, dq, ddq = motion(speed * T)
    return q, speed * dq, speed**2 * ddq


def needed(q, dq, ddq, rotor, load):
    """Torque of an arm whose joint 2 has a rotor and whose joint 1 has friction in proportion to its load."""
    tau = inverse_dynamics(q, dq, ddq, BETA)
    frictionless = inverse_dynamics(q, dq, ddq, np.r_[BETA[:5], np.zeros(4)])
    tau[0] += load * np.abs(frictionless[0]) * np.tanh(LAMBDA * dq[0])
    tau[1] += rotor * ddq[1]
    return tau


@pytest.mark.parametrize(("rotor", "load"), [(0.0, 0.0), (0.02, 0.0), (0.01, 0.25)])
def test_simulated_models_have_the_printed_error(tmp_path, rotor, load):
    fitted, unseen = moved(1.0), moved(0.8)
    log, validation = (
        Log(name=name, t=T, q=state[0], tau=needed(*state, rotor, load))
        for name, state in (("fitted", fitted), ("unseen", unseen))
    )
    result = repro.identify(log, validate=validation)
    result.save(tmp_path / "arm")
    urdf, mjcf = ((tmp_path / "arm" / name).read_text(encoding="utf-8") for name in ("arm.urdf", "arm.xml"))
    by_pinocchio, by_mujoco = pin.buildModelFromXML(urdf), mujoco.MjModel.from_xml_string(mjcf)
    steepness = result.details.preparation.friction_steepness
    printed = result.errors.groupby("log")["relative_rms"].apply(np.array)
    for name, torque, viscous, coulomb in (
        (
            "arm.urdf",
            torque_by_pinocchio(by_pinocchio, 9.80665),
            by_pinocchio.damping,
            by_pinocchio.upperDryFrictionLimit,
        ),
        ("arm.xml", torque_by_mujoco(mjcf), by_mujoco.dof_damping, by_mujoco.dof_frictionloss),
    ):
        scores = {score.log: np.array(score.relative_rms) for score in result.details.exports.get(name, ())}
        for recorded, (q, dq, ddq) in ((log, fitted), (validation, unseen)):
            rigid = np.stack([torque(*state) for state in zip(q.T, dq.T, ddq.T, strict=True)], axis=1)
            tau = rigid + viscous[:, None] * dq + coulomb[:, None] * np.tanh(steepness * dq)
            error = np.sqrt(np.mean((tau - recorded.tau) ** 2, axis=1) / np.mean(recorded.tau**2, axis=1))
            expected = scores.get(recorded.name, printed[recorded.name])
            assert np.abs(error - expected).max() < 0.02
    assert (set(result.details.exports) == {"arm.urdf", "arm.xml"}) is (load > 0.0)
