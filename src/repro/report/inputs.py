"""What the report is made from, and how its text files are read."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from repro.errors import InputError

#: The report must stay below this, so that it can be mailed and opened anywhere.
LARGEST_REPORT = 15_000_000


@dataclass(frozen=True)
class ReportInputs:
    """Files and facts that one report shows."""

    results: Path  # folder with ``claims.csv``, ``tables/`` and ``figures/`` (the numbers drawn)
    figures: Path  # folder with ``figNN.png`` and ``figNN.pdf``
    captures: Path  # ``SHA256SUMS`` of the recorded runs
    config_sha256: str  # SHA-256 of the configuration, in hexadecimal
    command: str = "snakemake --cores 2"  # what a target's name is put after to remake it
    # commit, packages and the like, as JSON would hold them; empty if nobody recorded them
    provenance: Mapping[str, object] = field(default_factory=dict)
    notice: str = ""  # a warning for the top of the page, for example that the budgets were tiny
    partial: bool = False  # whether a missing file is named in the page instead of refused

    @property
    def page(self) -> Path:
        """Where the report goes; links to files beside it start there."""
        return self.results / "report" / "index.html"


def read_bytes(path: Path, expected: str) -> bytes:
    """Read a file that must be there and hold something."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError.at(str(path), error.strerror or "an unreadable file", expected) from error
    if not content.strip():
        raise InputError.at(str(path), "an empty file", expected)
    return content


def read_text(path: Path, expected: str) -> str:
    """Read UTF-8 text, line ends made Unix ones."""
    try:
        text = read_bytes(path, expected).decode("utf-8")
    except UnicodeDecodeError as error:
        raise InputError.at(str(path), f"bytes that are not UTF-8 (at {error.start})", expected) from error
    return text.replace("\r\n", "\n")
