"""The simulated arm against Eq. 1, against SciPy's integrator, and against itself with finer steps and in a batch."""

import numpy as np
import pytest
from experiment_example import full_config
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from repro.board.controller import ControlConstants, simulate
from repro.board.frames import RADIANS_PER_COUNT
from repro.board.plant import Plant, Unmodelled
from repro.experiments.arm import disturbance, true_parameters
from repro.model.dynamics import forward_dynamics
from repro.signals.programs import TrajectorySettings, identification_reference

pytestmark = pytest.mark.slow

H = 2.5e-3
ARM = np.array([0.12, 0.0026375, 0.0227235, 0.95, 0.07838, 0.08, 0.00361, 0.4538, 0.31])
OTHER = np.array([0.9, 0.2, 0.15, 2.0, 0.6, 0.1, 0.05, 0.2, 0.1])
#: Levels of the joints differ so that no test passes with them exchanged.
ROUGH = Unmodelled(stribeck=(0.3, 0.8), stribeck_velocity=0.2, ripple=(0.05, 0.12), ripple_cycles=17.0)
#: The default levels of the arm of the configuration.
CALIBRATED = Unmodelled(stribeck=(1.03, 0.63), ripple=(0.171, 0.105))
TABLE_8 = ControlConstants((180.4817, 30.6819), (1270.7266, 102.2730), (1000.0, 1000.0), (2.7192, 2.7314))


class FinePlant(Plant):
    """A plant with `n` times as many substeps."""

    def __init__(self, n, beta, effects, phase):
        super().__init__(beta, H / n, effects, phase)
        self._n = n

    def advance(self, pwm, torque_per_count):
        for _ in range(self._n):
            super().advance(pwm, torque_per_count)


def written_out(beta, e, phase, tau):
    share, amplitude = np.array(e.stribeck), np.array(e.ripple)

    def derivative(_, x):
        q, dq = x[:2], x[2:]
        k = beta[7:]
        stribeck = k * share * (np.tanh(20 * dq) - np.tanh(dq / e.stribeck_velocity))
        ripple = amplitude * np.sin(e.ripple_cycles * q + phase)
        return np.concatenate([dq, forward_dynamics(q, dq, tau - stribeck - ripple, beta)])

    return derivative


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=30)
def test_derivative_is_eq_1_and_the_extra_torques(seed):
    rng = np.random.default_rng(seed)
    x, tau, phase = rng.normal(size=(4, 2)), rng.normal(size=(2, 2)), rng.uniform(0, 6, (2, 2))
    arms = np.stack([ARM, OTHER])
    plant, out = Plant(arms, H, ROUGH, phase), np.empty((4, 2))
    plant.derivative(x, tau / arms[:, 2], out)
    for b in (0, 1):
        expected = written_out(arms[b], ROUGH, phase[b], tau[:, b])(0.0, x[:, b])
        assert out[:, b] == pytest.approx(expected, rel=1e-10, abs=1e-10)
        single, alone = Plant(arms[b], H, ROUGH, phase[b]), np.empty((4, 1))
        single.derivative(x[:, b : b + 1], tau[:, b : b + 1] / arms[b, 2], alone)
        assert alone[:, 0] == pytest.approx(expected, rel=1e-10, abs=1e-10)


@pytest.mark.parametrize("effects", [Unmodelled(), ROUGH, CALIBRATED])
def test_agrees_with_scipy(effects):
    rng = np.random.default_rng(4)
    phase, pwm = np.array([0.4, 2.0]), np.repeat(rng.integers(-900, 900, (2, 6)), 6, axis=1)
    plants = [FinePlant(n, ARM, effects, phase) for n in (1, 8)]
    x = np.zeros(4)
    for i in range(pwm.shape[1]):
        for plant in plants:
            plant.advance(pwm[:, i : i + 1].astype(np.int32), TABLE_8.torque_per_count)
        motion = written_out(ARM, effects, phase, pwm[:, i] * TABLE_8.torque_per_count)
        x = solve_ivp(motion, (0, H), x, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    # The torque jumps by up to its full range. The default steps err by a tenth of an encoder count at most; finer
    # ones give SciPy's result.
    assert plants[0].state[:2, 0] == pytest.approx(x[:2], abs=0.1 * RADIANS_PER_COUNT)
    assert plants[1].state[:, 0] == pytest.approx(x, abs=1e-8)
    assert np.abs(x[:2]).min() > 1e-3


def test_halving_the_steps_changes_no_encoder_count():
    """For the arm and the specimen of the stored captures, in their first 3.75 s."""
    config = full_config()
    effects, phase = disturbance(config)
    beta, desired = true_parameters(config), identification_reference(TrajectorySettings()).q[:, :1500]
    coarse, fine = (simulate(FinePlant(n, beta, effects, phase), TABLE_8, desired) for n in (1, 2))
    np.testing.assert_array_equal(coarse, fine)
    assert np.ptp(coarse[0]) > 2000


@pytest.mark.parametrize("quick", [False, True])
def test_a_batch_is_its_arms_one_by_one(quick):
    desired = np.stack([identification_reference(TrajectorySettings()).q[:, :300]] * 3)
    desired[2] *= 0.5
    arms, phase = np.stack([ARM, OTHER, ARM]), np.array([[0.0, 1.0], [2.0, 3.0], [4.0, 5.0]])
    others = Unmodelled(stribeck=(0.1, 0.4), stribeck_velocity=0.05, ripple=(0.0, 0.3), ripple_cycles=12.0)
    levels = [ROUGH, others, Unmodelled()]
    position, pwm = simulate(Plant(arms, H, levels, phase, quick), TABLE_8, desired)
    for b in range(3):
        alone = simulate(Plant(arms[b], H, levels[b], phase[b], quick), TABLE_8, desired[b])
        np.testing.assert_array_equal([position[b], pwm[b]], [part[0] for part in alone])
    assert (position[0] != position[2]).any()


def test_torque_within_the_dead_band_does_nothing():
    lazy = Plant(ARM, H, Unmodelled(dead_band=40))
    lazy.advance(np.array([[40], [-40]], np.int32), TABLE_8.torque_per_count)
    assert (lazy.state == 0).all()
    lazy.advance(np.array([[140], [-90]], np.int32), TABLE_8.torque_per_count)
    plain = Plant(ARM, H)
    plain.advance(np.array([[100], [-50]], np.int32), TABLE_8.torque_per_count)
    assert (lazy.state == plain.state).all()
