"""The simulated FPGA board of Section III and Fig. 2, served behind a pseudo-terminal or a TCP socket."""

import fcntl
import logging
import os
import select
import signal
import socket
import sys
import termios
import time
import tty
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager, nullcontext
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from repro.board import messages
from repro.board.channel_errors import ErrorInjector
from repro.board.controller import ControlConstants, ControlLoop
from repro.board.frames import SAMPLING_PERIOD, encode
from repro.board.messages import Message, MessageDecoder, MessageKind
from repro.board.plant import Plant
from repro.errors import InputError, failure
from repro.signals.programs import MEMORY_SAMPLES

_LOG = logging.getLogger(__name__)

#: Longest time between two checks whether to stop, s.
_CHECK: Final = 0.05
#: Bytes that may wait for the host before a board as fast as possible waits too, and samples between two checks.
_WAITING, _BURST = 4096, 64
_READ: Final = 1 << 16


class Board:
    """A board with its arm, advanced by one sampling period at a time.

    Blocks of Fig. 2: **Write Ram** and **Ram-FPGA** are `receive` and the memory it fills, **Read Ram**,
    **Decoder**, **PD**, **PWM gen** and **Aq uart** are `tick`.
    """

    def __init__(
        self, make_plant: Callable[[], Plant], torque_per_count: ArrayLike, identity: Mapping[str, Any]
    ) -> None:
        self._make_plant, self._torque = make_plant, np.asarray(torque_per_count, dtype=np.float64)
        self.identity = dict(identity)  # description that the board answers to IDENTIFY
        self._decoder = MessageDecoder()
        self._ram = np.zeros((2, MEMORY_SAMPLES), dtype=np.float32)
        self._written = np.zeros(MEMORY_SAMPLES, dtype=np.bool_)
        self._gains: ControlConstants | None = None
        self._loop: ControlLoop | None = None
        self._sample = self._samples = 0
        self.refusals: list[str] = []

    @property
    def running(self) -> bool:
        """Whether the arm is moving."""
        return self._loop is not None

    def receive(self, data: bytes) -> bytes:
        """Take bytes of the downlink; while the arm moves only a stop is obeyed. Gives the answer, if any."""
        answer = b""
        for message in self._decoder.feed(data):
            try:
                answer += self._obey(message)
            except ValueError as error:
                self.refusals.append(f"{message.kind.name}: {error}")
        return answer

    def _obey(self, message: Message) -> bytes:
        if message.kind is MessageKind.STOP:
            self._end()
        elif self.running:
            raise ValueError("the arm is moving.")
        elif message.kind is MessageKind.GAINS:
            self._gains = messages.parse_gains(message)
        elif message.kind is MessageKind.TRAJECTORY:
            start, desired = messages.parse_trajectory(message)
            place = slice(start, start + desired.shape[1])
            self._ram[:, place], self._written[place] = desired, True
        elif message.kind is MessageKind.START:
            self._start(messages.parse_start(message))
        elif message.kind is MessageKind.IDENTIFY:
            return messages.encode_identity(self.identity)
        else:
            raise ValueError("only a board sends it.")
        return b""

    def _start(self, samples: int) -> None:
        if self._gains is None:
            raise ValueError("no gains have been received.")
        if missing := int(np.count_nonzero(~self._written[:samples])):
            raise ValueError(f"{missing} of {samples} samples of the trajectory have not been received.")
        self._loop = ControlLoop(self._make_plant(), self._gains, self._torque)
        self._sample, self._samples = 0, samples

    def tick(self) -> bytes:
        """Advance by one sampling period and give its frame, nothing if the arm is not moving.

        Positions are sent modulo 2^16 counts, as an encoder wraps.
        """
        if self._loop is None:
            return b""
        position, pwm = self._loop.step(self._ram[:, self._sample, np.newaxis])
        self._sample += 1
        if self._sample == self._samples:
            self._end()
        return encode(position.astype(np.int16), pwm)

    def _end(self) -> None:
        """Switch the motors off and forget the trajectory: a new start needs a whole one."""
        self._loop = None
        self._written[:] = False


