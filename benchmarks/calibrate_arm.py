"""The simulated arm from printed numbers: what is solved for, what follows, and which T1 agrees with Table 10.

Solved for: back-EMF, k2 and the levels of what Eq. 1 does not model (Stribeck friction and ripple of each joint, by one
factor a joint), so that the recorded specimen has

- the least-squares totals of ID (Table 10),
- the mean-square torque of joint 1 that the least-squares pair of ID gives (`repro.paper.metric_search`),
- the tracking of joint 2 (Table 8).

No network has a part in this. Run from the project's folder: ``python benchmarks/calibrate_arm.py [--t1]``.
"""

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

from repro.config import load_config, merged
from repro.fpga.controller import simulate
from repro.fpga.frames import RADIANS_PER_COUNT
from repro.fpga.plant import Plant
from repro.identification.least_squares import METHODS
from repro.model.dynamics import rebuild_torque
from repro.paper.appendix import FreeChoices, appendix_arm
from repro.paper.metric_search import least_squares_torque
from repro.paper.published import load_published
from repro.pipeline.experiment import (
    Recording,
    control_constants,
    disturbance,
    program_from_config,
    program_settings,
    true_parameters,
)
from repro.settings import metric_settings, signal_settings
from repro.signals.metric import metr2ev
from repro.signals.programs import ReferenceTrajectory, reference_trajectory

CONFIG = load_config(Path("config/config.yaml"))
SIGNALS, METRIC = signal_settings(CONFIG), metric_settings(CONFIG)
#: Levels that the factors multiply: Stribeck share, and ripple in N m.
UNIT = (0.3, 0.05)
#: Readings of T1 that are tried: DCT-II bands, and what has the printed range.
T1 = [(100, "numbers"), (50, "numbers"), (25, "numbers"), *((n, "motion") for n in (5, 8, 10, 12, 15, 18, 22, 25))]


def recorded(program: ReferenceTrajectory, position: np.ndarray, pwm: np.ndarray) -> Recording:
    """Recording of counts."""
    return Recording(program, position * RADIANS_PER_COUNT, pwm * control_constants(CONFIG).torque_per_count[:, None])


def least_squares(regression):
    """Parameters by ordinary least squares."""
    return METHODS["ordinary"].estimate(regression).beta


def outcome(x: np.ndarray, k1: float) -> np.ndarray:
    """Least-squares totals of ID (%), mean-square torque of joint 1 and tracking of joint 2 (%) at each row of `x`.

    A row holds back-EMF, k2 and the factor of each joint.
    """
    arms, effects, phases = [], [], []
    for back_emf, k2, *factors in x:
        levels = {"stribeck": [UNIT[0] * f for f in factors], "ripple_nm": [UNIT[1] * f for f in factors]}
        unmodelled, phase = disturbance(merged(CONFIG, {"arm": levels}), CONFIG["experiment"]["seed"])
        beta = appendix_arm(FreeChoices(k1=k1, k2=k2))
        arms.append(beta + back_emf * np.isin(np.arange(9), (5, 6)))
        effects.append(unmodelled)
        phases.append(phase)
    program = program_from_config(CONFIG, "ID")
    plant = Plant(np.array(arms), program.h, effects, np.array(phases))
    position, pwm = simulate(plant, control_constants(CONFIG), program.q)
    rows = []
    for k in range(len(x)):
        recording = recorded(program, position[k], pwm[k])
        r = recording.regression(SIGNALS)
        total = metr2ev(r.tau, rebuild_torque(r.y, least_squares(r)), METRIC).total
        proper = slice(program.n1, program.n2)
        tracking = metr2ev(program.q[:, proper], recording.q[:, proper], METRIC).total
        rows.append([*(100 * total), np.mean(r.tau[0] ** 2), 100 * tracking[1]])
    return np.array(rows)


def calibrate(k1: float) -> None:
    """Solve for the four numbers by Newton's method and print each step."""
    published = load_published()
    printed = [published[f"table10/ID/least-squares/total/joint{j}"].value for j in (1, 2)]
    level = least_squares_torque(published).set_index("joint")["mean_square"][1]
    target = np.array([*printed, level, published["table08/ID/total/joint2"].value])
    x, step = np.array([0.15, 0.2, 3.3, 1.5]), np.diag([0.03, 0.03, 0.2, 0.2])
    print(f"k1 = {k1}: aim {target.round(3)}")
    for _ in range(4):
        found = outcome(np.vstack([x, x + step]), k1)
        print(f"  back-EMF {x[0]:.3f}, k2 {x[1]:.3f}, factors {x[2:].round(3)}: {found[0].round(3)}")
        slope = (found[1:] - found[0]).T / np.diag(step)
        x = x + np.linalg.solve(slope, target - found[0])
    stribeck, ripple = (np.round(unit * x[2:], 4) for unit in UNIT)
    print(f"  stribeck {stribeck}, ripple {ripple} N m, {appendix_arm(FreeChoices(k1=k1, k2=x[1])).round(6)}")


def compare_t1(seeds: range = range(5, 21)) -> None:
    """Least squares on T1 for each reading of T1: the rms distance to the two printed totals."""
    published = load_published()
    printed = np.array([published[f"table10/T1/least-squares/total/joint{j}"].value for j in (1, 2)])
    beta = np.tile(true_parameters(CONFIG), (len(seeds), 1))
    effects, phases = zip(*(disturbance(CONFIG, seed) for seed in seeds), strict=True)
    control = control_constants(CONFIG)

    def record(programs: list[ReferenceTrajectory]) -> list[Recording]:
        plant = Plant(beta, programs[0].h, list(effects), np.array(phases))
        position, pwm = simulate(plant, control, np.stack([p.q for p in programs]))
        return [recorded(*each) for each in zip(programs, position, pwm, strict=True)]

    estimates = [least_squares(r.regression(SIGNALS)) for r in record([program_from_config(CONFIG, "ID")] * len(seeds))]
    settings = program_settings(CONFIG)
    for bands, range_of in T1:
        tried = replace(settings, t1_bands=float(bands), t1_range_of=range_of)
        programs = [reference_trajectory("T1", tried, np.random.default_rng(seed)) for seed in seeds]
        regressions = [r.regression(SIGNALS) for r in record(programs)]
        totals = [
            100 * metr2ev(r.tau, rebuild_torque(r.y, b), METRIC).total
            for r, b in zip(regressions, estimates, strict=True)
        ]
        median = np.median(totals, axis=0)
        square = np.median([np.mean(r.tau**2, axis=1) for r in regressions], axis=0)
        distance = float(np.sqrt(np.mean((median - printed) ** 2)))
        told = (
            f"{bands:4d} bands, range of the {range_of:7s}: {median.round(1)} % (printed {printed}), rms {distance:.2f}"
        )
        print(f"{told}; mean-square torque {square.round(3)} (N m)^2")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--t1", action="store_true", help="compare readings of T1 instead")
    if parser.parse_args().t1:
        compare_t1()
    else:
        for first in (0.4538, 0.28):
            calibrate(first)
