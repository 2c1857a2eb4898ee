"""`repro identify` of a log of a million rows against a plain script: processor time of both, in turn, and the ratio.

Each is a separate process, so that starting Python and loading modules counts. The command also draws its report.
"""

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from repro import contract

contract.hold(os.environ)

from identify_speed import made_up

SCRIPT = Path(__file__).with_name("plain_script.py")
#: Rates, Hz, and lengths, s, of logs of a million rows; the last is short, for what does not depend on the length.
LOGS = ((1000.0, 1000.0), (10_000.0, 100.0), (1000.0, 20.0))


def processor_time(command: Sequence[object]) -> float:
    """Processor time of a process, s."""
    process = subprocess.Popen([*map(str, command)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        raise SystemExit(f"{command} failed")
    return usage.ru_utime + usage.ru_stime


def main() -> None:
    """Print a line for each log."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--method", default="ordinary")
    parser.add_argument("--rounds", type=int, default=3)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for rate, seconds in LOGS:
            log = made_up(Path(folder) / "log.csv", seconds, rate)
            script = [sys.executable, SCRIPT, log]
            tool = [sys.executable, "-m", "repro", "identify", log, "--method", args.method]
            tool += ["--overwrite", "-o", Path(folder) / "out"]
            times = [(processor_time(script), processor_time(tool)) for _ in range(args.rounds)]
            plain, ours = (statistics.median(column) for column in zip(*times, strict=True))
            what = f"{rate * seconds:.0f} rows at {rate:g} Hz"
            print(f"{what}: script {plain:.2f} s, repro identify {ours:.2f} s, ratio {ours / plain:.2f}", flush=True)


if __name__ == "__main__":
    main()
