"""Commands for runs of the workflow: check a configuration, verify the results, compare two runs."""

import argparse
from pathlib import Path

from repro.commands.options import DEFAULT_CONFIG, add_config
from repro.errors import InputError


def check_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of ``repro check``."""
    parser.add_argument("overlays", nargs="*", type=Path, metavar="OVERLAY", help="files for snakemake --configfile")
    add_config(parser)


def check(arguments: argparse.Namespace) -> int:
    """Check a configuration of the workflow, as a run does before any work."""
    from repro.config.check import load_config
    from repro.experiments.stored_networks import check_stored
    from repro.signals.programs import PROGRAMS

    check_stored(load_config(arguments.config, *arguments.overlays, inputs=True, motions=PROGRAMS))
    print(f"{', '.join(map(str, (arguments.config, *arguments.overlays)))}: valid")
    return 0


def verify_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of ``repro verify``."""
    parser.add_argument(
        "--results", metavar="FOLDER", type=Path, help="results folder (default: that of the configuration)"
    )
    parser.add_argument(
        "--config",
        metavar="FILE",
        type=Path,
        nargs="+",
        help="configuration file, and overlays as snakemake had them (default: that of the results' project)",
    )


def _project_config(results: Path | None) -> Path:
    """Find the configuration of the project that a results folder is in."""
    folders = [] if results is None else [Path(), *results.absolute().parents]
    return next((file for folder in folders if (file := folder / DEFAULT_CONFIG).exists()), DEFAULT_CONFIG)


def _name_another_run(results: Path, config: Path) -> None:
    """Refuse results without a ledger where a folder in them has one, with the command that verifies that run."""
    from repro.paper.ledger import CLAIMS

    others = [] if (results / CLAIMS).exists() else sorted(results.glob(f"*/{CLAIMS}"))
    if others:
        folder = others[0].parent
        overlay = config.with_name(f"{folder.name}.yaml")  # as the overlays of the project name their folders
        overlaid = f" --config {config} {overlay}" if overlay.exists() else ""
        expected = f"a ledger; another run is verified with: repro verify --results {folder}{overlaid}"
        raise InputError.at(str(results / CLAIMS), "no such file", expected)


def verify(arguments: argparse.Namespace) -> int:
    """Verify the claims ledger: its sources, every cell of it, the captures, and what the project asserts."""
    from repro.config.check import load_config, read_config
    from repro.experiments.record import changed_files, changed_settings
    from repro.fingerprint import compare_hosts
    from repro.paper.claims import broken, summary
    from repro.paper.ledger import verify_ledger
    from repro.provenance import recorded_fingerprint

    files = arguments.config or [_project_config(arguments.results)]
    config = load_config(*files)
    # Names in the list of sources start from the project's folder.
    folder = files[0].absolute().parent.parent
    root = Path() if folder == Path.cwd() else folder
    results = arguments.results or root / config.results
    _name_another_run(results, files[0])
    claims, problems = verify_ledger(results, config, root)
    problems += [*changed_settings(results, read_config(*files), root), *changed_files(results, root)]
    print(compare_hosts(recorded_fingerprint(results)))
    for line in summary(claims) if claims is not None else []:
        print(line)
    for problem in problems:
        print(f"disagrees: {problem}")
    if claims is None or problems:
        print(f"{len(problems)} disagreements between {results} and its sources")
        return 1
    return 1 if len(broken(claims)) else 0


def compare_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of ``repro compare``."""
    parser.add_argument("first", type=Path, help="results folder, for example docs/reference")
    parser.add_argument("second", type=Path, help="another one, for example results")
    help_strict = "exit code 3 if a cell differs for which no limit is known"
    parser.add_argument("--strict", action="store_true", help=help_strict)


def compare(arguments: argparse.Namespace) -> int:
    """Compare two runs table by table: the largest difference of each class of number, and where it is."""
    from dataclasses import replace

    from repro.comparison import compare_runs, report, reproducible
    from repro.exhibits.catalogue import tolerances
    from repro.provenance import recorded_fingerprint

    runs = arguments.first, arguments.second
    allowed = replace(tolerances(), reproducible=reproducible(*map(recorded_fingerprint, runs)))
    compared, alone = compare_runs(*runs, allowed)
    for line in report(compared, alone, allowed):
        print(line)
    if any(each.broken for each in compared):
        return 1
    return 3 if arguments.strict and not all(each.judged for each in compared) else 0