class PtyEndpoint:
    """A pseudo-terminal, with a symbolic link to it if a stable name is needed."""

    def __init__(self, link: Path | None = None) -> None:
        self._link = link
        if link is not None and os.path.lexists(link) and not self._links_to("/dev/"):
            raise InputError.at(f"link {link}", "a file", "a name to make or a link to a terminal")
        self._open()

    def _links_to(self, start: str) -> bool:
        return self._link is not None and self._link.is_symlink() and str(self._link.readlink()).startswith(start)

    def _open(self) -> None:
        self._master, slave = os.openpty()
        tty.setraw(slave)  # no echo, no line discipline: bytes pass as they are
        self._device = os.ttyname(slave)
        os.close(slave)
        os.set_blocking(self._master, False)
        self._poll = select.poll()
        self._poll.register(self._master, select.POLLIN)  # a hang-up is reported always
        if self._link is not None:
            temporary = self._link.with_name(f".{self._link.name}-{os.getpid()}")
            try:
                temporary.unlink(missing_ok=True)
                temporary.symlink_to(self._device)
                temporary.replace(self._link)
            except OSError as error:
                os.close(self._master)
                raise InputError.at(f"link {self._link}", failure(error), "a name to make") from error

    @property
    def port(self) -> str:
        """Name that pyserial opens: the link, or else the device."""
        return self._device if self._link is None else str(self._link)

    def accept(self, timeout: float) -> int | None:
        """Give a descriptor that does not block while the other end is open; None if it is not within `timeout` s."""
        # Poll reports a hang-up at once for as long as it lasts, so an absent host is polled for now and then. What it
        # sent last is read first.
        for pause in (timeout, 0.0):
            events = sum(event for _, event in self._poll.poll(0))
            if not events & select.POLLHUP or events & select.POLLIN:
                return self._master
            time.sleep(pause)
        return None

    def on_disconnect(self) -> None:
        """Do nothing: the terminal waits for the next host."""

    def hang_up(self) -> None:
        """Replace the device by another one behind the same link."""
        self._wait_until_read()
        os.close(self._master)
        self._open()

    def _wait_until_read(self) -> None:
        """Give the host a second to read what has arrived: a closed terminal loses it."""
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
        """Remove device and link."""
        os.close(self._master)
        if self._link is not None and self._links_to(self._device):
            self._link.unlink()


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

    def accept(self, timeout: float) -> int | None:
        """Give a descriptor of the connection, or of the next one; None if none came within `timeout` s."""
        if self._peer is None:
            if not select.select([self._listener], [], [], timeout)[0]:
                return None
            self._peer, _ = self._listener.accept()
            self._peer.setblocking(False)
            self._peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return self._peer.fileno()

    def on_disconnect(self) -> None:
        """Close the connection."""
        if self._peer is not None:
            self._peer.close()
            self._peer = None

    hang_up = on_disconnect

    def close(self) -> None:
        """Close the connection and the listening socket."""
        self.on_disconnect()
        self._listener.close()


#: A place that one host at a time can connect to.
Endpoint = PtyEndpoint | SocketEndpoint


