"""The host's end of the serial link: download a motion, start the arm, record and store the frames that come back.

pyserial opens real ports, pseudo-terminals and ``socket://host:port`` alike; nothing here depends on which it is.
"""

import errno
import logging
import os
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Final

import numpy as np
import serial

from repro.board.capture import Capture, write_capture
from repro.board.frames import FRAME_BYTES, MAX_SPEED, RADIANS_PER_COUNT, SAMPLING_PERIOD
from repro.board.messages import MessageDecoder, MessageKind, encode_message, encode_start, parse_identity
from repro.board.parser import Frames, StreamParser
from repro.board.sidecar import CaptureMetadata, EndReason, Host
from repro.errors import InputError
from repro.files import writing
from repro.progress import Progress

_LOG = logging.getLogger(__name__)

#: Seconds between two reads of a port that had nothing.
_POLL: Final = 0.002
#: Seconds without a byte after which a line is considered idle; a running board sends every 2.5 ms.
_QUIET: Final = 0.1
#: Seconds that a simulated board may need to identify itself, and a running one to end its motion.
_IDENTIFY, _BUSY = 0.5, 25.0
#: Seconds between time stamps.
_STAMP: Final = 0.05
#: Most bytes read and written at once.
_READ, _WRITE = 1 << 16, 1024
#: Seconds by which a recording may exceed twice the length of its motion: a simulated board can be slow.
_SLACK: Final = 10.0
#: Farthest that the arm may hang from q = 0 at a start, rad: an undetected flipped bit adds 0.02. From there the
#: simulated arm stays below 3 rad/s; from 0.9, where friction holds it after ID, it exceeds the 8 allowed.
NEAR: Final = 0.05


def most_bytes(samples: int) -> int:
    """Limit the bytes received for a motion: four times its frames, and what a port gives at once."""
    return 4 * FRAME_BYTES * samples + 2 * _READ


def record(
    port: str, metadata: CaptureMetadata, baud: int, silence: float, keep: Callable[[bytes], object]
) -> tuple[bytes, CaptureMetadata]:
    """Record one motion; gives the bytes received and the metadata with board, host and end of the recording.

    Unplugging, `silence` (s), Ctrl-C, and more bytes or seconds than the motion can take end a recording early: the
    arm is sent the command to stop, and what arrived is kept. `keep` is called with each piece as it arrives.
    """
    receiver = Receiver(metadata.samples, silence, keep)
    reason: EndReason = "interrupted"
    with _open(port, baud) as line:
        try:
            with _reported(port):
                _wait_until_quiet(line, port)
                decoder = MessageDecoder()
                # The stop makes the board forget the samples of a download that broke off.
                _send(line, encode_message(MessageKind.STOP) + encode_message(MessageKind.IDENTIFY))
                board = _identity(line, port, decoder, _IDENTIFY)
                _send(line, metadata.program, Progress(f"download to {port}"))
                if board is None:
                    board = _identity(line, port, decoder, _QUIET)
                _LOG.info("%s: %s", port, "no answer, so real hardware" if board is None else "a simulated board")
                _read(line)
                began = datetime.now().astimezone().isoformat(timespec="milliseconds")
                _send(line, encode_start(metadata.samples))
            reason = receiver.run(line, Progress(f"recording from {port}"))
        finally:  # the arm must not go on by itself; after the end of a motion a stop changes nothing
            if not _stop(line) and reason:
                _LOG.warning("%s: no sign that the arm has stopped", port)
    if receiver.good == 0:
        if receiver.data:
            found = f"{len(receiver.data)} bytes without a frame (wrong baud rate {baud}, or another device?)"
        elif reason == "disconnected":
            found = "nothing before it disappeared"
        else:
            causes = "board not powered, another port or baud rate, or a download that the board refused?"
            found = f"nothing in the {silence:g} s after the start ({causes})"
        raise InputError.at(port, found, f"{metadata.samples} frames")
    host = Host(port=port, baud=baud, began=began, chunks=tuple(receiver.stamps))
    return bytes(receiver.data), replace(metadata, board=board, host=host, end_reason=reason)


@contextmanager
def _reported(port: str) -> Iterator[None]:
    """Report in one line a port that fails before there is anything to keep."""
    try:
        yield
    except OSError as error:  # pyserial's exceptions are of this kind
        raise InputError.at(port, f"a port that failed ({error})", "one that takes the download") from error


