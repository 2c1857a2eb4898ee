"""A CSV file as columns of numbers, read a block of lines at a time; faults are reported by line and column."""

import csv
import math
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from repro.errors import InputError
from repro.logs.encoding import EXPECTED, check_text, numbered_lines
from repro.model.parameters import Array

#: Most rows and columns of a log.
MOST_ROWS, MOST_COLUMNS = 1_000_000, 1000
#: Lines of comments before the header.
_HEAD = 1000
#: Lines that are read at a time.
_BLOCK = 20_000
_SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars", " ": "blanks"}
#: Numbers with a decimal comma, and those that may as well be whole ones with digits in groups.
_COMMA, _GROUPS = re.compile(r"[+-]?\d*,\d*([eE][+-]?\d+)?"), re.compile(r"[+-]?[1-9]\d{0,2},\d{3}")
#: What programs write where there is no number.
_EMPTY = frozenset(("", "nan", "-nan", "nan(ind)", "-nan(ind)", "null", "none", "na", "n/a"))

#: Line of the file, from 1, and as many cells as the header has, of each row.
Rows = list[tuple[int, list[str]]]


@dataclass(frozen=True)
class Table:
    """Cells of a CSV file."""

    file: str  # where it was read, for messages
    header: tuple[str, ...]  # names of the columns
    blocks: Callable[[], Iterable[Rows]]  # gives the rows, some at a time
    size: int  # lines of the file
    notes: tuple[str, ...] = ()  # how it was read, where not as usual

    def numbers(self, columns: Sequence[int]) -> tuple[Array, NDArray[np.int64], tuple[str, ...]]:
        """Columns as numbers."""
        found = [_Column(f"column {self.header[index]}") for index in columns]
        lines: list[int] = []
        for rows in self.blocks():
            lines += [line for line, _ in rows]
            if len(lines) > MOST_ROWS:
                expected = f"at most {MOST_ROWS}: cut the log, or record at a lower rate (100 Hz is enough)"
                raise InputError.at(self.file, f"more than {MOST_ROWS} rows", expected)
            for column, index in zip(found, columns, strict=True):
                column.add([(line, cells[index]) for line, cells in rows])
        commas, bad, expected = [c.comma for c in found if c.comma], [], "a finite number"
        if commas and any(c.point for c in found):
            bad, expected = commas, "a point, as in other numbers"
        elif commas and all(c.grouped for c in found):
            bad, expected = commas, "commas that are clearly for decimals, not for groups of digits: write a point"
        bad = bad or [c.underscore for c in found if c.underscore] or [c.wrong for c in found if c.wrong]
        if bad:
            line, name, cell = bad[0]
            raise InputError.at(f"{self.file}: line {line}, {name}", repr(cell[:40]), expected)
        values = np.stack([np.concatenate(c.values) for c in found])
        return values, np.array(lines), ("numbers have a decimal comma",) if commas else ()


@dataclass
class _Column:
    """Numbers of a column, and the first cell of each fault: its line, its column and its text."""

    name: str
    values: list[Array] = field(default_factory=list)
    point: bool = False  # whether a cell has one
    grouped: bool = True  # whether each comma may be for groups of digits
    comma: tuple[int, str, str] | None = None
    underscore: tuple[int, str, str] | None = None  # python takes 1_000 for a number
    wrong: tuple[int, str, str] | None = None

    def add(self, cells: list[tuple[int, str]]) -> None:
        """Append the cells of some lines."""
        text = "".join(cell for _, cell in cells)
        if "_" not in text and text.isascii():  # the usual case: numbers alone
            try:
                values = np.array([float(cell) for _, cell in cells])
            except ValueError:
                pass
            else:
                if np.isfinite(values).all():
                    self.point = self.point or "." in text
                    self.values.append(values)
                    return
        self.values.append(np.array([self._read(line, cell.strip()) for line, cell in cells]))

    def _read(self, line: int, cell: str) -> float:
        place = (line, self.name, cell)
        self.point = self.point or "." in cell
        if _COMMA.fullmatch(cell):
            self.comma = self.comma or place
            self.grouped = self.grouped and _GROUPS.fullmatch(cell) is not None
        if "_" in cell:
            self.underscore = self.underscore or place
        value = math.nan if cell.lower() in _EMPTY else _number(cell.replace(",", "."), math.inf)
        if math.isinf(value):
            self.wrong = self.wrong or place
        return value


def read_table(path: Path) -> Table:
    """Read the header of a CSV file and check its beginning; `Table.numbers` reads the rest."""
    size = check_text(path)
    if size > 2 * MOST_ROWS + _HEAD:  # half of the lines may be blank
        raise InputError.at(str(path), f"{size} lines", f"at most {2 * MOST_ROWS}, half of them blank")
    comment, lines = "", _filled(path)
    first = next(lines, None)
    while first and first[1].startswith("#"):
        comment, first = first[1].lstrip("# "), next(lines, None)
    if first is None:
        raise InputError.at(str(path), "no header" if comment else "an empty file", EXPECTED)
    (begin, header), second = first, next(lines, None)
    place, nameless = f"{path}: line {begin}", _is_numbers(header)
    unnamed = InputError.at(place, f"numbers ({header[:40]})", "a header that names the columns")
    if nameless:
        header, second = comment, first
        if _is_numbers(comment) or not re.search(r"[\s,;|]", comment):
            raise unnamed
    if second is None:
        raise InputError.at(str(path), "a header and no samples", EXPECTED)
    begin, row = second
    separator = _separator(place, header, row)
    names = tuple(cell.strip() for cell in _cells(header, separator))
    if nameless and len(names) != len(_cells(row, separator)):
        raise unnamed
    if len(names) > MOST_COLUMNS:
        raise InputError.at(f"{path}: header", f"{len(names)} columns", f"at most {MOST_COLUMNS}")
    twice = [name for k, name in enumerate(names) if name and name in names[:k]]
    if twice:
        raise InputError.at(f"{path}: header", f"the column {twice[0]!r} twice", "names that differ")

    def blocks() -> Iterator[Rows]:
        lines = (each for each in _filled(path) if each[0] >= begin)
        while block := list(islice(lines, _BLOCK)):
            rows = [(number, _cells(line, separator)) for number, line in block]
            for k, (number, cells) in enumerate(rows):
                if len(cells) != len(names):
                    last = k == len(rows) - 1 and next(lines, None) is None
                    ended = block[k][1].rstrip(" ").endswith(separator)
                    raise _ragged(f"{path}: line {number}", len(cells), len(names), ended, last)
            yield rows

    next(blocks())  # rows of another length are a clearer fault than a missing column
    notes = () if separator == "," else (f"columns are separated by {_SEPARATORS[separator]}",)
    return Table(str(path), names, blocks, size, notes)


def _filled(path: Path) -> Iterator[tuple[int, str]]:
    """Lines of a file that are not blank, with their numbers."""
    return ((number, line) for number, line in numbered_lines(path) if line.strip())


def in_words(lines: Sequence[int] | NDArray[np.int64]) -> str:
    """Lines in words: runs, the first few of many."""
    runs = np.split(np.array(lines), np.flatnonzero(np.diff(lines) > 1) + 1)
    words = [f"{run[0]} to {run[-1]}" if run.size > 1 else str(run[0]) for run in runs]
    more = f" and {len(words) - 5} more places" if len(words) > 6 else ""
    return f"line{'s' * (len(lines) > 1)} {', '.join(words[:5] if more else words)}{more}"


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
    """A cell's number; NaN, text and digits of other scripts alike are something else."""
    try:
        value = float(cell) if cell.isascii() else math.nan
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
