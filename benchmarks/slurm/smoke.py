"""Run the smoke workflow on a Slurm of one node, and compare every result with a local run's, byte for byte.

Usage: ``python benchmarks/slurm/smoke.py [TARGET...]``, in an environment that has the extra ``slurm``. Three runs in
temporary folders: local; on Slurm; on Slurm once more, with a job cancelled, the run killed and a job left behind, then
continued with the same command. Prints what a job costs beyond its own time, locally and on Slurm. Logs, benchmarks,
model cards and the record of the run hold wall times and are left out.
"""

import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

from cluster import cluster

ROOT = Path(__file__).resolve().parents[2]
CPUS = 2
SNAKEMAKE = [sys.executable, "-m", "snakemake", "--snakefile", str(ROOT / "Snakefile")]
SMOKE = ROOT / "config" / "smoke.yaml"
KINDS = {".bin", ".program", ".csv", ".json", ".safetensors", ".pdf", ".png", ".tex", ".md"}
SECONDS = 600


def commands(configs: Sequence[Path], targets: Sequence[str]) -> tuple[list[str], list[str]]:
    """Run these targets on this machine; run them on Slurm."""
    run_all = [*SNAKEMAKE, "--configfile", *map(str, configs)]
    profile = str(ROOT / "workflow" / "profiles" / "slurm")
    return (
        [*run_all, "--cores", str(CPUS), "--", *targets],
        [*run_all, "--workflow-profile", profile, "--", *targets],
    )


def with_plugin() -> dict[str, str]:
    """Environment of a run; ends with one line if Snakemake's plugin is missing."""
    if find_spec("snakemake_executor_plugin_slurm") is None:
        sys.exit("error: snakemake-executor-plugin-slurm: found none, expected it: pip install --editable '.[slurm]'")
    return {**os.environ, "PYTHONPATH": str(ROOT / "src")}


def working_folder(folder: Path) -> Path:
    """A new folder that the workflow runs in."""
    folder.mkdir(exist_ok=True)
    for name in ("config", "data"):
        (folder / name).symlink_to(ROOT / name)
    return folder


def run(command: list[str], folder: Path, environment: dict[str, str]) -> float:
    """Seconds that a run took; ends with its last words if it fails."""
    start = time.monotonic()
    ended = subprocess.run(
        command, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False
    )
    if ended.returncode:
        sys.exit(f"{ended.stdout[-5000:]}\nerror: snakemake: found exit code {ended.returncode}, expected 0")
    return time.monotonic() - start


def results(folder: Path) -> dict[str, bytes]:
    """Every result by its name."""
    found = [f for name in ("results", "paper_figures") for f in (folder / name).rglob("*") if f.suffix in KINDS]
    kept = [f for f in found if "logs" not in f.parts and not f.name.startswith((".", "model-card", "ro-crate"))]
    return {str(f.relative_to(folder)): f.read_bytes() for f in kept}


def differences(found: dict[str, bytes], expected: dict[str, bytes]) -> list[str]:
    """Names of the results that differ or that only one run has."""
    return sorted(k for k in expected.keys() | found.keys() if expected.get(k) != found.get(k))


def compare(folder: Path, expected: dict[str, bytes]) -> None:
    """End with the names of the files that differ, if any does."""
    found = results(folder)
    if different := differences(found, expected):
        sys.exit(f"error: {folder.name}: found {len(different)} files that differ: {', '.join(different)}")
    print(f"{folder.name}: all {len(found)} results have the bytes of the local run", flush=True)


def own_seconds(folder: Path) -> dict[str, float]:
    """Seconds that each job of a run took without Slurm and Snakemake, by the name of its benchmark."""
    files = [f for pattern in ("benchmarks", "*/benchmarks") for f in folder.glob(f"results/{pattern}/*.tsv")]
    tables = {f.stem: f.read_text(encoding="utf-8").split() for f in files}
    return {name: float(table[len(table) // 2]) for name, table in tables.items()}  # a line of names, one of values


def print_overhead(folder: Path, seconds: float) -> None:
    """Print what a job cost beyond its own time, as if the processors were never idle."""
    own = own_seconds(folder)
    overhead = (seconds - sum(own.values()) / CPUS) / len(own)
    print(f"{folder.name}: {len(own)} jobs in {seconds:.0f} s, {overhead:.2f} s a job beyond their own", flush=True)


def jobs_in(states: str, environment: dict[str, str]) -> set[str]:
    """Numbers of Slurm's jobs in these states."""
    command = ["squeue", "--noheader", "--format=%A", f"--states={states}"]
    return set(subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout.split())


def next_job(environment: dict[str, str], besides: set[str]) -> str:
    """Wait until Slurm runs a job that it did not run before."""
    deadline = time.monotonic() + SECONDS
    while not (new := jobs_in("RUNNING", environment) - besides):
        if time.monotonic() > deadline:
            sys.exit("error: Slurm: found no new job, expected one")
        time.sleep(0.2)
    return min(new)


def disturb(command: list[str], folder: Path, environment: dict[str, str]) -> None:
    """Cancel a job, wait until it runs again, kill the run, see its jobs keep the folder, and cancel them, too."""
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    process = subprocess.Popen(command, cwd=folder, env=environment, **quiet)
    first = next_job(environment, set())
    time.sleep(5)
    seen = jobs_in("RUNNING", environment) | {first}
    subprocess.run(["scancel", first], env=environment, check=True)
    left = next_job(environment, seen)
    time.sleep(5)
    process.send_signal(signal.SIGKILL)
    process.wait()
    again = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    if "LockException" not in again.stdout + again.stderr:
        sys.exit(f"{again.stderr[-2000:]}\nerror: second run: found no lock, expected one beside the first run's jobs")
    subprocess.run(["scancel", "--user", str(os.geteuid())], env=environment, check=True)
    while jobs_in("RUNNING,COMPLETING", environment):
        time.sleep(0.5)
    print(f"{folder.name}: cancelled job {first}, killed the run, cancelled job {left} that it left", flush=True)


def main() -> None:
    """Run three times and compare; exit code 1 if a byte differs."""
    environment = with_plugin()
    local, on_slurm = commands([SMOKE], sys.argv[1:])
    with cluster(CPUS) as slurm, tempfile.TemporaryDirectory() as name:
        environment |= slurm.variables
        folders = [working_folder(Path(name) / kind) for kind in ("local", "slurm", "disturbed")]
        seconds = run(local, folders[0], environment)
        expected = results(folders[0])
        print_overhead(folders[0], seconds)
        seconds = run(on_slurm, folders[1], environment)
        compare(folders[1], expected)
        print_overhead(folders[1], seconds)
        disturb(on_slurm, folders[2], environment)
        run(on_slurm, folders[2], environment)
        compare(folders[2], expected)


if __name__ == "__main__":
    main()
