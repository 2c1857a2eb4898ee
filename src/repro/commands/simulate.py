"""Run a simulated board that serial programs can connect to."""

import argparse
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING

from repro.commands.options import add_config, integer, number, seed
from repro.errors import InputError

if TYPE_CHECKING:
    from repro.fpga.channel_errors import ErrorRates


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of ``repro simulate``."""
    parser.add_argument("--listen", choices=("pty", "socket"), default="pty", help="what to offer (default: pty)")
    parser.add_argument("--link", type=Path, help="with pty: symbolic link to make, a name that stays the same")
    parser.add_argument("--host", default="127.0.0.1", help="with socket: address to listen on (default: 127.0.0.1)")
    parser.add_argument(
        "--port-number", type=integer(0, 65535), default=0, help="with socket: 0 takes a free one (default)"
    )
    parser.add_argument("--as-fast-as-possible", action="store_true", help="do not wait 2.5 ms between samples")
    parser.add_argument("--faults", default="", help="faults of the line, for example drop=1e-4,flip=1e-4")
    parser.add_argument("--seed", type=seed, help="of arm and faults (default: experiment.seed)")
    parser.add_argument("--once", action="store_true", help="end after the first motion, when its host has gone")
    add_config(parser)


def run(arguments: argparse.Namespace) -> int:
    """Serve until a signal comes, or the first motion is over."""
    import numpy as np

    from repro.config import load_config
    from repro.fpga.channel_errors import ErrorInjector
    from repro.fpga.server import PtyEndpoint, SocketEndpoint, serve
    from repro.pipeline.experiment import board_from_config

    if arguments.link is not None and arguments.listen != "pty":
        raise InputError.at("--link", f"--listen {arguments.listen}", "--listen pty")
    settings = parse_faults(arguments.faults)
    config = load_config(arguments.config)
    seed = config["experiment"]["seed"] if arguments.seed is None else arguments.seed
    board = board_from_config(config, seed)
    rng = np.random.default_rng(seed)
    endpoint = (
        PtyEndpoint(arguments.link)
        if arguments.listen == "pty"
        else SocketEndpoint(arguments.host, arguments.port_number)
    )
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
    from repro.fpga.channel_errors import ErrorRates

    names = [field.name for field in fields(ErrorRates)]
    values: dict[str, float] = {}
    for part in text.split(",") if text else ():
        name, _, value = part.partition("=")
        if name not in names or name in values:
            raise InputError.at("--faults", repr(part), f"each once: {', '.join(names)}, as in drop=1e-4,flip=1e-4")
        try:
            values[name] = (
                integer(0, 10**9)(value)
                if name in ("stall_bytes", "disconnect_after")
                else number(0.0, 1e6, "a number")(value)
            )
        except argparse.ArgumentTypeError as error:
            raise InputError.at(f"--faults: {name}", repr(value), "a number") from error
    try:
        return ErrorRates(**values)  # type: ignore[arg-type]
    except ValueError as error:
        raise InputError.at("--faults", text, str(error).rstrip(".")) from error
