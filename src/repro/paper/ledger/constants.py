"""Our side of what the authors chose and our code holds: frame, network, trajectory, image, constants of the proof.

What a module does is asked of the module where it can be: the trajectory is taken apart, the image coloured.
"""

import inspect
from typing import Any

import numpy as np
from scipy.special import expit

from repro.cnn.architecture import NetworkSettings
from repro.cnn.image import LOG_OFFSET, colours
from repro.cnn.priors import sample_beta
from repro.comparison.classes import LEDGER
from repro.fpga.frames import (
    COUNTS_PER_TURN,
    FIXED_BITS,
    FRAME_BYTES,
    PWM_LIMIT,
    TORQUE_BITS,
)
from repro.model.dynamics import LAMBDA
from repro.model.parameters import NAMES, Array
from repro.model.stability import LyapunovSettings
from repro.paper.claims import Ours
from repro.signals.programs import VALIDATION
from repro.signals.trajectories import identification_trajectory, random_trajectory
from repro.signals.validation_motions import start_and_end_window

#: Encoder counts in a turn of a motor, before the gear; the paper does not print it.
COUNTS_PER_MOTOR_TURN = 64
_LITERAL = "kept as data.prior: published; the default draws from wider ranges"


def fixed(value: float, module: str, note: str = "") -> Ours:
    """Compare a number of one of our modules."""
    return Ours(float(value), LEDGER, strict=True, note="; ".join(filter(None, (note, f"repro.{module}"))))


def constants() -> dict[str, Ours]:
    """Published settings that our code holds."""
    return {**_frame(), **_network(), **_images(), **_ranges(), **_identification_motion(), **_others()}


def _frame() -> dict[str, Ours]:
    torque = TORQUE_BITS[0].bit_count()
    identifier = (FIXED_BITS >> 56).bit_count()
    spare = FIXED_BITS.bit_count() - identifier
    position = 8 * FRAME_BYTES - identifier - spare - 2 * torque
    found = {
        "section3/frame": fixed(8 * FRAME_BYTES, "fpga.frames"),
        "section3/identifier": fixed(identifier / 8, "fpga.frames"),
        "section3/position-fields": fixed(position / 16, "fpga.frames"),
        "section3/position-bits": fixed(position / 2, "fpga.frames"),
        "section3/torque-bits": fixed(torque, "fpga.frames"),
        "section3/gear-ratio": fixed(
            COUNTS_PER_TURN / COUNTS_PER_MOTOR_TURN, "fpga.frames", "8400 counts a joint turn, 64 a motor turn"
        ),
    }
    limit = fixed(PWM_LIMIT, "fpga.frames")
    return found | {f"{name}/joint{j}": limit for name in ("fig03/saturation", "section5c/full-count") for j in (1, 2)}


def _network() -> dict[str, Ours]:
    n = NetworkSettings()
    shapes: dict[str, Ours] = {}
    for k in (1, 2, 3):
        maps, inputs, size, _ = n.weights[f"conv{k}.weight"]
        for what, value in (("size", size), ("inputs", inputs), ("outputs", maps)):
            shapes[f"section4b/kernel{k}/{what}"] = fixed(value, "cnn.architecture")
    channels = fixed(n.weights["conv1.weight"][1], "cnn.architecture")
    outputs = n.weights["fc6.weight"][0]
    return {
        **shapes,
        "section4a/image/channels": channels,
        "section4b/input/channels": channels,
        "section4b/outputs": fixed(outputs, "cnn.architecture"),
        "section4b/output-low": fixed(expit(-np.inf), "cnn.network", "sigmoid of Eq. 13"),
        "section4b/output-high": fixed(expit(np.inf), "cnn.network", "sigmoid of Eq. 13"),
        "section4b/biases": fixed(n.weights["conv1.bias"][0], "cnn.architecture"),
        "section4b/pool": fixed((n.image_size - n.kernels[0] + 1) / n.pooled[0], "cnn.architecture"),
        "section4b/loss-terms": fixed(outputs, "cnn.network"),
        "section4b/loss-divisor": fixed(2 * outputs, "cnn.network", "half the mean square"),
        "algorithm1/guesses": fixed(len(NAMES), "identification.algorithm1"),
        "algorithm1/joint-weight": fixed(1 / 2, "identification.algorithm1", "the mean of both joints"),
    }


