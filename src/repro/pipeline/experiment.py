"""The experimental set-up from the configuration: arm, board, motions, and the bytes between them (Section V-C)."""

from dataclasses import replace

import numpy as np

from repro.errors import InputError
from repro.fpga.capture import CaptureMetadata
from repro.fpga.controller import ControlConstants
from repro.fpga.messages import encode_program
from repro.model.parameters import Array
from repro.pipeline.job import Config
from repro.signals.kinematics import ArmGeometry
from repro.signals.programs import PROGRAMS, Program, ProgramSettings, check_limits, permitted_program
from repro.streams import Stream, stream


def control_constants(config: Config) -> ControlConstants:
    """Gains and motors of the board, from section ``board``."""
    b = config["board"]
    kp, kv, hz, full = (tuple(b[key]) for key in ("kp_nm_per_rad", "kv_nm_per_rad", "pwm_hz", "full_torque_nm"))
    return ControlConstants(kp, kv, hz, full)


def mechanical_parameters(config: Config) -> Array:
    """Parameters of the simulated arm without its motors' back-EMF, shape (9,)."""
    return np.array(config["arm"]["parameters"], dtype=np.float64)


def true_parameters(config: Config) -> Array:
    """Parameters of Eq. 1 that the PWM torque of the simulated arm obeys, shape (9,).

    Back-EMF is a torque -k_e dq, which cannot be distinguished from viscous friction in a torque computed from the PWM.
    """
    beta = mechanical_parameters(config)
    beta[5:7] += config["arm"]["back_emf_nm_s_per_rad"]
    return beta


def program_settings(config: Config) -> ProgramSettings:
    """Lengths and filters of the motions, from sections ``signals``, ``arm`` and ``experiment``."""
    s, e = config["signals"], config["experiment"]
    return ProgramSettings(
        geometry=ArmGeometry(*config["arm"]["link_lengths_m"]),
        duration=s["duration_s"],
        h=s["sampling_period_s"],
        margin=e["margin_samples"],
        lead_in=e["lead_in_s"],
        validation_samples=e["validation_samples"],
        t1_bands=e["random_bands"],
        t1_limit=e["random_range_rad"],
        t1_range_of=e["random_range_of"],
    )


def limits(config: Config) -> tuple[tuple[float, float], float]:
    """Torque (N m) that motions may ask of the nominal arm, and speed (rad/s); friction needs the rest."""
    first, second = config["board"]["full_torque_nm"]
    share = config["experiment"]["torque_share"]
    return (share * first, share * second), config["board"]["speed_limit_rad_s"]


def check_program(config: Config, program: Program) -> None:
    """Refuse a motion that the arm cannot follow; see `repro.signals.programs.check_limits`."""
    check_limits(program, true_parameters(config), *limits(config))


def program_from_config(config: Config, name: str, seed: int | None = None, duration: float | None = None) -> Program:
    """One of the motions, within what the arm can do."""
    if name not in PROGRAMS:
        raise InputError.at("motion", repr(name), f"one of {', '.join(PROGRAMS)}")
    settings = program_settings(config)
    if duration is not None:
        settings = replace(settings, duration=duration)
    rng = stream(config["experiment"]["seed"] if seed is None else seed, Stream.RANDOM_MOTION)
    return permitted_program(name, settings, rng, true_parameters(config), *limits(config))


def metadata_for(program: Program, config: Config) -> CaptureMetadata:
    """Metadata of a capture of a motion, with the bytes that load it into a board."""
    control = control_constants(config)
    load = encode_program(control, program.q)
    return CaptureMetadata(program.name, program.q.shape[1], program.n1, program.n2, program.h, load, control)
