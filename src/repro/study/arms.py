"""Arms of the study, what makes their torque differ from Eq. 1, and their recordings."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from repro.cnn.priors import AroundPrior
from repro.errors import InputError
from repro.files import read_tensors, write_tensors
from repro.fpga.controller import simulate
from repro.fpga.plant import Plant, Unmodelled
from repro.identification.least_squares import METHODS
from repro.model.parameters import Array
from repro.pipeline.experiment import Recording, control_constants, limits, program_from_config, true_parameters
from repro.pipeline.job import Config
from repro.pipeline.simulated_arms import draw_arms, draw_built_arms, tracking_error
from repro.progress import Progress
from repro.settings import metric_settings, signal_settings
from repro.signals.metric import TorqueScorer
from repro.signals.programs import VALIDATION, ReferenceTrajectory, peaks
from repro.streams import Stream, stream
from repro.study.design import Cell
from repro.study.motions import excitation_config, excitation_program

#: A narrow prior: each parameter of the stored arm, times or divided by up to this factor.
NARROW = 1.5
#: Arms for each that is wanted: drawn, and simulated to see whether they track.
DRAWN, SPARE = 24, 2
#: The amplitude of the effects is found in so many steps, each by at most this factor.
STEPS, LARGEST_STEP = 6, 5.0
#: Counts that a board can send.
_Counts = NDArray[np.int16]


def around_stored_arm(config: Config) -> AroundPrior:
    """Law of the narrow prior."""
    return AroundPrior(tuple(true_parameters(config).tolist()), NARROW)


def draw_law(law: str, rng: np.random.Generator, n: int, config: Config) -> Array:
    """Parameters (n, 9) of arms from the law of a prior."""
    if law == "narrow":
        return around_stored_arm(config)(rng, n)
    return {"wide": draw_arms, "mismatched": draw_built_arms}[law](rng, n, config)


def with_friction(beta: Array, factor: float) -> Array:
    """The same arms with their friction multiplied."""
    return np.asarray(beta * np.array([1.0] * 5 + [factor] * 4))


@dataclass(frozen=True)
class Effects:
    """What Eq. 1 leaves out of n arms. Only the first two act in the loop; the others act on what is recorded."""

    stribeck: Array  # (n, 2), increase of Coulomb friction near standstill over its size
    ripple: Array  # (n, 2), amplitude of a torque that turns with the joint, N m
    compliance: Array  # (n, 2), deflection between encoder and link, rad/(N m)
    saturation: Array  # (n, 2), by how much the torque constant changes with the torque, 1/(N m)
    delay: Array  # (n, 2), of the recorded torque, s
    phase: Array  # (n, 2), of the ripple, rad

    @classmethod
    def drawn(cls, rng: np.random.Generator, beta: Array) -> "Effects":
        """Levels of an amplitude of 1 for arms (n, 9), in proportion to the torque that holds each joint."""
        load = np.stack([beta[:, 3] + beta[:, 4] + beta[:, 7], beta[:, 4] + beta[:, 8]], axis=1)
        part = rng.uniform(0.0, 1.0, (4, *load.shape))
        delay = np.repeat(rng.uniform(0.0, 2.5e-3, (len(beta), 1)), 2, axis=1)
        phase = rng.uniform(0.0, 2.0 * np.pi, load.shape)
        return cls(part[0], 0.1 * part[1] * load, 0.01 * part[2] / load, 0.1 * part[3] / load, delay, phase)

    def times(self, amplitude: Array) -> "Effects":
        """Multiply the effects of each arm by its amplitude (n,)."""
        a = amplitude[:, np.newaxis]
        changed = (a * self.stribeck, a * self.ripple, a * self.compliance, a * self.saturation, a * self.delay)
        return Effects(*changed, self.phase)

    def observed(self, k: int, q: Array, tau: Array, h: float) -> tuple[Array, Array]:
        """What is recorded of arm `k` instead of its position and torque (2, N)."""
        measured = q + self.compliance[k, :, np.newaxis] * tau
        scaled = tau * (1.0 + self.saturation[k, :, np.newaxis] * np.abs(tau))
        n = np.arange(tau.shape[1])
        late = np.stack([np.interp(n - d / h, n, x) for d, x in zip(self.delay[k], scaled, strict=True)])
        return measured, late


def _counts(
    config: Config, beta: Array, q: Array, effects: Effects | None = None, what: str = "arms"
) -> tuple[_Counts, _Counts]:
    """Encoder and PWM counts of arms (n, 9) along one motion (2, N) or one each; a diverging loop's mean nothing."""
    unmodelled, phase = [Unmodelled()] * len(beta), np.zeros((len(beta), 2))
    if effects is not None:
        phase = effects.phase
        unmodelled = [
            Unmodelled(stribeck=(s[0], s[1]), ripple=(r[0], r[1]))
            for s, r in zip(effects.stribeck.tolist(), effects.ripple.tolist(), strict=True)
        ]
    plant = Plant(beta, config["signals"]["sampling_period_s"], unmodelled, phase, quick=True)
    with np.errstate(over="ignore", invalid="ignore"):
        return simulate(plant, control_constants(config), q, Progress(f"simulating {len(beta)} {what}"))


