"""Measures what a trained number's class allows: the same run with networks of other seeds and processors."""

from collections.abc import Sequence
from itertools import combinations
from pathlib import Path

import pandas as pd

from repro.comparison.classes import Kind, Spread, kind_of, origin
from repro.comparison.runs import compare_runs
from repro.comparison.tables import read_rows
from repro.errors import InputError

#: Tables of training images, drawn anew with another ``training.seed`` though no network has a part in them.
SEEDED = ("figures/fig08.csv", "figures/fig09.csv", "data/mean_torque.csv")
COLUMNS = ("table", "origin", "column", "runs", "cells", "widest")


def measure(runs: Sequence[Path]) -> pd.DataFrame:
    """Widest range of any one cell over the runs, for each table, origin and column that holds trained numbers."""
    for a, b in combinations(runs, 2):
        for file in compare_runs(a, b, Spread({}))[0]:
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
                if kind_of(table, cells[0], column) is not Kind.TRAINED:
                    continue
                try:
                    values = [float(row[column]) for row in cells]
                except ValueError:
                    continue
                groups.setdefault((origin(cells[0]), column), []).append(max(values) - min(values))
        rows += [(table, *key, len(runs), len(ranges), max(ranges)) for key, ranges in groups.items()]
    return pd.DataFrame(rows, columns=list(COLUMNS))
