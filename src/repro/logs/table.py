"""A CSV file as columns of numbers; whatever is wrong with it is told by line and column."""

import csv
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from repro.errors import InputError
from repro.model.parameters import Array

_EXPECTED = "a CSV table: a header, then rows of numbers"
_CONTROL = re.compile(rb"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f]")
_SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars", " ": "blanks"}
#: Numbers with a decimal comma, and those that may as well be whole ones with digits in groups.
_COMMA, _GROUPS = re.compile(r"[+-]?\d*,\d*([eE][+-]?\d+)?"), re.compile(r"[+-]?[1-9]\d{0,2},\d{3}")
#: What programs write where there is no number.
_EMPTY = frozenset(("", "nan", "-nan", "nan(ind)", "-nan(ind)", "null", "none", "na", "n/a"))


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
    notes : tuple of str
        How it was read, where not as usual.
    """

    file: str
    header: tuple[str, ...]
    rows: list[list[str]]
    lines: list[int]
    notes: tuple[str, ...] = ()

    def place(self, row: int, column: int) -> str:
        """File, line and column of a cell, for messages."""
        return f"{self.file}: line {self.lines[row]}, column {self.header[column]}"

    def numbers(self, columns: Sequence[int]) -> tuple[Array, tuple[str, ...]]:
        """Columns as numbers.

        Parameters
        ----------
        columns : sequence of int
            Their k indices.

        Returns
        -------
        values : array of shape (k, N)
            NaN where a cell is empty.
        notes : tuple of str
            Whether they have a decimal comma.

        Raises
        ------
        InputError
            If a cell is neither empty nor a finite number, or its comma may be for decimals or for groups of digits.
        """
        cells = [row[column].strip() for column in columns for row in self.rows]
        commas = [k for k, cell in enumerate(cells) if "," in cell and _COMMA.fullmatch(cell)]
        bad, expected = [], "a finite number"
        if commas:
            if any("." in cell for cell in cells):
                bad, expected = commas, "a point, as in other numbers"
            elif all(_GROUPS.fullmatch(cells[k]) for k in commas):
                bad, expected = commas, "commas that are clearly for decimals, not for groups of digits: write a point"
            cells = [cell.replace(",", ".") for cell in cells]
        values = np.array([math.nan if cell.lower() in _EMPTY else _number(cell, math.inf) for cell in cells])
        # Python takes 1_000 for a number.
        bad = bad or [k for k, cell in enumerate(cells) if "_" in cell] or np.flatnonzero(np.isinf(values)).tolist()
        if bad:
            column, row = divmod(bad[0], len(self.rows))
            cell = self.rows[row][columns[column]].strip()
            raise InputError.at(self.place(row, columns[column]), repr(cell[:40]), expected)
        return values.reshape(len(columns), -1), ("numbers have a decimal comma",) if commas else ()


def read_table(path: Path) -> Table:
    """Read a CSV file.

    Parameters
    ----------
    path : Path
        UTF-8 text, cells separated by commas, semicolons, tabs, bars or blanks; lines that begin with # may stand
        before the header, and the last of them may be the header.

    Returns
    -------
    Table
        Its header and cells.

    Raises
    ------
    InputError
        If the file is missing, unreadable, empty, not text, has one column, no header, no rows, a column twice, or
        rows of different length, or two characters may be the separator.
    """
    comment, lines = _leading_comment(_text(path).replace("\r\n", "\n").replace("\r", "\n").split("\n"))
    filled = [(number, line) for number, line in lines if line.strip()]
    if not filled:
        raise InputError.at(str(path), "no header" if comment else "an empty file", _EXPECTED)
    (number, header), rest = filled[0], filled[1:]
    place, nameless = f"{path}: line {number}", _is_numbers(header)
    unnamed = InputError.at(place, f"numbers ({header[:40]})", "a header that names the columns")
    if nameless:
        header, rest = comment, filled
        if _is_numbers(comment) or not re.search(r"[\s,;|]", comment):
            raise unnamed
    if not rest:
        raise InputError.at(str(path), "a header and no samples", _EXPECTED)
    separator = _separator(place, header, rest[0][1])
    rows = [_cells(line, separator) for _, line in rest]
    named = _cells(header, separator)
    if nameless and len(named) != len(rows[0]):
        raise unnamed
    names = tuple(cell.strip() for cell in named)
    twice = [name for k, name in enumerate(names) if name and name in names[:k]]
    if twice:
        raise InputError.at(f"{path}: header", f"the column {twice[0]!r} twice", "names that differ")
    for row, (number, line) in zip(rows, rest, strict=True):
        if len(row) != len(names):
            ended = line.rstrip(" ").endswith(separator)
            raise _ragged(f"{path}: line {number}", len(row), len(names), ended, number == rest[-1][0])
    notes = () if separator == "," else (f"columns are separated by {_SEPARATORS[separator]}",)
    return Table(str(path), names, rows, [number for number, _ in rest], notes)


def in_words(lines: Sequence[int]) -> str:
    """Lines in words: runs, the first few of many."""
    runs = np.split(np.array(lines), np.flatnonzero(np.diff(lines) > 1) + 1)
    words = [f"{run[0]} to {run[-1]}" if run.size > 1 else str(run[0]) for run in runs]
    more = f" and {len(words) - 5} more places" if len(words) > 6 else ""
    return f"line{'s' * (len(lines) > 1)} {', '.join(words[:5] if more else words)}{more}"


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


def _separator(place: str, header: str, row: str) -> str:
    """What separates the cells: what the header holds and makes numbers of as many cells of a row."""
    there = [separator for separator in _SEPARATORS if separator in header.strip() and separator != " "]
    fits = []
    for separator in there:
        cells = _cells(row, separator)
        clear = all(_is_number(cell.replace(",", ".")) or re.search("[^\\W\\d]", cell) for cell in cells)
        if clear and len(cells) == len(_cells(header, separator)):
            fits.append(separator)
    if len(fits) > 1:
        words = " or ".join(_SEPARATORS[separator] for separator in fits)
        raise InputError.at(place, f"columns that may be separated by {words}", "one of them")
    if not there and not header.strip().count(" "):
        raise InputError.at(place, f"one column ({header.strip()[:40]})", "columns separated by commas")
    return max(fits or there or " ", key=header.count)


def _cells(line: str, separator: str) -> list[str]:
    """Cells of a line."""
    if separator == " ":
        line = " ".join(line.split())
    if '"' not in line:
        return line.split(separator)
    try:
        return next(csv.reader([line], delimiter=separator))
    except csv.Error:  # a cell of more than 128 KiB
        return line.split(separator)


def _number(cell: str, otherwise: float = math.nan) -> float:
    """A cell's number, NaN and text alike are something else."""
    try:
        value = float(cell)
    except ValueError:
        return otherwise
    return otherwise if math.isnan(value) else value


def _is_number(cell: str) -> bool:
    """Whether a cell holds a number, or nothing at all."""
    return cell.strip().lower() in _EMPTY or not math.isnan(_number(cell))


def _is_numbers(line: str) -> bool:
    """Whether a line holds nothing but numbers, whatever separates them."""
    return all(_is_number(cell) for cell in re.split(r'[\s,;|"]', line))


def _ragged(place: str, found: int, expected: int, ended: bool, last: bool) -> InputError:
    """What to say of a row of another length than the header."""
    hint = ""
    if found == expected + 1 and ended:
        hint = " (a separator at its end)"
    elif found in (2 * expected, 2 * expected - 1):
        hint = " (decimal commas?)"
    elif last and found < expected:
        hint = " (the last line, cut off: delete it)"
    return InputError.at(place, f"{found} cells{hint}", f"{expected}, as in the header")
