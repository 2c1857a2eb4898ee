"""What was recorded, with what, and over which link."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Final, Literal

from repro.fpga.controller import ControlConstants
from repro.fpga.downlink import SingleArray, parse_program

#: Why a recording ended early; empty if it did not.
REASONS: Final = ("", "silent", "disconnected", "interrupted", "overrun")

Reason = Literal["", "silent", "disconnected", "interrupted", "overrun"]


@dataclass(frozen=True)
class Host:
    """The host's end of the link while it recorded."""

    port: str  # name or URL that was opened
    baud: int  # bits per second asked for
    began: str  # when the arm was started, ISO 8601 with the offset from UTC
    chunks: tuple[tuple[int, float], ...]  # bytes received so far and the time since the start (s), about every 50 ms


@dataclass(frozen=True)
class About:
    """What was recorded, and with what."""

    motion: str  # name of the motion
    samples: int  # number of samples expected
    n1: int  # the trajectory proper is samples n1 to n2 - 1
    n2: int
    h: float  # sampling period, s
    program: bytes  # gains and desired positions as the board was sent them
    control: ControlConstants  # gains, PWM frequencies and motor torques
    board: Mapping[str, object] | None  # how a simulated board described itself and its arm; None for real hardware
    host: Host | None = None  # the host's end; None for a recording simulated in process

    @property
    def source(self) -> str:
        """``simulated`` or ``serial``."""
        return "serial" if self.board is None else "simulated"

    @cached_property
    def desired(self) -> SingleArray:
        """Desired positions as the board received them, rad, shape (2, samples)."""
        return parse_program(self.program)[1]
