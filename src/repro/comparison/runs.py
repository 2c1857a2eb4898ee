"""Two results folders side by side: per table and class the largest difference and its place."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from repro.comparison.tolerances import Difference, Kind, Tolerances, differences
from repro.errors import InputError
from repro.files import read_rows

#: What is compared byte by byte: recordings and what was sent for them.
BYTES = ("experiment/*.bin", "experiment/*.program")
#: How a run went, not what it found.
LEFT_OUT = ("benchmarks", "logs")
#: How many files are named that one folder alone has.
SHOWN = 5


@dataclass(frozen=True)
class Compared:
    """What became of one file."""

    name: str  # path in the results folder
    cells: int  # cells, or bytes, that were compared
    found: tuple[Difference, ...]  # all that is not the same text

    def largest(self) -> list[Difference]:
        """The difference of each class that lies furthest towards or beyond what is allowed."""
        by_kind = {kind: [each for each in self.found if each.kind is kind] for kind in Kind}
        return [max(each, key=lambda d: (d.rank, d.size)) for each in by_kind.values() if each]

    @property
    def broken(self) -> bool:
        """Whether a class is broken."""
        return any(each.broken for each in self.found)


def compare_runs(a: Path, b: Path, tolerances: Tolerances) -> tuple[list[Compared], list[str]]:
    """Compare every table and recording that both folders have."""
    files = [_files(folder) for folder in (a, b)]
    both = sorted(files[0] & files[1])
    if not both:
        raise InputError.at(f"{a} and {b}", "no table in common", "two results folders")
    return [_compare(a, b, name, tolerances) for name in both], sorted(files[0] ^ files[1])


def _files(folder: Path) -> set[str]:
    if not folder.is_dir():
        raise InputError.at(str(folder), "no folder", "a results folder")
    for entry in folder.iterdir():
        if entry.is_symlink() and not entry.exists():
            raise InputError.at(str(entry), "a link that leads nowhere", "a folder or a file of a run")
    found = {path for pattern in ("*.csv", "*/*.csv", *BYTES) for path in folder.glob(pattern)}
    files = {path for path in found if path.relative_to(folder).parts[0] not in LEFT_OUT}
    for path in files:
        if not path.is_file():
            raise InputError.at(str(path), "no regular file", "a table or a recording of a run")
    return {path.relative_to(folder).as_posix() for path in files}


def _compare(a: Path, b: Path, name: str, tolerances: Tolerances) -> Compared:
    if not name.endswith(".csv"):
        x, y = ((folder / name).read_bytes() for folder in (a, b))
        changed = [Difference(Kind.EXACT, f"byte {_first(x, y)}", f"{len(x)} bytes", f"{len(y)} bytes", 1.0, 0.0)]
        return Compared(name, len(x), tuple(changed if x != y else ()))
    rows = read_rows(a / name), read_rows(b / name)
    table = name.removesuffix(".csv")
    return Compared(name, sum(map(len, rows[0])), tuple(differences(table, *rows, tolerances)))


def _first(x: bytes, y: bytes) -> int:
    return next((k for k, (p, q) in enumerate(zip(x, y, strict=False)) if p != q), min(len(x), len(y)))


def report(compared: Sequence[Compared], alone: Sequence[str]) -> list[str]:
    """Lines for a reader: a line for each file and class that differs, then the largest of each class."""
    lines = []
    for each in compared:
        for d in each.largest():
            lines.append(
                f"{each.name}: {_describe(d)}; {sum(x.kind is d.kind for x in each.found)} of {each.cells} cells"
            )
    same = sum(not each.found for each in compared)
    rest = f", {len(alone) - SHOWN} more" if len(alone) > SHOWN else ""
    names = f": {', '.join(alone[:SHOWN])}{rest}" if alone else ""
    counted = f"{len(compared)} files compared, {same} the same to the last digit, {len(alone)} in one folder alone"
    lines.append(counted + names)
    for kind in Kind:
        own = [(each, d) for each in compared for d in each.largest() if d.kind is kind]
        if own:
            file, d = max(own, key=lambda pair: (pair[1].rank, pair[1].size))
            lines.append(f"largest {kind}: {file.name}: {_describe(d)}")
        else:
            lines.append(f"largest {kind}: none differs")
    broken = [each.name for each in compared if each.broken]
    lines.append(f"broken: {', '.join(broken)}" if broken else "no class is broken")
    return lines


def _describe(d: Difference) -> str:
    allowed = "its spread was not measured" if d.allowed != d.allowed else f"{d.allowed:.2g} allowed"
    by = f", by {d.size:.2g}" if d.size not in (float("inf"), 1.0) or d.kind is not Kind.EXACT else ""
    return f"{d.kind}: {d.place}: {d.a or 'nothing'} and {d.b or 'nothing'}{by} ({allowed})"
