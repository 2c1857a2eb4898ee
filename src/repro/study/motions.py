"""Motions that the study identifies arms from: Eq. 10, the same at half its pace, a random and a D-optimal one."""

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

#: Pace of the slow one over that of Eq. 10.
SLOW_PACE = 0.5
#: Harmonics of the D-optimal motion, its range of position (rad) and speed (rad/s), and the share of the torque limit
#: that it asks of the stored arm: other arms have more friction.
HARMONICS, RANGE, SPEED, TORQUE_SHARE = 8, 1.5, 5.0, 0.6


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
