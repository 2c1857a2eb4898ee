"""The experiment on the arm (Section V-C): its arm, board and motions, and captures and recordings of them."""

import shutil
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from repro.board.capture import Capture, files_of, read_capture, recording_of, write_capture
from repro.board.controller import ControlConstants
from repro.board.frames import RADIANS_PER_COUNT
from repro.board.link import record_capture
from repro.board.logic import logic_board
from repro.board.messages import encode_program, encode_start
from repro.board.plant import Plant, Unmodelled
from repro.board.server import Board
from repro.board.sidecar import CaptureMetadata
from repro.config.model import Configuration
from repro.errors import InputError
from repro.files import atomic_write
from repro.identification.algorithm1.preprocessing import filtered
from repro.identification.regression import Regression
from repro.model.dynamics import ArmGeometry
from repro.model.parameters import Array
from repro.progress import Progress
from repro.signals.dct import SignalSettings
from repro.signals.programs import (
    PROGRAMS,
    ReferenceTrajectory,
    TrajectorySettings,
    check_limits,
    permitted_trajectory,
)
from repro.streams import Stream, stream


def control_constants(config: Configuration) -> ControlConstants:
    """Gains and motors of the board, from section ``board``."""
    b = config.board
    return ControlConstants(b.kp_nm_per_rad, b.kv_nm_per_rad, b.pwm_hz, b.full_torque_nm)


def true_parameters(config: Configuration) -> Array:
    """Parameters (9,) that the PWM torque of the simulated arm obeys, with its further viscous friction."""
    beta = np.array(config.arm.parameters, dtype=np.float64)
    beta[5:7] += config.arm.further_viscous_nm_s_per_rad
    return beta


def identification_settings(config: Configuration) -> TrajectorySettings:
    """Lengths of Eq. 10 as networks are trained on it, from ``signals`` and ``experiment``: not of the arm's ID."""
    s, e = config.signals, config.experiment
    return TrajectorySettings(
        duration=s.duration_s, h=s.sampling_period_s, margin=e.margin_samples, lead_in=e.lead_in_s
    )


def program_settings(config: Configuration) -> TrajectorySettings:
    """Lengths and shapes of the arm's motions, from sections ``signals``, ``arm`` and ``experiment``."""
    e = config.experiment
    geometry, lengths = ArmGeometry(*config.arm.link_lengths_m), identification_settings(config)
    return replace(lengths, duration=e.duration_s, geometry=geometry, t1=e.t1, t2=e.t2, t3=e.t3, t4=e.t4)


def limits(config: Configuration) -> tuple[tuple[float, float], float]:
    """Torque (N m) that motions may ask of the nominal arm, and speed (rad/s); friction needs the rest."""
    first, second = config.board.full_torque_nm
    share = config.experiment.torque_share
    return (share * first, share * second), config.board.speed_limit_rad_s


def check_program(config: Configuration, program: ReferenceTrajectory) -> None:
    """Refuse a motion that the arm cannot follow; see `repro.signals.programs.check_limits`."""
    check_limits(program, true_parameters(config), limits(config))


def program_from_config(config: Configuration, name: str, seed: int | None = None) -> ReferenceTrajectory:
    """One of the motions, within what the arm can do; T1 with a seed of its own if there is one."""
    if name not in PROGRAMS:
        raise InputError.at("motion", repr(name), f"one of {', '.join(PROGRAMS)}")
    rng = stream(config.experiment.seed if seed is None else seed, Stream.RANDOM_MOTION)
    return permitted_trajectory(name, program_settings(config), rng, true_parameters(config), limits(config))


def metadata_for(program: ReferenceTrajectory, config: Configuration) -> CaptureMetadata:
    """Metadata of a capture of a motion, with the bytes that load it into a board."""
    control = control_constants(config)
    load = encode_program(control, program.q)
    return CaptureMetadata(program.name, program.q.shape[1], program.n1, program.n2, program.h, load, control)


def disturbance(config: Configuration) -> tuple[Unmodelled, Array]:
    """What Eq. 1 leaves out of the arm: levels, and phases (2,) of the ripple, rad."""
    a = config.arm
    levels = Unmodelled(
        stribeck=a.stribeck,
        stribeck_velocity=a.stribeck_velocity_rad_s,
        ripple=a.ripple_nm,
        ripple_cycles=a.ripple_cycles,
        load_friction=a.load_friction,
        dead_band=a.dead_band_counts,
    )
    return levels, np.array(a.ripple_phase_rad)


