"""Check sums of everything that a ledger was made from, in the layout that ``sha256sum --check`` reads."""

import hashlib
from collections.abc import Iterable
from pathlib import Path

from repro.errors import InputError
from repro.files import write_text
from repro.paper.published import PUBLISHED_FILE

#: Name of the published numbers in the list: where they lie in the project's folder.
PUBLISHED_NAME = "src/repro/paper/published.csv"


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def write_sources(path: Path, files: Iterable[Path], root: Path = Path(), published: Path = PUBLISHED_FILE) -> None:
    """Write the check sums of files and of the published numbers."""
    sums = {PUBLISHED_NAME: published, **{file.as_posix(): root / file for file in files}}
    lines = []
    for name, file in sorted(sums.items()):
        try:
            lines.append(f"{_digest(file)}  {name}\n")
        except OSError as error:
            raise InputError.at(str(file), error.strerror or "an unreadable file", "what the ledger is from") from error
    write_text(path, "".join(lines))


def read_sources(path: Path) -> dict[str, str]:
    """Names and check sums of a list."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError.at(str(path), f"no readable list ({error})", "check sums of the ledger's sources") from error
    listed = {}
    for number, line in enumerate(lines, start=1):
        digest, separator, name = line.partition("  ")
        if not separator or len(digest) != 64 or not name:
            raise InputError.at(f"{path}: line {number}", repr(line), "a SHA-256, two spaces and a file name")
        listed[name] = digest
    if PUBLISHED_NAME not in listed:
        raise InputError.at(str(path), f"no line of {PUBLISHED_NAME}", "one")
    return listed


def changed_sources(path: Path, root: Path = Path(), published: Path = PUBLISHED_FILE) -> list[str]:
    """Files of a list that are gone or changed."""
    said = []
    for name, digest in read_sources(path).items():
        file = published if name == PUBLISHED_NAME else root / name
        try:
            found = _digest(file)
        except OSError as error:
            said.append(f"{name}: found {error.strerror or 'an unreadable file'}, expected the file that {path} lists")
            continue
        if found != digest:
            said.append(f"{name}: SHA-256: found {found}, expected the {digest} of {path}")
    return said
