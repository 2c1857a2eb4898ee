"""Calibration errors put into logs of an arm: how many are named, by a log alone and next to the others.

Usage: ``.venv/bin/python benchmarks/setup_faults.py LOG LOG ...``, logs of one arm as their owners made them. Each is
spoilt in sixteen ways; the others stay as they are.
"""

import argparse
import os
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from repro import contract

contract.hold(os.environ)

import numpy as np

from repro.fitting.prepare import LoadedLog, Options, load_log
from repro.fitting.problem import make_problem
from repro.identification.armfile import Arm
from repro.identification.calibration import correct_calibration
from repro.identification.filtering import MAX_DELAY

DEGREE = float(np.pi / 180.0)
#: Zeros in rad, offsets in shares of the largest torque, delays in s.
WRONG: list[dict[str, float]] = [
    *({"zero1": size * DEGREE} for size in (2, -4, 10)),
    *({"zero2": size * DEGREE} for size in (-3, 6, -10)),
    {"zero1": 5 * DEGREE, "zero2": -5 * DEGREE},
    *({"offset1": size} for size in (0.1, -0.2)),
    {"offset2": 0.1},
    *({"scale2": size} for size in (0.5, 0.7, 1.5, 2.0)),
    *({"delay": size} for size in (0.015, -0.03)),
]
OPTIONS = Options(("ordinary",), Path("unused"))


def spoilt(told: LoadedLog, wrong: dict[str, float]) -> tuple[LoadedLog, dict[str, float]]:
    """The log with calibration errors in it, and their sizes in rad, N m and s."""
    log, largest = told.log, np.abs(told.log.tau).max(axis=-1)
    sizes = {name: x * largest[int(name[-1]) - 1] if name.startswith("offset") else x for name, x in wrong.items()}
    # `corrected` undone: opposite zeros, and the scale before the offset.
    zeros = correct_calibration(log, {name: -x for name, x in sizes.items() if name.startswith("zero")})
    tau = log.tau * np.array([[1.0], [sizes.get("scale2", 1.0)]])
    tau = tau + np.array([[sizes.get("offset1", 0.0)], [sizes.get("offset2", 0.0)]])
    tau = np.stack([np.interp(log.t + sizes.get("delay", 0.0), log.t, joint) for joint in tau])
    return replace(told, log=replace(zeros, tau=tau)), sizes


@dataclass(frozen=True)
class Found:
    """What the output states of the first log of an arm."""

    named: dict[str, float]  # calibration errors that are corrected, and the delay
    instead: dict[str, float]  # errors that would explain the log nearly as well
    limits: dict[str, float | None]  # detection limits of the others; None: an error of any size could be hidden

    @property
    def said(self) -> dict[str, float]:
        """All errors that the output names."""
        return self.instead | self.named

    def announces(self, name: str, size: float) -> bool:
        """Whether the output states that an error as large as this one could be hidden."""
        limit = self.limits.get(name, 0.0)
        return limit is None or abs(size - (1.0 if name.startswith("scale") else 0.0)) <= limit


def found(logs: list[LoadedLog]) -> Found:
    """Identify logs of one arm."""
    first = make_problem(logs, (), Arm(), OPTIONS).logs[0]
    named = {error.name: error.value for error in first.calibration_errors} | {"delay": first.settings.delay}
    instead = {name: x for error in first.calibration_errors for name, x in error.instead.items()}
    return Found(named, instead, first.calibration_limits)


@dataclass(frozen=True)
class Trial:
    """What came of the errors put into a log."""

    put_in: str  # log and errors
    outcome: str  # what the output says
    named: bool
    close: bool  # whether each size is within 20 %
    announced: bool  # whether each error that is not named is at most the stated detection limit


def tried(job: tuple[int, dict[str, float]], files: list[Path], with_others: bool) -> Trial:
    """Put errors into one of the logs."""
    which, wrong = job
    logs = [load_log(file, Arm()) for file in [files[which], *files[:which], *files[which + 1 :]]]
    logs = logs if with_others else logs[:1]
    before = found(logs).named
    logs[0], sizes = spoilt(logs[0], wrong)
    result = found(logs)
    said, true, off = result.said, dict[str, float](), dict[str, float]()
    for name, size in sizes.items():
        if name == "scale2":
            true[name] = reach = size * before.get(name, 1.0)
        else:
            true[name], reach = size + before.get(name, 0.0), abs(size)
        off[name] = abs(said[name] - true[name]) / reach if name in said else np.inf
    # A delay is said in any case: it counts where it is half right, or at the end of what is looked at.
    at_end = abs(said["delay"]) >= 0.99 * MAX_DELAY
    return Trial(
        put_in=f"{files[which].name}: " + ", ".join(f"{name} {x:.3g}" for name, x in sizes.items()),
        outcome=", ".join(f"{name} {x:.3g}" for name, x in said.items()),
        named=all(x < (0.5 if name == "delay" and not at_end else np.inf) for name, x in off.items()),
        close=all(x < 0.2 for x in off.values()),
        announced=all(result.announces(name, x) for name, x in true.items() if name not in said or name == "delay"),
    )


def main() -> None:
    """Print what is not named, and how many are."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("logs", nargs="+", type=Path)
    parser.add_argument("--spoil", type=int, help="how many of the logs, from the first, are spoilt (all)")
    args = parser.parse_args()
    jobs = [(which, wrong) for which in range(args.spoil or len(args.logs)) for wrong in WRONG]
    for with_others in (False, True)[: len(args.logs)]:
        with ProcessPoolExecutor(2) as pool:
            trials = list(pool.map(partial(tried, files=args.logs, with_others=with_others), jobs))
        missed = [trial for trial in trials if not trial.named]
        for trial in missed:
            limit = "; below the stated limit" if trial.announced else ""
            print(f"  not named: {trial.put_in}; said: {trial.outcome}{limit}")
        named, close = sum(trial.named for trial in trials), sum(trial.close for trial in trials)
        below = sum(trial.announced for trial in missed)
        print("next to the others" if with_others else "alone", end=": ")
        print(f"{named} of {len(trials)} named, {close} within 20 %; {below} of the others below the stated limit")


if __name__ == "__main__":
    main()