def record(
    config: Config, beta: Array, programs: Sequence[ReferenceTrajectory], effects: Effects, what: str
) -> list[Recording]:
    """Recordings of arms (n, 9), each along its own motion."""
    h = config["signals"]["sampling_period_s"]
    position, pwm = _counts(config, beta, np.stack([program.q for program in programs]), effects, what)
    recordings = []
    for k, program in enumerate(programs):
        one = Recording.of_counts(program, position[k], pwm[k], config)
        q, tau = effects.observed(k, one.q, one.tau, h)
        recordings.append(replace(one, q=q, tau=tau))
    return recordings


# --- The arms that are tested -------------------------------------------------------------------------------------


def choose(config: Config, out: Path) -> None:
    """Write the excitations, and the arms of each prior that can do all motions of the study."""
    s = config["study"]
    excitations = {name: excitation_program(config, name) for name in s["excitations"]}
    validation = [program for k in range(s["arms"]) for program in _validation(config, k)]
    motions = [*excitations.values(), *{(p.name, p.q.tobytes()): p for p in validation}.values()]
    kept: dict[str, NDArray[Any]] = {}
    for index, prior in enumerate(s["priors"]):
        rng = stream(s["seed"], Stream.STUDY_ARMS, index)
        drawn = draw_law(prior, rng, DRAWN * s["arms"], config)
        for program in motions:
            drawn = drawn[_is_within_limits(config, with_friction(drawn, max(s["frictions"])), program)]
        drawn = drawn[: SPARE * s["arms"]]
        for program in excitations.values():
            for factor in (min(s["frictions"]), max(s["frictions"])):
                drawn = drawn[_tracks(config, with_friction(drawn, factor), program)]
        if len(drawn) < s["arms"]:
            found = f"at most {len(drawn)}, of {DRAWN * s['arms']} drawn ones that can do all motions"
            raise InputError.at("study.arms", s["arms"], found)
        kept[f"arms/{prior}"] = drawn[: s["arms"]]
    for name, program in excitations.items():
        kept[f"motion/{name}"] = program.q.astype(np.float32)  # as the board receives it
        kept[f"proper/{name}"] = np.array([program.n1, program.n2], dtype=np.int32)
    write_tensors(out, kept)


def _is_within_limits(config: Config, beta: Array, program: ReferenceTrajectory) -> NDArray[np.bool_]:
    """Whether a motion stays within torque and speed of each arm (n, 9)."""
    torque_limit, speed_limit = limits(config)
    speed, torque = peaks(program, beta)
    return np.asarray((torque <= np.array(torque_limit)).all(axis=-1) & (speed <= speed_limit).all())


