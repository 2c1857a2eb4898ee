"""Kill the smoke run with SIGKILL while it trains, start it again, and compare every byte with an undisturbed run.

Expects an undisturbed smoke run in place; leaves the second one there. Logs, benchmarks, model cards and the
record of the run hold wall times and are left out.
"""

import hashlib
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

COMMAND = [sys.executable, "-m", "snakemake", "--cores", "2", "--configfile", "config/smoke.yaml"]
FOLDERS = (Path("results/smoke"), Path("paper_figures/smoke"))
KINDS = {".csv", ".json", ".safetensors", ".pdf", ".png", ".tex", ".md"}


def digests() -> dict[str, str]:
    """SHA-256 of every result."""
    found = [f for folder in FOLDERS for f in sorted(folder.rglob("*")) if f.suffix in KINDS and "logs" not in f.parts]
    files = [f for f in found if not f.name.startswith((".", "model-card", "ro-crate"))]
    return {str(f): hashlib.sha256(f.read_bytes()).hexdigest() for f in files}


def run_and_kill(seconds: float = 300.0) -> None:
    """Start the run, wait for the first checkpoint, and kill the whole process group."""
    run = subprocess.Popen(COMMAND, start_new_session=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    deadline = time.monotonic() + seconds
    while not list(FOLDERS[0].glob("model/.checkpoint*.safetensors")):
        if run.poll() is not None or time.monotonic() > deadline:
            sys.exit("killed run: no checkpoint appeared while the run was alive")
        time.sleep(0.002)
    os.killpg(run.pid, signal.SIGKILL)
    run.wait()


def main() -> None:
    """Compare; exit code 1 and the names of the files that differ if any does."""
    undisturbed = digests()
    if not undisturbed:
        sys.exit("killed run: no undisturbed smoke run to compare with")
    for folder in FOLDERS:
        shutil.rmtree(folder)
    run_and_kill()
    before = set(digests())
    subprocess.run(COMMAND, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    again = digests()
    different = sorted(k for k in undisturbed.keys() | again.keys() if undisturbed.get(k) != again.get(k))
    if different:
        sys.exit(f"killed run: {len(different)} files differ: {', '.join(different)}")
    print(f"killed with {len(before)} of {len(again)} files made, continued, and all {len(again)} are the same bytes")


if __name__ == "__main__":
    main()
