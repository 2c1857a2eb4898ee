"""What each stage of a finished run took, from its recorded benchmarks, beside its budget.

Usage: ``python benchmarks/stages.py [RESULTS] [--cores 2]``. Exit code 1 if a stage is over its budget.
"""

import argparse
import sys
from pathlib import Path

import pandas as pd

#: Seconds on two quiet cores, and how the names of a stage's jobs begin: those of the default target.
STAGES = {
    "data": (5, ("acquire", "mean_torque", "simulate_tracked")),
    "training": (240, ("train",)),
    "identification": (60, ("identify_numeric", "score_numeric")),
    "experiment and spread": (60, ("identify_", "score_", "simulate_accepted", "explain", "check_coverage")),
    "exhibits, ledger and report": (60, ("draw_", "search_metric", "claims", "verify", "report")),
}


def main() -> int:
    """Print a line for each stage; 1 if one is over."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", nargs="?", type=Path, default=Path("results"))
    parser.add_argument("--cores", type=int, default=2, help="cores that share the jobs (default: 2)")
    arguments = parser.parse_args()
    files = [f for f in sorted((arguments.results / "benchmarks").glob("*.tsv")) if "paper" not in f.stem.split("-")]
    if not files:
        sys.exit(f"{arguments.results}/benchmarks: found no benchmark, expected those of a finished run")
    taken = dict.fromkeys(STAGES, 0.0)
    for file in files:
        stage = next((name for name, (_, starts) in STAGES.items() if file.name.startswith(starts)), None)
        if stage:
            taken[stage] += float(pd.read_csv(file, sep="\t")["s"].iloc[-1])
    for name, (budget, _) in STAGES.items():
        seconds = taken[name] / arguments.cores
        over = f"over by {seconds - budget:.0f}" if seconds > budget else "within"
        print(f"{name:30} {seconds:6.0f} s of {budget:4d}: {over}")
    return int(any(taken[name] / arguments.cores > budget for name, (budget, _) in STAGES.items()))


if __name__ == "__main__":
    sys.exit(main())
