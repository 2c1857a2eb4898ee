"""Compare two runs table by table: the largest difference of each class of number, and where it is."""

import argparse
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of ``repro compare``."""
    parser.add_argument("first", type=Path, help="results folder, for example docs/reference")
    parser.add_argument("second", type=Path, help="another one, for example results")


def run(arguments: argparse.Namespace) -> int:
    """Print the comparison; exit code 1 if a difference is larger than its class allows."""
    from repro.comparison.runs import compare_runs, report
    from repro.exhibits.catalogue import tolerances

    compared, alone = compare_runs(arguments.first, arguments.second, tolerances())
    for line in report(compared, alone):
        print(line)
    return int(any(each.broken for each in compared))
