"""Whether a file is text that can be a table, checked a block of bytes at a time."""

import codecs
import re
from collections.abc import Iterator
from pathlib import Path

from repro.documents import check_size
from repro.errors import InputError

EXPECTED = "a CSV table: a header, then rows of numbers"
#: Largest file, and most bytes without a line end.
LARGEST, LONGEST_LINE = 512 << 20, 1 << 20
_CONTROL = re.compile(rb"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f]")
_BEGINNINGS = {
    (b"\xff\xfe\x00\x00", b"\x00\x00\xfe\xff"): ("UTF-32 text", "UTF-8 text, a CSV table"),
    (b"\xff\xfe", b"\xfe\xff"): ("UTF-16 text", "UTF-8 text, a CSV table"),
    (b"PK", b"\x1f\x8b"): ("a compressed file or a spreadsheet", EXPECTED),
}


def numbered_lines(path: Path) -> Iterator[tuple[int, str]]:
    """Lines of a file that `check_text` accepted, without their ends, counted from 1."""
    with path.open(encoding="utf-8-sig") as file:
        for number, line in enumerate(file, 1):
            yield number, line.removesuffix("\n")


def check_text(path: Path) -> int:
    """Count the lines of a file; refuse one that is missing, empty, too large, no UTF-8 text, or has no line ends."""
    try:
        if not check_size(path, LARGEST, EXPECTED):
            raise InputError.at(str(path), "an empty file", EXPECTED)
        with path.open("rb") as file:
            return _check_blocks(str(path), iter(lambda: file.read(LONGEST_LINE), b""))
    except OSError as error:
        raise InputError.at(str(path), error.strerror or "an unreadable file", EXPECTED) from error


def _check_blocks(name: str, blocks: Iterator[bytes]) -> int:
    decoder, offset, lines, held = codecs.getincrementaldecoder("utf-8")(), 0, 1, b""
    for block in blocks:
        if not offset:
            for beginnings, (found, expected) in _BEGINNINGS.items():
                if block.startswith(beginnings):
                    raise InputError.at(name, found, expected)
        if control := _CONTROL.search(block):
            byte, place = block[control.start()], offset + control.start()
            raise InputError.at(name, f"binary data (byte 0x{byte:02x} at offset {place})", EXPECTED)
        try:
            decoder.decode(block)
        except UnicodeDecodeError as error:
            raise _not_utf8(name, held + block, error, lines) from error
        if len(block) == LONGEST_LINE and b"\n" not in block and b"\r" not in block:
            raise InputError.at(f"{name}: line {lines}", f"{LONGEST_LINE} bytes without a line end", EXPECTED)
        held, offset, lines = decoder.getstate()[0], offset + len(block), lines + block.count(b"\n")
    try:
        decoder.decode(b"", final=True)
    except UnicodeDecodeError as error:
        raise _not_utf8(name, held, error, lines) from error
    return lines


def _not_utf8(name: str, data: bytes, error: UnicodeDecodeError, lines: int) -> InputError:
    line = lines + data.count(b"\n", 0, error.start)
    found = f"byte 0x{data[error.start]:02x} in line {line}, which is not UTF-8"
    return InputError.at(name, found, "UTF-8 text, a CSV table")
