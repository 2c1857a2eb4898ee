"""Motions and arms of the study, what makes their torque differ from Eq. 1, and their recordings."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from repro.board.plant import Unmodelled
from repro.config.model import Configuration
from repro.config.sections import changed
from repro.errors import InputError
from repro.experiments.arm import Recording, limits, program_from_config, program_settings, true_parameters
from repro.experiments.simulated_arms import draw_arms, draw_built_arms, is_within_limits, run_loop, tracks
from repro.files import read_tensors, write_tensors
from repro.identification.armfile import Arm
from repro.identification.exciting_motion import Envelope, design
from repro.identification.least_squares import METHODS
from repro.model.parameters import Array
from repro.signals.metric import TorqueScorer
from repro.signals.programs import VALIDATION, ReferenceTrajectory
from repro.signals.validation_motions import random_motion
from repro.streams import Stream, stream
from repro_studies.design import FACTORS, TRAINED_ON, StudyCell

#: A narrow prior: each parameter of the stored arm, times or divided by up to this factor.
NARROW = 1.5
#: Arms that are simulated for each that is wanted, to see whether they track.
SPARE = 2
#: Arms in the list of a law for each that is simulated to train on.
LISTED = 160
#: Motion on which the size of the effects is set, whatever motion an arm is identified by.
REFERENCE = "eq10"
#: Arms that are drawn at a time, and samples of a motion of which one is examined.
PIECE, EVERY = 2000, 8
#: The amplitude of the effects is found in so many steps, each by at most this factor.
STEPS, LARGEST_STEP = 8, 5.0
#: Harmonics of the D-optimal motion, its range of position (rad) and speed (rad/s), and its share of the torque limit
#: of the stored arm: other arms have more friction.
HARMONICS, RANGE, SPEED, TORQUE_SHARE = 8, 1.5, 5.0, 0.6


def draw_law(law: str, rng: np.random.Generator, n: int, config: Configuration) -> Array:
    """Parameters (n, 9) of arms from the law of a prior."""
    if law == "narrow":
        return true_parameters(config) * np.exp(rng.uniform(-np.log(NARROW), np.log(NARROW), (n, 9)))
    return {"wide": draw_arms, "mismatched": draw_built_arms}[law](rng, n, config)


def prior_stream(config: Configuration, name: Stream, prior: str, *index: int) -> np.random.Generator:
    """Generator of one use of the study's seed for a prior, whichever other priors are in the study."""
    return stream(config.study.seed, name, [*TRAINED_ON].index(prior), *index)


def with_friction(beta: Array, factor: float) -> Array:
    """The same arms with their friction multiplied."""
    return np.asarray(beta * ([1.0] * 5 + [factor] * 4))


@dataclass(frozen=True)
class Effects:
    """What Eq. 1 leaves out of n arms. Only the first two act in the loop; the others act on what is recorded."""

    #: (5, n, 2): increase of Coulomb friction near standstill over its size; amplitude of a torque that turns with the
    #: joint, N m; deflection between encoder and link, rad/(N m); by how much the torque constant changes with the
    #: torque, 1/(N m); delay of the recorded torque, s.
    levels: Array
    phase: Array  # (n, 2), of the ripple, rad

    @classmethod
    def drawn(cls, rng: np.random.Generator, beta: Array) -> "Effects":
        """Levels of an amplitude of 1 for arms (n, 9), in proportion to the torque that holds each joint."""
        load = np.stack([beta[:, 3] + beta[:, 4] + beta[:, 7], beta[:, 4] + beta[:, 8]], axis=1)
        part = rng.uniform(0.0, 1.0, (4, *load.shape))
        delay = np.repeat(rng.uniform(0.0, 2.5e-3, (len(beta), 1)), 2, axis=1)
        levels = np.stack([part[0], 0.1 * part[1] * load, 0.01 * part[2] / load, 0.1 * part[3] / load, delay])
        return cls(levels, rng.uniform(0.0, 2.0 * np.pi, load.shape))

    def times(self, amplitude: Array) -> "Effects":
        """Multiply the effects of each arm by its amplitude (n,)."""
        return replace(self, levels=amplitude[:, np.newaxis] * self.levels)

    def observed(self, k: int, one: Recording) -> Recording:
        """What is recorded of arm `k` instead of its position and torque."""
        compliance, saturation, delay = self.levels[2:, k, :, np.newaxis]
        n, scaled = np.arange(one.tau.shape[1]), one.tau * (1.0 + saturation * np.abs(one.tau))
        late = [np.interp(n - d / one.program.h, n, x) for d, x in zip(delay, scaled, strict=True)]
        return replace(one, q=one.q + compliance * one.tau, tau=np.stack(late))


