"""A short experiment without a simulation: recordings of an arm that follows its program perfectly."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from repro.board.capture import write_capture
from repro.board.frames import RADIANS_PER_COUNT, encode
from repro.config import sections as own
from repro.config.check import load_config
from repro.errors import InputError
from repro.experiments.arm import control_constants, metadata_for, program_from_config, true_parameters
from repro.model.dynamics import inverse_dynamics

ROOT = Path(__file__).resolve().parents[2]
CAPTURES = ROOT / "data" / "captures"
MOTIONS = ("ID", "T1", "T2", "T3", "T4")


def refused(call, *arguments, **options):
    """The error that a call with wrong input ends in: one line of place, found and expected."""
    with pytest.raises(InputError) as caught:
        call(*arguments, **options)
    error = caught.value
    assert error.place and error.found and error.expected
    assert str(error) == f"{error.place}: found {error.found}, expected {error.expected}"
    return error


def refusal_in(line):
    """The error that a program printed as its last line."""
    return InputError.at(*re.fullmatch(r"(.+?): found (.+), expected (.+)\n?", line).groups())


def full_config():
    """The configuration of the repository."""
    return load_config(ROOT / "config" / "config.yaml")


def changed(config, **sections):
    """A copy with some values of some sections replaced."""
    return own.changed(config, sections)


def short_config():
    """Motions of a few seconds, and motors strong enough for them."""
    brief = {"t1": {"samples": 2400, "range_rad": 0.1}, "t2": {"samples": 2400}, "t3": {"samples": 2400}}
    brief |= {"t4": {"samples": 2400}, "duration_s": 6.0, "search_seeds": [1, 2, 3]}
    return changed(full_config(), signals={"duration_s": 6.0}, board={"full_torque_nm": (8.0, 8.0)}, experiment=brief)


def followed(program, config):
    """Counts of a perfect run: positions rounded, torques from Eq. 1."""
    q, h = program.q, program.h
    dq = np.gradient(q, h, axis=1)
    tau = inverse_dynamics(q, dq, np.gradient(dq, h, axis=1), true_parameters(config))
    counts = np.rint(tau / control_constants(config).torque_per_count[:, None]).clip(-1023, 1023)
    return np.rint(q / RADIANS_PER_COUNT).astype(int), counts.astype(int)


def capture(folder, motion, config, frames=None):
    """Capture of a perfect run or of other frames, written to a folder."""
    program = program_from_config(config, motion)
    metadata = replace(metadata_for(program, config), board={"board": "simulated"})
    path = folder / f"{motion}.bin"
    write_capture(path, encode(*followed(program, config)) if frames is None else frames, metadata)
    return path
