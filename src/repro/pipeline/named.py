"""Named input and output files of a rule, as a workflow script hands them over."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

Config = Mapping[str, Any]
Named = Iterable[tuple[str, str | Sequence[str]]]


def paths(named: Named) -> dict[str, list[Path]]:
    """Named inputs or outputs of a rule as lists of paths."""
    return {name: [Path(value)] if isinstance(value, str) else [Path(v) for v in value] for name, value in named}
