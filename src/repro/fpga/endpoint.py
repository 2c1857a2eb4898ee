"""Where a simulated board can be plugged in: a pseudo-terminal or a TCP socket, with a host or without."""

import fcntl
import os
import select
import socket
import sys
import termios
import time
import tty
from pathlib import Path
from typing import Protocol

from repro.errors import InputError


class Endpoint(Protocol):
    """A place that one host at a time can connect to."""

    @property
    def port(self) -> str:
        """What pyserial opens."""

    def host(self, timeout: float) -> int | None:
        """Descriptor that leads to the host, which must not block; None if none came within `timeout` seconds."""

    def left(self) -> None:
        """Take note that the host has gone."""

    def unplug(self) -> None:
        """Part from the host, as if the cable were pulled."""

    def close(self) -> None:
        """Leave nothing behind."""


class PtyEndpoint:
    """A pseudo-terminal."""

    def __init__(self, link: Path | None = None) -> None:
        self._link = link
        if link is not None and (link.exists() or link.is_symlink()) and not _is_terminal_link(link):
            raise InputError.at(f"link {link}", "a file", "a name to make or a link to a terminal")
        self._open()

    def _open(self) -> None:
        self._master, slave = os.openpty()
        tty.setraw(slave)  # no echo, no line discipline: bytes pass as they are
        self._device = os.ttyname(slave)
        os.close(slave)
        os.set_blocking(self._master, False)
        self._poll = select.poll()
        self._poll.register(self._master, 0)  # a hang-up is reported always
        if self._link is not None:
            try:
                temporary = self._link.with_name(f".{self._link.name}-{os.getpid()}")
                temporary.unlink(missing_ok=True)
                temporary.symlink_to(self._device)
                temporary.replace(self._link)
            except OSError as error:
                os.close(self._master)
                raise InputError.at(f"link {self._link}", error.strerror or "an error", "a name to make") from error

    @property
    def port(self) -> str:
        """The link, or else the device."""
        return self._device if self._link is None else str(self._link)

    def host(self, timeout: float) -> int | None:
        """Descriptor while somebody holds the other end open."""
        # A hang-up does not end by itself in poll, so an absent host is waited for by asking now and then.
        for wait in (timeout, 0.0):
            if not self._poll.poll(0):
                return self._master
            if wait:
                select.select([], [], [], wait)
        return None

    def left(self) -> None:
        """Nothing: the terminal waits for the next one."""

    def unplug(self) -> None:
        """Take the device away and make another, behind the same link."""
        self._wait_until_read()
        os.close(self._master)
        self._open()

    def _wait_until_read(self) -> None:
        """Give the host a second to take what has arrived: a terminal that goes takes it along."""
        try:
            slave = os.open(self._device, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        except OSError:
            return
        end, empty = time.monotonic() + 1.0, 0
        while empty < 3 and time.monotonic() < end:
            waiting = int.from_bytes(fcntl.ioctl(slave, termios.FIONREAD, bytes(4)), sys.byteorder)
            empty = 0 if waiting else empty + 1
            time.sleep(0.005)
        os.close(slave)

    def close(self) -> None:
        """Take device and link away."""
        os.close(self._master)
        if self._link is not None and self._link.is_symlink() and str(self._link.readlink()) == self._device:
            self._link.unlink()


def _is_terminal_link(link: Path) -> bool:
    return link.is_symlink() and str(link.readlink()).startswith("/dev/")


class SocketEndpoint:
    """A listening TCP socket."""

    def __init__(self, address: str, number: int) -> None:
        try:
            self._listener = socket.create_server((address, number))
        except (OSError, OverflowError) as error:
            raise InputError.at(f"socket {address}:{number}", f"an address refused ({error})", "a free one") from error
        self._address = address
        self._peer: socket.socket | None = None

    @property
    def port(self) -> str:
        """URL for pyserial."""
        return f"socket://{self._address}:{self._listener.getsockname()[1]}"

    def host(self, timeout: float) -> int | None:
        """Descriptor of the connection, or of the next one."""
        if self._peer is None:
            if not select.select([self._listener], [], [], timeout)[0]:
                return None
            self._peer, _ = self._listener.accept()
            self._peer.setblocking(False)
            self._peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return self._peer.fileno()

    def left(self) -> None:
        """Close the connection."""
        if self._peer is not None:
            self._peer.close()
            self._peer = None

    def unplug(self) -> None:
        """Close the connection."""
        self.left()

    def close(self) -> None:
        """Close the connection and listen no more."""
        self.left()
        self._listener.close()
