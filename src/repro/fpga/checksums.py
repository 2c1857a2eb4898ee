"""Check sums of a folder of captures, in the layout that ``sha256sum --check`` reads."""

import hashlib
from pathlib import Path
from typing import Final

from repro.errors import InputError
from repro.files import write_text

#: Name of the list.
SUMS: Final = "SHA256SUMS"


def _sums(folder: Path) -> dict[str, str]:
    files = sorted(path for path in folder.iterdir() if path.suffix in (".bin", ".program", ".json"))
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def write_sums(folder: Path) -> None:
    """Write the check sums of all captures of a folder and their sidecars to ``SHA256SUMS``."""
    write_text(folder / SUMS, "".join(f"{digest}  {name}\n" for name, digest in _sums(folder).items()))


def verify_folder(folder: Path) -> tuple[str, ...]:
    """Check a folder against its ``SHA256SUMS``."""
    list_file = folder / SUMS
    try:
        lines = list_file.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError.at(str(list_file), f"no readable list ({error})", "check sums of the captures") from error
    listed: dict[str, str] = {}
    for number, line in enumerate(lines, start=1):
        digest, separator, name = line.partition("  ")
        if not separator or len(digest) != 64:
            raise InputError.at(f"{list_file}: line {number}", repr(line), "a SHA-256, two spaces and a file name")
        listed[name] = digest
    found = _sums(folder)
    for name in sorted(listed.keys() | found.keys()):
        if name not in found:
            raise InputError.at(str(folder / name), "no file", f"the one listed in {SUMS}")
        if name not in listed:
            raise InputError.at(str(folder / name), "a file", f"only those listed in {SUMS}")
        if listed[name] != found[name]:
            raise InputError.at(f"{folder / name}: SHA-256", found[name], f"the {listed[name]} of {SUMS}")
    return tuple(found)