def _open(port: str, baud: int) -> serial.SerialBase:
    try:
        return serial.serial_for_url(port, baudrate=baud, timeout=0, write_timeout=5.0, exclusive=True)
    except (OSError, ValueError, OverflowError) as error:
        found = f"one that cannot be opened ({' '.join(str(error).split())})"
        expected = "a serial device, a pseudo-terminal or socket://HOST:PORT of a board"
        raise InputError.at(f"port {port}", found, expected) from error


def _send(line: serial.SerialBase, data: bytes, progress: Progress | None = None) -> None:
    for place in range(0, len(data), _WRITE):
        line.write(data[place : place + _WRITE])
        if progress is not None:
            progress(min(place + _WRITE, len(data)), len(data), "bytes")


def _wait_until_quiet(line: serial.SerialBase, port: str) -> None:
    """Drop bytes of an earlier recording, and wait for the end of a motion that still runs."""
    began = last = time.monotonic()
    reported = False
    while (now := time.monotonic()) - last < _QUIET:
        if _read(line):
            last = now
            if now - began > _BUSY:
                raise InputError.at(port, f"a board that still sends after {_BUSY:g} s", "one at rest")
            if not reported and now - began > _IDENTIFY:
                _LOG.info("%s: still sending, waiting for the end of its motion", port)
                reported = True
        else:
            time.sleep(_POLL)


def _stop(line: serial.SerialBase) -> bool:
    """Send the command to stop, up to five times, until the board is silent; whether it is."""
    with suppress(OSError):  # a port that has gone
        for _ in range(5):
            _send(line, encode_message(MessageKind.STOP))
            began = last = time.monotonic()
            while (now := time.monotonic()) - began < 2.0 * _QUIET:  # what was under way arrives, too
                last = now if _read(line) else last
                if now - last >= _QUIET:
                    return True
                time.sleep(_POLL)
    return False


def _identity(line: serial.SerialBase, port: str, decoder: MessageDecoder, wait: float) -> Mapping[str, object] | None:
    """Wait for the answer of a simulated board, at most so many seconds; a real one gives none."""
    end = time.monotonic() + wait
    while time.monotonic() < end:
        for message in decoder.feed(_read(line)):
            if message.kind == MessageKind.IDENTITY:
                try:
                    return parse_identity(message)
                except ValueError as error:
                    raise InputError.at(port, f"an unreadable answer ({error})", "a board's identity") from error
        time.sleep(_POLL)
    return None


def _read(line: serial.SerialBase) -> bytes:
    """Read the bytes that have arrived; the port has a timeout of 0, at which pyserial loses none."""
    return bytes(line.read(_READ))


