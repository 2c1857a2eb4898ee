"""Identify your own arm: from a log to parameters with intervals, and a report."""

import argparse
import logging
import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from repro.commands.options import add_config, folder, integer, number, seed
from repro.errors import InputError
from repro.identification.method import LEAST_SQUARES, NETWORKS

if TYPE_CHECKING:
    from repro.ownarm.evaluate import Fit
    from repro.ownarm.prepare import LoadedLog

_LOG = logging.getLogger(__name__)

GROUPS = {"all": (*LEAST_SQUARES, *NETWORKS), "least-squares": LEAST_SQUARES}
FILTERS = ("dct", "savitzky-golay", "butterworth")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of ``repro identify``."""
    parser.epilog = "Example: repro identify LOG.csv --validate OTHER.csv -o OUT. Guide: docs/own-arm.md."
    parser.add_argument(
        "logs",
        nargs="+",
        metavar="LOG",
        help="log FILE.csv, capture FILE.bin, or the port of a board to record from; several of one arm make one fit",
    )
    parser.add_argument(
        "--validate", nargs="+", type=Path, default=[], metavar="LOG", help="logs that only judge the result"
    )
    parser.add_argument("--arm", type=Path, help="arm.yaml: columns, units, signs, zero position, torque constants")
    parser.add_argument(
        "--method",
        action="append",
        choices=(*GROUPS, *LEAST_SQUARES, *NETWORKS),
        help="may be given more than once (default: all; least-squares takes seconds, the CNN half a minute and more)",
    )
    parser.add_argument("-o", "--out", required=True, type=folder, help="folder for parameters, report and exports")
    parser.add_argument("--overwrite", action="store_true", help="replace files of an earlier run in that folder")
    parser.add_argument("--filter", choices=FILTERS, default="dct", help="zero-phase filter (default: dct)")
    parser.add_argument(
        "--cutoff", type=number(0.1, 1000.0, "a frequency in Hz"), help="cut-off in Hz (default: chosen from the log)"
    )
    parser.add_argument("--seed", type=seed, default=1, help="of standard errors and search (default: 1)")
    parser.add_argument(
        "--self-test",
        action="store_true",
        help="estimate known parameters from synthetic logs with this motion, noise and delay",
    )
    parser.add_argument(
        "--friction", action="store_true", help="subtract friction that Eq. 1 does not model where the log shows it"
    )
    parser.add_argument(
        "--steps", type=integer(1, 10**7), default=1500, help="training steps of the CNN (default: 1500)"
    )
    parser.add_argument(
        "--threads", type=integer(1, 1024), help="no effect: the CNN uses one thread, so that the seed determines it"
    )
    parser.add_argument("--cache", type=Path, default=_cache(), help=f"trained networks (default: {_cache()})")
    parser.add_argument(
        "--trajectory", default="ID", help="with a port: motion to record, as for repro record (default: ID)"
    )
    add_config(parser)


def _cache() -> Path:
    """Folder for trained networks, of the user's choice by XDG_CACHE_HOME."""
    home = os.environ.get("XDG_CACHE_HOME")
    return (Path(home) if home else Path("~/.cache")) / "repro"


def run(arguments: argparse.Namespace) -> int:
    """Identify your own arm: from a log to parameters with intervals, and a report."""
    from repro.files import check_folder
    from repro.logs.armfile import read_arm
    from repro.ownarm.evaluate import add_self_test, assemble, fit_all, resolve
    from repro.ownarm.outputs import write_result, write_sidecar
    from repro.ownarm.prepare import Options, load_log, make_problem
    from repro.ownarm.text import summary
    from repro.progress import Progress

    check_folder(arguments.out, arguments.overwrite)
    arm = read_arm(arguments.arm)
    names = _methods(arguments)
    options = Options(
        methods=names,
        cache=arguments.cache.expanduser(),
        filter=arguments.filter,
        cutoff=arguments.cutoff,
        seed=arguments.seed,
        steps=arguments.steps,
        friction=arguments.friction,
    )
    if set(names) & set(NETWORKS):
        _check_cache(options.cache)
    _check_distinct(arguments)
    validation = tuple(load_log(path, arm) for path in arguments.validate)
    fitted, *more = (load_log(_source(arguments, log), arm) for log in arguments.logs)
    for loaded in (fitted, *more, *validation):
        _report_log(loaded, briefly=loaded is not fitted)
    problem = make_problem(fitted, validation, arm, options, tuple(more))
    for log in problem.logs:
        s = log.settings
        _LOG.info("%s: cut-off %.3g Hz: %s", log.loaded.name, s.cutoff, log.cutoff.reason)
        _LOG.info("the torque acts %.3g ms later than recorded; lambda %.4g s/rad", 1e3 * s.delay, s.friction_steepness)
    bars: dict[str, Progress] = {}

    def progress(what: str, done: int, total: int, note: str) -> None:
        bars.setdefault(what, Progress(what))(done, total, note)

    methods = resolve(options, progress)
    quick = [m for m in methods if m.name not in NETWORKS]
    fits = fit_all(problem, quick, options.seed, progress, _report_fit)
    if fits and len(quick) < len(methods):
        _LOG.info("so far, without the CNN:\n%s", summary(assemble(problem, fits, arm)[0]))
    fits += fit_all(problem, [m for m in methods if m not in quick], options.seed, progress, _report_fit)
    if not fits:
        raise InputError.at(fitted.name, "no solution by any method", "a log that shows more, see above")
    result, curves = assemble(problem, fits, arm)
    if arguments.self_test:
        result = add_self_test(result, problem, arm, options, progress)
    print(summary(result), flush=True)
    inputs = [Path(name) for name in (*arguments.logs, *arguments.validate, arguments.arm) if name]
    files = [*write_result(arguments.out, result, curves, arm, inputs), write_sidecar(arguments.out)]
    print(f"written to {arguments.out}: {', '.join(files)}")
    return 0


