"""Algorithm 1 on the accepted experiments with networks of other trainings: writes ``results/accepted_networks.csv``.

Each argument is ``SEED=RUN``: the seed of a training and the results folder of target ``accepted`` with it. Prints the
medians over the experiments, and in how many of them Algorithm 1 is above least squares.
"""

import argparse
from pathlib import Path

import pandas as pd

from repro.exhibits.print_compatible import MEAN, by_experiment
from repro.experiments.accepted import GUESSES
from repro.files import read_csv, write_csv

KEPT = Path(__file__).resolve().parent / "results/accepted_networks.csv"


def measure(seed: int, run: Path) -> pd.DataFrame:
    """Mean total over T1 to T4 of each experiment and number of guesses, next to that of least squares."""
    files = sorted(run.glob("accepted/experiment-*.csv"))
    totals = by_experiment(pd.concat([read_csv(file, GUESSES) for file in files], ignore_index=True))
    means = totals[totals["case"] == MEAN].set_index("experiment")
    level = means.loc[means["method"] == "least-squares", "total"]
    found = means[means["method"] == "algorithm1"].sort_values(["guesses", "experiment"]).reset_index()
    columns = {"algorithm1": found["total"], "least_squares": found["experiment"].map(level)}
    return found[["experiment", "guesses"]].assign(**columns).assign(training_seed=seed)


def main() -> None:
    """Measure, write and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("runs", nargs="+", metavar="SEED=RUN")
    given = (run.split("=", 1) for run in parser.parse_args().runs)
    table = pd.concat([measure(int(seed), Path(run)) for seed, run in given])
    table = table[["training_seed", "experiment", "guesses", "algorithm1", "least_squares"]]
    write_csv(KEPT, table)
    for (seed, guesses), rows in table.groupby(["training_seed", "guesses"]):
        won = (rows["algorithm1"] > rows["least_squares"]).sum()
        print(f"seed {seed}, {guesses} guesses: median {rows['algorithm1'].median():.3f}, above {won} of {len(rows)}")


if __name__ == "__main__":
    main()
