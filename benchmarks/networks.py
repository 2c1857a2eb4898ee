"""Headline similarities of Algorithm 1 with networks of other trainings: writes ``results/networks.csv``.

Each argument is ``NAME=RUN``: a name of the training, such as its seed, and a results folder with its scores of the
numeric tests and its identifications of the arm. Prints the range over the networks. For a RUN give Snakemake a
configuration with another `training.seed`, and the targets ``RUN/validation/numeric.csv`` and
``RUN/identification/experiment-seed1.json``.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from repro.config.check import load_config
from repro.experiments.identifications import SCORES, score_experiment
from repro.files import read_csv, write_csv
from repro.signals.programs import PROGRAMS

ROOT = Path(__file__).resolve().parents[1]
KEPT = ROOT / "benchmarks/results/networks.csv"


def means(scores: pd.DataFrame, by: Sequence[str]) -> pd.Series:
    """Median of the seeds of guesses in each cell of Algorithm 1, then the mean over the cells of each group."""
    cells = scores[scores["method"] == "algorithm1"].groupby([*by, "case", "joint"])["total"].median()
    return cells.groupby(list(by)).mean()


def measure(run: Path) -> dict[str, float]:
    """Mean totals of the four columns of README's table."""
    numeric = means(read_csv(run / "validation/numeric.csv", SCORES), ["trajectory"])
    found = sorted(run.glob("identification/experiment-seed*.json"))
    captures = [ROOT / f"data/captures/{motion}.bin" for motion in PROGRAMS]
    arm = score_experiment(found, captures, load_config(ROOT / "config/config.yaml"))
    of_arm = means(arm.assign(unseen=arm["case"] != "ID"), ["unseen"])
    return {
        "numeric_id": numeric["ID"],
        "numeric_validation": numeric["validation"],
        "arm_id": of_arm[False],
        "arm_validation": of_arm[True],
    }


def main() -> None:
    """Measure, write and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("runs", nargs="+", metavar="NAME=RUN")
    given = (run.split("=", 1) for run in parser.parse_args().runs)
    table = pd.DataFrame([{"training": name, **measure(Path(run))} for name, run in given])
    write_csv(KEPT, table)
    print((100.0 * table.set_index("training").agg(["min", "median", "max"])).round(2).T.to_string())


if __name__ == "__main__":
    main()
