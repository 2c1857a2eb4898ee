"""A CSV file or a ROS 2 bag as columns of numbers; errors are reported by line and column."""

import codecs
import csv
import math
import re
import struct
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from itertools import chain, islice
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from repro.documents import check_size
from repro.errors import InputError, require
from repro.model.parameters import Array

MOST_ROWS, MOST_COLUMNS = 1_000_000, 1000  # most rows and columns of a log
LARGEST, LONGEST_LINE = 512 << 20, 1 << 20  # largest file, and most bytes without a line end
_HEAD = 1000  # most lines of comments before the header
_BLOCK = 2_000  # lines that are read at a time
_EXPECTED = "a CSV table: a header, then rows of numbers"
_SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars", " ": "blanks"}
#: Numbers with a decimal comma, and those among them that could be integers with digits in groups.
_COMMA, _GROUPS = re.compile(r"[+-]?\d*,\d*([eE][+-]?\d+)?"), re.compile(r"[+-]?[1-9]\d{0,2},\d{3}")
#: Cells that programs write where there is no number.
_EMPTY = frozenset(("", "nan", "-nan", "nan(ind)", "-nan(ind)", "null", "none", "na", "n/a"))
_CONTROL = re.compile(rb"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f]")
_OTHER_FORMATS = {
    (b"\xff\xfe\x00\x00", b"\x00\x00\xfe\xff"): ("UTF-32 text", "UTF-8 text, a CSV table"),
    (b"\xff\xfe", b"\xfe\xff"): ("UTF-16 text", "UTF-8 text, a CSV table"),
    (b"PK\x03\x04", b"\x1f\x8b"): ("a compressed file or a spreadsheet", _EXPECTED),
}

#: Line of the file, from 1, and as many cells as the header has, of each row.
Rows = list[tuple[int, list[str]]]


@dataclass(frozen=True)
class Table:
    """Cells of a CSV file."""

    file: str  # for messages
    header: tuple[str, ...]
    blocks: Callable[[], Iterable[Rows]]  # gives the rows, some at a time
    notes: tuple[str, ...] = ()  # how it was read, where not as usual

    def numbers(self, columns: Sequence[int]) -> tuple[Array, NDArray[np.int64], tuple[str, ...]]:
        """Read k columns as numbers (k, N), NaN for empty cells, with the line of each row (N,) and notes."""
        readers = [_Column(f"column {self.header[index]}") for index in columns]
        lines: list[int] = []
        for rows in self.blocks():
            numbers = [line for line, _ in rows]
            lines += numbers
            if len(lines) > MOST_ROWS:
                expected = f"at most {MOST_ROWS}: cut the log, or record at a lower rate (100 Hz is enough)"
                raise InputError.at(self.file, f"more than {MOST_ROWS} rows", expected)
            for column, index in zip(readers, columns, strict=True):
                column.add(numbers, [cells[index] for _, cells in rows])
        self._check(readers)
        values = np.stack([np.concatenate(column.values) for column in readers])
        notes = ("numbers have a decimal comma",) if any("comma" in column.first for column in readers) else ()
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

    def __init__(self, name: str) -> None:
        self.name, self.values = name, list[Array]()
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
    size = check_text(path)
    if size > 2 * MOST_ROWS + _HEAD:  # half of the lines may be blank
        raise InputError.at(str(path), f"{size} lines", f"at most {2 * MOST_ROWS}, half of them blank")
    (place, header), (begin, row) = _head(path)
    separator = _separator(f"{path}: line {place}", header, row)
    cells = _cells(header, separator)
    if place == begin and len(cells) != len(_cells(row, separator)):
        raise _unnamed(path, begin, row)
    if len(cells) > MOST_COLUMNS:
        raise InputError.at(f"{path}: header", f"{len(cells)} columns", f"at most {MOST_COLUMNS}")
    names, blocks = _names(str(path), cells), partial(_blocks, path, begin, separator, len(cells))
    next(blocks())  # rows of another length are a clearer error than a missing column
    notes = () if separator == "," else (f"columns are separated by {_SEPARATORS[separator]}",)
    return Table(str(path), names, blocks, notes)


def _names(file: str, header: Sequence[object]) -> tuple[str, ...]:
    """Give the names of the columns; refuse a name that is there twice."""
    names = tuple(str(name).strip() for name in header)
    if twice := [name for k, name in enumerate(names) if name and name in names[:k]]:
        raise InputError.at(f"{file}: header", f"the column {twice[0]!r} twice", "names that differ")
    return names


