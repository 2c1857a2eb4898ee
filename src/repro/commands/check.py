"""Check a configuration of the workflow, as a run does before any work."""

import argparse
from pathlib import Path

from repro.commands.options import add_config


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of ``repro check``."""
    parser.add_argument("overlays", nargs="*", type=Path, metavar="OVERLAY", help="files for snakemake --configfile")
    add_config(parser)


def run(arguments: argparse.Namespace) -> int:
    """Read and check."""
    from repro.config import load_config

    load_config(arguments.config, *arguments.overlays)
    print(f"{', '.join(map(str, (arguments.config, *arguments.overlays)))}: valid")
    return 0
