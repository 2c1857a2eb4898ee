"""Many arms simulated behind the board, such as those that a network is trained on.

Training on closed-loop motions (``data.motions: tracked``) is an extension: the paper trains on Eq. 10 exactly.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from repro.board.controller import simulate
from repro.board.frames import RADIANS_PER_COUNT
from repro.board.plant import NOTHING, Plant, Unmodelled
from repro.cnn.dataset import SampledMotion, sample_motion, stack_motions
from repro.cnn.priors import DRAWS, Law
from repro.config.model import Configuration
from repro.errors import InputError
from repro.experiments.arm import control_constants, identification_settings, limits
from repro.files import read_tensors, write_tensors
from repro.identification.algorithm1.preprocessing import derivatives
from repro.model.parameters import Array, Links, inertial_from_links
from repro.progress import Progress
from repro.signals.dct import SignalSettings
from repro.signals.programs import ReferenceTrajectory, identification_reference, peaks
from repro.signals.trajectories import Motion, identification_trajectory
from repro.streams import Stream, stream

#: Law that arms are drawn from.
Draw = Callable[[np.random.Generator, int, Configuration], Array]
#: Counts that a board sends.
Counts = NDArray[np.int16]
#: Arms drawn without one that fits, after which a draw ends.
MOST_REFUSED = 10_000_000


def array_loader(path: Path, expected: str) -> Callable[[str, tuple[int, ...]], NDArray[Any]]:
    """Return a function ``load(name, shape)`` that reads an array of a file and cuts its first axis to the shape."""
    arrays, _ = read_tensors(path, expected)

    def load(name: str, shape: tuple[int, ...]) -> NDArray[Any]:
        if name not in arrays or arrays[name][: shape[0]].shape != shape:
            raise InputError.at(f"{path}: {name}", "another shape or nothing", f"an array of shape {shape}")
        return arrays[name][: shape[0]]

    return load


def _built(rng: np.random.Generator, n: int) -> Array:
    """Law that trains nothing: rods with a motor at the elbow, a load at the tip, and friction a share of gravity."""
    l1, l2 = rng.uniform(0.1, 0.35, (2, n))
    rod1, rod2 = rng.uniform(0.4, 1.2, n) * l1, rng.uniform(0.4, 1.2, n) * l2  # kg, 0.4 to 1.2 kg/m
    motor, load = rng.uniform(0.05, 0.3, n), rng.uniform(0.0, 0.25, n)
    m1, m2 = rod1 + motor, rod2 + load
    lc1, lc2 = l1 * (rod1 / 2 + motor) / m1, l2 * (rod2 / 2 + load) / m2
    j1 = rod1 * l1**2 / 12 + rod1 * (l1 / 2 - lc1) ** 2 + motor * (l1 - lc1) ** 2
    j2 = rod2 * l2**2 / 12 + rod2 * (l2 / 2 - lc2) ** 2 + load * (l2 - lc2) ** 2
    inertial = inertial_from_links(Links(m1, m2, l1, lc1, lc2, j1, j2))
    viscous, coulomb = rng.uniform(0.02, 0.2, (2, n, 2)) * inertial[np.newaxis, :, 3:5]  # of gravity
    return np.concatenate([inertial, viscous, 2.0 * coulomb], axis=1)


def draw_arms(rng: np.random.Generator, n: int, config: Configuration, law: Law = DRAWS["links"]) -> Array:
    """The first `n` arms of a law that the motors can carry and the loop can hold."""
    t, full = config.data.tracked, np.array(config.board.full_torque_nm)
    arms, refused = np.empty((0, 9)), 0
    while len(arms) < n:
        if refused > MOST_REFUSED:
            places = "data.tracked.load_share, data.tracked.least_inertia_kg_m2"
            raise InputError.at(places, f"none of {refused} arms within them", "a larger share, or smaller inertias")
        beta = law(rng, 4 * n)
        g1, g2, k1, k2 = beta[:, [3, 4, 7, 8]].T
        load = np.stack([g1 + g2 + k1, g2 + k2], axis=1)
        fit = (load <= t.load_share * full).all(1) & (beta[:, [0, 2]] >= t.least_inertia_kg_m2).all(1)
        arms, refused = np.concatenate([arms, beta[fit]]), 0 if fit.any() else refused + 4 * n
    return arms[:n]


draw_built_arms: Draw = partial(draw_arms, law=_built)


def run_loop(
    config: Configuration,
    beta: Array,
    desired: Array,
    what: str = "arms",
    unmodelled: Unmodelled | Sequence[Unmodelled] = NOTHING,
    phase: ArrayLike = (0.0, 0.0),
    quick: bool = False,
) -> tuple[Counts, Counts]:
    """Encoder and PWM counts (n, 2, N) of arms (n, 9) along one motion or one each; a diverging loop's mean nothing."""
    plant = Plant(beta, config.signals.sampling_period_s, unmodelled, phase, quick)
    with np.errstate(over="ignore", invalid="ignore"):
        return simulate(plant, control_constants(config), desired, Progress(f"simulating {len(beta)} {what}"))