def table_of(frame: pd.DataFrame, file: str) -> Table:
    """Take a DataFrame as a table, its rows numbered from 1."""
    names = _names(file, list(frame.columns))
    columns = [[_cell(value) for value in frame[name]] for name in frame.columns]
    rows = [(number, list(cells)) for number, cells in enumerate(zip(*columns, strict=True), 1)]
    if not rows:
        raise InputError.at(file, "no rows", _EXPECTED)
    return Table(file, names, lambda: [rows])


def _cell(value: object) -> str:
    """Write a value of a DataFrame as a table would; every digit stays."""
    if value is None or value is pd.NA:
        return ""
    return repr(float(value)) if isinstance(value, (int, float)) and not isinstance(value, bool) else str(value)


def _head(path: Path) -> tuple[tuple[int, str], tuple[int, str]]:
    """Find the header and the first row, each with its line; a header in a comment has the line of the row."""
    comment, lines = "", _filled(path)
    for first in lines:
        if first[1].startswith("#"):
            comment = first[1].lstrip("# ")
        elif not _is_numbers(first[1]):
            for second in lines:
                return first, second
            raise InputError.at(str(path), "a header and no samples", _EXPECTED)
        elif _is_numbers(comment) or not re.search(r"[\s,;|]", comment):
            raise _unnamed(path, *first)
        else:
            return (first[0], comment), first
    raise InputError.at(str(path), "no header" if comment else "an empty file", _EXPECTED)


def _unnamed(path: Path, line: int, row: str) -> InputError:
    return InputError.at(f"{path}: line {line}", f"numbers ({row[:40]})", "a header that names the columns")


def _blocks(path: Path, begin: int, separator: str, n_columns: int) -> Iterator[Rows]:
    """Give the rows from line `begin` on, a block at a time; refuse a row of another length."""
    lines = (line for line in _filled(path) if line[0] >= begin)
    while block := list(islice(lines, _BLOCK)):
        rows = [(number, _cells(line, separator)) for number, line in block]
        for k, (number, cells) in enumerate(rows):
            if len(cells) != n_columns:
                last = k == len(rows) - 1 and next(lines, None) is None
                ended = block[k][1].rstrip(" ").endswith(separator)
                raise _ragged(f"{path}: line {number}", len(cells), n_columns, ended, last)
        yield rows


def _filled(path: Path) -> Iterator[tuple[int, str]]:
    """Give the lines that are not blank, without their ends, with their numbers from 1."""
    with path.open(encoding="utf-8-sig") as file:
        for number, line in enumerate(file, 1):
            if line.strip():
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


def _ragged(place: str, found: int, expected: int, ended: bool, last: bool) -> InputError:
    """Report a row of another length than the header."""
    hint = ""
    if found == expected + 1 and ended:
        hint = " (a separator at its end)"
    elif found in (2 * expected, 2 * expected - 1):
        hint = " (decimal commas?)"
    elif last and found < expected:
        hint = " (the last line, cut off: delete it)"
    return InputError.at(place, f"{found} cells{hint}", f"{expected}, as in the header")


def check_text(path: Path) -> int:
    """Count the lines of a file; refuse one that is missing, empty, too large, no UTF-8 text, or has no line ends."""
    try:
        if not check_size(path, LARGEST, _EXPECTED):
            raise InputError.at(str(path), "an empty file", _EXPECTED)
        with path.open("rb") as file:
            return _check_blocks(str(path), iter(partial(file.read, LONGEST_LINE), b""))
    except OSError as error:
        raise InputError.at(str(path), error.strerror or "an unreadable file", _EXPECTED) from error


def _check_blocks(name: str, blocks: Iterable[bytes]) -> int:
    decoder, offset, lines, incomplete = codecs.getincrementaldecoder("utf-8")(), 0, 1, b""
    for block in chain(blocks, [b""]):
        for beginnings, (found, expected) in _OTHER_FORMATS.items():
            if not offset and block.startswith(beginnings):
                raise InputError.at(name, found, expected)
        if control := _CONTROL.search(block):
            byte, place = block[control.start()], offset + control.start()
            raise InputError.at(name, f"binary data (byte 0x{byte:02x} at offset {place})", _EXPECTED)
        try:
            decoder.decode(block, final=not block)
        except UnicodeDecodeError as error:
            data, line = incomplete + block, lines + (incomplete + block).count(b"\n", 0, error.start)
            found = f"byte 0x{data[error.start]:02x} in line {line}, which is not UTF-8"
            raise InputError.at(name, found, "UTF-8 text, a CSV table") from error
        if len(block) == LONGEST_LINE and b"\n" not in block and b"\r" not in block:
            raise InputError.at(f"{name}: line {lines}", f"{LONGEST_LINE} bytes without a line end", _EXPECTED)
        incomplete, offset, lines = decoder.getstate()[0], offset + len(block), lines + block.count(b"\n")
    return lines


