"""Commands for a board: simulate one, record from it, decode what was recorded."""

import argparse
import os
import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn
from urllib.parse import urlsplit

from repro.commands.options import add_config, integer, number, seconds, seed
from repro.errors import InputError

if TYPE_CHECKING:
    from repro.board.capture import Capture
    from repro.board.channel_errors import ErrorRates
    from repro.config.model import Configuration
    from repro.signals.programs import ReferenceTrajectory


def simulate_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of ``repro simulate``."""
    add = parser.add_argument
    add(
        "--board", choices=("python", "rtl"), default="python", help="rtl: simulate the design in logic (docs/board.md)"
    )
    add("--listen", choices=("pty", "socket"), default="pty", help="what to offer (default: pty)")
    add("--link", metavar="NAME", type=Path, help="with pty: symbolic link to make, a name that stays the same")
    add("--host", metavar="ADDRESS", help="with socket: address to listen on (default: 127.0.0.1)")
    add("--port-number", metavar="NUMBER", type=integer(0, 65535), help="with socket: 0 takes a free one (default)")
    add("--as-fast-as-possible", action="store_true", help="do not wait 2.5 ms between samples")
    add("--faults", metavar="KIND=RATE,...", default="", help="faults of the line, for example drop=1e-4,flip=1e-4")
    add("--seed", metavar="INTEGER", type=seed, help="of the faults (default: 1)", default=1)
    add("--once", action="store_true", help="end after the first motion, when its host has gone")
    add_config(parser)


def simulate(arguments: argparse.Namespace) -> int:
    """Run a simulated board that serial programs can connect to."""
    import numpy as np

    from repro.board.channel_errors import ErrorInjector
    from repro.board.logic import logic_board
    from repro.board.server import Board, PtyEndpoint, SocketEndpoint, serve
    from repro.config.check import load_config
    from repro.experiments.arm import board_from_config

    for option, listen in (("link", "pty"), ("host", "socket"), ("port-number", "socket")):
        if vars(arguments)[option.replace("-", "_")] is not None and arguments.listen != listen:
            raise InputError.at(f"--{option}", f"--listen {arguments.listen}", f"--listen {listen}")
    settings = parse_faults(arguments.faults)
    config = load_config(arguments.config)
    board = board_from_config(config, logic_board() if arguments.board == "rtl" else Board)
    rng = np.random.default_rng(arguments.seed)
    socket = arguments.host or "127.0.0.1", arguments.port_number or 0
    endpoint = PtyEndpoint(arguments.link) if arguments.listen == "pty" else SocketEndpoint(*socket)
    serve(
        board,
        endpoint,
        real_time=not arguments.as_fast_as_possible,
        injector=(lambda: ErrorInjector(settings, rng)) if arguments.faults else None,
        once=arguments.once,
        ready=lambda port: print(port, flush=True),
    )
    return 0


def parse_faults(text: str) -> "ErrorRates":
    """Read error rates such as ``drop=1e-4,flip=1e-4``."""
    from repro.board.channel_errors import ErrorRates

    readers: dict[str, Callable[[str], float]] = {
        **{field.name: number(0.0, 1.0, "a number") for field in fields(ErrorRates)},
        "stall_s": number(0.0, 1e6, "a number"),
        **dict.fromkeys(("stall_bytes", "disconnect_after"), integer(0, 10**9)),
    }
    values: dict[str, float] = {}
    for part in text.split(",") if text else ():
        name, _, value = part.partition("=")
        if name not in readers or name in values:
            raise InputError.at("--faults", repr(part), f"each once: {', '.join(readers)}, as in drop=1e-4,flip=1e-4")
        try:
            values[name] = readers[name](value)
        except argparse.ArgumentTypeError as error:
            raise InputError(f"--faults: {name}: {error}") from error
    if sum(values.get(name, 0.0) for name in ("drop", "flip", "insert")) > 1.0:
        raise InputError.at("--faults", text, "drop, flip, insert: must not exceed 1 together")
    return ErrorRates(**values)  # type: ignore[arg-type]


#: URLs of pyserial behind which a board can be.
_URLS = ("socket://", "rfc2217://")


def record_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of ``repro record``."""
    add = parser.add_argument
    add("--port", metavar="DEVICE", help="device, pseudo-terminal or socket://HOST:PORT (default: experiment.port)")
    add(
        "--trajectory",
        metavar="MOTION",
        required=True,
        help="ID, a motion such as T1, or a table FILE.csv with columns q1_rad, q2_rad",
    )
    add(
        "--out",
        metavar="CAPTURE",
        required=True,
        type=Path,
        help="capture NAME.bin; NAME.program and NAME.json are written next to it",
    )
    add("--baud", metavar="RATE", type=integer(1, 10**8), help="bits per second (default: experiment.baud)")
    add(
        "--timeout",
        metavar="SECONDS",
        type=seconds,
        default=2.0,
        help="seconds of silence that end a recording (default: 2)",
    )
    add("--overwrite", action="store_true", help="replace a capture that is there")
    add_config(parser)


def record(arguments: argparse.Namespace) -> int:
    """Record a motion from a board, real or simulated, into a capture file."""
    from repro.board.capture import check_target
    from repro.board.link import record_capture
    from repro.config.check import load_config
    from repro.experiments.arm import metadata_for

    check_target(arguments.out, arguments.overwrite)
    config = load_config(arguments.config)
    program = program_of(config, arguments.trajectory)
    metadata = metadata_for(program, config)
    port = config.experiment.port if arguments.port is None else arguments.port
    baud = arguments.baud or config.experiment.baud
    if "://" in port and not _is_address(port):
        raise InputError.at("--port", repr(port), f"a device, or HOST:PORT behind {' or '.join(_URLS)}")
    capture = record_capture(arguments.out, port, metadata, baud, arguments.timeout, arguments.overwrite)
    print(summarise_capture(capture))
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


