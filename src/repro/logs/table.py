"""A CSV file as columns of numbers; whatever is wrong with it is told by line and column."""

import csv
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from repro.errors import InputError
from repro.model.parameters import Array

_EXPECTED = "a CSV table: a header, then numbers separated by commas"
_CONTROL = re.compile(rb"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f]")
_OTHER_DELIMITERS = {";": "';'", "\t": "tabs", "|": "'|'"}


@dataclass(frozen=True)
class Table:
    """Cells of a CSV file.

    Attributes
    ----------
    file : str
        Where it was read, for messages.
    header : tuple of str
        Names of the columns.
    rows : list of list of str
        Cells, as many in each row as the header has.
    lines : list of int
        Line of the file that each row is, from 1.
    """

    file: str
    header: tuple[str, ...]
    rows: list[list[str]]
    lines: list[int]

    def place(self, row: int, column: int) -> str:
        """File, line and column of a cell, for messages."""
        return f"{self.file}: line {self.lines[row]}, column {self.header[column]}"

    def numbers(self, column: int) -> Array:
        """One column.

        Parameters
        ----------
        column : int
            Its index.

        Returns
        -------
        array of shape (N,)
            Its numbers.

        Raises
        ------
        InputError
            If a cell is empty, or not a finite number.
        """
        cells = [row[column] for row in self.rows]
        for row, cell in enumerate(cells):
            if not cell.strip():
                raise InputError.at(self.place(row, column), "an empty cell", "a number")
        try:
            values = np.array([float(cell) for cell in cells])
        except ValueError:
            values = np.array([_number(cell) for cell in cells])
        # Python takes 1_000 for a number.
        bad = [row for row, cell in enumerate(cells) if "_" in cell] or np.flatnonzero(~np.isfinite(values)).tolist()
        if bad:
            raise InputError.at(self.place(bad[0], column), repr(cells[bad[0]].strip()[:40]), "a finite number")
        return values


def read_table(path: Path) -> Table:
    """Read a CSV file.

    Parameters
    ----------
    path : Path
        UTF-8 text, cells separated by commas; lines that begin with # may stand before the header, and the last
        of them may be the header.

    Returns
    -------
    Table
        Its header and cells.

    Raises
    ------
    InputError
        If the file is missing, unreadable, empty, not text, has another delimiter, no header, no rows, a column
        twice, or rows of different length.
    """
    comment, lines = _leading_comment(_text(path).replace("\r\n", "\n").replace("\r", "\n").split("\n"))
    filled = [(number, line) for number, line in lines if line.strip()]
    if not filled:
        raise InputError.at(str(path), "no header" if comment else "an empty file", _EXPECTED)
    _check_delimiter(str(path), *filled[0])
    number, first = filled[0]
    header, rest = _cells(first), filled[1:]
    if all(_is_number(cell) for cell in header):
        named = _cells(comment)
        if len(named) != len(header) or all(_is_number(cell) for cell in named):
            raise InputError.at(f"{path}: line {number}", f"numbers ({first[:40]})", "a header that names the columns")
        header, rest = named, filled
    names = tuple(cell.strip() for cell in header)
    twice = [name for k, name in enumerate(names) if name and name in names[:k]]
    if twice:
        raise InputError.at(f"{path}: header", f"the column {twice[0]!r} twice", "names that differ")
    if not rest:
        raise InputError.at(str(path), "a header and no samples", _EXPECTED)
    rows = [_cells(line) for _, line in rest]
    for row, (number, line) in zip(rows, rest, strict=True):
        if len(row) != len(names):
            raise _ragged(f"{path}: line {number}", len(row), len(names), line, last=number == rest[-1][0])
    return Table(str(path), names, rows, [number for number, _ in rest])


def _text(path: Path) -> str:
    """Content of a text file."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError.at(str(path), error.strerror or "an unreadable file", _EXPECTED) from error
    if not data:
        raise InputError.at(str(path), "an empty file", _EXPECTED)
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise InputError.at(str(path), "UTF-16 text", "UTF-8 text, a CSV table")
    if data[:2] in (b"PK", b"\x1f\x8b"):
        raise InputError.at(str(path), "a compressed file or a spreadsheet", _EXPECTED)
    control = _CONTROL.search(data)
    if control:
        found = f"binary data (byte 0x{data[control.start()]:02x} at offset {control.start()})"
        raise InputError.at(str(path), found, _EXPECTED)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        found = f"byte 0x{data[error.start]:02x} in line {line}, which is not UTF-8"
        raise InputError.at(str(path), found, "UTF-8 text, a CSV table") from error


def _leading_comment(lines: list[str]) -> tuple[str, Iterator[tuple[int, str]]]:
    """Last of the comment lines at the beginning without its #, and the numbered lines behind them."""
    begin = next((k for k, line in enumerate(lines) if line.strip() and not line.startswith("#")), len(lines))
    comments = [line for line in lines[:begin] if line.strip()]
    return comments[-1].lstrip("# ") if comments else "", enumerate(lines[begin:], begin + 1)


def _check_delimiter(file: str, number: int, line: str) -> None:
    """Refuse cells that are not separated by commas."""
    place = f"{file}: line {number}"
    for delimiter, name in _OTHER_DELIMITERS.items():
        if line.count(delimiter) > line.count(","):
            raise InputError.at(place, f"{name} between the columns", "a comma (and a point in numbers)")
    if "," not in line:
        if len(line.split()) > 2:
            raise InputError.at(place, "spaces between the columns", "a comma")
        raise InputError.at(place, f"one column ({line.strip()[:40]})", "columns separated by commas")


def _cells(line: str) -> list[str]:
    """Cells of a line."""
    if '"' not in line:
        return line.split(",")
    try:
        return next(csv.reader([line]))
    except csv.Error:  # a cell of more than 128 KiB
        return line.split(",")


def _number(cell: str) -> float:
    """A cell's number, NaN for text."""
    try:
        return float(cell)
    except ValueError:
        return math.nan


def _is_number(cell: str) -> bool:
    """Whether a cell holds a number, or nothing at all."""
    return not cell.strip() or cell.strip().lower() == "nan" or not math.isnan(_number(cell))


def _ragged(place: str, found: int, expected: int, line: str, last: bool) -> InputError:
    """What to say of a row of another length than the header."""
    hint = ""
    if found == expected + 1 and line.rstrip().endswith(","):
        hint = " (a comma at its end)"
    elif found in (2 * expected, 2 * expected - 1):
        hint = " (decimal commas?)"
    elif last and found < expected:
        hint = " (the last line, cut off: delete it)"
    return InputError.at(place, f"{found} cells{hint}", f"{expected}, as in the header")
