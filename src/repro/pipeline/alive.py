"""Who works in a folder: each run and its jobs say so by name, and what is left of dead runs is cleared.

Snakemake's locks outlive a run that was killed. A later run may remove them if nothing that was begun before can still
write. No lock of the operating system tells that here, because a network file system may not keep one. Instead each run
makes the folder ``.snakemake/runs/NAME``, and each of its jobs an empty file in it; a name says which process it is,
so that the computer it ran on, and no other, can tell that it has ended. A run ends by removing its folder. A job that
starts afterwards, for example one that waited in a queue, cannot make its file, and stops before it touches a result.
"""

import atexit
import os
import shutil
import signal
import socket
import sys
import threading
from collections.abc import Mapping, MutableMapping
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import NoReturn

#: Environment variable by which jobs find their run, on whatever computer.
RUN = "REPRO_RUN"
#: Seconds that jobs get to end by themselves after the run was interrupted.
_PATIENCE = 2.0


def begin_run(state: Path, environment: MutableMapping[str, str], unlock: bool = False) -> None:
    """Sign this run in until the process ends, and remove the locks if everything before it is dead."""
    runs = state / "runs"
    own = runs / _name(os.getpid())
    own.mkdir(parents=True, exist_ok=True)
    environment[RUN] = str(own)
    atexit.register(shutil.rmtree, own, ignore_errors=True)
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, partial(_interrupt, own))
    others = [run for run in runs.iterdir() if run != own]
    if unlock:
        for run in others:
            shutil.rmtree(run, ignore_errors=True)
    elif all(_cleared(run) for run in others):
        shutil.rmtree(state / "locks", ignore_errors=True)


def _interrupt(run: Path, *_: object) -> NoReturn:
    """End the run's jobs on this computer before Snakemake waits for them.

    A terminal sends SIGINT to the jobs as well, so they get two seconds to end by themselves.
    """
    timer = threading.Timer(_PATIENCE, _interrupt_jobs, [run])
    timer.daemon = True
    timer.start()
    raise KeyboardInterrupt


def _interrupt_jobs(run: Path) -> None:
    jobs = [job.name for job in run.iterdir()] if run.exists() else []
    shutil.rmtree(run, ignore_errors=True)  # a job that has not signed in yet ends when it tries to
    for name in jobs:
        if _same_processes(name) and not _ended(name):
            with suppress(ProcessLookupError, PermissionError):
                os.kill(int(name.rsplit("_", 2)[1]), signal.SIGINT)


def join_run(environment: Mapping[str, str]) -> None:
    """Sign this job in with its run, if it has one, until the process ends."""
    if RUN not in environment:
        return
    run = Path(environment[RUN])
    job = run / _name(os.getpid())
    try:
        job.touch()
    except FileNotFoundError:
        print(f"{run}: found no such run, expected that of this job: it is over, and so is the job", file=sys.stderr)
        raise SystemExit(1) from None
    atexit.register(job.unlink, missing_ok=True)


def _cleared(run: Path) -> bool:
    """Remove the folder of a run if it and its jobs have ended; whether it is gone."""
    try:
        if not _ended(run.name):
            return False
        for job in run.iterdir():
            if _ended(job.name):
                job.unlink(missing_ok=True)
        run.rmdir()  # fails, wherever it is done, if a job has signed in by now
    except FileNotFoundError:
        return True  # the run has removed it itself
    except OSError:
        return False
    return True


def _name(pid: int) -> str:
    """Name that no other process ever has: computer, its boot, space of process numbers, number, start."""
    machine, boot = (_text(Path(p)) for p in ("/etc/machine-id", "/proc/sys/kernel/random/boot_id"))
    own = Path("/proc/self/ns/pid")
    space = own.stat().st_ino if own.exists() else 0  # a container has one of its own
    return f"{socket.gethostname()}-{machine}_{boot}_{space}_{pid}_{_started(pid)}"


def _text(path: Path) -> str:
    """Content of a file of the system; nothing where it has none, as macOS."""
    return path.read_text(encoding="ascii").strip() if path.exists() else ""


def _started(pid: int) -> str:
    """When a process started, in ticks since boot; nothing if it is dead but not yet buried, or nobody can tell."""
    if not Path("/proc/self/stat").exists():
        return ""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace").rpartition(")")[2].split()
    return "" if fields[0] in "ZX" else fields[19]


def _same_processes(name: str) -> bool:
    """Whether a process was started on this computer since it booted, and its number is valid here."""
    return name.rsplit("_", 2)[0] == _name(os.getpid()).rsplit("_", 2)[0]


def _ended(name: str) -> bool:
    """Whether a process has ended; not so if that cannot be proven from here."""
    there, here = name.rsplit("_", 4), _name(os.getpid()).rsplit("_", 4)
    if there[0] != here[0]:
        return False
    boot, space, pid, started = there[1:]
    if boot != here[1]:
        return True
    if space != here[2]:
        return False
    try:
        os.kill(int(pid), 0)
        return _started(int(pid)) != started
    except PermissionError:
        return False  # another user's, which /proc may hide
    except (ProcessLookupError, FileNotFoundError):
        return True