MOST_MESSAGES = 200_000  # most messages, of which each takes some kilobytes of memory


def is_bag(path: Path) -> bool:
    """Whether a path is a file or the folder of a bag."""
    return path.suffix in (".mcap", ".db3") or (path / "metadata.yaml").is_file()


def read_bag(path: Path, topic: str | None) -> Table:
    """Read the joint states of a bag: a row for each message, numbered from 1, time in s since the first stamp."""
    if not path.exists():
        raise InputError.at(str(path), "no such file", "a ROS 2 bag")
    files = sorted(file for file in path.iterdir() if not file.is_dir()) if path.is_dir() else [path]
    for file in files:
        check_size(file, LARGEST, "a file of a ROS 2 bag")
    require("rosbags", "bags", str(path))
    from apsw import Error as DatabaseError  # noqa: PLC0415  (rosbags reads SQLite and Zstandard by these)
    from backports.zstd import ZstdError  # noqa: PLC0415
    from rosbags.highlevel import AnyReader, AnyReaderError  # noqa: PLC0415
    from rosbags.rosbag2 import ReaderError  # noqa: PLC0415
    from rosbags.typesys import Stores, TypesysError, get_typestore  # noqa: PLC0415

    # The last row is what parsing of damaged bytes raises in Python and in the library's own code.
    damage = (
        *(AnyReaderError, ReaderError, TypesysError, DatabaseError, ZstdError, struct.error),
        *(ArithmeticError, AssertionError, AttributeError, LookupError, MemoryError, OSError),
        *(RuntimeError, TypeError, ValueError),
    )
    try:
        with AnyReader([path], default_typestore=get_typestore(Stores.LATEST)) as reader:
            topics = sorted({c.topic for c in reader.connections if c.msgtype == "sensor_msgs/msg/JointState"})
            chosen = [name for name in topics if topic in (None, name)]
            if len(chosen) != 1:
                expected = f"{topic or 'one, or the one to read'}, as topic in the arm file"
                raise InputError.at(f"{path}: topics of sensor_msgs/JointState", ", ".join(topics) or "none", expected)
            wanted = [c for c in reader.connections if c.topic == chosen[0]]
            if (n := sum(c.msgcount for c in wanted)) > MOST_MESSAGES:
                raise InputError.at(f"{path}: {chosen[0]}", f"{n} messages", f"at most {MOST_MESSAGES}")
            messages = [(at, reader.deserialize(raw, c.msgtype)) for c, at, raw in reader.messages(wanted)]
            return _table(path, chosen[0], messages)
    except InputError:
        raise
    except damage as error:
        found = " ".join(str(error).split())[:200] or type(error).__name__
        raise InputError.at(str(path), found, "a whole ROS 2 bag") from error


def _table(path: Path, topic: str, messages: list[tuple[int, Any]]) -> Table:
    """Tabulate messages, each with the time at which it was received, ns."""
    if not messages:
        raise InputError.at(f"{path}: {topic}", "no messages", "joint states")
    notes = [f"{len(messages)} messages of {topic}, counted as lines"]
    stamps = [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for _, m in messages]
    if not any(stamps):
        notes.append("the messages have no stamps; the times at which they were received are taken")
        stamps = [at for at, _ in messages]
    rows = []
    for stamp, (_, message) in zip(stamps, messages, strict=True):
        row = {"time": repr((stamp - stamps[0]) / 1e9)}
        for kind in ("position", "velocity", "effort"):
            if len(values := getattr(message, kind)):
                row |= {f"{name}.{kind}": repr(float(x)) for name, x in zip(message.name, values, strict=True)}
        rows.append(row)
    header = tuple(dict.fromkeys(name for row in rows for name in row))
    cells = [(number, [row.get(name, "") for name in header]) for number, row in enumerate(rows, 1)]
    return Table(str(path), header, lambda: [cells], tuple(notes))