def program_of(config: "Configuration", trajectory: str) -> "ReferenceTrajectory":
    """Give the motion of a name or of a table ``FILE.csv``, within the limits of the arm."""
    from repro.experiments.arm import check_program, program_from_config
    from repro.signals.programs import PROGRAMS

    if trajectory in PROGRAMS:
        return program_from_config(config, trajectory)
    if not trajectory.endswith(".csv"):
        raise InputError.at("--trajectory", repr(trajectory), f"one of {', '.join(PROGRAMS)} or FILE.csv")
    program = read_program(Path(trajectory))
    nearest = config.board.speed_limit_rad_s * program.h
    for joint, start in enumerate(program.q[:, 0], start=1):
        if abs(start) > nearest:
            expected = f"at most {nearest:.2g} rad from zero, where the arm hangs at rest"
            raise InputError.at(f"{trajectory}: row 1, q{joint}_rad", f"{start:.4g} rad", expected)
    try:
        check_program(config, program)
    except InputError as error:
        raise InputError.at(f"{trajectory}: {error.place}", error.found, error.expected) from error
    return program


def read_program(path: Path) -> "ReferenceTrajectory":
    """Read the motion of a table."""
    import numpy as np

    from repro.board.frames import RADIANS_PER_COUNT, SAMPLING_PERIOD
    from repro.documents import read_bytes
    from repro.files import read_rows
    from repro.signals.programs import MEMORY_SAMPLES, ReferenceTrajectory

    def refuse(row: int, name: str, found: str, expected: str) -> NoReturn:
        raise InputError.at(f"{path}: row {row + 1}, {name}", found, expected)

    largest, columns = (2**15 - 1) * RADIANS_PER_COUNT, []
    read_bytes(path, 4 << 20, "a CSV table of a motion")  # refuses what is larger, or endless
    table = read_rows(path, ("q1_rad", "q2_rad"))
    times = [name for name in (table[0] if table else ()) if name.casefold() in ("t", "t_s", "time", "time_s")]
    for name in (*times, "q1_rad", "q2_rad"):
        column = np.full(len(table), np.nan)
        for row, cell in enumerate(cells[name] for cells in table):
            with suppress(ValueError):
                column[row] = float("" if "_" in cell else cell)  # Python takes 1_000 for a number
            if not np.isfinite(column[row]):
                refuse(row, name, repr(cell[:40]) if cell.strip() else "an empty cell", "a finite number")
        if name in times:
            steps = np.diff(column)
            for row in np.flatnonzero(np.abs(steps - SAMPLING_PERIOD) > 0.01 * SAMPLING_PERIOD).tolist():
                expected = f"{SAMPLING_PERIOD:g} s, the period of the board (repro excite --rate 400)"
                refuse(row + 1, name, f"a step of {steps[row]:.4g} s", expected)
            continue
        for row in np.flatnonzero(np.abs(column) > largest).tolist():
            expected = f"at most {largest:.6g} rad, which the encoder counts up to"
            refuse(row, name, f"{column[row]:.6g} rad", expected)
        columns.append(column)
    if not 2 <= len(table) <= MEMORY_SAMPLES:
        expected = f"a motion of 2 to {MEMORY_SAMPLES}, as many as the board's memory has"
        raise InputError.at(str(path), f"{len(table) or 'no'} rows", expected)
    return ReferenceTrajectory(path.stem, np.stack(columns), 0, len(table), SAMPLING_PERIOD)


def decode_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of ``repro decode``."""
    add = parser.add_argument
    add("file", metavar="CAPTURE", type=Path, help="capture NAME.bin, with NAME.json next to it")
    add("-o", "--out", metavar="FILE", help="table to write, FILE.csv, or - for standard output")
    add("--overwrite", action="store_true", help="replace a table that is there")


def decode(arguments: argparse.Namespace) -> int:
    """Decode a capture file: what is in it, and its samples as a table."""
    from repro.board.capture import files_of, read_capture, to_table
    from repro.files import csv_text, write_csv, writing

    out = arguments.out
    if out not in (None, "-") and os.path.lexists(out):
        if Path(out).is_dir():
            raise InputError.at(out, "a folder", "FILE.csv, or -")
        if not arguments.overwrite:
            raise InputError.at(out, "a file", "a new name, or --overwrite")
        if Path(out).exists() and any(each.exists() and each.samefile(out) for each in files_of(arguments.file)):
            raise InputError.at(out, "a file of the capture itself", "another name")
    if out not in (None, "-") and not out.endswith(".csv"):
        raise InputError.at("--out", repr(out), "FILE.csv, or -")
    capture = read_capture(arguments.file)
    if out == "-":
        print(summarise_capture(capture), file=sys.stderr)
        sys.stdout.write(csv_text(to_table(capture)))
        return 0
    if out is not None:
        with writing(out):
            write_csv(Path(out), to_table(capture))
    print(summarise_capture(capture))
    return 0


def summarise_capture(capture: "Capture") -> str:
    """Summarise a capture in three lines."""
    metadata, counts = capture.metadata, capture.counts
    state = "complete" if capture.complete else f"incomplete ({metadata.end_reason})"
    return (
        f"{capture.place}: {metadata.motion}, source {metadata.source}, {state}\n"
        f"frames: {counts.good} good of {metadata.samples} expected ({metadata.samples * metadata.h:g} s)\n"
        f"gaps: {counts.gaps}, about {counts.lost} frames lost, {counts.skipped} bytes skipped"
    )
