"""Options and types of options that several subcommands share."""

import argparse
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from repro.errors import InputError

#: Configuration of the project's folder, and the copy that is used elsewhere.
DEFAULT_CONFIG, PACKAGED_CONFIG = Path("config/config.yaml"), Path(__file__).parent.parent / "default.yaml"


def default_config() -> Path:
    """Give the configuration of the project's folder, or its copy in the package."""
    return DEFAULT_CONFIG if DEFAULT_CONFIG.exists() else PACKAGED_CONFIG


def add_config(parser: argparse.ArgumentParser) -> None:
    """Declare ``--config``."""
    parser.add_argument(
        "--config",
        metavar="FILE",
        type=Path,
        default=default_config(),
        help=f"configuration file (default: {DEFAULT_CONFIG})",
    )


def folder(text: str) -> Path:
    """Type of an option that is a folder; an empty text would be the working folder."""
    if not text.strip():
        raise argparse.ArgumentTypeError(f"found {text!r}, expected a folder")
    return Path(text)


def integer(low: int, high: int) -> Callable[[str], int]:
    """Type of an option that is an integer within a range."""

    def read(text: str) -> int:
        digits = text.isascii() and text.isdigit() and len(text) <= len(str(high))
        if not (digits and low <= int(text) <= high):
            raise argparse.ArgumentTypeError(f"found {text[:40]!r}, expected a whole number from {low} to {high}")
        return int(text)

    return read


def number(low: float, high: float, what: str) -> Callable[[str], float]:
    """Type of an option that is a number within a range."""

    def read(text: str) -> float:
        value = math.nan
        with suppress(ValueError):
            value = float(text)
        if not (text.isascii() and low <= value <= high):
            raise argparse.ArgumentTypeError(f"found {text[:40]!r}, expected {what} of {low:g} to {high:g}")
        return value

    return read


seed = integer(0, 2**32 - 1)
seconds = number(0.1, 3600.0, "a time in s")


@contextmanager
def options_named(*names: str) -> Iterator[None]:
    """Report these arguments of a function as the options that they are on the command line."""
    try:
        yield
    except InputError as error:
        argument = error.place.partition(":")[0] in names  # a log may have the name of an option
        place = f"--{error.place.replace('_', '-')}" if argument else error.place
        raise InputError.at(place, error.found, error.expected) from error