def record(
    config: Configuration, beta: Array, programs: Sequence[ReferenceTrajectory], effects: Effects, what: str
) -> list[Recording]:
    """Recordings of arms (n, 9), each along its own motion."""
    unmodelled = [Unmodelled(stribeck=s, ripple=r) for s, r in zip(*effects.levels[:2].tolist(), strict=True)]
    desired = np.stack([program.q for program in programs])
    counts = run_loop(config, beta, desired, what, unmodelled, effects.phase, quick=True)
    recordings = [Recording.of_counts(*one, config) for one in zip(programs, *counts, strict=True)]
    return [effects.observed(k, one) for k, one in enumerate(recordings)]


def excitation_config(config: Configuration, excitation: str) -> Configuration:
    """Configuration with the length of an excitation; the slow one has half the pace of Eq. 10."""
    duration = config.signals.duration_s / (0.5 if excitation == "slow" else 1.0)
    return changed(config, {section: {"duration_s": duration} for section in ("signals", "experiment")})


def excitation_program(config: Configuration, excitation: str) -> ReferenceTrajectory:
    """Motion that arms are identified from and that the stored arm can do: of Eq. 10, random or D-optimal."""
    c = excitation_config(config, excitation)
    if excitation in ("eq10", "slow"):
        return program_from_config(c, "ID")
    h, margin = c.signals.sampling_period_s, c.experiment.margin_samples
    samples = round(c.signals.duration_s / h) + 2 * margin
    rng = stream(c.study.seed, Stream.STUDY_MOTION, int(excitation == "optimal"))
    if excitation == "random":
        t = program_settings(c)
        motion = random_motion(rng, replace(t.t1, samples=samples), h)
    else:
        first, second = limits(c)[0]
        torque = TORQUE_SHARE * first, TORQUE_SHARE * second
        arm = Arm(position_limit=((-RANGE, RANGE),) * 2, speed_limit=(SPEED, SPEED), torque_limit=torque)
        motion = design(Envelope(arm, true_parameters(c)), (samples - 1, h), HARMONICS, np.array([0.05, 0.05]), rng)
    return ReferenceTrajectory("ID", motion.q, margin, samples - margin, h)


def choose(config: Configuration, out: Path) -> None:
    """Write the excitations, the arms of each prior that are tested, and a list of those of each law to learn from."""
    s = config.study
    excitations = {name: excitation_program(config, name) for name in dict.fromkeys((REFERENCE, *s.excitations))}
    kept: dict[str, NDArray[Any]] = {}
    for prior in s.priors:
        drawn = _able(prior, Stream.STUDY_ARMS, SPARE * s.arms, config, excitations)
        for program in excitations.values():
            for factor in (min(s.frictions), max(s.frictions)):
                if len(drawn):
                    position, _ = run_loop(config, with_friction(drawn, factor), program.q, quick=True)
                    drawn = drawn[tracks(config, position, program)]
        if len(drawn) < s.arms:
            raise InputError.at("study.arms", s.arms, f"at most {len(drawn)}, which follow all motions")
        kept[f"arms/{prior}"] = drawn[: s.arms]
    for law in {TRAINED_ON[prior]: None for prior in s.priors}:
        kept[f"law/{law}"] = _able(law, Stream.STUDY_LAW, LISTED * s.training_arms, config, excitations)
    for name, program in excitations.items():
        kept[f"motion/{name}"] = program.q.astype(np.float32)  # as the board receives it
        kept[f"proper/{name}"] = np.array([program.n1, program.n2], dtype=np.int32)
    write_tensors(out, kept)


