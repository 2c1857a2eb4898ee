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
    """The host's end of the link while it recorded.

    Attributes
    ----------
    port : str
        Name or URL that was opened.
    baud : int
        Bits per second asked for.
    began : str
        When the arm was started, ISO 8601 with the offset from UTC.
    chunks : tuple of (int, float)
        Bytes received so far and the time since the start (s), about every 50 ms.
    """

    port: str
    baud: int
    began: str
    chunks: tuple[tuple[int, float], ...]


@dataclass(frozen=True)
class About:
    """What was recorded, and with what.

    Attributes
    ----------
    motion : str
        Name of the motion.
    samples : int
        Number of samples expected.
    n1, n2 : int
        The trajectory proper is samples n1 to n2 - 1.
    h : float
        Sampling period, s.
    program : bytes
        Gains and desired positions as the board was sent them.
    control : ControlConstants
        Gains, PWM frequencies and motor torques.
    board : mapping or None
        How a simulated board described itself and its arm; None for real hardware.
    host : Host or None
        The host's end; None for a recording simulated in process.
    """

    motion: str
    samples: int
    n1: int
    n2: int
    h: float
    program: bytes
    control: ControlConstants
    board: Mapping[str, object] | None
    host: Host | None = None

    @property
    def source(self) -> str:
        """``simulated`` or ``serial``."""
        return "serial" if self.board is None else "simulated"

    @cached_property
    def desired(self) -> SingleArray:
        """Desired positions as the board received them, rad, shape (2, samples)."""
        return parse_program(self.program)[1]
