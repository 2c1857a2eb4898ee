"""A CSV file as columns of numbers; errors are reported by line and column."""

import csv
import math
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from itertools import islice
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from repro.errors import InputError, shown
from repro.logs.columns import SPELLINGS, unit_named
from repro.logs.instants import seconds_of
from repro.logs.plain_numbers import plain_numbers
from repro.logs.plain_text import EXPECTED, check_text
from repro.model.parameters import Array

MAX_COLUMNS = 1000  # most columns of a log
_MAX_COMMENT_LINES = 1000  # most lines of comments before the header
_LINES_PER_BLOCK = 2_000  # lines that are read at a time
COMMENTS = ("#", "%", "//")  # what lines of comments begin with
_SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars", " ": "blanks"}
_RULE = re.compile(r"[\s|+:=,;-]*(-{3}|={3})[\s|+:=,;-]*")  # a line between header and rows
#: Numbers with a decimal comma, and those among them that could be integers with digits in groups.
_COMMA, _GROUPS = re.compile(r"[+-]?\d*,\d*([eE][+-]?\d+)?"), re.compile(r"[+-]?[1-9]\d{0,2},\d{3}")
#: Cells that programs write where there is no number.
_EMPTY = frozenset(("", "nan", "-nan", "nan(ind)", "-nan(ind)", "null", "none", "na", "n/a"))
#: Line of the file, from 1, and as many cells as the header has, of each row.
Rows = list[tuple[int, list[str]]]


@dataclass(frozen=True)
class Table:
    """Cells of a CSV file."""

    file: str  # for messages
    header: tuple[str, ...]
    blocks: Callable[[], Iterable[Rows]]  # gives the rows, some at a time
    notes: tuple[str, ...] = ()  # how it was read, where not as usual
    #: Gives columns (k, N) at once with the line of each row; None if the cells must be read one by one.
    at_once: Callable[[Sequence[int]], tuple[Array, NDArray[np.int64]] | None] = lambda _: None

    def numbers(
        self, columns: Sequence[int], time: int | None = None
    ) -> tuple[Array, NDArray[np.int64], tuple[str, ...]]:
        """Read k columns as numbers (k, N), NaN for empty cells, with the line of each row (N,) and notes.

        The one at the place `time` may have dates and clock times, which are read as seconds.
        """
        if plain := self.at_once(columns):
            return *plain, ()
        readers = [_Column(f"column {self.header[index]}", k == time) for k, index in enumerate(columns)]
        lines: list[int] = []
        for rows in self.blocks():
            numbers = [line for line, _ in rows]
            lines += numbers
            for column, index in zip(readers, columns, strict=True):
                column.add(numbers, [cells[index] for _, cells in rows])
        self._check(readers)
        values = np.stack([np.concatenate(column.values) for column in readers])
        notes: tuple[str, ...] = (
            ("numbers have a decimal comma",) if any("comma" in column.first for column in readers) else ()
        )
        notes += ("dates and clock times are read as seconds",) if any(column.stamped for column in readers) else ()
        return values, np.array(lines), notes

    def _check(self, columns: Sequence["_Column"]) -> None:
        """Refuse cells that are no finite numbers, and commas that could be for decimals or for groups of digits."""
        commas, underscores, wrong = (
            [column.first[kind] for column in columns if kind in column.first]
            for kind in ("comma", "underscore", "wrong")
        )
        cells, expected = underscores or wrong, "a finite number"
        if commas and any(column.point for column in columns):
            cells, expected = commas, "a point, as in other numbers"
        elif commas and all(column.grouped for column in columns):
            cells, expected = commas, "commas that are clearly for decimals, not for groups of digits: write a point"
        for line, name, text in cells[:1]:
            raise InputError.at(f"{self.file}: line {line}, {name}", repr(text[:40]), expected)


