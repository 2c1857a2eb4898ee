"""The host's end of the serial link: download a motion, start the arm, record what comes back.

pyserial opens real ports, pseudo-terminals, ``socket://host:port`` and ``loop://`` alike, and nothing here knows
which of them it has.
"""

import logging
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from datetime import datetime
from typing import Final

import serial

from repro.errors import InputError
from repro.fpga.about import Host, Reason
from repro.fpga.downlink import encode_identify, encode_stop, parse_identity
from repro.fpga.frames import BAUD
from repro.fpga.messages import MessageDecoder, MessageKind
from repro.fpga.receiver import POLL, QUIET, Receiver, take
from repro.progress import Progress

_LOG = logging.getLogger(__name__)

#: Seconds for which a simulated board may think about who it is, and a running one may take to end its motion.
_IDENTIFY, _BUSY = 0.5, 25.0
#: Bytes written at once.
_WRITE: Final = 1024


@dataclass(frozen=True)
class LinkSettings:
    """How a port is used."""

    baud: int = BAUD  # bits per second; what is not a real port ignores it
    silence: float = 2.0  # seconds without a byte after which a recording ends

    def __post_init__(self) -> None:
        """Refuse settings that cannot work."""
        if self.baud < 1:
            raise ValueError(f"baud: must be positive, got {self.baud}.")
        if not self.silence >= QUIET:
            raise ValueError(f"silence: must be {QUIET} s or more, got {self.silence}.")


@dataclass(frozen=True)
class Recording:
    """What a port gave."""

    data: bytes  # as received since the start
    # How a simulated board described itself; None for real hardware, which is silent
    board: Mapping[str, object] | None
    reason: Reason  # why the recording ended before all samples had come
    host: Host  # the host's end of the link


def record(
    port: str,
    download: bytes,
    start: bytes,
    samples: int,
    settings: LinkSettings | None = None,
    keep: Callable[[bytes], object] = lambda piece: None,  # noqa: ARG005
) -> Recording:
    """Record one motion.

    Unplugging, silence, Ctrl-C, and more bytes or seconds than the motion can take end a recording early: the arm is
    sent the command to stop, and what arrived is kept.
    """
    s = LinkSettings() if settings is None else settings
    line = _open(port, s.baud)
    receiver = Receiver(samples, s.silence, keep=keep)
    reason: Reason = "interrupted"
    try:
        with _one_line(port):
            _wait_until_quiet(line, port)
            board = _identity(line, port)
            _LOG.info("%s: %s", port, "no answer, so real hardware" if board is None else "a simulated board")
            _send(line, download, Progress(f"download to {port}"))
            take(line)
        began = datetime.now().astimezone().isoformat(timespec="milliseconds")
        try:
            with _one_line(port):
                _send(line, start)
            receiver.run(line, Progress(f"recording from {port}"))
            reason = receiver.close()
        finally:
            if reason:
                with suppress(OSError):  # the arm must not go on by itself, if it can still be told
                    _send(line, encode_stop())
    finally:
        line.close()
    if receiver.good == 0:
        raise InputError.at(port, _no_frames(len(receiver.data), reason, s), f"{samples} frames")
    return Recording(bytes(receiver.data), board, reason, Host(port, s.baud, began, tuple(receiver.stamps)))


@contextmanager
def _one_line(port: str) -> Iterator[None]:
    """Tell of a port that fails before there is anything to keep."""
    try:
        yield
    except OSError as error:  # pyserial's exceptions are of this kind
        raise InputError.at(port, f"a port that failed ({error})", "one that takes the download") from error


def _no_frames(received: int, reason: str, settings: LinkSettings) -> str:
    """Say what came instead of frames, and why that may be."""
    if received:
        return f"{received} bytes without a frame (wrong baud rate {settings.baud}, or another device?)"
    if reason == "disconnected":
        return "nothing before it disappeared"
    return (
        f"nothing in the {settings.silence:g} s after the start (board not powered, another port or baud rate, "
        "or a download that the board refused?)"
    )


def _open(port: str, baud: int) -> serial.SerialBase:
    try:
        return serial.serial_for_url(port, baudrate=baud, timeout=0, write_timeout=5.0, exclusive=True)
    except (OSError, ValueError, OverflowError) as error:
        expected = "a serial device, a pseudo-terminal or socket://HOST:PORT of a board"
        why = " ".join(str(error).split())
        raise InputError.at(f"port {port}", f"one that cannot be opened ({why})", expected) from error


def _send(line: serial.SerialBase, data: bytes, progress: Progress | None = None) -> None:
    for place in range(0, len(data), _WRITE):
        line.write(data[place : place + _WRITE])
        if progress is not None:
            progress(min(place + _WRITE, len(data)), len(data), "bytes")


def _wait_until_quiet(line: serial.SerialBase, port: str) -> None:
    """Drop what an earlier recording left, and let a motion that still runs end."""
    began = last = time.monotonic()
    told = False
    while (now := time.monotonic()) - last < QUIET:
        if take(line):
            last = now
            if now - began > _BUSY:
                raise InputError.at(port, f"a board that still sends after {_BUSY:g} s", "one at rest")
            if not told and now - began > _IDENTIFY:
                _LOG.info("%s: still sending, waiting for the end of its motion", port)
                told = True
        else:
            time.sleep(POLL)


def _identity(line: serial.SerialBase, port: str) -> Mapping[str, object] | None:
    """Ask a board who it is: a simulated one answers, a real one does not."""
    _send(line, encode_identify())
    decoder = MessageDecoder()
    end = time.monotonic() + _IDENTIFY
    while time.monotonic() < end:
        for message in decoder.feed(take(line)):
            if message.kind == MessageKind.IDENTITY:
                try:
                    return parse_identity(message)
                except ValueError as error:
                    raise InputError.at(
                        port, f"an answer that tells nothing ({error})", "a board's identity"
                    ) from error
        time.sleep(POLL)
    return None
