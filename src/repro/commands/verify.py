"""Verify the claims ledger: its sources, every cell of it, the captures, and what the project asserts."""

import argparse
from pathlib import Path

from repro.commands.options import DEFAULT_CONFIG


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of ``repro verify``."""
    parser.add_argument("--results", type=Path, help="results folder (default: that of the configuration)")
    parser.add_argument(
        "--config",
        type=Path,
        nargs="+",
        default=[DEFAULT_CONFIG],
        help=f"configuration file, and overlays as snakemake had them (default: {DEFAULT_CONFIG})",
    )


def run(arguments: argparse.Namespace) -> int:
    """Print the summary, every asserted claim that fails and everything that does not agree."""
    from repro.config import load_config
    from repro.fingerprint import told
    from repro.paper.claims import broken
    from repro.paper.ledger import verify_ledger
    from repro.paper.ledger_page import summary
    from repro.pipeline.provenance import recorded_fingerprint

    config = load_config(*arguments.config)
    # Names in the list of sources start from the project's folder.
    folder = arguments.config[0].absolute().parent.parent
    root = Path() if folder == Path.cwd() else folder
    results = arguments.results or root / config["results"]
    claims, problems = verify_ledger(results, config, root)
    print(told(recorded_fingerprint(results)))
    for line in summary(claims) if claims is not None else []:
        print(line)
    for problem in problems:
        print(f"disagrees: {problem}")
    if claims is None or problems:
        print(f"{len(problems)} disagreements between {results} and its sources")
        return 1
    return 1 if len(broken(claims)) else 0
