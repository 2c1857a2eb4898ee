"""Record a motion from a board, real or simulated, into a capture file."""

import argparse
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

from repro.commands.options import add_config, integer, seconds
from repro.errors import InputError

if TYPE_CHECKING:
    from repro.signals.programs import Program

#: URLs of pyserial behind which a board can be.
_URLS = ("socket://", "rfc2217://")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of ``repro record``."""
    parser.add_argument("--port", help="device, pseudo-terminal or socket://HOST:PORT (default: experiment.port)")
    parser.add_argument(
        "--trajectory",
        required=True,
        help="ID, a motion such as T1, or a table FILE.csv with columns q1_rad, q2_rad",
    )
    parser.add_argument(
        "--out", required=True, type=Path, help="capture NAME.bin; NAME.program and NAME.json are written next to it"
    )
    parser.add_argument("--baud", type=integer(1, 10**8), help="bits per second (default: experiment.baud)")
    parser.add_argument(
        "--timeout", type=seconds, default=2.0, help="seconds of silence that end a recording (default: 2)"
    )
    parser.add_argument("--overwrite", action="store_true", help="replace a capture that is there")
    add_config(parser)


def run(arguments: argparse.Namespace) -> int:
    """Download, start, record, write."""
    from repro.commands.decode import summary
    from repro.config import load_config
    from repro.fpga.capture import check_target, write_capture
    from repro.fpga.link import raw_file, record
    from repro.pipeline.experiment import metadata_for

    check_target(arguments.out, arguments.overwrite)
    config = load_config(arguments.config)
    program = program_of(config, arguments.trajectory)
    metadata = metadata_for(program, config)
    defaults = config["experiment"]
    port = defaults["port"] if arguments.port is None else arguments.port
    baud = defaults["baud"] if arguments.baud is None else arguments.baud
    if "://" in port and not _is_address(port):
        raise InputError.at("--port", repr(port), f"a device, or HOST:PORT behind {' or '.join(_URLS)}")
    with raw_file(arguments.out, metadata, arguments.overwrite) as raw:
        data, metadata = record(port, metadata, baud, arguments.timeout, raw.add)
        raw.close()
        capture = write_capture(arguments.out, data, metadata, arguments.overwrite)
    print(summary(capture))
    if capture.complete:
        return 0
    print(f"{arguments.out}: incomplete ({capture.metadata.end_reason}); what arrived is kept", file=sys.stderr)
    return 1


def _is_address(url: str) -> bool:
    """Whether a URL names a host and a port that pyserial can connect to."""
    try:
        parts = urlsplit(url)
        return url.startswith(_URLS) and bool(parts.hostname) and bool(parts.port)
    except ValueError:  # no number, or above 65535
        return False


def program_of(config: Mapping[str, Any], trajectory: str) -> "Program":
    """Give the motion of a name or of a table ``FILE.csv``, within the limits of the arm."""
    from repro.pipeline.experiment import check_program, program_from_config
    from repro.signals.programs import PROGRAMS

    if trajectory in PROGRAMS:
        return program_from_config(config, trajectory)
    if not trajectory.endswith(".csv"):
        raise InputError.at("--trajectory", repr(trajectory), f"one of {', '.join(PROGRAMS)} or FILE.csv")
    program = read_program(Path(trajectory))
    try:
        check_program(config, program)
    except InputError as error:
        raise InputError(f"{trajectory}: {error}") from error
    return program


def read_program(path: Path) -> "Program":
    """Read the motion of a table."""
    import numpy as np
    import pandas as pd

    from repro.documents import read_bytes
    from repro.files import read_csv
    from repro.fpga.frames import RADIANS_PER_COUNT, SAMPLING_PERIOD
    from repro.signals.programs import MEMORY_SAMPLES, Program

    largest, columns = 2**15 * RADIANS_PER_COUNT, []
    read_bytes(path, 4 << 20, "a CSV table of a motion")  # refuses what is larger, or endless
    table = read_csv(path, ("q1_rad", "q2_rad"))
    for name in ("q1_rad", "q2_rad"):
        column = np.asarray(pd.to_numeric(table[name], errors="coerce"), dtype=np.float64)
        for row in np.flatnonzero(~np.isfinite(column)):
            cell = table[name].iloc[row]
            found = repr(cell[:40]) if isinstance(cell, str) else str(cell)
            raise InputError.at(f"{path}: row {row + 1}, {name}", found, "a finite number")
        for row in np.flatnonzero(np.abs(column) > largest):
            expected = f"at most {largest:.4g} rad, which the encoder counts up to"
            raise InputError.at(f"{path}: row {row + 1}, {name}", f"{column[row]:.4g} rad", expected)
        columns.append(column)
    if not 2 <= len(table) <= MEMORY_SAMPLES:
        expected = f"a motion of 2 to {MEMORY_SAMPLES}, as many as the board's memory has"
        raise InputError.at(str(path), f"{len(table) or 'no'} rows", expected)
    return Program(path.stem, np.stack(columns), 0, len(table), SAMPLING_PERIOD)
