"""`repro identify` without the CNN on a log of 75 s at 400 Hz: seconds of each method alone, and of the whole command.

A log is made by Eq. 1 unless one is given. Each round of a method reads, describes, chooses cut-off and delay, solves,
draws the bootstrap, predicts each half from the other and judges. The whole command also loads its modules, draws the
report and writes the files.
"""

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from repro import contract

contract.hold(os.environ)

import numpy as np

from repro.commands.identify import LEAST_SQUARES
from repro.fitting.evaluate import assemble, fit_all, resolve
from repro.fitting.prepare import Options, load_log
from repro.fitting.problem import make_problem
from repro.identification.armfile import Arm
from repro.model.dynamics import inverse_dynamics

BETA = np.array([0.13, 0.067, 0.026, 3.4, 1.1, 0.05, 0.02, 0.2, 0.15])


def made_up(path: Path, seconds: float = 75.0, rate: float = 400.0) -> Path:
    """A log with an encoder step of 0.4 mrad and torque noise."""
    t = np.arange(round(seconds * rate)) / rate
    rng = np.random.default_rng(1)
    q = np.zeros((2, t.size))
    dq, ddq = np.zeros_like(q), np.zeros_like(q)
    for joint in range(2):
        for frequency in rng.uniform(0.02, 0.6, 8):
            w, size, phase = 2 * np.pi * frequency, rng.uniform(0.1, 0.5), rng.uniform(0, 2 * np.pi)
            q[joint] += size * np.sin(w * t + phase)
            dq[joint] += size * w * np.cos(w * t + phase)
            ddq[joint] -= size * w**2 * np.sin(w * t + phase)
    tau = inverse_dynamics(q, dq, ddq, BETA) + 0.05 * rng.standard_normal(q.shape)
    columns = np.column_stack([t, *(np.round(q / 4e-4) * 4e-4), *tau])
    np.savetxt(path, columns, delimiter=",", header="time,q1,q2,tau1,tau2", comments="", fmt="%.6f")
    return path


def silent(*_: object) -> None:
    """Report to nobody."""


def main() -> None:
    """Time each method alone, all together, and the whole command."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("log", nargs="?", type=Path)
    parser.add_argument("--rounds", type=int, default=5)
    args = parser.parse_args()
    arm = Arm()
    with tempfile.TemporaryDirectory() as folder:
        log = args.log or made_up(Path(folder) / "log.csv")
        for names in (*((name,) for name in LEAST_SQUARES), LEAST_SQUARES):
            options = Options(names, Path(folder))
            seconds = []
            for _ in range(args.rounds + 1):
                began = time.perf_counter()
                problem = make_problem((load_log(log, arm),), (), arm, options)
                assemble(problem, fit_all(problem, resolve(options, silent), 1, silent), arm)
                seconds.append(time.perf_counter() - began)
            title = names[0] if len(names) == 1 else f"all {len(names)} methods"
            print(f"{title}: {statistics.median(seconds[1:]):.2f} s, the first time {seconds[0]:.2f} s")
        for name in ("ordinary", "consistent", "least-squares"):
            command = [sys.executable, "-m", "repro", "identify", log, "--method", name, "--overwrite"]
            seconds = []
            for _ in range(args.rounds):
                began = time.perf_counter()
                subprocess.run([*command, "-o", Path(folder) / "out"], check=True, capture_output=True)
                seconds.append(time.perf_counter() - began)
            print(
                f"repro identify --method {name}: best {min(seconds):.2f} s, median {statistics.median(seconds):.2f} s"
            )


if __name__ == "__main__":
    main()
