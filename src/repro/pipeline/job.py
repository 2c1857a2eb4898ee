"""What every workflow script runs inside: its files by name, a log with the traceback, one line for bad input."""

import logging
import os
import sys
from collections.abc import Iterable, Iterator, Mapping, MutableMapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from repro.errors import InputError
from repro.pipeline.alive import join_run

Config = Mapping[str, Any]
Named = Iterable[tuple[str, str | Sequence[str]]]


def paths(named: Named) -> dict[str, list[Path]]:
    """Named inputs or outputs of a rule as lists of paths."""
    return {name: [Path(value)] if isinstance(value, str) else [Path(v) for v in value] for name, value in named}


def _worth_telling(record: logging.LogRecord) -> bool:
    """Whether to log it: progress of this project, and of libraries only what is wrong, whatever level they set."""
    return record.name.partition(".")[0] in ("repro", "root") or record.levelno >= logging.WARNING


@contextmanager
def job(log: str, threads: int = 1) -> Iterator[None]:
    """Run a rule's work."""
    join_run(os.environ)
    path = Path(log)
    path.parent.mkdir(parents=True, exist_ok=True)
    root = logging.getLogger()
    to_file, to_terminal = logging.FileHandler(path, mode="w"), logging.StreamHandler(sys.stderr)
    to_file.setFormatter(logging.Formatter("%(asctime)s %(message)s"))
    logging.getLogger("repro").setLevel(logging.INFO)
    for handler in (to_file, to_terminal):
        handler.addFilter(_worth_telling)
        root.addHandler(handler)
    torch = sys.modules.get("torch")  # a script imports what it uses before its job begins; most need no network
    if torch:
        torch.set_num_threads(threads)
        torch.set_deterministic_debug_mode("error")  # use_deterministic_algorithms loads a compiler for a second
    try:
        yield
    except InputError as error:
        root.error("%s", error)
        raise SystemExit(2) from None
    except BaseException:
        to_terminal.setLevel(logging.CRITICAL + 1)  # the traceback goes to the log alone
        root.exception("failed")
        print(f"failed: the traceback is in {log}", file=sys.stderr)
        raise SystemExit(1) from None
    finally:
        root.removeHandler(to_terminal)
        root.removeHandler(to_file)
        to_file.close()


#: glibc keeps freed blocks instead of returning them: page faults otherwise cost a twentieth of a training step.
ALLOCATOR = {
    "MALLOC_MMAP_THRESHOLD_": str(32 << 20),
    "MALLOC_TRIM_THRESHOLD_": str(8 << 30),
    "MALLOC_TOP_PAD_": str(256 << 20),
}


def set_allocator(environment: MutableMapping[str, str]) -> None:
    """Set the allocator of later jobs, unless the user has."""
    for name, value in ALLOCATOR.items():
        environment.setdefault(name, value)
