"""Put up a Slurm of one node from Debian's packages, run a command with it, and take everything down again.

Usage: ``python benchmarks/slurm/cluster.py COMMAND ARGUMENT...``; the command finds ``sbatch`` and ``squeue`` working.
All state is in a temporary folder; neither cgroups nor systemd nor an accounting database is needed.
"""

import os
import pwd
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import IO

PROGRAMS = {"slurmctld": "slurmctld", "slurmd": "slurmd", "sbatch": "slurm-client", "munged": "munge"}
CONFIGURATION = """\
ClusterName=one
SlurmctldHost={host}(127.0.0.1)
SlurmUser={user}
SlurmdUser={user}
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
AuthInfo=socket={folder}/munge.socket
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/filetxt
JobCompLoc={folder}/jobs.txt
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
ReturnToService=2
NodeName=node NodeAddr=127.0.0.1 CPUs={cpus} RealMemory={memory} State=UNKNOWN
PartitionName=all Nodes=node Default=YES MaxTime=INFINITE State=UP
"""


def install() -> None:
    """Install what is missing; as root, or with sudo."""
    path = os.pathsep.join([os.environ["PATH"], "/usr/sbin"])
    missing = sorted({package for program, package in PROGRAMS.items() if not shutil.which(program, path=path)})
    if missing:
        sudo = [] if os.geteuid() == 0 else ["sudo"]
        subprocess.run([*sudo, "apt-get", "update", "--quiet"], check=True, stdout=subprocess.DEVNULL)
        command = ["apt-get", "install", "--quiet", "--yes", "--no-install-recommends", *missing]
        subprocess.run([*sudo, "env", "DEBIAN_FRONTEND=noninteractive", *command], check=True, stdout=sys.stderr)
        services = [package for package in missing if package != "slurm-client"]
        if services and Path("/run/systemd/system").is_dir():  # there the packages have started them
            subprocess.run([*sudo, "systemctl", "disable", "--now", *services], check=True)


def free_ports(number: int) -> list[int]:
    """Ports that nothing listens on."""
    sockets = [socket.socket() for _ in range(number)]
    for each in sockets:
        each.bind(("127.0.0.1", 0))
    ports = [each.getsockname()[1] for each in sockets]
    for each in sockets:
        each.close()
    return ports


def ours(conf: Path) -> list[int]:
    """Processes of this cluster: daemons, job steps and jobs all carry the name of its configuration."""
    found = []
    for environ in Path("/proc").glob("[0-9]*/environ"):
        try:
            if f"SLURM_CONF={conf}".encode() in environ.read_bytes().split(b"\0"):
                found.append(int(environ.parent.name))
        except OSError:
            continue  # it has ended, or is another user's
    return found


def take_down(conf: Path, seconds: float = 5.0) -> None:
    """End every process of this cluster, first politely."""
    deadline = time.monotonic() + seconds
    while pids := ours(conf):
        for pid in pids:
            try:
                os.kill(pid, signal.SIGTERM if time.monotonic() < deadline else signal.SIGKILL)
            except ProcessLookupError:
                continue
        time.sleep(0.5)


@dataclass
class Cluster:
    """A running Slurm: what its commands need of the environment, and its daemons by their names."""

    variables: dict[str, str]
    log: IO[str]
    ended_jobs: Path
    commands: dict[str, list[str]]
    daemons: dict[str, subprocess.Popen[bytes]] = field(default_factory=dict)

    @property
    def environment(self) -> dict[str, str]:
        """Whole environment of a command."""
        return {**os.environ, **self.variables}

    def start(self, name: str) -> None:
        """Start a daemon."""
        command = self.commands[name]
        self.daemons[name] = subprocess.Popen(command, env=self.environment, stdout=self.log, stderr=self.log)

    def job_seconds(self) -> list[float]:
        """Seconds that each ended job had a processor, so far."""
        lines = self.ended_jobs.read_text(encoding="utf-8").splitlines() if self.ended_jobs.exists() else []
        fields = [dict(part.split("=", 1) for part in line.split() if "=" in part) for line in lines]
        ends = [[datetime.fromisoformat(job[name]) for name in ("StartTime", "EndTime")] for job in fields]
        return [(end - start).total_seconds() for start, end in ends]

    def kill(self, name: str) -> None:
        """Kill a daemon; jobs run on."""
        self.daemons[name].kill()
        self.daemons[name].wait()


@contextmanager
def cluster(cpus: int) -> Iterator[Cluster]:
    """Slurm of one node with this many processors."""
    install()
    with tempfile.TemporaryDirectory(prefix="slurm-") as name:
        folder, conf = Path(name), Path(name) / "slurm.conf"
        memory = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") >> 20
        user = pwd.getpwuid(os.geteuid()).pw_name
        settings = {"user": user, "host": socket.gethostname(), "ports": free_ports(2), "cpus": cpus, "memory": memory}
        conf.write_text(CONFIGURATION.format(folder=folder, **settings), encoding="utf-8")
        folder.chmod(0o711)  # munge wants its socket to be reachable
        for needed in ("state", "spool"):
            (folder / needed).mkdir()
        key = folder / "munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o600)
        # The plugin drops SLURM_CONF on its way to srun, and this Slurm is not the one of /etc.
        srun = folder / "srun"
        srun.write_text(f'#!/bin/sh\nSLURM_CONF={conf} exec {shutil.which("srun")} "$@"\n', encoding="utf-8")
        srun.chmod(0o755)
        path = os.pathsep.join([name, os.environ["PATH"], "/usr/sbin"])
        munge = {"key-file": key, "socket": folder / "munge.socket", "pid-file": folder / "munge.pid"}
        munge |= {"log-file": folder / "munge.log", "seed-file": folder / "munge.seed"}
        commands = {
            "munged": [
                "munged",
                "--foreground",
                "--force",
                *(f"--{option}={value}" for option, value in munge.items()),
            ],
            "slurmctld": ["slurmctld", "-D", "-i", "-f", str(conf)],
            "slurmd": ["slurmd", "-D", "-N", "node", "-f", str(conf)],
        }
        for number in (signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, lambda *_: sys.exit(1))
        with (folder / "daemons.log").open("w") as log:
            slurm = Cluster({"PATH": path, "SLURM_CONF": str(conf)}, log, folder / "jobs.txt", commands)
            try:
                for daemon in commands:
                    slurm.start(daemon)
                wait_until_idle(slurm.environment, folder)
                yield slurm
            finally:
                take_down(conf)
                for process in slurm.daemons.values():
                    process.wait()


def wait_until_idle(environment: dict[str, str], folder: Path, seconds: float = 60.0) -> None:
    """Wait for the node; end with the daemons' last words if it does not come."""
    deadline = time.monotonic() + seconds
    while True:
        command = ["sinfo", "--noheader", "--format=%T"]
        said = subprocess.run(command, env=environment, capture_output=True, text=True, check=False).stdout.strip()
        if said == "idle":
            return
        if time.monotonic() > deadline:
            logs = "\n".join(log.read_text(encoding="utf-8")[-2000:] for log in sorted(folder.glob("*.log")))
            sys.exit(f"error: Slurm: found its node {said or 'missing'}, expected it idle\n{logs}")
        time.sleep(0.5)


if __name__ == "__main__":
    with cluster(cpus=os.cpu_count() or 1) as with_slurm:
        status = subprocess.run(sys.argv[1:], env=with_slurm.environment, check=False).returncode
    sys.exit(status)
