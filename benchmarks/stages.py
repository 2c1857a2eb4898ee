"""What each stage of a finished run took, from its recorded benchmarks.

Usage: ``python benchmarks/stages.py [RESULTS] [--cores 2]``.
"""

import argparse
import sys
from pathlib import Path

import pandas as pd

#: How the names of a stage's jobs begin: those of the default target.
STAGES = {
    "data": ("acquire", "mean_torque", "simulate_tracked"),
    "training": ("train",),
    "identification": ("identify_numeric", "score_numeric"),
    "experiment and spread": ("identify_", "score_", "simulate_accepted", "explain", "check_coverage"),
    "exhibits, ledger and report": ("draw_", "search_metric", "claims", "verify", "report"),
}


def main() -> None:
    """Print a line for each stage."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", nargs="?", type=Path, default=Path("results"))
    parser.add_argument("--cores", type=int, default=2, help="cores that share the jobs (default: 2)")
    arguments = parser.parse_args()
    files = [f for f in sorted((arguments.results / "benchmarks").glob("*.tsv")) if "paper" not in f.stem.split("-")]
    if not files:
        sys.exit(f"{arguments.results}/benchmarks: found no benchmark, expected those of a finished run")
    taken = dict.fromkeys(STAGES, 0.0)
    for file in files:
        stage = next((name for name, starts in STAGES.items() if file.name.startswith(starts)), None)
        if stage:
            taken[stage] += float(pd.read_csv(file, sep="\t")["s"].iloc[-1])
    for name, seconds in taken.items():
        print(f"{name:30} {seconds / arguments.cores:6.0f} s")


if __name__ == "__main__":
    main()