def _images() -> dict[str, Ours]:
    # Eq. 16 is linear until it is clipped: each channel alone, and small.
    level = 0.125
    weight = [3.0 * colours(level * np.eye(2)[k][:, None, None])[0, 0] / level for k in (0, 1)]
    offset = fixed(LOG_OFFSET, "cnn.image")
    return {
        "eq09/torque-factor": fixed(2, "cnn.dataset"),
        "eq09/offset/alpha": offset,
        "eq09/offset/psi": offset,
        "eq16/red/channel1": fixed(weight[0][0], "cnn.image"),
        "eq16/red/channel2": fixed(weight[1][0], "cnn.image"),
        "eq16/green/channel1": fixed(weight[0][1], "cnn.image"),
        "eq16/blue/channel1": fixed(weight[0][2], "cnn.image"),
    }


class _Ranges(np.random.Generator):
    """Generator that notes the ranges asked of it."""

    def __init__(self) -> None:
        super().__init__(np.random.PCG64(0))
        self.asked: list[tuple[float, float]] = []

    def uniform(self, low: Any = 0.0, high: Any = 1.0, size: Any = None) -> Any:  # noqa: ANN401
        self.asked.append((float(low), float(high)))
        return super().uniform(low, high, size)


def _ranges() -> dict[str, Ours]:
    rng = _Ranges()
    sample_beta(rng, 1, "published")
    length, mass, friction = rng.asked[0], rng.asked[4], rng.asked[-1]
    ranges = {"length": length, "mass": mass, "friction": friction}
    return {
        f"section4a/{name}-{end}": fixed(value, "cnn.priors", _LITERAL)
        for name, bounds in ranges.items()
        for end, value in zip(("low", "high"), bounds, strict=True)
    }


def second_harmonic(residual: Array, acceleration: Array, time: Array) -> tuple[float, float, float]:
    """Amplitude, frequency and phase of one sinusoid."""
    frequency = float(np.sqrt(-(acceleration @ residual) / (residual @ residual)))
    waves = np.stack([np.cos(frequency * time), -np.sin(frequency * time)], axis=-1)
    (c, s), *_ = np.linalg.lstsq(waves, residual, rcond=None)
    phase = float(np.arctan2(s, c)) % np.pi
    return float(c / np.cos(phase)), frequency, phase


def _identification_motion() -> dict[str, Ours]:
    motion = identification_trajectory()
    sine, cosine = np.sin(motion.time), np.cos(motion.time)
    first = second_harmonic(motion.q[0] - sine, motion.ddq[0] + sine, motion.time)
    amplitude, frequency, phase = second_harmonic(motion.q[1] + cosine, motion.ddq[1] - cosine, motion.time)
    # Eq. 10 has a sine for joint 2: a sin(w t + p) = a cos(w t + p - pi/2), and -cos(x) = cos(x - pi).
    shifted = phase + 0.5 * np.pi
    second = (-amplitude if shifted >= np.pi else amplitude, frequency, shifted % np.pi)
    names = ("amplitude", "frequency", "phase")
    return {
        f"eq10/{name}/joint{joint}": fixed(value, "signals.trajectories")
        for joint, values in ((1, first), (2, second))
        for name, value in zip(names, values, strict=True)
    }


def _others() -> dict[str, Ours]:
    random = inspect.signature(random_trajectory).parameters
    # Far from one end, the window 1 - exp(-a t^2) shows the coefficient a of the other.
    start, end = (-np.log(1.0 - start_and_end_window(np.array([0.0, t, 100.0]))[1]) for t in (1.0, 99.0))
    proof, motions = LyapunovSettings(), VALIDATION.values()
    published, drawn = sum(m.published for m in motions), sum(m.random for m in motions)
    return {
        "section4a/steepness": fixed(LAMBDA, "model.dynamics"),
        "section5/validation-trajectories": fixed(published, "signals.programs", "T1 to T4"),
        "section5b/random-low": fixed(random["low"].default, "signals.trajectories"),
        "section5b/random-high": fixed(random["high"].default, "signals.trajectories"),
        "section4a/time-low": fixed(identification_trajectory().time[0], "signals.trajectories"),
        "section6/window/start": fixed(start, "signals.validation_motions"),
        "section6/window/end": fixed(end, "signals.validation_motions"),
        "appendix/rho": fixed(proof.rho, "model.stability"),
        "appendix/epsilon": fixed(proof.epsilon, "model.stability"),
        "appendix/gamma": fixed(proof.gamma, "model.stability"),
        "section1a/random-trajectories": fixed(drawn, "signals.programs", "T1"),
    }
