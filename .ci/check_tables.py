"""Check the tables that a run left: every row there, totals the product of their factors, layouts beside the data.

Usage: ``python .ci/check_tables.py results/smoke/tables``
"""

import sys
from pathlib import Path

import pandas as pd

#: Rows of every method in a table of parameters, and in one of similarities.
PARAMETERS = {"table04": 18, "table05": 18, "table09": 9}
SIMILARITIES = {"table06": 8, "table07": 8, "table08": 2, "table10": 10}
ROWS = {"table02": 9, "table03": 17}
OTHERS = ("stability", "verdict", "metric_search")


def faults(folder: Path) -> list[str]:
    """One line for each thing that is wrong."""
    found = []
    for name in (*ROWS, *PARAMETERS, *SIMILARITIES, *OTHERS):
        for suffix in (".csv", ".tex", ".md"):
            file = folder / f"{name}{suffix}"
            if not file.is_file() or not file.stat().st_size:
                found.append(f"{file}: found nothing, expected a table")
    if found:
        return found
    for name, rows in ROWS.items():
        count = len(pd.read_csv(folder / f"{name}.csv"))
        if count != rows:
            found.append(f"{folder / name}.csv: found {count} rows, expected {rows}")
    for name, expected in (PARAMETERS | SIMILARITIES).items():
        frame = pd.read_csv(folder / f"{name}.csv")
        for method, group in frame.groupby("method"):
            if len(group) != expected:
                found.append(f"{folder / name}.csv: found {len(group)} rows of {method}, expected {expected}")
        if name in SIMILARITIES and (frame["total"] - frame["time"] * frame["frequency"]).abs().max() > 1e-9:
            found.append(f"{folder / name}.csv: found a total that is not time times frequency, expected the product")
    return found


if __name__ == "__main__":
    problems = faults(Path(sys.argv[1]))
    print("\n".join(problems) if problems else "all tables are there and consistent")
    sys.exit(bool(problems))
