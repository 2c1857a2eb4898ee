"""Random edits of the kept reference, one at a time: does `repro verify` name each file that was edited?

Usage, in the project's folder: ``python benchmarks/tampering.py --edits 60 --seed 1``. It works on a copy.
"""

import argparse
import random
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from repro.config.check import load_config
from repro.errors import InputError
from repro.paper import ledger
from repro.paper.ledger import PUBLISHED_NAME, verify_ledger

FOLDERS = ("docs/reference", "docs/gallery", "data")
Edit = Callable[[random.Random, Path], Path | None]


def flip_a_bit(rng: random.Random, file: Path) -> Path:
    """Flip one bit."""
    content = bytearray(file.read_bytes())
    content[rng.randrange(len(content))] ^= 1 << rng.randrange(8)
    file.write_bytes(content)
    return file


def change_a_digit(rng: random.Random, file: Path) -> Path | None:
    """Replace one digit by another."""
    content = bytearray(file.read_bytes())
    digits = [k for k, byte in enumerate(content) if chr(byte).isdecimal()]
    if not digits:
        return None
    place = rng.choice(digits)
    content[place] = rng.choice([digit for digit in b"0123456789" if digit != content[place]])
    file.write_bytes(content)
    return file


def swap_rows(rng: random.Random, file: Path) -> Path | None:
    """Swap two lines that differ."""
    lines = file.read_bytes().splitlines(keepends=True)
    a, b = rng.randrange(len(lines)), rng.randrange(len(lines))
    if lines[a] == lines[b]:
        return None
    lines[a], lines[b] = lines[b], lines[a]
    file.write_bytes(b"".join(lines))
    return file


def remove_a_row(rng: random.Random, file: Path) -> Path:
    """Remove one line."""
    lines = file.read_bytes().splitlines(keepends=True)
    del lines[rng.randrange(len(lines))]
    file.write_bytes(b"".join(lines))
    return file


def remove(_rng: random.Random, file: Path) -> Path:
    """Remove the file."""
    file.unlink()
    return file


def add(rng: random.Random, file: Path) -> Path:
    """Copy the file to a new name next to it."""
    return Path(shutil.copy(file, file.with_name(f"{rng.randrange(10**6)}-{file.name}")))


EDITS: tuple[Edit, ...] = (flip_a_bit, change_a_digit, swap_rows, remove_a_row, remove, add)


def copy_kept(root: Path) -> None:
    """Copy what is verified into an empty project folder."""
    for name in FOLDERS:
        shutil.copytree(name, root / name)
    (root / PUBLISHED_NAME).parent.mkdir(parents=True)
    shutil.copy(PUBLISHED_NAME, root / PUBLISHED_NAME)


@contextmanager
def one_edit(root: Path, rng: random.Random) -> Iterator[tuple[str, Path]]:
    """Edit a file drawn from the folders and the published numbers, give what was done to which file, and undo it."""
    files = [path for name in FOLDERS for path in sorted((root / name).rglob("*")) if path.is_file()]
    files += [root / PUBLISHED_NAME] * (len(files) // 10)
    edited = None
    while edited is None:
        edit, file = rng.choice(EDITS), rng.choice(files)
        if edit is add and file == root / PUBLISHED_NAME:
            continue
        before = file.read_bytes()
        edited = edit(rng, file)
    yield edit.__doc__ or "", edited
    if edited == file:
        file.write_bytes(before)
    else:
        edited.unlink()


def problems_of(root: Path) -> list[str]:
    """What the verification of a copy reports."""
    try:
        config = load_config(root / "config/config.yaml")
        return verify_ledger(root / FOLDERS[0], config, root)[1]
    except InputError as error:
        return [str(error)]


def main() -> int:
    """Edit, verify and undo, as often as asked for; list each edit that was not named."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--edits", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    rng, named = random.Random(arguments.seed), 0
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder).resolve()
        copy_kept(root)
        ledger.PUBLISHED_FILE = root / PUBLISHED_NAME
        for name in ("config", "workflow/schemas"):
            shutil.copytree(name, root / name)
        for _ in range(arguments.edits):
            with one_edit(root, rng) as (what, edited):
                name = edited.relative_to(root).as_posix()
                found = any(name in problem for problem in problems_of(root))
            named += found
            print(f"{'named' if found else 'NOT NAMED'}: {name}: {what}", flush=True)
    print(f"{named} of {arguments.edits} edits named")
    return 0 if named == arguments.edits else 1


if __name__ == "__main__":
    sys.exit(main())
