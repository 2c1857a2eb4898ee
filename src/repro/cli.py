"""The ``repro`` command."""

import argparse
import atexit
import gc
import io
import logging
import os
import re
import sys
from collections.abc import Sequence
from contextlib import redirect_stderr, redirect_stdout, suppress
from itertools import takewhile
from pathlib import Path
from typing import Any, NoReturn, TextIO, cast

from repro import __version__, contract
from repro.commands import boards, excite, identify, runs
from repro.errors import InputError, end_by_exception, failure, one_of, shown

#: What a file name or a line of a result cannot contain: control characters, bytes that are not UTF-8.
_UNWRITABLE = re.compile("[\x00-\x1f\x7f\ud800-\udfff]")
#: Subcommands in the order of a user's work: what declares its options, and what runs it.
COMMANDS = {
    "identify": (identify.add_arguments, identify.run),
    "excite": (excite.add_arguments, excite.run),
    "simulate": (boards.simulate_arguments, boards.simulate),
    "record": (boards.record_arguments, boards.record),
    "decode": (boards.decode_arguments, boards.decode),
    "check": (runs.check_arguments, runs.check),
    "verify": (runs.verify_arguments, runs.verify),
    "compare": (runs.compare_arguments, runs.compare),
}


class OneLineParser(argparse.ArgumentParser):
    """A parser that reports a bad option in one line, without the usage."""

    def error(self, message: str) -> NoReturn:
        """Print the line and exit with code 2."""
        self.exit(2, f"{self.prog}: {message} (all options: {self.prog} --help)\n")

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:  # noqa: ANN401 - as it is declared there
        """Refuse an option that a subcommand does not have before one that is missing."""
        options = [text.partition("=")[0] for text in takewhile(lambda text: text != "--", args or ())]
        known = [name for name in self._option_string_actions if name.startswith("--")]
        for name in () if self._subparsers else (text for text in options if text.startswith("--")):
            if not any(option.startswith(name) for option in known):
                self.error(f"option: found {name}, expected {one_of(known, name)}")
        parsed, rest = super().parse_known_args(args, namespace)
        if rest and not self._subparsers:
            self.error(f"argument: found {rest[0]}, expected the name of an option before it")
        return parsed, rest

    def _check_value(self, action: argparse.Action, value: object) -> None:
        if action.choices is not None and value not in action.choices:
            raise argparse.ArgumentError(action, f"found {value!r}, expected {one_of(map(str, action.choices), value)}")


class _Version(argparse.Action):
    """Print the version, and in a checkout its commit."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from repro.provenance import commit  # noqa: PLC0415 - loads pandas, which other commands may not need

        checkout = Path(__file__).resolve().parents[2]
        print(f"repro {__version__}" + (f", commit {commit(checkout)}" if (checkout / ".git").exists() else ""))
        parser.exit()


def parser() -> argparse.ArgumentParser:
    """Parser of the command line."""
    top = OneLineParser(prog="repro", description="Identification of a two-joint arm, from board to figure.")
    top.add_argument("--version", action=_Version, nargs=0, help="show the version, and in a checkout its commit")
    subparsers = top.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name, (add_arguments, run) in COMMANDS.items():
        first_line = (run.__doc__ or "").partition("\n")[0]
        add_arguments(subparsers.add_parser(name, help=first_line, description=first_line))
    return top


def _check(arguments: Sequence[str]) -> None:
    """Refuse arguments that nothing can be named after, and a closed standard output."""
    for text in arguments:
        if found := _UNWRITABLE.search(text):
            raise InputError.at(f"argument {text[:80]!r}", repr(found[0]), "text without control characters, in UTF-8")
    if sys.stdout is None:
        raise InputError.at("standard output", "a closed one", "one that can be written to")


class _Terminal:
    """A stream that escapes what a terminal would obey: names and cells come from files of others."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # a name need not fit the encoding of the terminal

    def write(self, text: str) -> int:
        return self._stream.write("\n".join(map(shown, text.split("\n"))))

    def __getattr__(self, name: str) -> Any:  # noqa: ANN401
        return getattr(self._stream, name)


def _terminal(stream: TextIO | None) -> TextIO | None:
    return cast("TextIO", _Terminal(stream)) if stream else None


def main(argv: Sequence[str] | None = None) -> int:
    """Run a subcommand."""
    with redirect_stdout(_terminal(sys.stdout)), redirect_stderr(_terminal(sys.stderr)):
        return _run(argv)


def _run(argv: Sequence[str] | None) -> int:
    try:
        argv = sys.argv[1:] if argv is None else argv
        _check(argv)
        if not argv:
            parser().print_help(sys.stderr)
            return 2
        arguments = parser().parse_args(argv)
        end_by_exception()
        contract.hold(os.environ)
        gc.set_threshold(500_000)  # modules and figures are many objects that live to the end
        atexit.register(gc.freeze)  # and need not be searched for cycles there
        logging.basicConfig(level=logging.INFO, format="%(message)s", stream=sys.stderr, force=True)
        logging.getLogger("matplotlib").setLevel(logging.WARNING)  # its first run on a machine reports its font cache
        code: int = COMMANDS[arguments.command][1](arguments)
        sys.stdout.flush()
    except InputError as error:
        print(" ".join(str(error).splitlines()), file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    except OSError as error:
        with suppress(OSError):  # what is still buffered must not fail again at exit
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if isinstance(error, BrokenPipeError):  # whoever read our output has seen enough
            return 1
        place = str(error.filename or "output")[:200]
        print(InputError.at(place, failure(error), "what can be read or written"), file=sys.stderr)
        return 2
    return code
