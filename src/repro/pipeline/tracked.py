"""Closed-loop motions: how arms track Eq. 10 behind the simulated board (``data.motions: tracked``).

The paper trains on Eq. 10 exactly and says that a recorded motion need not be identical to it (Section VI). This
extension trains on the motions of simulated arms in the loop.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from repro.cnn.dataset import SampledMotion, sample_motion, stack_motions
from repro.cnn.priors import sample_beta
from repro.errors import InputError
from repro.files import read_tensors, write_tensors
from repro.fpga.controller import simulate
from repro.fpga.frames import RADIANS_PER_COUNT
from repro.fpga.plant import Plant, Unmodelled
from repro.identification.algorithm1.preprocessing import derivatives
from repro.model.parameters import Array, Links, inertial_from_links
from repro.pipeline.experiment import control_constants
from repro.pipeline.job import Config
from repro.progress import Progress
from repro.settings import signal_settings
from repro.signals.dct import SignalSettings, image_regressor
from repro.signals.programs import ReferenceTrajectory, identification_reference
from repro.signals.trajectories import Motion, identification_trajectory
from repro.streams import Stream, stream

#: Law that arms are drawn from.
Draw = Callable[[np.random.Generator, int, Config], Array]


@dataclass(frozen=True)
class Tracked:
    """Arms and how they tracked Eq. 10."""

    program: ReferenceTrajectory  # the motion that was sent
    position: NDArray[np.int16]  # counts of encoder and PWM
    pwm: NDArray[np.int16]
    parameters: Array  # of each arm


def draw_arms(rng: np.random.Generator, n: int, config: Config) -> Array:
    """Physical arms that the motors can carry and the loop can hold."""
    arms = np.empty((0, 9))
    while len(arms) < n:
        arms = np.concatenate([arms, _held(sample_beta(rng, 4 * n, "links"), config)])
    return arms[:n]


def _held(beta: Array, config: Config) -> Array:
    """Those of some arms that the motors can carry and the loop can hold."""
    t, full = config["data"]["tracked"], np.array(config["board"]["full_torque_nm"])
    g1, g2, k1, k2 = beta[:, 3], beta[:, 4], beta[:, 7], beta[:, 8]
    load = np.stack([g1 + g2 + k1, g2 + k2], axis=1)
    fit = (load <= t["load_share"] * full).all(1) & (beta[:, [0, 2]] >= t["least_inertia_kg_m2"]).all(1)
    held: Array = beta[fit]
    return held


def draw_built_arms(rng: np.random.Generator, n: int, config: Config) -> Array:
    """Arms as somebody builds them: rods with a motor at the elbow and a load at the tip, friction a share of gravity.

    A second generator, that neither trains nor calibrates anything: other laws for lengths, masses and friction.
    """
    arms = np.empty((0, 9))
    while len(arms) < n:
        l1, l2 = rng.uniform(0.1, 0.35, (2, 4 * n))
        rod1, rod2 = rng.uniform(0.4, 1.2, 4 * n) * l1, rng.uniform(0.4, 1.2, 4 * n) * l2  # kg, 0.4 to 1.2 kg/m
        motor, load = rng.uniform(0.05, 0.3, 4 * n), rng.uniform(0.0, 0.25, 4 * n)
        m1, m2 = rod1 + motor, rod2 + load
        lc1, lc2 = l1 * (rod1 / 2 + motor) / m1, l2 * (rod2 / 2 + load) / m2
        j1 = rod1 * l1**2 / 12 + rod1 * (l1 / 2 - lc1) ** 2 + motor * (l1 - lc1) ** 2
        j2 = rod2 * l2**2 / 12 + rod2 * (l2 / 2 - lc2) ** 2 + load * (l2 - lc2) ** 2
        inertial = inertial_from_links(Links(m1, m2, l1, lc1, lc2, j1, j2))
        gravity = inertial[:, 3:5]
        viscous, coulomb = rng.uniform(0.02, 0.2, (2, 4 * n, 2)) * gravity[np.newaxis]
        beta = np.concatenate([inertial, viscous, 2.0 * coulomb], axis=1)
        arms = np.concatenate([arms, _held(beta, config)])
    return arms[:n]


def _program(config: Config) -> ReferenceTrajectory:
    s, e = config["signals"], config["experiment"]
    return identification_reference(s["duration_s"], s["sampling_period_s"], e["margin_samples"], e["lead_in_s"])


def tracking_error(position: NDArray[np.int16], program: ReferenceTrajectory) -> Array:
    """Largest error of each arm along the trajectory proper, rad, of encoder counts of shape (K, 2, N)."""
    error: Array = np.abs(position * RADIANS_PER_COUNT - program.q)[..., program.n1 : program.n2].max((1, 2))
    return error


def simulate_arms(
    config: Config, count: int, rng: np.random.Generator, effects: bool = True, draw: Draw = draw_arms
) -> Tracked:
    """Simulate arms as one batch and keep those that track."""
    t, program = config["data"]["tracked"], _program(config)
    drawn = count + count // 4 + 1
    beta = draw(rng, drawn, config)
    levels = rng.uniform(0.0, [t["stribeck"], t["ripple_nm"]], (drawn, 2)) * effects
    unmodelled = [
        Unmodelled(stribeck=(s, s), ripple=(a, a), ripple_cycles=t["ripple_cycles"]) for s, a in levels.tolist()
    ]
    plant = Plant(beta, program.h, unmodelled, rng.uniform(0.0, 2.0 * np.pi, (drawn, 2)))
    progress = Progress(f"simulating {drawn} arms")
    position, pwm = simulate(plant, control_constants(config), program.q, progress)
    kept = np.flatnonzero(tracking_error(position, program) <= t["largest_error_rad"])[:count]
    if len(kept) < count:
        found = f"{len(kept)} of {drawn} arms that track"
        raise InputError.at("data.tracked.largest_error_rad", found, f"{count}: a larger error")
    return Tracked(program, position[kept], pwm[kept], beta[kept])


def simulate_tracked(config: Config, out: Path) -> None:
    """Simulate the arms whose motions a network is trained on, and keep them."""
    t = config["data"]["tracked"]
    arms = simulate_arms(config, t["arms"], stream(t["seed"], Stream.TRACKED_ARMS))
    kept = {name: getattr(arms, name) for name in ("position", "pwm", "parameters")}
    write_tensors(out, {**kept, "desired": arms.program.q.astype(np.float32)})


def read_tracked(path: Path, config: Config) -> Tracked:
    """Arms of a file of `simulate_tracked`: the first ``data.tracked.arms`` of them."""
    program, arms = _program(config), config["data"]["tracked"]["arms"]
    kept, _ = read_tensors(path, "motions of `simulate_tracked`")
    n = program.q.shape
    for name, shape in (("position", (arms, *n)), ("pwm", (arms, *n)), ("desired", n), ("parameters", (arms, 9))):
        if name not in kept or kept[name][: shape[0]].shape != shape:
            raise InputError.at(f"{path}: {name}", "another shape or nothing", f"an array of shape {shape}")
    sent = replace(program, q=kept["desired"].astype(np.float64))
    return Tracked(sent, *(kept[name][:arms] for name in ("position", "pwm", "parameters")))


def derived_motion(q: Array, signals: SignalSettings) -> Motion:
    """Motion of a recorded position, lines 1 and 2 of Algorithm 1."""
    return Motion(signals.h * np.arange(q.shape[-1], dtype=np.float64), *derivatives(q, signals))


def describe_motions(config: Config) -> str:
    """What motions a network is trained on, in words for its model card."""
    if config["data"]["motions"] == "ideal":
        return "Eq. 10 exactly"
    t, shown = config["data"]["tracked"], config["algorithm1"]["image_motion"]
    return f"Eq. 10 as {t['arms']} simulated arms track it (seed {t['seed']}); f of the image on the {shown} motion"


def training_motion(config: Config, tracked: Path | None = None) -> SampledMotion:
    """Motions that a network is trained on."""
    signals, unmodelled = signal_settings(config), any(config["data"]["unmodelled"].values())
    if config["data"]["motions"] == "ideal":
        return sample_motion(identification_trajectory(signals.duration, signals.h), signals, unmodelled=unmodelled)
    arms = read_tracked(tracked or Path(), config)
    proper = slice(arms.program.n1, arms.program.n2)
    tracks = (derived_motion(q * RADIANS_PER_COUNT, signals) for q in arms.position)
    motions = [sample_motion(track, signals, proper, unmodelled) for track in tracks]
    if config["algorithm1"]["image_motion"] == "measured":
        return stack_motions(motions)
    sent = derived_motion(arms.program.q, signals)
    model = image_regressor(sent.q[:, proper], sent.dq[:, proper], sent.ddq[:, proper], signals)
    return stack_motions(motions, model)
