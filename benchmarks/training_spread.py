"""How far trained numbers scatter over networks: writes the spread that `repro compare` and the ledger allow.

Each RUN is a results folder of the whole workflow that differs from the others in its networks alone: another
``training.seed``, another processor; with ``--add`` also runs of stored networks. Prints how similarities scatter.
"""

import argparse
import os
from pathlib import Path

from repro import contract

contract.hold(os.environ)

import pandas as pd

from repro.comparison.spread import measure
from repro.files import write_csv

SPREAD = Path(__file__).resolve().parent.parent / "src/repro/comparison/spread.csv"
SHOWN = ("tables/table06", "tables/table07", "tables/table10", "model/training")
COLUMNS = ("total", "test_loss")


def main():
    """Measure, write and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("runs", nargs="+", type=Path, help="results folders")
    parser.add_argument("--add", action="store_true", help="to what was measured before: the wider one stays")
    args = parser.parse_args()
    runs, measured = args.runs, measure(args.runs)
    if args.add:
        both = pd.concat([pd.read_csv(SPREAD, keep_default_na=False), measured])
        merged = both.groupby(["table", "origin", "column"], sort=False)
        measured = merged.agg({"runs": "sum", "cells": "max", "widest": "max"}).reset_index()
    write_csv(SPREAD, measured)
    print(f"{len(measured)} groups of trained numbers over {len(runs)} runs: {SPREAD.name}\n")
    print("| table | method | column | cells | widest range of a cell |\n|---|---|---|---|---|")
    for row in measured[measured["table"].isin(SHOWN) & measured["column"].isin(COLUMNS)].itertuples():
        print(f"| {row.table} | {row.origin} | {row.column} | {row.cells} | {row.widest:.3g} |")


if __name__ == "__main__":
    main()
