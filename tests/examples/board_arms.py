"""Random arms on the simulated board: recordings with its encoders, PWM and control loop, and their true parameters."""

from pathlib import Path

import numpy as np

from repro.board.controller import simulate
from repro.board.frames import RADIANS_PER_COUNT
from repro.board.plant import NOTHING, Plant
from repro.config.check import load_config
from repro.experiments.arm import control_constants
from repro.identification.log import Log
from repro.model.parameters import is_positive_definite

CONFIG = load_config(Path(__file__).resolve().parents[2] / "config" / "config.yaml")
#: An arm that gives every number of Appendix A, with further viscous friction: not the configured one.
ARM = np.array([0.12, 0.0026375, 0.0227235, 0.95, 0.07838, 0.2, 0.12771, 0.4538, 0.228])
#: Samples that the board's memory holds, and the time between two, s.
SAMPLES, H = 8192, 2.5e-3


def random_arms(count, rng):
    """Parameters within a factor 1.65 of `ARM`'s, each with a positive-definite M(q), shape (count, 9)."""
    arms = []
    while len(arms) < count:
        beta = ARM * np.exp(rng.uniform(-0.5, 0.5, 9))
        if is_positive_definite(beta):
            arms.append(beta)
    return np.array(arms)


def multisine(rng, samples=SAMPLES):
    """Desired position of both joints, shape (2, samples): twelve harmonics of 0.1 Hz, starting from rest at zero."""
    t = H * np.arange(samples)
    harmonics = np.arange(1, 13)
    size = rng.normal(size=(2, 12)) / np.sqrt(harmonics)
    phase = rng.uniform(0.0, 2.0 * np.pi, (2, 12, 1))
    q = np.einsum("jk,jkn->jn", size, np.sin(0.2 * np.pi * np.outer(harmonics, t) + phase))
    q *= np.array([[1.0], [1.2]]) / np.abs(q).max(axis=1, keepdims=True)
    return q - q[:, :1] * np.exp(-t / 0.3)


def recorded(arms, desired, unmodelled=NOTHING, ripple_phase=(0.0, 0.0), quick=False):
    """Log of each arm (B, 9) that follows `desired` (B, 2, N)."""
    control = control_constants(CONFIG)
    position, pwm = simulate(Plant(arms, H, unmodelled, ripple_phase, quick=quick), control, desired)
    q, tau = RADIANS_PER_COUNT * position, pwm * control.torque_per_count[:, np.newaxis]
    t = H * np.arange(desired.shape[-1])
    return [Log(name=f"arm {k}", t=t, q=q[k], tau=tau[k], simulated=True) for k in range(len(arms))]
