"""The bytes of a recording, stored as they arrive, so that none is lost if the capture cannot be written."""

import errno
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from repro.errors import InputError
from repro.files import writing
from repro.fpga.link import most_bytes
from repro.fpga.sidecar import CaptureMetadata

#: Space for the sidecar, bytes.
_SIDECAR = 128 << 10


class RawFile:
    """File to which received bytes are appended, with disk space reserved until it is closed."""

    def __init__(self, path: Path, reserved: int) -> None:
        self._path, self._pieces = path, list[bytes]()
        self._file = path.open("xb", buffering=0)
        try:
            for _ in range(0, reserved, len(_ZEROS)):
                if self._file.write(_ZEROS) < len(_ZEROS):
                    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            self._file.seek(0)
        except OSError:
            self.remove()
            raise

    def add(self, piece: bytes) -> None:
        """Append bytes; a disk that fails must not end the recording."""
        self._pieces.append(piece)
        with suppress(OSError):
            self._file.write(piece)

    def close(self) -> None:
        """Release the reserved space that was not used."""
        if not self._file.closed:
            with suppress(OSError):
                self._file.truncate()
            self._file.close()

    def remove(self) -> None:
        """Delete the file."""
        self._file.close()
        self._path.unlink(missing_ok=True)

    def rescue(self) -> str:
        """Name the place of the bytes, after writing them elsewhere if needed; empty if there are none."""
        self.close()
        data = b"".join(self._pieces)
        if not data:
            self.remove()
            return ""
        with suppress(OSError):
            if self._path.read_bytes() == data:
                return f"; the {len(data)} bytes received are in {self._path}"
        with suppress(OSError), tempfile.NamedTemporaryFile(prefix="recording-", suffix=".bin", delete=False) as other:
            other.write(data)
            return f"; the {len(data)} bytes received are in {other.name}"
        return f"; the {len(data)} bytes received could not be written anywhere"


_ZEROS = bytes(1 << 16)


@contextmanager
def raw_file(capture: Path, metadata: CaptureMetadata, overwrite: bool) -> Iterator[RawFile]:
    """Store the bytes of a recording in ``NAME.bin.part`` until its capture ``NAME.bin`` is written.

    If that fails, the message names the file with the bytes received.
    """
    folder = next(parent for parent in capture.absolute().parents if parent.exists())
    path = folder / f"{capture.name}.part"
    if path.exists() and not overwrite:
        expected = "none: move it away, or give --overwrite"
        raise InputError.at(str(path), "bytes that an earlier recording left", expected)
    with writing(capture):
        path.unlink(missing_ok=True)
        raw = RawFile(path, 2 * most_bytes(metadata.samples) + len(metadata.program) + _SIDECAR)
    try:
        with writing(capture):
            yield raw
    except InputError as error:
        raise InputError(f"{error}{raw.rescue()}") from error
    except BaseException:
        raw.rescue()
        raise
    raw.remove()
