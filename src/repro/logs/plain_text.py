"""Check that a file is UTF-8 text of a size that can be read; name the other formats that logs come in."""

import codecs
from collections.abc import Iterable
from functools import partial
from itertools import chain
from pathlib import Path

from repro.documents import check_size
from repro.errors import InputError, failure

MAX_FILE_BYTES, MAX_LINE_BYTES = 512 << 20, 1 << 20  # largest file, and most bytes without a line end
EXPECTED = "a CSV table: a header, then rows of numbers"
_TEXT = "UTF-8 text, a CSV table: iconv -f {} -t UTF-8 FILE > LOG.csv"
_CONTROL = bytes((*range(9), 11, 12, *range(14, 32), 127))  # characters that no text contains
_OTHER_FORMATS = {
    (b"\xff\xfe\x00\x00", b"\x00\x00\xfe\xff"): ("UTF-32 text", _TEXT.format("UTF-32")),
    (b"\xff\xfe", b"\xfe\xff"): ("UTF-16 text", _TEXT.format("UTF-16")),
    (b"MATLAB 5.0 MAT", b"MATLAB 7.3 MAT"): (
        "a file of MATLAB",
        f"{EXPECTED}; in MATLAB: writetable(table(t, q1, q2, tau1, tau2), 'log.csv')",
    ),
    (b"\x89HDF",): ("an HDF5 file, as MATLAB writes it, too", f"{EXPECTED}; in Python: h5py, then to_csv of pandas"),
    (b"\x93NUMPY",): ("an array of NumPy", f"{EXPECTED}; in Python: pandas.DataFrame(array, columns=NAMES).to_csv"),
    (b"\x1f\x8b",): ("a compressed file", f"{EXPECTED}, not packed: gunzip --stdout FILE > LOG.csv"),
    (b"PK\x03\x04", b"\xd0\xcf\x11\xe0"): (
        "a spreadsheet, arrays of NumPy (.npz) or a ZIP archive",
        f"{EXPECTED}; in Python: pandas.read_excel(FILE).to_csv, or pandas.DataFrame of the arrays of numpy.load",
    ),
    (b"PAR1",): ("a Parquet file", f"{EXPECTED}; in Python: pandas.read_parquet(FILE).to_csv"),
    (b"\x80\x02", b"\x80\x03", b"\x80\x04", b"\x80\x05"): (
        "a pickle of Python",
        f"{EXPECTED}; in Python: to_csv of the data frame that was saved",
    ),
    (b"ULog",): ("a ULog of PX4", f"{EXPECTED}; ulog2csv of pyulog writes one"),
    (b"{", b"[{", b"[\n", b"[\r\n", b"[ {"): (
        "JSON",
        f"{EXPECTED}; in Python: pandas.read_json(FILE).to_csv, with lines=True where each line is a record",
    ),
    (b"header:\n", b"---\n"): ("YAML", f"{EXPECTED}; of messages of ROS, the bag"),
}


def check_text(path: Path) -> None:
    """Refuse a file that is missing, empty, too large, no UTF-8 text, or has no line ends."""
    try:
        if not check_size(path, MAX_FILE_BYTES, EXPECTED):
            raise InputError.at(str(path), "an empty file", EXPECTED)
        with path.open("rb") as file:
            _check_blocks(str(path), iter(partial(file.read, MAX_LINE_BYTES), b""))
    except OSError as error:
        raise InputError.at(str(path), failure(error), EXPECTED) from error


def _check_blocks(name: str, blocks: Iterable[bytes]) -> None:
    decoder, offset, lines, incomplete = codecs.getincrementaldecoder("utf-8")(), 0, 1, b""
    for block in chain(blocks, [b""]):
        for beginnings, (found, expected) in _OTHER_FORMATS.items():
            if not offset and block.startswith(beginnings):
                raise InputError.at(name, found, expected)
        if len(block.translate(None, _CONTROL)) < len(block):
            at, byte = next((at, byte) for at, byte in enumerate(block) if byte in _CONTROL)
            place = offset + at
            raise InputError.at(name, f"binary data (byte 0x{byte:02x} at offset {place})", EXPECTED)
        try:
            decoder.decode(block, final=not block)
        except UnicodeDecodeError as error:
            data, line = incomplete + block, lines + (incomplete + block).count(b"\n", 0, error.start)
            found = f"byte 0x{data[error.start]:02x} in line {line}, which is not UTF-8"
            raise InputError.at(name, found, _TEXT.format("LATIN1")) from error
        if len(block) == MAX_LINE_BYTES and b"\n" not in block and b"\r" not in block:
            raise InputError.at(f"{name}: line {lines}", f"{MAX_LINE_BYTES} bytes without a line end", EXPECTED)
        incomplete, offset, lines = decoder.getstate()[0], offset + len(block), lines + block.count(b"\n")
