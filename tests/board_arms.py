"""Random arms on the simulated board: recordings with its encoders, PWM and control loop, and their true parameters."""

from pathlib import Path

import numpy as np

from repro.fpga.frames import RADIANS_PER_COUNT
from repro.fpga.loop import simulate
from repro.fpga.plant import Plant
from repro.logs.log import Log
from repro.model.feasibility import is_positive_definite
from repro.pipeline.experiment import control_constants, load_config, true_parameters

ROOT = Path(__file__).resolve().parent.parent
#: Samples of a recording: what the board's memory holds.
SAMPLES = 8192
H = 2.5e-3


def random_arms(count, rng):
    """Parameters within a factor 1.65 of the configured arm's, each with a positive-definite M(q), shape (count, 9)."""
    base = true_parameters(load_config(ROOT / "config" / "config.yaml"))
    arms = []
    while len(arms) < count:
        beta = base * np.exp(rng.uniform(-0.5, 0.5, 9))
        if is_positive_definite(beta):
            arms.append(beta)
    return np.array(arms)


def multisine(rng):
    """Desired position of both joints, shape (2, SAMPLES): twelve harmonics of 0.1 Hz, starting from rest at zero."""
    t = H * np.arange(SAMPLES)
    harmonics = np.arange(1, 13)
    q = np.empty((2, SAMPLES))
    for joint, amplitude in enumerate((1.0, 1.2)):
        size = rng.normal(size=12) / np.sqrt(harmonics)
        phase = rng.uniform(0.0, 2.0 * np.pi, 12)
        sines = size @ np.sin(2.0 * np.pi * 0.1 * np.outer(harmonics, t) + phase[:, None])
        q[joint] = amplitude * sines / np.abs(sines).max()
    return q - q[:, :1] * np.exp(-t / 0.3)


def recorded(arms, desired, unmodelled=None):
    """Log of each arm following `desired`."""
    config = load_config(ROOT / "config" / "config.yaml")
    control = control_constants(config)
    plant = Plant(arms, H) if unmodelled is None else Plant(arms, H, unmodelled)
    position, pwm = simulate(plant, control, desired)
    t = H * np.arange(desired.shape[1])
    torque = pwm * control.torque_per_count[:, None]
    return [Log(f"arm {k}", t, position[k] * RADIANS_PER_COUNT, torque[k], simulated=True) for k in range(len(arms))]