def _tracks(config: Config, beta: Array, program: ReferenceTrajectory) -> NDArray[np.bool_]:
    """Whether each arm (n, 9) tracks a motion."""
    if not len(beta):
        return np.zeros(0, dtype=np.bool_)
    position, _ = _counts(config, beta, program.q)
    return np.asarray(tracking_error(position, program) <= config["data"]["tracked"]["largest_error_rad"])


def _validation(config: Config, k: int) -> list[ReferenceTrajectory]:
    """Motions T1 to T4 of arm number `k`."""
    return [program_from_config(config, name, k + 1) for name in VALIDATION]


def read_excitation(path: Path, config: Config, excitation: str) -> ReferenceTrajectory:
    """An excitation as the board receives it."""
    kept, _ = read_tensors(path, "motions and arms of the study")
    q, (begin, end) = kept[f"motion/{excitation}"].astype(np.float64), kept[f"proper/{excitation}"].tolist()
    return ReferenceTrajectory("ID", q, begin, end, config["signals"]["sampling_period_s"])


def read_arms(path: Path, prior: str) -> Array:
    """The arms (n, 9) of a prior."""
    kept, _ = read_tensors(path, "motions and arms of the study")
    return np.asarray(kept[f"arms/{prior}"], dtype=np.float64)


# --- Recordings of a job's cells ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Specimen:
    """One arm of one cell, with what was recorded of it."""

    cell: Cell
    arm: int
    true: Array  # (9,)
    least_squares: float  # similarity of ordinary least squares on the excitation
    recordings: Sequence[Recording]  # the excitation first, then T1 to T4


def specimens(config: Config, cells: Sequence[Cell], program: ReferenceTrajectory, arms: Array) -> list[Specimen]:
    """Record the arms (n, 9) in cells of one excitation and one prior.

    Effects are drawn once for each arm. In each cell one amplitude of all of them is found for each arm, so that
    ordinary least squares reaches the cell's similarity on the excitation: 1 - S^2.5, the relative error in the
    frequency factor of metr2ev, is nearly proportional to it.
    """
    c, n = excitation_config(config, cells[0].excitation), len(arms)
    beta = np.concatenate([with_friction(arms, cell.friction) for cell in cells])
    prior = config["study"]["priors"].index(cells[0].prior)
    units = [Effects.drawn(stream(config["study"]["seed"], Stream.STUDY_EFFECTS, prior), arms)] * len(cells)
    unit = Effects(*(np.concatenate(parts) for parts in zip(*(vars(one).values() for one in units), strict=True)))
    target = np.repeat([1.0 - cell.discrepancy**2.5 for cell in cells], n)
    amplitude, reached, identified = np.ones(len(beta)), np.zeros(len(beta)), []
    for step in range(STEPS):
        identified = record(c, beta, [program] * len(beta), unit.times(amplitude), "runs of the excitation")
        reached = np.array([least_squares_similarity(recording, c) for recording in identified])
        if step < STEPS - 1:
            factor = target / np.maximum(1.0 - reached**2.5, 1e-6)
            amplitude *= np.clip(factor, 1.0 / LARGEST_STEP, LARGEST_STEP)
    own = [_validation(config, k) for k in range(n)] * len(cells)
    further = [
        record(c, beta, [programs[m] for programs in own], unit.times(amplitude), f"runs of {name}")
        for m, name in enumerate(VALIDATION)
    ]
    return [
        Specimen(cells[k // n], k % n, beta[k], float(reached[k]), [identified[k], *(runs[k] for runs in further)])
        for k in range(len(beta))
    ]


def least_squares_similarity(recording: Recording, config: Config) -> float:
    """Mean similarity of both joints by ordinary least squares on its own recording."""
    r = recording.regression(signal_settings(config))
    return float(TorqueScorer(r.tau, r.y, metric_settings(config))(METHODS["ordinary"].estimate(r).beta).total.mean())