def tracks(config: Configuration, position: Counts, program: ReferenceTrajectory) -> NDArray[np.bool_]:
    """Check whether arms with these encoder counts (n, 2, N) track the trajectory proper."""
    error = np.abs(position * RADIANS_PER_COUNT - program.q)[..., program.n1 : program.n2].max((1, 2))
    return np.asarray(error <= config.data.tracked.largest_error_rad)


def is_within_limits(config: Configuration, beta: Array, program: ReferenceTrajectory) -> NDArray[np.bool_]:
    """Check whether a motion stays within torque and speed of each arm (n, 9)."""
    (torque_limit, speed_limit), (speed, torque) = limits(config), peaks(program, beta)
    return np.asarray((torque <= np.array(torque_limit)).all(axis=-1) & (speed <= speed_limit).all())


def simulate_arms(
    config: Configuration, count: int, rng: np.random.Generator, effects: bool = True, draw: Draw = draw_arms
) -> tuple[ReferenceTrajectory, Counts, Counts, Array]:
    """Simulate arms as one batch; gives what they were sent, and counts and parameters of those that track."""
    t, program = config.data.tracked, identification_reference(identification_settings(config))
    drawn = count + count // 4 + 1
    beta = draw(rng, drawn, config)
    levels = (rng.uniform(0.0, [t.stribeck, t.ripple_nm], (drawn, 2)) * effects).tolist()
    unmodelled = [Unmodelled(stribeck=(s, s), ripple=(a, a), ripple_cycles=t.ripple_cycles) for s, a in levels]
    phase = rng.uniform(0.0, 2.0 * np.pi, (drawn, 2))
    position, pwm = run_loop(config, beta, program.q, unmodelled=unmodelled, phase=phase)
    kept = np.flatnonzero(tracks(config, position, program))[:count]
    if len(kept) < count:
        found = f"{len(kept)} of {drawn} arms that track"
        raise InputError.at("data.tracked.largest_error_rad", found, f"{count}: a larger error")
    return program, position[kept], pwm[kept], beta[kept]


def simulate_tracked(config: Configuration, out: Path) -> None:
    """Simulate the arms whose motions a network is trained on, and keep them."""
    t = config.data.tracked
    program, position, _, beta = simulate_arms(config, t.arms, stream(t.seed, Stream.TRACKED_ARMS))
    desired = program.q.astype(np.float32)
    write_tensors(out, {"position": position, "parameters": beta, "desired": desired})


def sampled_tracks(
    positions: Iterable[Array],
    program: ReferenceTrajectory,
    signals: SignalSettings,
    unmodelled: bool = False,
    desired: bool = False,
) -> SampledMotion:
    """Regressors of recorded positions (2, N); f of the image on each, or on the motion that was sent."""

    def sampled(q: Array, unmodelled: bool = False) -> SampledMotion:
        motion = Motion(signals.sampling_period_s * np.arange(q.shape[-1], dtype=np.float64), *derivatives(q, signals))
        return sample_motion(motion, signals, slice(program.n1, program.n2), unmodelled)

    return stack_motions([sampled(q, unmodelled) for q in positions], sampled(program.q).model if desired else None)


def training_motion(config: Configuration, tracked: Path | None = None) -> SampledMotion:
    """Motions that a network is trained on: Eq. 10, or of `simulate_tracked` the first ``data.tracked.arms``."""
    signals, unmodelled = config.signals, bool(config.data.unmodelled)
    if config.data.motions == "ideal":
        return sample_motion(
            identification_trajectory(signals.duration_s, signals.sampling_period_s), signals, unmodelled=unmodelled
        )
    load = array_loader(tracked or Path(), "motions of `simulate_tracked`")
    program = identification_reference(identification_settings(config))
    sent = replace(program, q=load("desired", program.q.shape).astype(np.float64))
    position = load("position", (config.data.tracked.arms, *sent.q.shape))
    desired = config.algorithm1.image_motion == "desired"
    return sampled_tracks(position * RADIANS_PER_COUNT, sent, signals, unmodelled, desired)
