"""How far trained numbers scatter over networks: writes the spread that `repro compare` and the ledger allow.

Each RUN is a results folder of the whole workflow that differs from the others in its networks alone: another
``training.seed``, another processor; with ``--add`` also runs of stored networks. Prints how similarities scatter.
"""

import argparse
import os
from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations
from pathlib import Path

from repro import contract

contract.hold(os.environ)

import pandas as pd

from repro.comparison import Kind, compare_runs, origin
from repro.errors import InputError
from repro.exhibits.catalogue import tolerances
from repro.files import read_rows, write_csv

SPREAD = Path(__file__).resolve().parent.parent / "src/repro/spread.csv"
SHOWN = ("tables/table06", "tables/table07", "tables/table10", "model/training")
COLUMNS = ("total", "test_loss")
#: Tables of training images, drawn anew with another ``training.seed`` though no network has a part in them.
SEEDED = ("figures/fig08.csv", "figures/fig09.csv", "data/mean_torque.csv")
SPREAD_COLUMNS = ("table", "origin", "column", "runs", "cells", "widest")


def measure(runs: Sequence[Path]) -> pd.DataFrame:
    """Widest range of any one cell over the runs, for each table, origin and column that holds trained numbers."""
    unmeasured = replace(tolerances(), widest={})
    for a, b in combinations(runs, 2):
        for file in compare_runs(a, b, unmeasured)[0]:
            for d in file.found:
                if d.broken and d.kind is not Kind.TRAINED and file.name not in SEEDED:
                    raise InputError.at(f"{b / file.name}: {d.place}", d.b, f"{d.a}, as in {a}, for it is not trained")
    rows = []
    names = sorted(path.relative_to(runs[0]).as_posix() for glob in ("*.csv", "*/*.csv") for path in runs[0].glob(glob))
    for name in names:
        if not all((run / name).exists() for run in runs):
            continue
        tables, table = [read_rows(run / name) for run in runs], name.removesuffix(".csv")
        groups: dict[tuple[str, str], list[float]] = {}
        for cells in zip(*tables, strict=True):
            for column in cells[0]:
                if unmeasured.kind(table, cells[0], column) is not Kind.TRAINED:
                    continue
                try:
                    values = [float(row[column]) for row in cells]
                except ValueError:
                    continue
                groups.setdefault((origin(cells[0]), column), []).append(max(values) - min(values))
        rows += [(table, *key, len(runs), len(ranges), max(ranges)) for key, ranges in groups.items()]
    return pd.DataFrame(rows, columns=list(SPREAD_COLUMNS))


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
