"""A simulated board as a process: plugged into an endpoint, paced like the real one or as fast as it can."""

import logging
import os
import select
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from types import FrameType
from typing import Final, Protocol

from repro.fpga.endpoint import Endpoint
from repro.fpga.faults import FaultInjector
from repro.fpga.frames import SAMPLING_PERIOD

_LOG = logging.getLogger(__name__)

#: Seconds between two looks at whether to stop.
_LOOK: Final = 0.05
#: Bytes that may wait for the host before a board as fast as possible waits as well, and samples between two looks.
_WAITING, _BURST = 4096, 64
_READ: Final = 1 << 16


class SimulatedBoard(Protocol):
    """What the server needs of a board."""

    refusals: list[str]

    @property
    def running(self) -> bool:
        """After a valid start, until the last sample."""

    def receive(self, data: bytes) -> bytes:
        """Take bytes of the downlink; answer at once or with nothing."""

    def tick(self) -> bytes:
        """Let one sampling period pass; bytes of the uplink."""


class BoardServer:
    """Carries bytes between a board and whoever is connected.

    A board does not know whether anybody listens: without a host it goes on to the end of its motion, and what it
    sends is lost. With a host nothing is lost, however slowly it reads.
    """

    def __init__(
        self,
        board: SimulatedBoard,
        endpoint: Endpoint,
        real_time: bool = True,
        faults: Callable[[], FaultInjector] | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._board, self._endpoint, self._real_time, self._make_faults = board, endpoint, real_time, faults
        self._clock = clock
        self._faults: FaultInjector | None = None
        self._unplugged = False
        self._pending = bytearray()
        self._began = self._silent_until = 0.0
        self._samples = 0
        self._under_way = False
        self._motions = 0

    def serve(self, stopped: Callable[[], bool], once: bool = False) -> None:
        """Serve one host after another."""
        while not stopped():
            descriptor = self._endpoint.host(self._pause())
            if descriptor is None:
                self._pending.clear()
            elif not self._exchange(descriptor):
                self._endpoint.left()
            self._advance()
            if once and self._motions and descriptor is None:
                return

    def _pause(self) -> float:
        """Seconds until there is something to do unless the host says or takes something."""
        now = self._clock()
        if self._silent_until > now:
            return min(_LOOK, self._silent_until - now)
        if not self._board.running:
            return _LOOK
        if self._real_time:
            return min(_LOOK, max(0.0, self._began + SAMPLING_PERIOD * self._samples - now))
        return 0.0 if len(self._pending) < _WAITING else _LOOK

    def _exchange(self, descriptor: int) -> bool:
        """Hear the host and send it what waits; False if it has gone."""
        sending = bool(self._pending) and self._clock() >= self._silent_until
        readable, writable, _ = select.select([descriptor], [descriptor] if sending else [], [], self._pause())
        try:
            if readable:
                data = os.read(descriptor, _READ)
                if not data:
                    return False
                self._hear(data)
            if writable:
                del self._pending[: os.write(descriptor, self._pending)]
        except BlockingIOError:
            return True
        except OSError:
            return False
        return True

    def _hear(self, data: bytes) -> None:
        was_running, refused = self._board.running, len(self._board.refusals)
        self._pending += self._board.receive(data)
        for why in self._board.refusals[refused:]:
            _LOG.info("refused %s", why)
        if self._board.running and not was_running:
            _LOG.info("motion started")
            self._under_way, self._began, self._samples, self._unplugged = True, self._clock(), 0, False
            self._faults = None if self._make_faults is None else self._make_faults()

    def _advance(self) -> None:
        """Let the board go on as far as it may."""
        for _ in range(self._due()):
            if not self._board.running:
                break
            frame = self._board.tick()
            self._samples += 1
            if self._faults is not None:
                frame = self._faults.apply(frame)
                if stall := self._faults.take_stall():
                    self._silent_until = max(self._silent_until, self._clock()) + stall
            self._pending += frame
        if self._faults is not None and self._faults.disconnected and not (self._pending or self._unplugged):
            _LOG.info("cable pulled out after %d samples", self._samples)
            self._endpoint.unplug()
            self._unplugged = True
        if self._under_way and not self._board.running and not self._pending:
            _LOG.info("motion finished: %d samples", self._samples)
            self._under_way = False
            self._motions += 1

    def _due(self) -> int:
        """Samples that may be taken now."""
        if not self._board.running:
            return 0
        if self._real_time:
            return int((self._clock() - self._began) / SAMPLING_PERIOD) + 1 - self._samples
        return _BURST if len(self._pending) < _WAITING else 0


def serve(
    board: SimulatedBoard,
    endpoint: Endpoint,
    *,
    real_time: bool = True,
    faults: Callable[[], FaultInjector] | None = None,
    once: bool = False,
    ready: Callable[[str], None] | None = None,
    stopped: Callable[[], bool] | None = None,
) -> None:
    """Serve a board until a signal or `stopped` ends it, then close its endpoint."""
    try:
        with _signals() if stopped is None else nullcontext(stopped) as ended:
            _LOG.info("listening on %s", endpoint.port)
            if ready is not None:
                ready(endpoint.port)
            BoardServer(board, endpoint, real_time, faults).serve(ended, once)
    finally:
        endpoint.close()


@contextmanager
def _signals() -> Iterator[Callable[[], bool]]:
    """Turn SIGINT and SIGTERM into an answer to "is it over?"."""
    received: list[int] = []

    def note(number: int, _: FrameType | None) -> None:
        received.append(number)

    before = {number: signal.signal(number, note) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield lambda: bool(received)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