class _Column:
    """Numbers of a column, and its first cell of each kind of error."""

    def __init__(self, name: str, stamps: bool) -> None:
        self.name, self.values = name, list[Array]()
        self.stamps, self.stamped = stamps, False  # whether cells may be dates and clock times, and whether one is
        # Whether a cell has a point, and whether each comma could be for groups of digits.
        self.point, self.grouped = False, True
        # Line, column and text by kind: a comma, an underscore (Python takes 1_000 for a number), a wrong number
        self.first: dict[str, tuple[int, str, str]] = {}

    def add(self, lines: list[int], cells: list[str]) -> None:
        text, values = "".join(cells), np.array([math.nan])
        if "_" not in text and text.isascii():  # the usual case: numbers alone
            with suppress(ValueError):
                values = np.array([float(cell) for cell in cells])
        if np.isfinite(values).all():
            self.point = self.point or "." in text
        else:
            values = np.array([self._read(line, cell.strip()) for line, cell in zip(lines, cells, strict=True)])
        self.values.append(values)

    def _read(self, line: int, cell: str) -> float:
        if self.stamps and (moment := seconds_of(cell)) is not None:
            self.stamped = True
            return moment
        place = (line, self.name, cell)
        self.point = self.point or "." in cell
        if _COMMA.fullmatch(cell):
            self.first.setdefault("comma", place)
            self.grouped = self.grouped and _GROUPS.fullmatch(cell) is not None
        if "_" in cell:
            self.first.setdefault("underscore", place)
        value = math.nan if cell.lower() in _EMPTY else _number(cell.replace(",", "."), math.inf)
        if math.isinf(value):
            self.first.setdefault("wrong", place)
        return value


def read_table(path: Path) -> Table:
    """Read the header of a CSV file, perhaps in a comment, and check its first rows; `Table.numbers` reads the rest."""
    check_text(path)
    head = _head(path)
    (place, header), (begin, row) = head.header, head.row
    separator = _separator(f"{path}: line {place}", header, row)
    cells = _cells(header, separator)
    if place == begin and len(cells) != len(_cells(row, separator)):
        raise _unnamed(path, begin, row)
    if len(cells) > MAX_COLUMNS:
        raise InputError.at(f"{path}: header", f"{len(cells)} columns", f"at most {MAX_COLUMNS}")
    blocks = partial(_blocks, path, begin, separator, cells)
    next(blocks())  # rows of another length are a clearer error than a missing column
    notes: tuple[str, ...] = () if separator == "," else (f"columns are separated by {_SEPARATORS[separator]}",)
    notes += (f"{list_lines(head.skipped)} before the header left out",) if head.skipped else ()
    if head.units:
        units = [unit.strip().strip("[]()") for unit in _cells(head.units, separator)]
        cells = [
            f"{name.strip()} [{unit}]" if unit.strip("-") else name for name, unit in zip(cells, units, strict=True)
        ]
        notes += ("the line below the header states units",)
    at_once = partial(plain_numbers, path, begin, separator, len(cells))
    return Table(str(path), _names(str(path), cells), blocks, notes, at_once)


def _names(file: str, header: Sequence[object]) -> tuple[str, ...]:
    """Give the names of the columns; refuse a name that is there twice."""
    names = tuple(shown(str(name).strip()) for name in header)
    if twice := [name for k, name in enumerate(names) if name and name in names[:k]]:
        raise InputError.at(f"{file}: header", f"the column {twice[0]!r} twice", "names that differ")
    return names


def table_of(frame: pd.DataFrame, file: str) -> Table:
    """Take a DataFrame as a table, its rows numbered from 1."""
    names = _names(file, list(frame.columns))
    columns = [[_cell(value) for value in frame[name]] for name in frame.columns]
    rows = [(number, list(cells)) for number, cells in enumerate(zip(*columns, strict=True), 1)]
    if not rows:
        raise InputError.at(file, "no rows", EXPECTED)
    return Table(file, names, lambda: [rows])


