"""What the report is made from, and how its text files are read."""

import csv
from collections.abc import Mapping, Sequence
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


def read_rows(path: Path, columns: Sequence[str] = ()) -> tuple[list[str], list[dict[str, str]]]:
    """Read a CSV table as the text it holds: numbers keep the digits they were written with."""
    try:
        header, *body = [row for row in csv.reader(read_text(path, "a CSV table").splitlines(keepends=True)) if row]
    except csv.Error as error:
        raise InputError.at(str(path), f"text that is not a table ({error})", "a CSV table") from error
    missing = [name for name in columns if name not in header]
    if missing:
        raise InputError.at(f"{path}: header", f"no column {', '.join(missing)}", f"columns {', '.join(columns)}")
    for number, row in enumerate(body, start=1):
        if len(row) != len(header):
            raise InputError.at(f"{path}: row {number}", f"{len(row)} fields", f"{len(header)} fields")
    return header, [dict(zip(header, row, strict=True)) for row in body]
