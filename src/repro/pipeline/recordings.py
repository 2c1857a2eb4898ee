"""Captures read back: the measured signals of one motion."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from repro.errors import InputError
from repro.fpga.capture import Capture, read_capture
from repro.fpga.frames import RADIANS_PER_COUNT
from repro.fpga.recording import recording_of
from repro.identification.algorithm1.preprocessing import filtered
from repro.identification.regression import Regression
from repro.model.parameters import Array
from repro.pipeline.experiment import program_from_config
from repro.pipeline.job import Config
from repro.signals.programs import Program
from repro.signals.sampling import SignalSettings


@dataclass(frozen=True)
class Recording:
    """What was measured along one motion."""

    program: Program  # desired positions as the board received them, and where the trajectory proper begins and ends
    q: Array  # measured position (rad) and torque (N m)
    tau: Array

    def regression(self, signals: SignalSettings) -> Regression:
        """What methods solve: lines 1 to 4 of Algorithm 1."""
        return filtered(self.q, self.tau, signals, self.program.n1, self.program.n2)


#: Most encoder counts by which the motion sent may differ from the configuration's: single precision costs 0.0002 on
#: motions of 3 rad, another processor's last bits 0.0003; a hundredth of a count moves no PWM value but by chance.
SAME_MOTION = 0.01


def check_recorded(capture: Capture, program: Program) -> None:
    """Refuse a capture of another motion than the configuration's."""
    metadata = capture.metadata
    found, expected = (metadata.samples, metadata.n1, metadata.n2), (program.q.shape[1], program.n1, program.n2)
    apart = np.abs(metadata.desired - program.q).max() / RADIANS_PER_COUNT if found == expected else np.inf
    if apart > SAME_MOTION:
        what = f"{apart:.3g} encoder counts away" if np.isfinite(apart) else f"samples, n1, n2 of {found}"
        raise InputError.at(
            f"{capture.place}: trajectory",
            f"a recording of another {program.name}, {what}",
            f"that of this configuration {expected}; record it again or set experiment.source: simulated",
        )


def read_recording(path: Path, config: Config) -> Recording:
    """Measured signals of a capture."""
    capture = read_capture(path)
    program = program_from_config(config, path.stem)
    check_recorded(capture, program)
    measured = recording_of(capture)
    still = np.ptp(measured.q, axis=1) < 10 * RADIANS_PER_COUNT
    if still.any():
        raise InputError.at(f"{path}: joint {int(still.argmax()) + 1}", "no motion", "a joint that moves")
    return Recording(replace(program, q=capture.metadata.desired.astype(np.float64)), measured.q, measured.tau)


def read_recordings(captures: Sequence[str | Path], config: Config) -> list[Recording]:
    """Recordings of a rule's captures, whose sidecars are inputs of the rule, too."""
    return [read_recording(path, config) for path in map(Path, captures) if path.suffix == ".bin"]
