"""Arms simulated behind the board: those that a network is trained on, many of a Monte Carlo study, and a factorial's.

Training on closed-loop motions (``data.motions: tracked``) is an extension: the paper trains on Eq. 10 exactly and
says that a recorded motion need not be identical to it (Section VI). A specimen is one arm with its share of unmodelled
effects and its random motion T1.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

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
from repro.pipeline.experiment import (
    Recording,
    control_constants,
    disturbance,
    limits,
    program_from_config,
    true_parameters,
)
from repro.pipeline.job import Config
from repro.progress import Progress
from repro.settings import signal_settings
from repro.signals.dct import SignalSettings, image_regressor
from repro.signals.programs import PROGRAMS, VALIDATION, ReferenceTrajectory, check_limits, identification_reference
from repro.signals.trajectories import Motion, identification_trajectory
from repro.streams import Stream, stream

#: Law that arms are drawn from.
Draw = Callable[[np.random.Generator, int, Config], Array]
#: Arms drawn for each that the Monte Carlo study wants.
DRAWN = 8
#: Name of the factorial's block that no effect is estimated from: an arm and a specimen frozen before, scored once.
CONFIRMATION = "confirmation"


@dataclass(frozen=True)
class Tracked:
    """Arms and how they tracked Eq. 10."""

    program: ReferenceTrajectory  # the motion that was sent
    position: NDArray[np.int16]  # counts of encoder and PWM
    pwm: NDArray[np.int16]
    parameters: Array  # of each arm


# --- Closed-loop motions to train on ------------------------------------------------------------------------------


def draw_arms(rng: np.random.Generator, n: int, config: Config) -> Array:
    """Physical arms that the motors can carry and the loop can hold."""
    return _draw_held(lambda: sample_beta(rng, 4 * n, "links"), n, config)


def _draw_held(draw: Callable[[], Array], n: int, config: Config) -> Array:
    """The first `n` drawn arms that the motors can carry and the loop can hold."""
    t, full = config["data"]["tracked"], np.array(config["board"]["full_torque_nm"])
    arms = np.empty((0, 9))
    while len(arms) < n:
        beta = draw()
        g1, g2, k1, k2 = beta[:, 3], beta[:, 4], beta[:, 7], beta[:, 8]
        load = np.stack([g1 + g2 + k1, g2 + k2], axis=1)
        fit = (load <= t["load_share"] * full).all(1) & (beta[:, [0, 2]] >= t["least_inertia_kg_m2"]).all(1)
        arms = np.concatenate([arms, beta[fit]])
    return arms[:n]


def draw_built_arms(rng: np.random.Generator, n: int, config: Config) -> Array:
    """Arms as somebody builds them: rods with a motor at the elbow and a load at the tip, friction a share of gravity.

    A second generator, that neither trains nor calibrates anything: other laws for lengths, masses and friction.
    """

    def draw() -> Array:
        l1, l2 = rng.uniform(0.1, 0.35, (2, 4 * n))
        rod1, rod2 = rng.uniform(0.4, 1.2, 4 * n) * l1, rng.uniform(0.4, 1.2, 4 * n) * l2  # kg, 0.4 to 1.2 kg/m
        motor, load = rng.uniform(0.05, 0.3, 4 * n), rng.uniform(0.0, 0.25, 4 * n)
        m1, m2 = rod1 + motor, rod2 + load
        lc1, lc2 = l1 * (rod1 / 2 + motor) / m1, l2 * (rod2 / 2 + load) / m2
        j1 = rod1 * l1**2 / 12 + rod1 * (l1 / 2 - lc1) ** 2 + motor * (l1 - lc1) ** 2
        j2 = rod2 * l2**2 / 12 + rod2 * (l2 / 2 - lc2) ** 2 + load * (l2 - lc2) ** 2
        inertial = inertial_from_links(Links(m1, m2, l1, lc1, lc2, j1, j2))
        viscous, coulomb = rng.uniform(0.02, 0.2, (2, 4 * n, 2)) * inertial[np.newaxis, :, 3:5]  # of gravity
        return np.concatenate([inertial, viscous, 2.0 * coulomb], axis=1)

    return _draw_held(draw, n, config)


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


# --- Specimens ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Specimen:
    """One arm with its share of unmodelled effects and its random motion."""

    seed: int  # of what Eq. 1 leaves out, and of T1
    arm: int | str  # in the Monte Carlo study 0 is that of section ``arm``
    block: str = ""  # name in the factorial
    back_emf: float = 0.0
    true: Array = field(default_factory=lambda: np.empty(9))
    recordings: Mapping[str, Recording] = field(default_factory=dict)  # by motion, ID first


def simulate_specimens(
    config: Config, seeds: Sequence[int], beta: Array, programs: Mapping[str, Sequence[ReferenceTrajectory]]
) -> dict[str, NDArray[Any]]:
    """Parameters (n, 9) of specimens and their counts on each motion, simulated as one batch, which shares substeps."""
    desired = [program.q for of_motion in programs.values() for program in of_motion]
    longest = max(q.shape[-1] for q in desired)
    held = np.stack([np.pad(q, ((0, 0), (0, longest - q.shape[-1])), mode="edge") for q in desired])
    levels, phases = zip(*(disturbance(config, seed) for seed in seeds), strict=True)
    n, h = len(programs), config["signals"]["sampling_period_s"]
    plant = Plant(np.tile(beta, (n, 1)), h, levels * n, np.tile(phases, (n, 1)))
    position, pwm = simulate(plant, control_constants(config), held, Progress(f"simulating {len(held)} runs"))
    kept: dict[str, NDArray[Any]] = {"parameters": beta}
    for k, (name, of_motion) in enumerate(programs.items()):
        own = np.s_[k * len(seeds) : (k + 1) * len(seeds), :, : of_motion[0].q.shape[-1]]
        kept |= {f"{name}/position": position[own], f"{name}/pwm": pwm[own]}
    return kept


def _read_specimens(
    path: Path, config: Config, specimens: Sequence[Specimen], duration: float | None = None, first: str = "ID"
) -> list[Specimen]:
    """Specimens with their parameters and recordings; `first` is the name of ID in the file."""
    kept, _ = read_tensors(path, "recordings of simulated arms")
    n = len(specimens)

    def stored(name: str, shape: tuple[int, ...]) -> NDArray[Any]:
        if name not in kept or kept[name].shape != shape:
            raise InputError.at(f"{path}: {name}", "another shape or nothing", f"an array of shape {shape}")
        return kept[name]

    true = stored("parameters", (n, 9))
    found = []
    for k, one in enumerate(specimens):
        recordings = {}
        for motion in PROGRAMS:
            program = program_from_config(config, motion, one.seed, duration)
            name = first if motion == "ID" else motion
            position, pwm = (stored(f"{name}/{what}", (n, *program.q.shape))[k] for what in ("position", "pwm"))
            sent = replace(program, q=program.q.astype(np.float32).astype(np.float64))  # as the board received it
            recordings[motion] = Recording.of_counts(sent, position, pwm, config)
        found.append(replace(one, true=true[k], recordings=recordings))
    return found


# --- Many arms ----------------------------------------------------------------------------------------------------


def spread_arms(config: Config) -> Array:
    """Arms of the spread: that of section ``arm``, and others that can do the same motions."""
    seeds, durations, count = (config["spread"][name] for name in ("seeds", "durations_s", "arms"))
    motions = [program_from_config(config, "ID", duration=d) for d in durations]
    fastest = min(motions, key=lambda motion: motion.q.shape[1])
    motions += [program_from_config(config, name, seed) for name in VALIDATION for seed in seeds]
    drawn = draw_arms(stream(config["experiment"]["seed"], Stream.SPREAD_ARMS), DRAWN * count, config)
    drawn[:, 5:7] += config["arm"]["back_emf_nm_s_per_rad"]  # all arms have the same motors
    capable = [beta for beta in drawn if all(_is_within_limits(motion, beta, config) for motion in motions)]
    arms = np.stack([true_parameters(config), *capable])
    with np.errstate(over="ignore", invalid="ignore"):  # the loop of a light arm may diverge: it is left out
        position, _ = simulate(Plant(arms, fastest.h), control_constants(config), fastest.q)
    tracked = tracking_error(position, fastest) <= config["data"]["tracked"]["largest_error_rad"]
    tracked[0] = True  # the arm of the captures
    if tracked.sum() < count:
        raise InputError.at("spread.arms", count, f"at most {tracked.sum()}, of {DRAWN * count} drawn ones that can")
    kept: Array = arms[tracked][:count]
    return kept


def _is_within_limits(motion: ReferenceTrajectory, beta: Array, config: Config) -> bool:
    """Whether a motion stays within torque and speed of an arm."""
    try:
        check_limits(motion, beta, *limits(config))
    except InputError:
        return False
    return True


def simulate_spread(config: Config, out: Path) -> None:
    """Simulate every seed on every motion and identification duration, and keep the counts."""
    seeds, durations = config["spread"]["seeds"], config["spread"]["durations_s"]
    programs = {f"ID{k}": [program_from_config(config, "ID", duration=d)] * len(seeds) for k, d in enumerate(durations)}
    programs |= {name: [program_from_config(config, name, seed) for seed in seeds] for name in VALIDATION}
    arms = spread_arms(config)
    kept = simulate_specimens(config, seeds, arms[np.arange(len(seeds)) % len(arms)], programs)
    for name, of_motion in programs.items():
        kept[f"{name}/desired"] = np.stack([program.q for program in of_motion]).astype(np.float32)
    write_tensors(out, kept)


def read_spread(path: Path, config: Config, index: int) -> list[Specimen]:
    """Recordings of every seed for one identification duration."""
    seeds, durations, arms = (config["spread"][name] for name in ("seeds", "durations_s", "arms"))
    specimens = [Specimen(seed, k % arms) for k, seed in enumerate(seeds)]
    return _read_specimens(path, config, specimens, durations[index], f"ID{index}")


# --- Blocks of the factorial --------------------------------------------------------------------------------------


def _blocks(config: Config) -> list[Specimen]:
    """Every specimen with both back-EMFs; the specimens have the arms in turn."""
    f = config["factorial"]
    arms = {"first": config["arm"]["parameters"], "second": f["second_arm"], CONFIRMATION: f["confirmation_arm"]}
    labels = [(seed, ("first", "second")[k % 2], str(seed)) for k, seed in enumerate(f["specimens"])]
    labels.append((f["confirmation_specimen"], CONFIRMATION, CONFIRMATION))
    return [
        Specimen(seed, arm, block, back_emf, np.array(arms[arm]) + back_emf * np.isin(np.arange(9), (5, 6)))
        for seed, arm, block in labels
        for back_emf in f["back_emf_nm_s_per_rad"]
    ]


def simulate_blocks(config: Config, out: Path) -> None:
    """Simulate every block on all motions, and keep the counts."""
    blocks = _blocks(config)
    programs = {name: [program_from_config(config, name, block.seed) for block in blocks] for name in PROGRAMS}
    true = np.stack([block.true for block in blocks])
    write_tensors(out, simulate_specimens(config, [block.seed for block in blocks], true, programs))


def read_blocks(path: Path, config: Config) -> list[Specimen]:
    """Recordings of every block."""
    return _read_specimens(path, config, _blocks(config))