def _methods(arguments: argparse.Namespace) -> tuple[str, ...]:
    """Resolve groups of methods; several logs are for least squares, because a network is trained for one motion."""
    default = ("all",) if len(arguments.logs) == 1 else ("least-squares",)
    names = tuple(dict.fromkeys(n for m in arguments.method or default for n in GROUPS.get(m, (m,))))
    if len(arguments.logs) > 1 and set(names) & set(NETWORKS):
        expected = "--method least-squares, or one log: a network is trained for one motion"
        raise InputError.at("--method", "Algorithm 1 for several logs", expected)
    if arguments.self_test and not set(names) - set(NETWORKS):
        raise InputError.at("--self-test", "Algorithm 1 alone", "a method of least squares, which claims intervals")
    return names


def _source(arguments: argparse.Namespace, text: str) -> Path:
    """Give the file of a log; a port is recorded first, and the capture is kept next to the result."""
    path = Path(text)
    if text.startswith("/dev/") and not path.exists():
        raise InputError.at(text, "no such port", "the port of a board that is plugged in")
    if "://" not in text and not path.is_char_device():
        return path
    from repro.commands import boards

    capture: Path = arguments.out.parent / f"{arguments.out.name}-recording.bin"
    if capture.exists() and not arguments.overwrite:
        raise InputError.at(str(capture), "a recording", "a new name for the folder, or --overwrite")
    parser = argparse.ArgumentParser()
    boards.record_arguments(parser)
    command = ["--port", text, "--trajectory", arguments.trajectory, "--out", str(capture)]
    command += ["--config", str(arguments.config)] + ["--overwrite"] * arguments.overwrite
    if boards.record(parser.parse_args(command)) != 0:
        raise InputError.at(text, "no complete recording", "a board that answers, see the lines above")
    return capture


def _check_distinct(arguments: argparse.Namespace) -> None:
    """Refuse a log that is given twice."""
    files = [Path(log) for log in arguments.logs if Path(log).exists()]
    for k, path in enumerate(files):
        if any(path.samefile(other) for other in files[:k]):
            raise InputError.at(str(path), "the same log twice", "each log once")
    for path in arguments.validate:
        if path.exists() and any(path.samefile(log) for log in files):
            raise InputError.at(f"--validate {path}", "the log itself", "a log of another motion")


def _report_log(loaded: "LoadedLog", briefly: bool) -> None:
    d = loaded.description
    _LOG.info("%s%s", d.name, " (simulated board)" if d.simulated else "")
    for label, value in d.facts:
        if not briefly or label in ("length", "rate", "gaps"):
            _LOG.info("  %s: %s", label, value)
    for note in d.notes:
        _LOG.info("  note: %s", note)
    for warning in d.warnings:
        _LOG.warning("  WARNING: %s", warning)


def _report_fit(fit: "Fit") -> None:
    _LOG.info("%s", "; ".join((f"{fit.method.title}: done", *fit.estimate.notes)))


def _check_cache(cache: Path) -> None:
    """Refuse a cache that cannot be written before minutes of training are spent."""
    try:
        cache.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=cache):
            pass
    except OSError as error:
        raise InputError.at(
            f"--cache {cache}", error.strerror or "no folder", "a folder that can be written"
        ) from error
