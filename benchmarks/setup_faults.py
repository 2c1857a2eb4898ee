"""Calibration errors put into logs of an arm: how many are named, by a log alone and next to the others.

Usage: ``.venv/bin/python benchmarks/setup_faults.py LOG LOG ...``, logs of one arm as their owners made them. Each is
spoilt in sixteen ways; the others stay as they are.
"""

import argparse
import os
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
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


def found(logs: list[LoadedLog]) -> tuple[dict[str, float], dict[str, float]]:
    """Faults of the first log with its delay, and what it can hardly tell them from."""
    first = make_problem(logs, (), Arm(), OPTIONS).logs[0]
    named = {error.name: error.value for error in first.calibration_errors} | {"delay": first.settings.delay}
    return named, {name: x for error in first.calibration_errors for name, x in error.instead.items()}


def tried(job: tuple[int, dict[str, float]], files: list[Path], beside: bool) -> tuple[str, str, bool, bool]:
    """What was put into which log, what came of it, whether it is named, and whether its size is within 20 %."""
    which, wrong = job
    logs = [load_log(file, Arm()) for file in [files[which], *files[:which], *files[which + 1 :]]]
    logs = logs if beside else logs[:1]
    before, _ = found(logs)
    logs[0], sizes = spoilt(logs[0], wrong)
    named, instead = found(logs)
    said = instead | named
    off = {}
    for name, size in sizes.items():
        if name == "scale2":
            true = reach = size * before.get(name, 1.0)
        else:
            true, reach = size + before.get(name, 0.0), abs(size)
        off[name] = abs(said[name] - true) / reach if name in said else np.inf
    # A delay is said in any case: it counts where it is half right, or at the end of what is looked at.
    at_end = abs(said["delay"]) >= 0.99 * MAX_DELAY
    reached = all(x < (0.5 if name == "delay" and not at_end else np.inf) for name, x in off.items())
    told = ", ".join(f"{name} {x:.3g}" for name, x in sizes.items())
    outcome = ", ".join(f"{name} {x:.3g}" for name, x in said.items()) or "nothing"
    return f"{files[which].name}: {told}", outcome, reached, all(x < 0.2 for x in off.values())


def main() -> None:
    """Print what is not named, and how many are."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("logs", nargs="+", type=Path)
    parser.add_argument("--spoil", type=int, help="how many of the logs, from the first, are spoilt (all)")
    args = parser.parse_args()
    jobs = [(which, wrong) for which in range(args.spoil or len(args.logs)) for wrong in WRONG]
    for beside in (False, True)[: len(args.logs)]:
        with ProcessPoolExecutor(2) as pool:
            results = list(pool.map(partial(tried, files=args.logs, beside=beside), jobs))
        for told, outcome, named, _ in results:
            print(*([] if named else [f"  not named: {told}; said: {outcome}\n"]), end="")
        named, close = (sum(row[k] for row in results) for k in (2, 3))
        print(f"{'beside the others' if beside else 'alone'}: {named} of {len(results)} named, {close} within 20 %")


if __name__ == "__main__":
    main()