class Receiver:
    """Receives bytes until all samples have come or no more do; `good` counts the frames so far."""

    def __init__(
        self, samples: int, silence: float, keep: Callable[[bytes], object], clock: Callable[[], float] = time.monotonic
    ) -> None:
        self.data = bytearray()
        self.stamps: list[tuple[int, float]] = []
        self.good = 0
        self._samples, self._silence, self._keep, self._clock = samples, silence, keep, clock
        self._parser = StreamParser()

    def run(self, line: serial.SerialBase, progress: Callable[[int, int], None]) -> EndReason:
        """Receive to the last sample, or give the reason to end before; `progress` gets samples done and expected."""
        began = last = self._clock()
        longest = 2.0 * self._samples * SAMPLING_PERIOD + self._silence + _SLACK
        ended: EndReason = ""
        try:
            while not ended:
                piece, now = _read(line), self._clock()
                if now - began > longest or len(self.data) + len(piece) > most_bytes(self._samples):
                    ended = "overrun"
                elif piece:
                    last = now
                    if self._accept(piece):
                        break
                    if not self.stamps or now - began - self.stamps[-1][1] >= _STAMP:
                        self.stamps.append((len(self.data), round(now - began, 6)))
                    progress(self.good, self._samples)
                elif now - last >= (_QUIET if self._all_there() else self._silence):
                    ended = "silent"
                else:
                    time.sleep(_POLL)
        except OSError:  # pyserial's exceptions are of this kind
            ended = "disconnected"
        except KeyboardInterrupt:
            if not self.data:
                raise
            ended = "interrupted"
        while self.stamps and self.stamps[-1][0] >= len(self.data):  # of bytes after the last sample, too
            self.stamps.pop()
        self.stamps.append((len(self.data), round(last - began, 6)))
        progress(self.good, self._samples)
        self.good = min(self.good + len(self._parser.finish()), self._samples)
        within = sum(gap.lost for gap in self._parser.gaps if gap.next_frame < self.good)
        early = ended in ("interrupted", "overrun")  # frames still came, so the estimate is no evidence that all came
        return "" if self.good + (0 if early else within) >= self._samples else ended

    def _accept(self, piece: bytes) -> bool:
        """Add bytes, without those after the last sample; True once all samples have come."""
        self.data += piece
        self._keep(piece)
        frames, missing = self._parser.feed(piece), self._samples - self.good
        if self.good == 0 and len(frames):
            self._check_start(frames)
        self.good += min(len(frames), missing)
        if len(frames) < missing:
            return False
        del self.data[int(frames.offset[missing - 1]) + FRAME_BYTES :]
        return True

    def _check_start(self, frames: Frames) -> None:
        """Refuse a motion that does not begin at q = 0; frames before the first good one may be lost."""
        position, lost = frames.position[:, 0] * RADIANS_PER_COUNT, int(frames.offset[0]) // FRAME_BYTES
        joint = int(np.abs(position).argmax())
        if abs(position[joint]) > NEAR + lost * MAX_SPEED * SAMPLING_PERIOD:
            expected = f"at most {NEAR:g} rad at the start: let the arm hang at rest at q = 0"
            raise InputError.at(f"arm: joint {joint + 1}", f"{position[joint]:.3g} rad", expected)

    def _all_there(self) -> bool:
        """Whether the samples are complete if all undecided bytes are frames."""
        counts = self._parser.counts
        undecided = counts.received - counts.skipped - FRAME_BYTES * counts.good
        return counts.good + undecided // FRAME_BYTES >= self._samples


#: Space for the sidecar, bytes.
_SIDECAR = 128 << 10


class RawFile:
    """File to which received bytes are appended, with disk space reserved until it is closed."""

    def __init__(self, path: Path, reserved: int) -> None:
        self._path = path
        self._file = path.open("xb", buffering=0)
        try:
            if self._file.write(bytes(reserved)) < reserved:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            self._file.seek(0)
        except OSError:
            self.remove()
            raise

    def add(self, piece: bytes) -> None:
        """Append bytes; a disk that fails must not end the recording."""
        with suppress(OSError):
            self._file.write(piece)

    def close(self) -> None:
        """Release the reserved space that was not used."""
        with suppress(OSError, ValueError):  # ValueError: closed before
            self._file.truncate()
        self._file.close()

    def remove(self) -> None:
        """Delete the file."""
        self._file.close()
        self._path.unlink(missing_ok=True)

    def rescue(self) -> str:
        """Name the file with the bytes received; empty if there are none."""
        self.close()
        if size := self._path.stat().st_size:
            return f"; the {size} bytes received are in {self._path}"
        self.remove()
        return ""


def record_capture(
    out: Path, port: str, metadata: CaptureMetadata, baud: int, silence: float = 2.0, overwrite: bool = False
) -> Capture:
    """Record one motion into ``NAME.bin``; the bytes are in ``NAME.bin.part`` until it is written, or if that fails."""
    folder = next(parent for parent in out.absolute().parents if parent.exists())
    path = folder / f"{out.name}.part"
    if path.exists() and not overwrite:
        expected = "none: move it away, or give --overwrite"
        raise InputError.at(str(path), "bytes that an earlier recording left", expected)
    with writing(out):
        path.unlink(missing_ok=True)
        raw = RawFile(path, 2 * most_bytes(metadata.samples) + len(metadata.program) + _SIDECAR)
    try:
        with writing(out):
            data, metadata = record(port, metadata, baud, silence, raw.add)
            raw.close()
            capture = write_capture(out, data, metadata, overwrite)
    except InputError as error:
        raise InputError.at(error.place, error.found, f"{error.expected}{raw.rescue()}") from error
    except BaseException:
        raw.rescue()
        raise
    raw.remove()
    return capture
