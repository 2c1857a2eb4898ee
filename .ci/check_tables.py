"""Check the tables that a run left: every row there, totals the product of their factors, layouts beside the data.

Usage: ``python .ci/check_tables.py results/smoke/tables``
"""

import sys
from pathlib import Path

import pandas as pd

CASES = {"table04": ("N1", "N2"), "table05": ("N3", "N4"), "table06": None, "table07": None}
ROWS = {"table02": 9, "table03": 17}


def faults(folder: Path) -> list[str]:
    """One line for each thing that is wrong."""
    found = []
    for name in (*ROWS, *CASES, "metric_search"):
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
    for name, cases in CASES.items():
        frame = pd.read_csv(folder / f"{name}.csv")
        expected = len(cases) * 9 if cases else 8
        for method, group in frame.groupby("method"):
            if len(group) != expected:
                found.append(f"{folder / name}.csv: found {len(group)} rows of {method}, expected {expected}")
        if cases is None and (frame["total"] - frame["time"] * frame["frequency"]).abs().max() > 1e-9:
            found.append(f"{folder / name}.csv: found a total that is not time times frequency, expected the product")
    return found


if __name__ == "__main__":
    problems = faults(Path(sys.argv[1]))
    print("\n".join(problems) if problems else "all tables are there and consistent")
    sys.exit(bool(problems))
