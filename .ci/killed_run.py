"""Kill a part of the smoke run with SIGKILL in a training, start it again; compare every byte with an undisturbed run.

The part trains the published network and the one of tracked motions. It ends with their estimates and the figure of the
losses. Replaces what is in `FOLDERS`. Logs, benchmarks and model cards hold wall times and are left out.
"""

import hashlib
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

FOLDERS = (Path("results/smoke"), Path("paper_figures/smoke"))
TARGETS = ["fig10", *(f"{FOLDERS[0]}/identification/experiment{suffix}-seed1.json" for suffix in ("", "-tracked"))]
COMMAND = [sys.executable, "-m", "snakemake", "--cores", "2", "--configfile", "config/smoke.yaml", "--", *TARGETS]
KINDS = {".csv", ".json", ".safetensors", ".bin", ".program", ".pdf", ".png"}
QUIET = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}


def digests() -> dict[str, str]:
    """SHA-256 of every result."""
    found = [f for folder in FOLDERS for f in sorted(folder.rglob("*")) if f.suffix in KINDS and "logs" not in f.parts]
    files = [f for f in found if not f.name.startswith((".", "ro-crate"))]
    return {str(f): hashlib.sha256(f.read_bytes()).hexdigest() for f in files}


def remove() -> None:
    """Remove what a run left."""
    for folder in FOLDERS:
        shutil.rmtree(folder, ignore_errors=True)


def run_and_kill(seconds: float = 300.0) -> None:
    """Start the run, wait for the first checkpoint, and kill the whole process group."""
    run = subprocess.Popen(COMMAND, start_new_session=True, **QUIET)
    deadline = time.monotonic() + seconds
    while not list(FOLDERS[0].glob("model/.checkpoint*.safetensors")):
        if run.poll() is not None or time.monotonic() > deadline:
            sys.exit("killed run: no checkpoint appeared while the run was alive")
        time.sleep(0.002)
    os.killpg(run.pid, signal.SIGKILL)
    run.wait()


def main() -> None:
    """Compare; exit code 1 and the names of the files that differ if any does."""
    remove()
    subprocess.run(COMMAND, check=True, **QUIET)
    undisturbed = digests()
    remove()
    run_and_kill()
    before = digests()
    if not before.keys() < undisturbed.keys():
        sys.exit(f"killed run: {len(before)} of {len(undisturbed)} files were made before the kill, expected fewer")
    subprocess.run(COMMAND, check=True, **QUIET)
    again = digests()
    different = sorted(k for k in undisturbed.keys() | again.keys() if undisturbed.get(k) != again.get(k))
    if different:
        sys.exit(f"killed run: {len(different)} files differ: {', '.join(different)}")
    print(f"killed with {len(before)} of {len(again)} files made, continued, and all {len(again)} are the same bytes")


if __name__ == "__main__":
    main()