def _cell(value: object) -> str:
    """Write a value of a DataFrame as a table would; every digit stays."""
    if value is None or value is pd.NA:
        return ""
    return repr(float(value)) if isinstance(value, (int, float)) and not isinstance(value, bool) else str(value)


@dataclass(frozen=True)
class _Head:
    """Header and first row, each with its line; a header in a comment has the line of the row."""

    header: tuple[int, str]
    row: tuple[int, str]
    units: str = ""  # line of units between them
    skipped: tuple[int, ...] = ()  # lines before the header


def _head(path: Path) -> _Head:
    """Find the header and the first row: what stands before the rows, or else the first two lines."""
    found = _above_rows(path)
    return found if found else _Head(*_first_lines(path))


def _above_rows(path: Path) -> _Head | None:
    """Find the last line before the first row that has as many cells, perhaps with a line of units between them."""
    texts: list[tuple[int, str]] = []
    comment = ""
    for line in islice(_filled(path), _MAX_COMMENT_LINES):
        if line[1].startswith(COMMENTS):
            comment = line[1].lstrip("#%/ ")
            continue
        if not _is_row(line[1]):
            texts.append(line)
            continue
        separator = max(_SEPARATORS, key=lambda each: (len(_cells(line[1], each)), each != " "))
        count = len(_cells(line[1], separator))
        if not texts and not _is_numbers(line[1]) and len(_cells(comment, separator)) == count:
            return _Head((line[0], comment), line)
        fits = [k for k, (_, text) in enumerate(texts) if len(_cells(text, separator)) == count]
        if not fits or fits[-1] != len(texts) - 1:
            return None
        last = fits[-1]
        units = len(fits) > 1 and fits[-2] == last - 1 and _are_units(_cells(texts[last][1], separator))
        header = last - units
        skipped = tuple(number for number, _ in texts[:header])
        return _Head(texts[header], line, texts[last][1] if units else "", skipped)
    return None


def _is_row(line: str) -> bool:
    """Whether a line is of numbers, times and empty cells, with fewer words than these."""
    separator = next((each for each in (";", "\t", "|", ",") if each in line), " ")
    cells = [cell.strip() for cell in _cells(line, separator)]
    numbers = sum(seconds_of(cell) is not None or not math.isnan(_number(cell.replace(",", "."))) for cell in cells)
    return numbers > 1 and 2 * numbers > sum(cell.lower() not in _EMPTY for cell in cells)


def _are_units(cells: Sequence[str]) -> bool:
    """Whether cells are units, or empty."""
    named = [cell.strip().strip("[]()") for cell in cells if cell.strip().strip("-")]
    return bool(named) and all(any(unit_named(unit, kind) for kind in SPELLINGS) for unit in named)


def _first_lines(path: Path) -> tuple[tuple[int, str], tuple[int, str]]:
    """Take the first line as the header, and the next one as a row; or a comment before numbers."""
    comment, lines = "", _filled(path)
    for first in lines:
        if first[1].startswith(COMMENTS):
            comment = first[1].lstrip("#%/ ")
        elif not _is_numbers(first[1]):
            for second in lines:
                return first, second
            raise InputError.at(str(path), "a header and no samples", EXPECTED)
        elif _is_numbers(comment) or not re.search(r"[\s,;|]", comment):
            raise _unnamed(path, *first)
        else:
            return (first[0], comment), first
    raise InputError.at(str(path), "no header" if comment else "an empty file", EXPECTED)


def _unnamed(path: Path, line: int, row: str) -> InputError:
    return InputError.at(
        f"{path}: line {line}", f"numbers ({row[:40]})", "a header that names the columns, and no numbers above it"
    )


