"""Runs and their jobs: the lock of the folder, the log with the traceback, one line for bad input."""

import errno
import fcntl
import logging
import os
import shutil
import socket
import sys
from collections.abc import Collection, Iterator, MutableMapping
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import TextIO

from repro.errors import InputError, end_by_exception
from repro.files import remove_partial_files

#: Folder of Snakemake's records.
STATE = Path(".snakemake")
#: Disk space that a run needs to begin, bytes: Snakemake's own records of a few jobs. A whole run needs 100 MB.
MIN_FREE_SPACE = 16 << 20


def share_lock(state: Path = STATE, clear: Collection[Path] = ()) -> TextIO:
    """Hold the folder's lock, which runs and jobs share, until the file is closed or the process ends.

    If folders to `clear` are given and nobody else holds the lock, an earlier run was killed: Snakemake's own locks are
    removed, and files half written in these folders. Not if that run was on another host, whose lock may be invisible
    here. Where nothing can be written, the process ends with one line.
    """
    try:
        state.mkdir(exist_ok=True)
        file = (state / "run.lock").open("a+")
        if clear and shutil.disk_usage(state).free < MIN_FREE_SPACE:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    except OSError as error:
        expected = f"a folder that can be written, with {MIN_FREE_SPACE >> 20} MB of room"
        print(InputError.at(str(state.absolute()), error.strerror, expected), file=sys.stderr)
        raise SystemExit(2) from None
    try:
        if clear:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if _last_host(file) in ("", socket.gethostname()):
                shutil.rmtree(state / "locks", ignore_errors=True)
                for folder in clear:
                    remove_partial_files(folder)
            file.truncate(0)
            file.write(socket.gethostname())
            file.flush()
        fcntl.flock(file, fcntl.LOCK_SH)
    except BlockingIOError:
        fcntl.flock(file, fcntl.LOCK_SH)
    except OSError:
        pass  # a file system without locks: there a killed run needs snakemake --unlock
    return file


def _last_host(lock: TextIO) -> str:
    """Name of the host of the last run that held the lock alone; empty if none did."""
    lock.seek(0)
    return lock.read().strip()


def _is_relevant(record: logging.LogRecord) -> bool:
    """Whether to log it: progress of this project, and of libraries only what is wrong, whatever level they set."""
    return record.name.partition(".")[0] in ("repro", "root") or record.levelno >= logging.WARNING


@contextmanager
def job(log: str, threads: int = 1) -> Iterator[None]:
    """Log to `log` and the terminal, share the folder's lock, and turn an `InputError` into one line."""
    end_by_exception()
    lock: AbstractContextManager[object] = share_lock() if STATE.is_dir() else nullcontext()
    Path(log).parent.mkdir(parents=True, exist_ok=True)
    root = logging.getLogger()
    to_file, to_terminal = logging.FileHandler(log, mode="w"), logging.StreamHandler(sys.stderr)
    to_file.setFormatter(logging.Formatter("%(asctime)s %(message)s"))
    logging.getLogger("repro").setLevel(logging.INFO)
    for handler in (to_file, to_terminal):
        handler.addFilter(_is_relevant)
        root.addHandler(handler)
    torch = sys.modules.get("torch")  # a script imports what it uses before its job begins; most need no network
    if torch:
        torch.set_num_threads(threads)
        torch.set_deterministic_debug_mode("error")  # use_deterministic_algorithms loads a compiler for a second
    try:
        with lock:
            yield
    except InputError as error:
        root.error("%s", error)
        raise SystemExit(2) from None
    except BaseException as error:
        if isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT):  # there the log cannot grow
            print(InputError.at(str(error.filename or Path.cwd()), error.strerror, "room on the disk"), file=sys.stderr)
            raise SystemExit(2) from None
        to_terminal.setLevel(logging.CRITICAL + 1)  # the traceback goes to the log alone
        root.exception("failed")
        print(f"failed: the traceback is in {log}", file=sys.stderr)
        raise SystemExit(1) from None
    finally:
        root.removeHandler(to_terminal)
        root.removeHandler(to_file)
        to_file.close()


#: glibc keeps freed blocks instead of returning them: page faults otherwise cost a twentieth of a training step. Where
#: the kernel leaves the choice to the program, blocks are on huge pages: a training step alone takes a fifth less.
ALLOCATOR = {
    "GLIBC_TUNABLES": "glibc.malloc.hugetlb=1",
    "MALLOC_MMAP_THRESHOLD_": str(32 << 20),
    "MALLOC_TRIM_THRESHOLD_": str(8 << 30),
    "MALLOC_TOP_PAD_": str(256 << 20),
}


def set_allocator(environment: MutableMapping[str, str]) -> None:
    """Set the allocator of later jobs, unless the user has."""
    for name, value in ALLOCATOR.items():
        environment.setdefault(name, value)
