"""Captures read back: the measured signals of one motion."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from repro.errors import InputError
from repro.fpga.about import trajectory_digest
from repro.fpga.capture import Capture, read_capture
from repro.fpga.frames import RADIANS_PER_COUNT
from repro.fpga.recorded import samples
from repro.model.parameters import Array
from repro.pipeline.experiment import program_from_config
from repro.pipeline.named import Config
from repro.signals.programs import Program


@dataclass(frozen=True)
class Recording:
    """What was measured along one motion.

    Attributes
    ----------
    program : Program
        Desired positions and where the trajectory proper begins and ends.
    q, tau : arrays of shape (2, N)
        Measured position (rad) and torque (N m).
    """

    program: Program
    q: Array
    tau: Array


def check_recorded(capture: Capture, program: Program) -> None:
    """Refuse a capture of another motion than the configuration's."""
    if capture.about.trajectory_sha256 != trajectory_digest(program.q):
        raise InputError.at(
            f"{capture.place}: trajectory",
            f"a recording of another {program.name}",
            "that of this configuration; record it again or set experiment.source: simulated",
        )


def read_recording(path: Path, config: Config) -> Recording:
    """Measured signals of a capture.

    Parameters
    ----------
    path : Path
        ``NAME.bin`` of one of the five motions.
    config : mapping
        Sections ``signals``, ``arm``, ``board`` and ``experiment``.

    Returns
    -------
    Recording
        Short gaps are filled; see `repro.fpga.recorded.samples`.

    Raises
    ------
    InputError
        If the capture is damaged, incomplete, of another motion, or the arm did not move.
    """
    capture = read_capture(path)
    program = program_from_config(config, path.stem)
    check_recorded(capture, program)
    measured = samples(capture)
    still = np.ptp(measured.q, axis=1) < 10 * RADIANS_PER_COUNT
    if still.any():
        raise InputError.at(f"{path}: joint {int(still.argmax()) + 1}", "no motion", "a joint that moves")
    return Recording(program, measured.q, measured.tau)
