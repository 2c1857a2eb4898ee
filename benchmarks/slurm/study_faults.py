"""Run a tiny study on a Slurm of one node, strike it by scripted faults, and compare it with a local run.

Usage: ``python benchmarks/slurm/study_faults.py [FAULTS]`` (default 28), as root, in an environment that has the extra
``slurm``. Seven kinds of faults follow each other, each at another moment while a job runs. Then the same command goes
on, after ``--unlock`` if it needs it. When the study is complete, its results are compared byte for byte and
removed, and it starts again, until all faults have struck. The working folder is a file system of its own, which one
kind of fault fills. A command that waits although Slurm has had no job for minutes is killed, and counted as hung.
Prints a line a fault and writes ``results/study_faults.csv``.
"""

import csv
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from cluster import Cluster, cluster
from smoke import CPUS, SMOKE, commands, differences, results, run, with_plugin, working_folder

TARGETS = ["study"]
CONFIGS = [SMOKE, Path(__file__).with_name("tiny_study.yaml")]
TABLE = Path(__file__).resolve().parents[1] / "results" / "study_faults.csv"
#: Seconds before a fault, and how long it lasts.
DELAYS, LASTS = (1, 4, 8, 14, 22), 12
#: Size of the working folder, and runs after which a study that is not complete has failed.
MEGABYTES, MOST_RUNS = 192, 40
#: Seconds without a job after which the command hangs: it looks for its jobs every 180 s at the latest.
HANGS = 200


@contextmanager
def small_disk(folder: Path) -> Iterator[Path]:
    """A file system of limited size."""
    folder.mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={MEGABYTES}m", "tmpfs", str(folder)], check=True)
    try:
        yield folder
    finally:
        subprocess.run(["umount", "--lazy", str(folder)], check=True)


@dataclass
class Study:
    """The command on Slurm: its process, and the job that a fault strikes."""

    command: list[str]
    folder: Path
    slurm: Cluster
    environment: dict[str, str]
    log: Path
    job: str = ""
    kills: int = 0
    runs: int = 0
    unlocked: int = 0
    hung: int = 0
    idle_since: float = 0.0

    def start(self) -> None:
        """Start the same command once more, when the jobs that the last run left have ended."""
        while self.jobs("RUNNING,PENDING,COMPLETING"):
            time.sleep(1)
        if self.log.is_file() and "LockException" in self.log.read_text(encoding="utf-8"):
            self.unlocked += 1
            unlock = [*self.command[:3], "--unlock", *self.command[3:]]  # after `python -m snakemake`
            subprocess.run(unlock, cwd=self.folder, env=self.environment, check=True)
        self.runs, self.idle_since = self.runs + 1, 0.0
        if self.runs > MOST_RUNS:
            sys.exit(f"error: the study: found it incomplete after {MOST_RUNS} runs, expected it complete")
        with self.log.open("w") as log:
            self.process = subprocess.Popen(
                self.command, cwd=self.folder, env=self.environment, stdout=log, stderr=subprocess.STDOUT
            )

    def slurm_command(self, *command: str) -> str:
        """Output of a command of Slurm; nothing if it fails."""
        ended = subprocess.run(command, env=self.environment, capture_output=True, text=True, check=False)
        return ended.stdout

    def jobs(self, states: str) -> dict[str, str]:
        """Rule or group of each of Slurm's jobs in these states."""
        lines = self.slurm_command("squeue", "--noheader", "--format=%A|%k", f"--states={states}").splitlines()
        named = [line.partition("|") for line in lines]
        return {job: comment.removeprefix("rule_").partition("_wildcards")[0] for job, _, comment in named}

    def next_job(self) -> str | None:
        """Wait for a running job, the newest first, and name its rule or group; None if the command ends."""
        while self.goes_on():
            if running := self.jobs("RUNNING"):
                self.job, self.idle_since = max(running, key=int), 0.0
                return running[self.job]
            time.sleep(0.3)
        return None

    def goes_on(self) -> bool:
        """Whether the command runs; it is killed if it hangs."""
        if self.process.poll() is None and not self.jobs("RUNNING,PENDING,COMPLETING"):
            self.idle_since = self.idle_since or time.monotonic()
            if time.monotonic() - self.idle_since > HANGS:
                self.hung += 1
                self.process.kill()
                self.process.wait()
        else:
            self.idle_since = 0.0
        return self.process.poll() is None

    def end(self) -> int:
        """Wait for the end of the command and give its exit code."""
        while self.goes_on():
            time.sleep(1)
        return int(self.process.returncode)

    # --- Faults ---------------------------------------------------------------------------------------------------

    def cancel(self) -> None:
        """Cancel the job."""
        self.slurm_command("scancel", self.job)

    def drain(self) -> None:
        """Drain the node for a while."""
        self.slurm_command("scontrol", "update", "nodename=node", "state=drain", "reason=fault")
        time.sleep(LASTS)
        self.slurm_command("scontrol", "update", "nodename=node", "state=resume")

    def kill_controller(self) -> None:
        """Kill Slurm's controller and start it again."""
        self._restart("slurmctld")

    def kill_node_daemon(self) -> None:
        """Kill the node's daemon and start it again."""
        self._restart("slurmd")

    def kill_snakemake(self) -> None:
        """Kill the command, and cancel its waiting jobs; those that run are cancelled every second time."""
        self.process.kill()
        self.process.wait()
        self.kills += 1
        states = ("PENDING", "RUNNING") if self.kills % 2 == 0 else ("PENDING",)
        for state in states:
            self.slurm_command("scancel", "--user", str(os.geteuid()), "--state", state)

    def terminate_snakemake(self) -> None:
        """Interrupt the command."""
        self.process.terminate()
        self.end()

    def fill_disk(self) -> None:
        """Fill the disk for a while."""
        ballast = self.folder / "ballast"
        with ballast.open("wb", buffering=0) as file:
            for size in (1 << 20, 1 << 10, 1):
                with suppress(OSError):
                    while True:
                        file.write(b"\0" * size)
        time.sleep(2 * LASTS)
        ballast.unlink()

    def _restart(self, daemon: str) -> None:
        self.slurm.kill(daemon)
        time.sleep(LASTS)
        self.slurm.start(daemon)


