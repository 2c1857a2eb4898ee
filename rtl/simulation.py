"""The board's design simulated behind its pins: serial line and encoders."""

import ctypes
import weakref
from pathlib import Path
from typing import Final

from rtl.board import Board
from rtl.compiled import compile_design

#: Clocks a bit and a sampling period of a quick simulation. The sampling period is as many bits as at 100 MHz, and long
#: enough for the controller; the frames are the same.
FAST: Final = (8, 3072)


class Simulation:
    """A board from power-up on, with `divisor` clocks a bit and `period` clocks a sampling period."""

    def __init__(self, divisor: int = FAST[0], period: int = FAST[1]) -> None:
        sample_hz = 400.0
        clock_hz = sample_hz * period
        design = Board(clock_hz, clock_hz / divisor, sample_hz)
        # The fastest joint makes 27 edges in a sampling period.
        defines = {"DIVISOR": divisor, "EDGE": period // 64}
        self._library = library = compile_design(design, Path(__file__).with_suffix(".cc"), defines)
        library.board_new.restype = ctypes.c_void_p
        for name in ("read", "identified", "clocks"):
            getattr(library, f"board_{name}").restype = ctypes.c_uint64
        self._board = ctypes.c_void_p(library.board_new())
        self.period = period

        weakref.finalize(self, library.board_free, self._board)

    def send(self, data: bytes) -> None:
        """Put bytes on the line to the board, behind those that wait."""
        self._library.board_send(self._board, data, ctypes.c_uint64(len(data)))

    def move(self, first: int, second: int) -> None:
        """Turn the encoders to these counts."""
        self._library.board_move(self._board, ctypes.c_int64(first), ctypes.c_int64(second))

    def run(self, *, bytes_: int = 0, idle: bool = False, over: bool = False, clocks: int = 1 << 62) -> None:
        """Run until the board has sent so many bytes, or lines and encoders are idle, or no motion is under way."""
        arguments = (ctypes.c_uint64(bytes_), int(idle), int(over), ctypes.c_uint64(clocks))
        self._library.board_run(self._board, *arguments)

    def read(self, most: int = 1 << 16) -> bytes:
        """Take the bytes that the board has sent."""
        data = ctypes.create_string_buffer(most)
        n = self._library.board_read(self._board, data, ctypes.c_uint64(most))
        return data.raw[:n]

    @property
    def running(self) -> bool:
        """Whether the arm is moving."""
        return bool(self._library.board_status(self._board) & 1)

    @property
    def last(self) -> bool:
        """Whether the motion's last sample has been read."""
        return bool(self._library.board_status(self._board) & 2)

    def refused(self) -> list[int]:
        """Take the types of the messages that were refused, oldest first."""
        return list(iter(lambda: int(self._library.board_refused(self._board)), 0))

    @property
    def identified(self) -> int:
        """Number of requests for the board's identity so far."""
        return int(self._library.board_identified(self._board))

    @property
    def clocks(self) -> int:
        """Clocks since power-up."""
        return int(self._library.board_clocks(self._board))
