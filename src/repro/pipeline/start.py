"""What the Snakefile does before it defines a rule: check the configuration, set the allocator."""

import sys
from collections.abc import Iterable, Mapping, MutableMapping
from pathlib import Path
from typing import Any

from repro.config import check_config
from repro.errors import InputError


def accept_config(config: Mapping[str, Any], schema: Path, files: Iterable[str | Path]) -> None:
    """Check the configuration; on a fault print its one line and leave with exit code 2."""
    try:
        check_config(config, schema, [Path(file) for file in files])
    except InputError as error:
        print(error, file=sys.stderr)
        raise SystemExit(2) from None


#: glibc keeps freed blocks instead of returning them: page faults otherwise cost a twentieth of a training step.
ALLOCATOR = {
    "MALLOC_MMAP_THRESHOLD_": str(32 << 20),
    "MALLOC_TRIM_THRESHOLD_": str(8 << 30),
    "MALLOC_TOP_PAD_": str(256 << 20),
}


def set_allocator(environment: MutableMapping[str, str]) -> None:
    """Set the allocator of the jobs to come, unless the user has."""
    for name, value in ALLOCATOR.items():
        environment.setdefault(name, value)
