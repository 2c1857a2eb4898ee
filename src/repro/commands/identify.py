"""Identify your own arm: from a log to parameters, how sure they are, and a report."""

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
    from repro.ownarm.judge import Found
    from repro.ownarm.prepared import Told
    from repro.ownarm.result import Result, Score

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
        help="what comes out of this motion, noise and delay where the parameters are known",
    )
    parser.add_argument(
        "--friction", action="store_true", help="take out friction beyond Eq. 1 where the log asks for it"
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
    """Read, tell, prepare, solve, judge, write."""
    from repro.logs.armfile import read_arm
    from repro.ownarm.job import assemble, resolve, solve_all, with_self_test
    from repro.ownarm.outputs import check_folder, write_all, write_sidecar
    from repro.ownarm.prepared import make_problem, read
    from repro.ownarm.settings import Options
    from repro.progress import Progress

    check_folder(arguments.out, arguments.overwrite)
    arm = read_arm(arguments.arm)
    # A network is trained for one motion, so several logs are for least squares.
    usual = ("all",) if len(arguments.logs) == 1 else ("least-squares",)
    chosen = tuple(dict.fromkeys(n for m in arguments.method or usual for n in GROUPS.get(m, (m,))))
    if len(arguments.logs) > 1 and set(chosen) & set(NETWORKS):
        raise InputError.at(
            "--method",
            "Algorithm 1 for several logs",
            "--method least-squares, or one log: a network is trained for one motion",
        )
    if arguments.self_test and not set(chosen) - set(NETWORKS):
        raise InputError.at("--self-test", "Algorithm 1 alone", "a method of least squares, which claims intervals")
    options = Options(
        chosen,
        arguments.cache.expanduser(),
        arguments.filter,
        arguments.cutoff,
        arguments.seed,
        arguments.steps,
        arguments.friction,
    )
    if set(chosen) & set(NETWORKS):
        _check_cache(options.cache)
    _check_apart(arguments)
    others = tuple(read(path, arm) for path in arguments.validate)
    fitted, *more = (read(_source(arguments, log), arm) for log in arguments.logs)
    for told in (fitted, *more, *others):
        _tell(told, briefly=told is not fitted)
    problem = make_problem(fitted, others, arm, options, tuple(more))
    for log in problem.logs:
        s = log.settings
        _LOG.info("%s: cut-off %.3g Hz: %s", log.told.description.name, s.cutoff, log.cutoff.reason)
        _LOG.info("the torque acts %.3g ms later than recorded; lambda %.4g s/rad", 1e3 * s.delay, s.friction_steepness)
    progress: dict[str, Progress] = {}

    def report(what: str, done: int, total: int, note: str) -> None:
        progress.setdefault(what, Progress(what))(done, total, note)

    methods = resolve(options, report)
    quick = [m for m in methods if m.name not in NETWORKS]
    found = solve_all(problem, quick, options.seed, report, _found)
    if found and len(quick) < len(methods):
        _LOG.info("so far, without the CNN:\n%s", summary(assemble(problem, found, arm)[0]))
    found += solve_all(problem, [m for m in methods if m not in quick], options.seed, report, _found)
    if not found:
        raise InputError.at(fitted.description.name, "no solution by any method", "a log that tells more, see above")
    result, curves = assemble(problem, found, arm)
    if arguments.self_test:
        result = with_self_test(result, problem, arm, options, report)
    print(summary(result), flush=True)
    inputs = [Path(name) for name in (*arguments.logs, *arguments.validate, arguments.arm) if name]
    files = [*write_all(arguments.out, result, curves, arm, inputs), write_sidecar(arguments.out)]
    print(f"written to {arguments.out}: {', '.join(files)}")
    return 0


def _source(arguments: argparse.Namespace, text: str) -> Path:
    """The log's file; a port is recorded from first, and the capture is kept beside the result."""
    path = Path(text)
    if text.startswith("/dev/") and not path.exists():
        raise InputError.at(text, "no such port", "the port of a board that is plugged in")
    if "://" not in text and not path.is_char_device():
        return path
    from repro.commands import record

    capture: Path = arguments.out.parent / f"{arguments.out.name}-recording.bin"
    if capture.exists() and not arguments.overwrite:
        raise InputError.at(str(capture), "a recording", "a new name for the folder, or --overwrite")
    parser = argparse.ArgumentParser()
    record.add_arguments(parser)
    command = ["--port", text, "--trajectory", arguments.trajectory, "--out", str(capture)]
    command += ["--config", str(arguments.config)] + ["--overwrite"] * arguments.overwrite
    if record.run(parser.parse_args(command)) != 0:
        raise InputError.at(text, "no complete recording", "a board that answers, see the lines above")
    return capture


def _check_apart(arguments: argparse.Namespace) -> None:
    """Refuse a log that is given twice, and a network for several motions at once."""
    files = [Path(log) for log in arguments.logs if Path(log).exists()]
    for k, path in enumerate(files):
        if any(path.samefile(other) for other in files[:k]):
            raise InputError.at(str(path), "the same log twice", "each log once")
    for path in arguments.validate:
        if path.exists() and any(path.samefile(log) for log in files):
            raise InputError.at(f"--validate {path}", "the log itself", "a log of another motion")


def _tell(told: "Told", briefly: bool) -> None:
    d = told.description
    _LOG.info("%s%s", d.name, " (simulated board)" if d.simulated else "")
    for label, value in d.facts:
        if not briefly or label in ("length", "rate", "gaps"):
            _LOG.info("  %s: %s", label, value)
    for note in d.notes:
        _LOG.info("  note: %s", note)
    for warning in d.warnings:
        _LOG.warning("  WARNING: %s", warning)


def _found(found: "Found") -> None:
    _LOG.info("%s", "; ".join((f"{found.method.title}: done", *found.estimate.notes)))


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


def _left_out(score: "Score") -> str:
    """A half of the log, or one of several logs that the others foretell."""
    from repro.ownarm.result import HALVES

    return score.log if score.log in HALVES else f"{score.log} from the others"


def _errors(score: "Score") -> str:
    """Torque error of both joints, and that of the re-simulated position where there is one."""
    torque = "/".join(f"{100 * error:.1f}" for error in score.relative_rms)
    return torque if score.position_rms is None else "{} ({:.2g}/{:.2g} rad)".format(torque, *score.position_rms)


def summary(result: "Result") -> str:
    """What to know without opening the report."""
    from repro.ownarm.setup import friction, not_shown
    from repro.ownarm.words import ALLOWED

    best = next(m for m in result.methods if m.method == result.recommended)
    lines = [f"{result.arm}{' (simulated)' if result.simulated else ''}: {best.title}, {result.reason}"]
    for p in best.parameters:
        lines.append(f"  {p.name} = {p.estimate:.4g} {p.unit}: {p.verdict}")
    if best.claims_intervals:
        lines.append(f"  {ALLOWED}")
    lines += [f"  {friction(term)}" for terms in result.friction for term in terms if term.taken]
    lines += [f"  {line}" for line in not_shown(result)]
    lines.append("torque error, relative RMS of joint 1 / joint 2 in % (re-simulated position in windows of 0.5 s):")
    for m in result.methods:
        parts = [("fit", m.fit), *((_left_out(s), s) for s in m.halves), *((s.log, s) for s in m.validation)]
        errors = ", ".join(f"{name} {_errors(s)}" for name, s in parts)
        mark = "*" if m.method == result.recommended else " "
        lines.append(f" {mark}{m.method}{'' if m.consistent else ' (not physically consistent)'}: {errors}")
    if result.selftest:
        t = result.selftest
        lines.append(f"self-test: {t.draws} logs made of this motion with the parameters of {t.method}")
        heads = ("", "true", "median found", "range", "held by the interval")
        lines += ["  {:4}{:>11}{:>14}{:>26}{:>22}".format(*row) for row in (heads, *t.rows)]
        lines.append(t.verdict)
    lines += [f"WARNING: {warning}" for warning in result.warnings]
    return "\n".join(lines)