class BoardServer:
    """Carries bytes between a board and its host, which loses none however slowly it reads.

    Without a host the board goes on to the end of its motion and its frames are lost, as on a real line.
    """

    def __init__(
        self,
        board: Board,
        endpoint: Endpoint,
        real_time: bool = True,
        injector: Callable[[], ErrorInjector] | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._board, self._endpoint, self._real_time, self._make_injector = board, endpoint, real_time, injector
        self._clock = clock
        self._injector: ErrorInjector | None = None
        self._pending = bytearray()
        self._began = self._silent_until = 0.0
        self._samples = self._motions = 0
        self._unplugged = self._under_way = False

    def serve(self, stopped: Callable[[], bool], once: bool = False) -> None:
        """Serve one host after another."""
        while not stopped():
            descriptor = self._endpoint.accept(self._pause())
            if descriptor is None:
                self._pending.clear()
            elif not self._exchange(descriptor):
                self._endpoint.on_disconnect()
            self._advance()
            if once and self._motions and descriptor is None:
                return

    def _pause(self) -> float:
        """Seconds until there is something to do without the host."""
        now = self._clock()
        if self._silent_until > now:
            return min(_CHECK, self._silent_until - now)
        if not self._board.running:
            return _CHECK
        if self._real_time:
            return min(_CHECK, max(0.0, self._began + SAMPLING_PERIOD * self._samples - now))
        return 0.0 if len(self._pending) < _WAITING else _CHECK

    def _exchange(self, descriptor: int) -> bool:
        """Read from the host and send it what waits; False if it has gone."""
        sending = bool(self._pending) and self._clock() >= self._silent_until
        readable, writable, _ = select.select([descriptor], [descriptor] if sending else [], [], self._pause())
        try:
            if readable:
                if not (data := os.read(descriptor, _READ)):
                    return False
                self._receive(data)
            if writable:
                del self._pending[: os.write(descriptor, self._pending)]
        except OSError as error:
            return isinstance(error, BlockingIOError)
        return True

    def _receive(self, data: bytes) -> None:
        was_running, refused = self._board.running, len(self._board.refusals)
        self._pending += self._board.receive(data)
        for refusal in self._board.refusals[refused:]:
            _LOG.info("refused %s", refusal)
        if self._board.running and not was_running:
            _LOG.info("motion started")
            self._under_way, self._began, self._samples, self._unplugged = True, self._clock(), 0, False
            self._injector = self._make_injector and self._make_injector()

    def _advance(self) -> None:
        """Advance the board by the samples that are due."""
        for _ in range(self._due()):
            if not self._board.running:
                break
            frame = self._board.tick()
            self._samples += 1
            if self._injector is not None:
                frame = self._injector.apply(frame)
                if stall := self._injector.take_stall():
                    self._silent_until = max(self._silent_until, self._clock()) + stall
            self._pending += frame
        if self._injector is not None and self._injector.disconnected and not (self._pending or self._unplugged):
            _LOG.info("cable pulled out after %d samples", self._samples)
            self._endpoint.hang_up()
            self._unplugged = True
        if self._under_way and not self._board.running and not self._pending:
            _LOG.info("motion finished: %d samples", self._samples)
            self._under_way = False
            self._motions += 1

    def _due(self) -> int:
        """Number of samples that may be taken now."""
        if not self._board.running:
            return 0
        if self._real_time:
            return min(_BURST, int((self._clock() - self._began) / SAMPLING_PERIOD) + 1 - self._samples)
        return _BURST if len(self._pending) < _WAITING else 0


def serve(
    board: Board,
    endpoint: Endpoint,
    *,
    real_time: bool = True,
    injector: Callable[[], ErrorInjector] | None = None,
    once: bool = False,
    ready: Callable[[str], None] = lambda _: None,
    stopped: Callable[[], bool] | None = None,
) -> None:
    """Serve a board until a signal or `stopped` ends it, then close its endpoint."""
    with closing(endpoint), _signals() if stopped is None else nullcontext(stopped) as ended:
        _LOG.info("listening on %s", endpoint.port)
        ready(endpoint.port)
        BoardServer(board, endpoint, real_time, injector).serve(ended, once)


@contextmanager
def _signals() -> Iterator[Callable[[], bool]]:
    """Give a function that is true once SIGINT or SIGTERM came."""
    received: list[int] = []
    numbers = (signal.SIGINT, signal.SIGTERM)
    before = {number: signal.signal(number, lambda came, _: received.append(came)) for number in numbers}
    try:
        yield lambda: bool(received)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
