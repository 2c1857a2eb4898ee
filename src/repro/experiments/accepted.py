"""Accepted experiments: arms, unmodelled effects and motions that the printed numbers do not rule out."""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from repro.board.controller import simulate
from repro.board.plant import Plant
from repro.config.model import Configuration
from repro.config.sections import changed
from repro.experiments.arm import Recording, control_constants, disturbance, program_from_config, true_parameters
from repro.files import read_csv, read_tensors, write_tensors
from repro.model.parameters import NAMES, Array
from repro.progress import Progress
from repro.signals.programs import PROGRAMS

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


def settings_of(values: Mapping[Hashable, Any]) -> dict[str, Any]:
    """Settings of the experiment with the columns of a row of ``data/experiments/accepted.csv``."""

    def pair(name: str) -> list[float]:
        return [float(values[f"{name}1"]), float(values[f"{name}2"])]

    def motion(name: str, *quantities: str) -> dict[str, Any]:
        return {"samples": int(values[f"{name}_samples"])} | {x: float(values[f"{name}_{x}"]) for x in quantities}

    l1 = float(values["l1"])
    arm = {
        "parameters": [float(values[name]) for name in NAMES],
        "link_lengths_m": [l1, round(REACH - l1, 9)],
        "further_viscous_nm_s_per_rad": pair("viscous"),
        "stribeck": pair("stribeck"),
        "stribeck_velocity_rad_s": float(values["stribeck_velocity"]),
        "ripple_nm": pair("ripple"),
        "ripple_cycles": float(values["ripple_cycles"]),
        "ripple_phase_rad": pair("ripple_phase"),
        "load_friction": pair("load_friction"),
    }
    sinusoid = {"amplitude_rad": pair("t4_amplitude"), "frequency_hz": pair("t4_frequency")}
    experiment = {
        "duration_s": float(values["duration_s"]),
        "seed": int(values["seed"]),
        "t1": motion("t1", "bands") | {"range_of": "numbers"},
        "t2": motion("t2", "turns", "centre"),
        "t3": motion("t3", "levels"),
        "t4": motion("t4") | sinusoid,
    }
    return {"signals": {"frequency_reading": values["unit"]}, "arm": arm, "experiment": experiment}


def experiment_config(values: Mapping[Hashable, Any], config: Configuration) -> Configuration:
    """Configuration of an experiment; board and methods are those of `config`."""
    return changed(config, settings_of(values))


def read_experiments(path: Path) -> pd.DataFrame:
    """Read the accepted experiments, the one with the smallest misfit first."""
    return read_csv(path, ("experiment", *NAMES, *SETTINGS))


def _padded(arrays: list[Array]) -> Array:
    """Stack motions (2, N) of unequal length, held at their end."""
    longest = max(q.shape[-1] for q in arrays)
    return np.stack([np.pad(q, ((0, 0), (0, longest - q.shape[-1])), mode="edge") for q in arrays])


def simulate_accepted(experiments: Path, out: Path, config: Configuration) -> None:
    """Simulate every accepted experiment on all motions, as one batch by the quick method, and keep the counts."""
    each = [experiment_config(row, config) for row in read_experiments(experiments).to_dict("records")]
    programs = [program_from_config(one, name) for name in PROGRAMS for one in each]
    effects, phases = zip(*(disturbance(one) for one in each), strict=True)
    arms, phase = (np.tile(x, (len(PROGRAMS), 1)) for x in (list(map(true_parameters, each)), phases))
    plant = Plant(arms, programs[0].h, effects * len(PROGRAMS), phase, quick=True)
    desired, progress = _padded([program.q for program in programs]), Progress("simulating accepted experiments")
    position, pwm = simulate(plant, control_constants(config), desired, progress)
    write_tensors(out, {"position": position, "pwm": pwm})


@dataclass(frozen=True)
class Experiment:
    """One accepted experiment with its recordings."""

    number: int
    config: Configuration
    recordings: list[Recording]  # of ID, then of T1 to T4

    @property
    def true(self) -> Array:
        """Parameters (9,) of its arm."""
        return true_parameters(self.config)


def read_accepted(experiments: Path, counts: Path, config: Configuration) -> list[Experiment]:
    """All accepted experiments with the recordings of `simulate_accepted`."""
    table = read_experiments(experiments).to_dict("records")
    kept, _ = read_tensors(counts, "recordings of the accepted experiments")
    position, pwm = (
        kept[name].reshape(len(PROGRAMS), len(table), *kept[name].shape[1:]) for name in ("position", "pwm")
    )
    found = []
    for place, row in enumerate(table):
        own, recordings = experiment_config(row, config), []
        for k, name in enumerate(PROGRAMS):
            program = program_from_config(own, name)
            proper = np.s_[k, place, :, : program.q.shape[1]]
            sent = replace(program, q=program.q.astype(np.float32).astype(np.float64))  # as the board receives it
            recordings.append(Recording.of_counts(sent, position[proper], pwm[proper], own))
        found.append(Experiment(int(row["experiment"]), own, recordings))
    return found


def of_this_unit(experiments: list[Experiment], config: Configuration) -> list[Experiment]:
    """Those with the unit of omega that the configuration has, so that its networks read them."""
    unit = config.signals.frequency_reading
    return [one for one in experiments if one.config.signals.frequency_reading == unit]


def experiment_units(path: Path) -> dict[int, str]:
    """Unit of omega of each accepted experiment by its number; none where there is no such file."""
    if not path.is_file():
        return {}
    table = read_experiments(path)
    return dict(zip(table["experiment"].tolist(), table["unit"].tolist(), strict=True))
