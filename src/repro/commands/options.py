"""Options and types of options that several subcommands share."""

import argparse
import math
from pathlib import Path

DEFAULT_CONFIG = Path("config/config.yaml")


def add_config(parser: argparse.ArgumentParser) -> None:
    """Declare ``--config``."""
    parser.add_argument(
        "--config", type=Path, default=DEFAULT_CONFIG, help=f"configuration file (default: {DEFAULT_CONFIG})"
    )


def whole_number(text: str) -> int:
    """Read an integer, 0 or more."""
    if not (text.isascii() and text.isdigit()):
        raise argparse.ArgumentTypeError(f"found {text!r}, expected a whole number, 0 or more")
    return int(text)


def positive_integer(text: str) -> int:
    """Read an integer, 1 or more."""
    if whole_number(text) == 0:
        raise argparse.ArgumentTypeError(f"found {text!r}, expected a whole number, 1 or more")
    return int(text)


def positive_seconds(text: str) -> float:
    """Read a time of at least 0.1 s."""
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not 0.1 <= seconds < math.inf:
        raise argparse.ArgumentTypeError(f"found {text!r}, expected a time of 0.1 s or more")
    return seconds