def _blocks(path: Path, begin: int, separator: str, header: Sequence[str]) -> Iterator[Rows]:
    """Give the rows from line `begin` on, a block at a time; refuse a row of another length, and the header again.

    A separator at the end of a row adds no cell.
    """
    n_columns = len(header)
    lines = (line for line in _filled(path) if line[0] >= begin and not line[1].startswith(COMMENTS))
    while block := list(islice(lines, _LINES_PER_BLOCK)):
        rows = [(number, _cells(line, separator)) for number, line in block]
        for k, (number, cells) in enumerate(rows):
            if cells == header:
                raise InputError.at(f"{path}: line {number}", "the header again", "one run: a file for each")
            if len(cells) == n_columns + 1 and not cells[-1].strip():
                cells.pop()
            if len(cells) != n_columns:
                last = k == len(rows) - 1 and next(lines, None) is None
                raise _ragged(f"{path}: line {number}", len(cells), n_columns, last)
        yield rows


def _filled(path: Path) -> Iterator[tuple[int, str]]:
    """Give the lines that are neither blank nor a rule of a table, without their ends, with their numbers from 1."""
    with path.open(encoding="utf-8-sig") as file:
        for number, line in enumerate(file, 1):
            if line.strip() and not _RULE.fullmatch(line):
                yield number, line.removesuffix("\n")


def list_lines(lines: Sequence[int] | NDArray[np.int64]) -> str:
    """Write lines as runs, the first few of many."""
    runs = np.split(np.array(lines), np.flatnonzero(np.diff(lines) > 1) + 1)
    texts = [f"{run[0]} to {run[-1]}" if run.size > 1 else str(run[0]) for run in runs]
    more = f" and {len(texts) - 5} more places" if len(texts) > 6 else ""
    return f"line{'s' * (len(lines) > 1)} {', '.join(texts[:5] if more else texts)}{more}"


def _separator(place: str, header: str, row: str) -> str:
    """Find the character in the header that cuts the row into as many cells, each a number or a word."""
    present, fits = [separator for separator in _SEPARATORS if separator in header.strip() and separator != " "], []
    for separator in present:
        cells = _cells(row, separator)
        clear = all(_is_number(cell.replace(",", ".")) or re.search("[^\\W\\d]", cell) for cell in cells)
        if clear and len(cells) == len(_cells(header, separator)):
            fits.append(separator)
    if len(fits) > 1:
        names = " or ".join(_SEPARATORS[separator] for separator in fits)
        raise InputError.at(place, f"columns that may be separated by {names}", "one of them")
    if not present and not header.strip().count(" "):
        raise InputError.at(place, f"one column ({header.strip()[:40]})", "columns separated by commas")
    return max(fits or present or " ", key=header.count)


def _cells(line: str, separator: str) -> list[str]:
    if separator == " ":
        line = " ".join(line.split())
    if '"' in line:
        with suppress(csv.Error):  # a cell of more than 128 KiB
            return next(csv.reader([line], delimiter=separator))
    return line.split(separator)


def _number(cell: str, otherwise: float = math.nan) -> float:
    """Read a number; NaN, text and digits of other scripts give `otherwise`."""
    value = math.nan
    with suppress(ValueError):
        value = float(cell) if cell.isascii() else value
    return otherwise if math.isnan(value) else value


def _is_number(cell: str) -> bool:
    """Whether a cell is a number or empty."""
    return cell.strip().lower() in _EMPTY or not math.isnan(_number(cell))


def _is_numbers(line: str) -> bool:
    """Whether a line contains nothing but numbers, whatever separates them."""
    return all(_is_number(cell) for cell in re.split(r'[\s,;|"]', line))


def _ragged(place: str, found: int, expected: int, last: bool) -> InputError:
    """Report a row of another length than the header."""
    hint = ""
    if found in (2 * expected, 2 * expected - 1):
        hint = " (decimal commas?)"
    elif last and found < expected:
        hint = " (the last line, cut off: delete it)"
    return InputError.at(place, f"{found} cells{hint}", f"{expected}, as in the header")