KINDS = {
    "job cancelled": Study.cancel,
    "snakemake killed": Study.kill_snakemake,
    "node drained": Study.drain,
    "disk full": Study.fill_disk,
    "controller killed": Study.kill_controller,
    "snakemake terminated": Study.terminate_snakemake,
    "node daemon killed": Study.kill_node_daemon,
}


def complete(study: Study, expected: dict[str, bytes], rows: list[dict[str, object]]) -> None:
    """Go on until the study is complete, and compare it; the rows are those of the faults since its start."""
    while study.end():
        study.start()
    found = results(study.folder)
    different = differences(found, expected)
    for row in rows:
        row |= {"runs": study.runs, "unlocked": study.unlocked, "hung": study.hung}
        row |= {"files": len(found), "different": len(different)}
    print(f"study complete after {len(rows)} faults, {study.runs} runs, {study.unlocked} unlocked, {study.hung} hung:")
    print(f"  {len(found)} files, {len(different)} differ{': ' if different else ''}{', '.join(different)}", flush=True)


def strike_all(study: Study, faults: int, expected: dict[str, bytes]) -> list[dict[str, object]]:
    """Strike the study by so many faults, and start it again whenever it is complete."""
    rows: list[dict[str, object]] = []
    first, begin = 0, time.monotonic()
    study.start()
    for number in range(faults):
        while (name := study.next_job()) is None:
            if study.process.returncode == 0:
                complete(study, expected, rows[first:])
                first = len(rows)
                for made in ("results", "paper_figures"):
                    shutil.rmtree(study.folder / made)
                study.runs = study.unlocked = study.hung = 0
            study.start()
        kind, delay = list(KINDS)[number % len(KINDS)], DELAYS[number % len(DELAYS)]
        time.sleep(delay)
        struck = time.monotonic()
        KINDS[kind](study)
        goes_on = "restarted" if study.process.poll() is not None else "runs on"
        if goes_on == "restarted":
            study.start()
        at, lasted = struck - begin, time.monotonic() - struck
        rows.append({"fault": number + 1, "at_s": round(at), "kind": kind, "job": name, "command": goes_on})
        print(f"{at:5.0f} s, fault {number + 1}: {kind} while {name} ran, {lasted:.0f} s: {goes_on}", flush=True)
    complete(study, expected, rows[first:])
    return rows


def main() -> None:
    """Exit code 1 if a byte differs."""
    faults, environment = int(sys.argv[1]) if len(sys.argv) > 1 else 28, with_plugin()
    local, on_slurm = commands(CONFIGS, TARGETS)
    with cluster(CPUS) as slurm, tempfile.TemporaryDirectory() as name:
        environment |= slurm.variables
        reference = working_folder(Path(name) / "local")
        seconds = run(local, reference, environment)
        expected = results(reference)
        print(f"local run: {len(expected)} files in {seconds:.0f} s", flush=True)
        with small_disk(Path(name) / "slurm") as folder:
            log = Path(name) / "snakemake.log"
            study = Study(on_slurm, working_folder(folder), slurm, environment, log)
            rows = strike_all(study, faults, expected)
    with TABLE.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows(rows)
    if any(row["different"] for row in rows):
        sys.exit(1)


if __name__ == "__main__":
    main()
