"""Random arms on the simulated board: recordings with its encoders, PWM and control loop, and their true parameters."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from repro.config import load_config
from repro.fpga.controller import simulate
from repro.fpga.frames import RADIANS_PER_COUNT
from repro.fpga.plant import NOTHING, Plant, Unmodelled
from repro.logs.log import Log
from repro.model.parameters import is_positive_definite
from repro.pipeline.experiment import control_constants, true_parameters

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


def unlike_eq_1(count, rng):
    """What Eq. 1 leaves out of each arm: Stribeck friction and ripple of random size."""
    return [
        Unmodelled(stribeck=(s, s), stribeck_velocity=0.3, ripple=(r, r), ripple_cycles=11.0)
        for s, r in zip(rng.uniform(0.0, 0.5, count), rng.uniform(0.0, 0.1, count), strict=True)
    ]


def badly_set_up(log, rng):
    """A log with zeros off by some 2 degrees, torque offsets of 0.02 N m, and torque recorded up to 10 ms early."""
    zero, late, offset = rng.normal(0.0, np.radians(2.0), (2, 1)), rng.uniform(0.0, 0.01), rng.normal(0.0, 0.02, (2, 1))
    tau = np.stack([np.interp(log.t + late, log.t, joint) for joint in log.tau])
    return replace(log, q=log.q + zero, tau=tau + offset)


def recorded(arms, desired, unmodelled=NOTHING, ripple_phase=(0.0, 0.0)):
    """Log of each arm following `desired`, shape (2, N), or (B, 2, N) with a motion for each."""
    control = control_constants(load_config(ROOT / "config" / "config.yaml"))
    position, pwm = simulate(Plant(arms, H, unmodelled, ripple_phase), control, desired)
    t = H * np.arange(desired.shape[-1])
    torque = pwm * control.torque_per_count[:, None]
    q = position * RADIANS_PER_COUNT
    return [Log(name=f"arm {k}", t=t, q=q[k], tau=torque[k], simulated=True) for k in range(len(arms))]
