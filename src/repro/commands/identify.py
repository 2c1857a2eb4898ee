"""Identify your own arm: from a log to parameters with intervals, and a report."""

import argparse
import warnings
from pathlib import Path

from repro.commands.options import add_config, default_config, folder, integer, number, options_named, seed
from repro.errors import InputError
from repro.identification.method import GROUPS, LEAST_SQUARES, NETWORKS, network_cache

FILTERS = ("dct", "savitzky-golay", "butterworth")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of ``repro identify``."""
    add = parser.add_argument
    parser.epilog = "Example: repro identify LOG.csv --validate OTHER.csv -o OUT. Guide: docs/own-arm.md."
    add(
        "logs",
        nargs="+",
        metavar="LOG",
        help="log FILE.csv, capture FILE.bin, or the port of a board to record from; several of one arm make one fit",
    )
    add("--validate", nargs="+", type=Path, default=[], metavar="LOG", help="logs that only judge the result")
    add("--arm", metavar="FILE", type=Path, help="arm.yaml: columns, units, signs, zero position, torque constants")
    add(
        "--method",
        action="append",
        choices=(*GROUPS, *LEAST_SQUARES, *NETWORKS),
        help="may be given more than once (default: least-squares, which takes seconds; Algorithm 1 is there to "
        "compare with the paper: it trains a CNN for the motion of one log, from half a minute to a few minutes)",
    )
    add("-o", "--out", metavar="FOLDER", required=True, type=folder, help="folder for parameters, report and exports")
    add("--overwrite", action="store_true", help="replace files of the same names in that folder")
    add("--filter", choices=FILTERS, default="dct", help="zero-phase filter (default: dct)")
    add(
        "--cutoff",
        metavar="HZ",
        type=number(0.1, 1000.0, "a frequency in Hz"),
        help="cut-off in Hz (default: chosen from the log)",
    )
    add("--seed", metavar="INTEGER", type=seed, default=1, help="of standard errors and search (default: 1)")
    add(
        "--self-test",
        action="store_true",
        help="estimate known parameters from synthetic logs with this motion, noise and delay",
    )
    add(
        "--friction",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="subtract friction that Eq. 1 does not model where the log shows it (default: yes)",
    )
    add(
        "--prior",
        metavar="FILE",
        type=Path,
        help="JSON of what is known before: parameters.json of an earlier result, or value and sd of some parameters",
    )
    add("--earlier", type=Path, metavar="FILE.json", help="parameters.json of an earlier result, to compare with")
    add(
        "--strict",
        action="store_true",
        help="exit code 3 if the parameters must not be used: not physically consistent, or torque errors above 50 %%",
    )
    add(
        "--steps",
        metavar="COUNT",
        type=integer(1, 10**7),
        default=1500,
        help="training steps of the CNN (default: 1500)",
    )
    add(
        "--cache",
        metavar="FOLDER",
        type=Path,
        default=network_cache(),
        help=f"trained networks (default: {network_cache()})",
    )
    add("--trajectory", metavar="MOTION", help="with a port: motion to record, as for repro record (default: ID)")
    add_config(parser)


def run(arguments: argparse.Namespace) -> int:
    """Identify your own arm: from a log to parameters with intervals, and a report."""
    from repro.files import check_folder
    from repro.fitting.api import choose_methods, identify

    check_folder(arguments.out, arguments.overwrite)
    method = arguments.method or "least-squares"
    if not any(map(_is_port, arguments.logs)):
        for option, given in (("--trajectory", arguments.trajectory), ("--config", arguments.config)):
            if given not in (None, default_config()):
                raise InputError.at(option, repr(str(given)), "none, or the port of a board to record from")
    with options_named("method", "self_test"):  # before minutes of recording
        choose_methods(method, len(arguments.logs), arguments.self_test)
    same = (
        "validate",
        "arm",
        "filter",
        "cutoff",
        "friction",
        "prior",
        "earlier",
        "self_test",
        "seed",
        "steps",
        "cache",
    )
    with warnings.catch_warnings(), options_named("cutoff", "method Algorithm 1", "validate", "cache"):
        sources = [_source(arguments, place) for place in range(len(arguments.logs))]
        warnings.simplefilter("ignore", UserWarning)  # they are printed with the result
        result = identify(sources, method=method, **{name: getattr(arguments, name) for name in same})
    files = result.save(arguments.out, arguments.overwrite)
    print(result)
    print(f"written to {arguments.out}: {', '.join(files)}")
    if arguments.strict and result.unusable:
        print(f"--strict: {result.unusable}")
        return 3
    return 0


def _is_port(text: str) -> bool:
    """Whether a text names a port: also one below /dev that is not plugged in, but no file there."""
    path = Path(text)
    return "://" in text or path.is_char_device() or (text.startswith("/dev/") and not path.exists())


def _source(arguments: argparse.Namespace, place: int) -> Path:
    """Give the file of a log; a port is recorded first, and the capture is kept next to the result."""
    text = arguments.logs[place]
    path, number = Path(text), f"-{place + 1}" * (len(arguments.logs) > 1)
    if text.startswith("/dev/") and not path.exists():
        raise InputError.at(text, "no such port", "the port of a board that is plugged in")
    if not _is_port(text):
        return path
    from repro.commands import boards

    capture: Path = arguments.out.parent / f"{arguments.out.name}-recording{number}.bin"
    if capture.exists() and not arguments.overwrite:
        raise InputError.at(str(capture), "a recording", "a new name for the folder, or --overwrite")
    parser = argparse.ArgumentParser()
    boards.record_arguments(parser)
    command = ["--port", text, "--trajectory", arguments.trajectory or "ID", "--out", str(capture)]
    command += ["--config", str(arguments.config)] + ["--overwrite"] * arguments.overwrite
    if boards.record(parser.parse_args(command)) != 0:
        raise InputError.at(text, "no complete recording", "a board that answers, see the lines above")
    return capture
