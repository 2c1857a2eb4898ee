"""The design of the study: its cells, and the motions that arms are identified from.

A cell is a combination of four factors. Its blocks are arms, the same in all cells of one prior, so that cells and
methods are compared on the same arms.
"""

from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from repro.config import merged
from repro.identification.exciting_motion import Envelope, design
from repro.logs.armfile import Arm
from repro.pipeline.experiment import limits, program_from_config, program_settings, true_parameters
from repro.pipeline.job import Config
from repro.progress import Progress
from repro.signals.programs import ReferenceTrajectory
from repro.signals.trajectories import Motion
from repro.signals.validation_motions import random_motion
from repro.streams import Stream, stream

#: Networks: of the amortised posterior, and of Algorithm 1 trained on the ideal motion and on motions as arms track it.
POSTERIOR, ALGORITHM1, TRACKED = NETWORKS = ("posterior", "algorithm1", "algorithm1+tracked")
#: Pace of the slow one over that of Eq. 10.
SLOW_PACE = 0.5
#: Law of the training arms for each prior; tested arms are of that law, but of another one if it is mismatched.
TRAINED_ON = {"wide": "wide", "narrow": "narrow", "mismatched": "wide"}
#: Harmonics of the D-optimal motion, its range of position (rad) and speed (rad/s), and the share of the torque limit
#: that it asks of the stored arm: other arms have more friction.
HARMONICS, RANGE, SPEED, TORQUE_SHARE = 8, 1.5, 5.0, 0.6


@dataclass(frozen=True)
class Cell:
    """One combination of the factors."""

    excitation: str
    discrepancy: float  # similarity that ordinary least squares is to reach on the excitation
    prior: str
    friction: float  # factor on the friction of the arms that are tested
    searched: bool  # whether Algorithm 1 is run, too


def cells(config: Config) -> list[Cell]:
    """All cells in order; Algorithm 1 is run in every `cnn_fraction`-th of them, balanced over pairs of factors."""
    s = config["study"]
    factors = [list(enumerate(s[name])) for name in ("excitations", "discrepancies", "priors", "frictions")]
    return [
        Cell(excitation, discrepancy, prior, friction, searched=(i + j + k + m) % s["cnn_fraction"] == 0)
        for (i, excitation), (j, discrepancy), (k, prior), (m, friction) in product(*factors)
    ]


def jobs(config: Config) -> dict[str, list[Cell]]:
    """Cells by the name of their job: those of one excitation and one prior need the same networks."""
    found: dict[str, list[Cell]] = {}
    groups: dict[str, list[Cell]] = {}
    for cell in cells(config):
        groups.setdefault(f"{cell.excitation}-{cell.prior}", []).append(cell)
    size = config["study"]["cells_per_job"]
    for name, members in groups.items():
        found |= {f"{name}-{k // size}": members[k : k + size] for k in range(0, len(members), size)}
    return found


# --- Motions ------------------------------------------------------------------------------------------------------


def excitation_config(config: Config, excitation: str) -> dict[str, Any]:
    """Configuration with the length of an excitation."""
    duration = config["signals"]["duration_s"]
    return merged(config, {"signals": {"duration_s": duration / SLOW_PACE if excitation == "slow" else duration}})


def excitation_program(config: Config, excitation: str) -> ReferenceTrajectory:
    """Motion that arms are identified from, which the stored arm can do."""
    c = excitation_config(config, excitation)
    if excitation in ("eq10", "slow"):
        return program_from_config(c, "ID")
    h, margin = c["signals"]["sampling_period_s"], c["experiment"]["margin_samples"]
    samples = round(c["signals"]["duration_s"] / h) + 2 * margin
    if excitation == "random":
        t = program_settings(c)
        rng = stream(c["study"]["seed"], Stream.STUDY_MOTION)
        motion = random_motion(rng, t.t1_bands, t.t1_limit, t.t1_range_of, samples, h)
    else:
        motion = _optimal(c, (samples - 1, h))
    return ReferenceTrajectory("ID", motion.q, margin, samples - margin, h)


def _optimal(config: Config, times: tuple[int, float]) -> Motion:
    """D-optimal motion within the limits of the stored arm, from and to rest."""
    first, second = limits(config)[0]
    torque = (TORQUE_SHARE * first, TORQUE_SHARE * second)
    arm = Arm(position_limit=((-RANGE, RANGE),) * 2, speed_limit=(SPEED, SPEED), torque_limit=torque)
    envelope = Envelope(arm, true_parameters(config))
    rng = stream(config["study"]["seed"], Stream.STUDY_MOTION)
    return design(envelope, times, HARMONICS, np.array([0.05, 0.05]), rng, Progress("searching for a motion"))