def _able(
    prior: str, use: Stream, n: int, config: Configuration, excitations: Mapping[str, ReferenceTrajectory]
) -> Array:
    """The first n arms of a prior whose motors can do all its motions, examined at every `EVERY`-th sample."""
    s, rng, able = config.study, prior_stream(config, use, prior), [np.empty((0, 9))]
    validation = {(p.name, p.q.tobytes()): p for k in range(s.arms) for p in _validation(config, prior, k)}
    motions = [*excitations.values(), *validation.values()]
    thin = [replace(p, q=p.q[:, ::EVERY], n1=p.n1 // EVERY, n2=p.n2 // EVERY, h=p.h * EVERY) for p in motions]
    while sum(map(len, able)) < n:
        beta = draw_law(prior, rng, PIECE, config)
        for program in thin:
            beta = beta[is_within_limits(config, with_friction(beta, max(s.frictions)), program)]
        if not len(beta):
            found = f"at most 0, as none of {PIECE} drawn ones can do all motions"
            raise InputError.at("study.arms", s.arms, found)
        able.append(beta)
    return np.concatenate(able)[:n]


def _validation(config: Configuration, prior: str, k: int) -> list[ReferenceTrajectory]:
    """Motions T1 to T4 of arm number `k` of a prior."""
    seed = int(prior_stream(config, Stream.STUDY_VALIDATION, prior, k).integers(2**32))
    return [program_from_config(config, name, seed) for name in VALIDATION]


def read_choice(
    path: Path, config: Configuration, excitation: str
) -> tuple[ReferenceTrajectory, dict[str, NDArray[Any]]]:
    """An excitation as the board receives it, and all that `choose` wrote."""
    kept, _ = read_tensors(path, "motions and arms of the study")
    q, (begin, end) = kept[f"motion/{excitation}"].astype(np.float64), kept[f"proper/{excitation}"].tolist()
    return ReferenceTrajectory("ID", q, begin, end, config.signals.sampling_period_s), kept


@dataclass(frozen=True)
class Specimen:
    """One arm of the study in one cell."""

    seed: int  # of its guesses
    labels: Mapping[str, Any]  # its columns in tables
    true: Array
    recordings: Sequence[Recording]  # of ID, then of T1 to T4


def specimens(config: Configuration, cells: Sequence[StudyCell], choice: Path) -> list[Specimen]:
    """Record the arms of a prior in cells of one excitation.

    Effects are drawn once for each arm. In each cell one amplitude of all of them is found for each arm, so that
    ordinary least squares reaches the cell's similarity on `REFERENCE`: 1 - S^2.5, the relative error in the frequency
    factor of metr2ev, is nearly proportional to it. So cells that differ in the excitation have the same arms.
    """
    program, kept = read_choice(choice, config, cells[0].excitation)
    reference, _ = read_choice(choice, config, REFERENCE)
    arms = kept[f"arms/{cells[0].prior}"]
    c, n = excitation_config(config, cells[0].excitation), len(arms)
    beta = np.concatenate([with_friction(arms, cell.friction) for cell in cells])
    drawn = Effects.drawn(prior_stream(config, Stream.STUDY_EFFECTS, cells[0].prior), arms)
    unit = Effects(np.tile(drawn.levels, (1, len(cells), 1)), np.tile(drawn.phase, (len(cells), 1)))
    target = np.repeat([1.0 - cell.discrepancy**2.5 for cell in cells], n)
    amplitude = np.ones(len(beta))
    for remaining in reversed(range(STEPS)):
        recorded = record(config, beta, [reference] * len(beta), unit.times(amplitude), f"runs of {REFERENCE}")
        reached = [_least_squares_similarity(recording, config) for recording in recorded]
        if remaining:
            factor = target / np.maximum(1.0 - np.array(reached) ** 2.5, 1e-6)
            amplitude *= np.clip(factor, 1.0 / LARGEST_STEP, LARGEST_STEP)
    motions = [[program, *_validation(config, cells[0].prior, k)] for k in range(n)] * len(cells)
    by_motion, effects = zip(*motions, strict=True), unit.times(amplitude)
    runs = zip(*(record(c, beta, same, effects, f"runs of {same[0].name}") for same in by_motion), strict=True)
    labels = [{**{name: getattr(cell, name) for name in FACTORS}, "arm": k} for cell in cells for k in range(n)]
    return [
        Specimen(label["arm"] + 1, {**label, "least_squares": similarity}, true, own)
        for label, similarity, true, own in zip(labels, reached, beta, runs, strict=True)
    ]


def _least_squares_similarity(recording: Recording, config: Configuration) -> float:
    """Mean similarity of both joints by ordinary least squares on its own recording."""
    r = recording.regression(config.signals)
    return float(TorqueScorer(r.tau, r.y, config.metric)(METHODS["ordinary"].estimate(r).beta).total.mean())