def board_from_config(config: Configuration, make: type[Board] = Board) -> Board:
    """Simulated board with its arm; `make` is what simulates the board."""
    beta, h = true_parameters(config), config.signals.sampling_period_s
    levels, phase = disturbance(config)
    further = list(config.arm.further_viscous_nm_s_per_rad)
    stated = {"parameters": config.arm.parameters, "further_viscous_nm_s_per_rad": further}
    effects = {name: list(value) if isinstance(value, tuple) else value for name, value in asdict(levels).items()}
    identity = {"board": "simulated", "arm": {**stated, **effects, "ripple_phase": phase.tolist()}}
    return make(lambda: Plant(beta, h, levels, phase), control_constants(config).torque_per_count, identity)


@dataclass(frozen=True)
class Recording:
    """What was measured along one motion."""

    program: ReferenceTrajectory  # positions as the board received them, and the bounds of the trajectory proper
    q: Array  # measured position (rad) and torque (N m)
    tau: Array

    @classmethod
    def of_counts(cls, program: ReferenceTrajectory, position: Array, pwm: Array, config: Configuration) -> "Recording":
        """Recording of encoder and PWM counts."""
        per_count = control_constants(config).torque_per_count[:, np.newaxis]
        return cls(program, position * RADIANS_PER_COUNT, pwm * per_count)

    def regression(self, signals: SignalSettings) -> Regression:
        """What methods solve: lines 1 to 4 of Algorithm 1."""
        return filtered(self.q, self.tau, signals, self.program.n1, self.program.n2)


#: Most encoder counts by which the motion sent may differ from the configuration's: single precision costs 0.0002 on
#: motions of 3 rad, another processor's last bits 0.0003; a hundredth of a count moves no PWM value but by chance.
SAME_MOTION = 0.01


def check_recorded(capture: Capture, program: ReferenceTrajectory) -> None:
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


def read_recording(path: Path, config: Configuration) -> Recording:
    """Measured signals of a capture."""
    capture = read_capture(path)
    program = program_from_config(config, path.stem)
    check_recorded(capture, program)
    q, tau = recording_of(capture)
    still = np.ptp(q, axis=1) < 10 * RADIANS_PER_COUNT
    if still.any():
        raise InputError.at(f"{path}: joint {int(still.argmax()) + 1}", "no motion", "a joint that moves")
    return Recording(replace(program, q=capture.metadata.desired.astype(np.float64)), q, tau)


def read_recordings(captures: Sequence[str | Path], config: Configuration) -> list[Recording]:
    """Recordings of a rule's captures, whose sidecars are inputs of the rule, too."""
    return [read_recording(path, config) for path in map(Path, captures) if path.suffix == ".bin"]


def acquire(motion: str, out: Path, config: Configuration) -> None:
    """Put the capture of a motion at `out`: stored, simulated (in Python or in logic) or from a serial port."""
    e, program = config.experiment, program_from_config(config, motion)
    if e.source in ("simulated", "rtl"):
        simulate_capture(out, program, config, logic_board() if e.source == "rtl" else Board)
    elif e.source == "serial":
        record_capture(out, e.port, metadata_for(program, config), e.baud, overwrite=True)
    else:
        stored = Path(e.captures) / f"{motion}.bin"
        capture = read_capture(stored)
        check_recorded(capture, program)
        metadata = capture.metadata
        expected = "that of this configuration; record it again or set experiment.source: simulated"
        if metadata.control != control_constants(config):
            raise InputError.at(f"{capture.place}: control", "other gains or motors", expected)
        if metadata.board is not None and metadata.board != board_from_config(config).identity:
            raise InputError.at(f"{capture.place}: board", "another simulated arm", expected)
        for there, here in zip(files_of(stored), files_of(out), strict=True):
            atomic_write(here, partial(shutil.copyfile, there))


def simulate_capture(out: Path, program: ReferenceTrajectory, config: Configuration, make: type[Board]) -> None:
    """Capture of the simulated board run in this process, byte for byte what it sends over a line."""
    board, metadata = board_from_config(config, make=make), metadata_for(program, config)
    board.receive(metadata.program + encode_start(metadata.samples))
    if not board.running:
        raise InputError.at(f"simulated board: {program.name}", "; ".join(board.refusals), "a start")
    progress, data = Progress(f"simulating {program.name}"), bytearray()
    while board.running:
        data += board.tick()
        progress(len(data) // 8, metadata.samples)
    write_capture(out, bytes(data), replace(metadata, board=board.identity), overwrite=True)
