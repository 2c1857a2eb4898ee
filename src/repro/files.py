"""Result files that are whole or absent: written to a temporary name, then renamed."""

import csv
import io
import json
import os
import tempfile
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save_file

from repro.documents import read_bytes
from repro.errors import InputError, failure, option

#: Disk space that `check_folder` tests, bytes: more than a usual result needs.
_FREE_SPACE = 8 << 20
#: Significant digits of every number in a CSV: enough to redraw and to check, short enough to read.
CSV_FLOAT_FORMAT = "%.10g"


def remove_partial_files(folder: Path) -> None:
    """Remove what killed processes left half written in a folder, of which no process may write there now."""
    for file in folder.rglob(".*.partial.*"):
        file.unlink(missing_ok=True)


def atomic_write(path: Path | str, write: Callable[[Path], object]) -> None:
    """Let `write` fill a temporary file next to `path`, then rename it to `path`."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem}-", suffix=f".partial{path.suffix}")
    os.close(handle)
    temporary = Path(name)
    try:
        write(temporary)
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o666 & ~umask)  # mkstemp makes the file private
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


@contextmanager
def writing(place: Path | str) -> Iterator[None]:
    """Report what cannot be written, such as a full disk, in one line."""
    try:
        yield
    except OSError as error:
        expected = "a place that can be written, with room"
        raise InputError.at(str(place), failure(error), expected) from error


def check_folder(out: Path, overwrite: bool) -> None:
    """Refuse an output folder that contains anything, unless `overwrite`, or that cannot be written."""
    with writing(out):
        if out.is_symlink() and not out.exists():
            raise InputError.at(str(out), "a link to nothing", "a folder, or a name that is free")
        if out.exists() and not out.is_dir():
            raise InputError.at(str(out), "a file", "a folder, or a name that is free")
        if out.exists() and not overwrite and any(out.iterdir()):
            expected = f"a new or empty folder, or {option('overwrite')}"
            raise InputError.at(str(out), "a folder with files in it", expected)
        with _folder_near(out) as folder:  # fails where a parent is a link to nothing
            (Path(folder) / "space").write_bytes(bytes(_FREE_SPACE))


def _folder_near(out: Path) -> tempfile.TemporaryDirectory[str]:
    """Create a temporary folder on the disk of `out`."""
    near = next((parent for parent in out.absolute().parents if os.path.lexists(parent)), out)  # the root has none
    if out.exists() and out.stat().st_dev != near.stat().st_dev:  # another file system: files cannot be moved there
        near = out
    return tempfile.TemporaryDirectory(prefix=".repro-", suffix=".partial", dir=near)


def fill_folder(
    out: Path, fill: Callable[[Path], None], optional: Collection[str] = (), inputs: Iterable[Path] = ()
) -> list[str]:
    """Let `fill` write into a temporary folder, then move its files to `out`: all of them, or none.

    Older files named in `optional` are removed. No input is replaced.
    """
    given = {path.resolve() for path in inputs}
    with writing(out), _folder_near(out) as temporary:
        folder = Path(temporary)
        fill(folder)
        names = sorted(path.name for path in folder.iterdir())
        for name in (*names, *optional):
            if Path(os.path.realpath(out / name)) in given:
                raise InputError.at(str(out / name), "an input of this command", "another folder for the results")
            if (out / name).is_dir():
                raise InputError.at(str(out / name), "a folder", "a file of an earlier run, or a name that is free")
        earlier = folder / "earlier"  # files of another run; the optional ones contradict this one
        earlier.mkdir()
        older = [name for name in dict.fromkeys((*names, *optional)) if os.path.lexists(out / name)]
        steps = [(out / name, earlier / name) for name in older]
        _move([*steps, *((folder / name, out / name) for name in names)], out)
        for name in older:
            (earlier / name).unlink()
        earlier.rmdir()
        folder.rmdir()  # by hand, because this needs no file descriptor
        return names


def _move(steps: Iterable[tuple[Path, Path]], out: Path) -> None:
    """Rename files one after another; if one cannot be, all have their old names again."""
    with ExitStack() as undo:  # backwards
        if not out.exists():
            out.mkdir(parents=True, exist_ok=True)
            undo.callback(out.rmdir)
        for source, target in steps:
            source.rename(target)
            undo.callback(target.rename, source)
        undo.pop_all()


def write_text(path: Path | str, text: str) -> None:
    """Write UTF-8 text with Unix line ends."""
    atomic_write(path, lambda temporary: temporary.write_bytes(text.encode()))


def write_json(path: Path | str, content: object) -> None:
    """Write JSON with sorted keys; a NaN is refused."""
    write_text(path, json.dumps(content, indent=1, sort_keys=True, allow_nan=False) + "\n")


def finite(content: object) -> Any:  # noqa: ANN401
    """Convert content to what JSON can express, with null for NaN and infinity."""
    return json.loads(json.dumps(content), parse_constant=lambda _: None)


def csv_text(frame: pd.DataFrame) -> str:
    """Format a table without its index, numbers with ten significant digits."""
    return frame.to_csv(index=False, float_format=CSV_FLOAT_FORMAT, lineterminator="\n")


def write_csv(path: Path | str, frame: pd.DataFrame) -> None:
    """Write a table as `csv_text` formats it."""
    write_text(path, csv_text(frame))


#: Bytes of a table that is read whole.
LARGEST_TABLE = 2**26


def read_csv(path: Path, columns: tuple[str, ...] = ()) -> pd.DataFrame:
    """Read a CSV table and check that it has these columns."""
    text = _table_text(path)
    try:
        frame = pd.read_csv(io.StringIO(text))
    except (ValueError, pd.errors.ParserError) as error:
        found = f"text that is not a table ({' '.join(str(error).split())})"
        raise InputError.at(str(path), found, "a CSV table") from error
    _check_header(str(path), [str(name) for name in frame.columns], columns)
    return frame


def _table_text(path: Path) -> str:
    try:
        return read_bytes(path, LARGEST_TABLE, "a CSV table").decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError.at(str(path), f"bytes that are not UTF-8 (at {error.start})", "a CSV table") from error


def _check_header(place: str, header: Sequence[str], columns: tuple[str, ...]) -> None:
    missing = [name for name in columns if name not in header]
    if missing:
        found = f"no column {', '.join(missing)} but {', '.join(header)[:80] or 'nothing'}"
        raise InputError.at(f"{place}: header", found, f"columns {', '.join(columns)}")
    # pandas renames the second one
    if twice := next((name for name in columns if header.count(name) > 1 or f"{name}.1" in header), None):
        raise InputError.at(f"{place}: header", f"the column {twice!r} twice", "names that differ")


def read_rows(path: Path, columns: tuple[str, ...] = ()) -> list[dict[str, str]]:
    """Read the rows of a CSV table as text, so that numbers keep their digits, and check that it has these columns."""
    return parse_rows(_table_text(path), str(path), columns)


def parse_rows(text: str, place: str, columns: tuple[str, ...] = ()) -> list[dict[str, str]]:
    """Split the text of a CSV table into rows; `place` is its name in messages."""
    try:
        reader = csv.reader(io.StringIO(text, newline=""), strict=True)
        header, rows = next(reader, []), [(reader.line_num, row) for row in reader if row]
    except csv.Error as error:
        raise InputError.at(place, f"text that is not a table ({error})", "a CSV table") from error
    _check_header(place, header, columns)
    for number, row in rows:
        if len(row) != len(header):
            raise InputError.at(f"{place}: line {number}", f"{len(row)} fields", f"{len(header)}, as in the header")
    return [dict(zip(header, row, strict=True)) for _, row in rows]


def write_tensors(path: Path | str, arrays: Mapping[str, NDArray[Any]], header: dict[str, str] | None = None) -> None:
    """Write arrays as safetensors; the header has no fixed order."""
    contiguous = {name: np.asarray(array, order="C") for name, array in arrays.items()}  # memory is written as it is
    atomic_write(path, lambda temporary: save_file(contiguous, temporary, header))


def read_tensors(path: Path, expected: str) -> tuple[dict[str, NDArray[Any]], dict[str, str]]:
    """Read the arrays and the header of a safetensors file."""
    if path.exists() and not path.is_file():
        raise InputError.at(str(path), "a folder, a pipe or a device", expected)
    try:
        with safe_open(path, framework="np") as f:
            return {name: f.get_tensor(name) for name in f.keys()}, f.metadata() or {}  # noqa: SIM118
    except (OSError, SafetensorError) as error:
        raise InputError.at(str(path), f"no readable safetensors file ({error})", expected) from error
