"""Why the literal Algorithm 1 fails on the arm: from the ideal case to the recording, one cause at a time.

Each step is the identification run of the simulated arm with one more cause than the one before, and the search of
Algorithm 1 is run on each with the same guesses. The arm is simulated in process, whatever the experiment's source.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from repro.fpga.controller import PDController
from repro.fpga.frames import PWM_LIMIT, RADIANS_PER_COUNT
from repro.fpga.plant import Plant
from repro.identification.algorithm1.listing import Prepared, derivatives, prepare, regression_of
from repro.identification.algorithm1.residual import ResidualReader
from repro.identification.algorithm1.run import Algorithm1
from repro.identification.algorithm1.search import ImageMotion, search, select
from repro.model.dynamics import LAMBDA, rebuild_torque, regressor
from repro.model.parameters import Array
from repro.pipeline.experiment import control_constants, program_from_config, true_parameters
from repro.pipeline.job import Config
from repro.pipeline.recordings import Recording
from repro.pipeline.specimen import disturbance
from repro.progress import Progress
from repro.settings import metric_settings, signal_settings
from repro.signals.dct import dct2low
from repro.signals.metric import metr2ev
from repro.streams import Stream, stream


def beyond(q: Array, dq: Array, config: Config) -> Array:
    """Torque that Eq. 1 leaves out of the specimen that was recorded, N m, shape (2, N)."""
    levels, phase = disturbance(config, config["experiment"]["seed"])
    fade = np.tanh(LAMBDA * dq) - np.tanh(dq / levels.stribeck_velocity)
    friction = levels.stribeck * true_parameters(config)[7:, np.newaxis] * fade
    ripple = levels.ripple * np.sin(levels.ripple_cycles * q + phase[:, np.newaxis])
    return np.asarray(friction + ripple)


@dataclass(frozen=True)
class States:
    """The simulated specimen along ID, with what no encoder shows."""

    recording: Recording  # what the board sends: the stored recording, where that is of this arm
    dq: Array  # velocity (rad/s) and acceleration (rad/s^2) right after each sample's torque was set
    ddq: Array
    motors: Array  # torque of the motors, N m; but for a dead band it is what the board records


def simulate_states(config: Config) -> States:
    """Run the closed loop of ``experiment.seed``'s specimen along ID, keeping the states."""
    control, (levels, phase) = control_constants(config), disturbance(config, config["experiment"]["seed"])
    program = program_from_config(config, "ID")
    plant = Plant(true_parameters(config), program.h, levels, phase)
    controller = PDController(control.kp_counts, control.kv_counts)
    inertia3, torque = true_parameters(config)[2], control.torque_per_count[:, np.newaxis]
    desired = program.q.astype(np.float32)
    n = desired.shape[1]
    position, pwm, motors = (np.empty((2, n)) for _ in range(3))
    dq, ddq, slope = np.empty((2, n)), np.empty((2, n)), np.empty((4, 1))
    for i in range(n):
        counts = np.rint(plant.state[:2] / RADIANS_PER_COUNT).astype(np.int32)
        sent = controller(desired[:, i : i + 1], counts)
        plant.derivative(plant.state, plant.effective(sent) * torque / inertia3, slope)
        position[:, i], pwm[:, i], motors[:, i] = counts[:, 0], sent[:, 0], (plant.effective(sent) * torque)[:, 0]
        dq[:, i], ddq[:, i] = slope[:2, 0], slope[2:, 0]
        plant.advance(sent, control.torque_per_count)
    as_sent = replace(program, q=desired.astype(np.float64))
    return States(Recording(as_sent, position * RADIANS_PER_COUNT, pwm * torque), dq, ddq, motors)


def dissect(tau_mean: Array, config: Config, image_motion: ImageMotion) -> dict[str, Prepared]:
    """Signals of each step, one cause more than the one before, after line 12; `repro.render.why` words them."""
    signals, beta, control = signal_settings(config), true_parameters(config), control_constants(config)
    states = simulate_states(config)
    program, recording = states.recording.program, states.recording
    proper = slice(program.n1, program.n2)
    h, c_f, reading = signals.h, signals.c_f, signals.reading

    sent = derivatives(program.q, signals)
    eq1 = rebuild_torque(regressor(*sent), beta)
    more = eq1 + beyond(sent[0], sent[1], config)
    torque = control.torque_per_count[:, np.newaxis]
    counted = np.clip(np.rint(more / torque), -PWM_LIMIT, PWM_LIMIT) * torque
    rounded = np.rint(sent[0] / RADIANS_PER_COUNT) * RADIANS_PER_COUNT
    exact = (recording.q, dct2low(states.dq, h, c_f, reading), dct2low(states.ddq, h, c_f, reading))
    steps: Mapping[str, tuple[tuple[Array, Array, Array], Array]] = {
        "ideal": (sent, eq1),
        "beyond": (sent, more),
        "quantised": ((rounded, sent[1], sent[2]), counted),
        "loop": (exact, recording.tau),
        "recording": (derivatives(recording.q, signals), recording.tau),
    }

    def cut(motion: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
        first, second, third = (x[:, proper] for x in motion)
        return first, second, third

    shown = cut(sent) if image_motion == "desired" else None
    regressions = (
        regression_of(cut(motion), dct2low(tau, h, c_f, reading)[:, proper], signals) for motion, tau in steps.values()
    )
    return {step: prepare(each, tau_mean, signals, shown=shown) for step, each in zip(steps, regressions, strict=True)}


def explain(algorithm1: Algorithm1, tau_mean: Array, seeds: Sequence[int], config: Config) -> pd.DataFrame:
    """Similarity and the estimate's error of one network at each step."""
    metric, why, true = metric_settings(config), config["why"], true_parameters(config)
    prepared = dissect(tau_mean, config, algorithm1.search.image_motion)
    progress = Progress(f"why, network {algorithm1.variant}")
    rows: list[dict[str, Any]] = []
    for step, signals in prepared.items():
        right = true / signals.largest
        for seed in seeds:
            reader = ResidualReader(algorithm1.network, algorithm1.image, signals)
            found = search(reader, signals, algorithm1.search, stream(seed, Stream.EXPERIMENT_SEARCH))
            rebuilt = rebuild_torque(signals.regression.y, select(found.beta, signals, algorithm1.search).beta)
            total = metr2ev(signals.regression.tau, rebuilt, metric).total
            rng = stream(seed, Stream.WHY)
            uniform = rng.uniform(algorithm1.search.low, algorithm1.search.high, (why["guesses"], len(right)))
            near = np.maximum(right + why["near"] * rng.standard_normal(uniform.shape), algorithm1.search.low)
            errors = (float(np.sqrt(np.mean((reader.estimate(g) - right) ** 2))) for g in (uniform, near))
            names = ("total1", "total2", "error_uniform", "error_near")
            values = dict(zip(names, (*map(float, total), *errors), strict=True))
            rows.append({"network": algorithm1.variant, "step": step, "seed": seed, **values})
            progress(len(rows), len(prepared) * len(seeds))
    return pd.DataFrame(rows)
