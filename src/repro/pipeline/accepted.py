"""Accepted experiments: arms, unmodelled effects and motions that the printed numbers do not rule out."""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from repro.files import read_csv, read_tensors, write_tensors
from repro.fpga.controller import simulate
from repro.fpga.plant import Plant, Unmodelled
from repro.model.dynamics import ArmGeometry
from repro.model.parameters import NAMES, Array
from repro.pipeline.experiment import Recording, control_constants, identification_settings
from repro.pipeline.job import Config
from repro.progress import Progress
from repro.settings import signal_settings
from repro.signals.dct import SignalSettings
from repro.signals.programs import PROGRAMS, ReferenceTrajectory, TrajectorySettings, reference_trajectory
from repro.signals.validation_motions import Circle, Profile, RandomMotion, Sinusoid
from repro.streams import Stream, stream

#: What makes an experiment besides the parameters of its arm.
SETTINGS = (
    *("unit", "duration_s", "l1", "viscous1", "viscous2", "stribeck1", "stribeck2", "stribeck_velocity"),
    *("ripple1", "ripple2", "ripple_cycles", "ripple_phase1", "ripple_phase2", "load_friction1", "load_friction2"),
    *("seed", "t1_samples", "t1_bands", "t2_samples", "t2_turns", "t2_centre", "t3_samples", "t3_levels"),
    *("t4_samples", "t4_amplitude1", "t4_amplitude2", "t4_frequency1", "t4_frequency2"),
)
#: Columns of the scores of an experiment.
GUESSES = (
    *("experiment", "unit", "method", "seed", "guesses", "met", "similarity"),
    *("case", "joint", "time", "frequency", "total"),
)
REACH = 0.315  # l1 + l2, m: 2.52 m/s at 8 rad/s (Section III)


@dataclass(frozen=True, eq=False)
class Experiment:
    """One arm with its unmodelled effects and its five motions."""

    true: Array  # parameters (9,) that the PWM torque obeys
    effects: Unmodelled
    phase: Array  # of the ripple (2,), rad
    signals: SignalSettings  # with the unit of omega
    trajectories: TrajectorySettings
    seed: int  # of T1

    def program(self, name: str) -> ReferenceTrajectory:
        """One motion; of T1 the first that its seed draws."""
        return reference_trajectory(name, self.trajectories, stream(self.seed, Stream.RANDOM_MOTION))


def experiment_of(values: Mapping[Hashable, Any], config: Config) -> Experiment:
    """Experiment with the columns of a row of ``data/experiments/accepted.csv``; the board is the configuration's."""

    def pair(name: str) -> tuple[float, float]:
        return float(values[f"{name}1"]), float(values[f"{name}2"])

    def samples(name: str) -> int:
        return int(values[f"{name}_samples"])

    l1 = float(values["l1"])
    further = np.zeros(len(NAMES))
    further[5:7] = pair("viscous")
    effects = Unmodelled(
        stribeck=pair("stribeck"),
        stribeck_velocity=float(values["stribeck_velocity"]),
        ripple=pair("ripple"),
        ripple_cycles=float(values["ripple_cycles"]),
        load_friction=pair("load_friction"),
    )
    trajectories = replace(
        identification_settings(config),
        geometry=ArmGeometry(l1, REACH - l1),
        duration=float(values["duration_s"]),
        t1=RandomMotion(samples("t1"), float(values["t1_bands"]), range_of="numbers"),
        t2=Circle(samples("t2"), float(values["t2_turns"]), float(values["t2_centre"])),
        t3=Profile(samples("t3"), float(values["t3_levels"])),
        t4=Sinusoid(samples("t4"), pair("t4_amplitude"), pair("t4_frequency")),
    )
    return Experiment(
        np.array([float(values[name]) for name in NAMES]) + further,
        effects,
        np.array(pair("ripple_phase")),
        replace(signal_settings(config), omega_unit=values["unit"]),
        trajectories,
        int(values["seed"]),
    )


def read_experiments(path: Path) -> pd.DataFrame:
    """Read the accepted experiments, the one with the smallest misfit first."""
    return read_csv(path, ("experiment", *NAMES, *SETTINGS))


def simulate_accepted(experiments: Path, out: Path, config: Config) -> None:
    """Simulate every accepted experiment on all motions, as one batch by the quick method, and keep the counts."""
    each = [experiment_of(row, config) for row in read_experiments(experiments).to_dict("records")]
    programs = [one.program(name) for name in PROGRAMS for one in each]
    longest = max(program.q.shape[1] for program in programs)
    desired = np.stack([np.pad(p.q, ((0, 0), (0, longest - p.q.shape[1])), mode="edge") for p in programs])
    arms = np.tile([one.true for one in each], (len(PROGRAMS), 1))
    effects, phases = (
        [one.effects for one in each] * len(PROGRAMS),
        np.tile([x.phase for x in each], (len(PROGRAMS), 1)),
    )
    plant = Plant(arms, programs[0].h, effects, phases, quick=True)
    position, pwm = simulate(plant, control_constants(config), desired, Progress("simulating accepted experiments"))
    write_tensors(out, {"position": position, "pwm": pwm})


def recordings_of(experiment: Experiment, place: int, counts: Path, config: Config) -> list[Recording]:
    """Recordings of the experiment at a place of the file, ID first."""
    kept, _ = read_tensors(counts, "recordings of the accepted experiments")
    position, pwm = (
        kept[name].reshape(len(PROGRAMS), -1, *kept[name].shape[1:])[:, place] for name in ("position", "pwm")
    )
    recordings = []
    for k, name in enumerate(PROGRAMS):
        program = experiment.program(name)
        own = np.s_[k, :, : program.q.shape[1]]
        sent = replace(program, q=program.q.astype(np.float32).astype(np.float64))
        recordings.append(Recording.of_counts(sent, position[own], pwm[own], config))
    return recordings


def experiment_units(path: Path) -> dict[int, str]:
    """Unit of omega of each accepted experiment by its number; none where there is no such file."""
    if not path.is_file():
        return {}
    table = read_experiments(path)
    return dict(zip(table["experiment"].tolist(), table["unit"].tolist(), strict=True))
