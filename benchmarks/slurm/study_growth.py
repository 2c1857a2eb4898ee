"""Seconds of a tiny study with 10, 100 and 1,000 conditions: on one core, on two, and on a Slurm of one node.

Usage: ``python benchmarks/slurm/study_growth.py [CONDITIONS...]``, as root, in an environment that has the extra
``slurm``. Conditions have two arms, no network is searched with, and a job identifies 200 conditions, so that it takes
minutes as a job of the default study does. Prints a line a run; how long Slurm's jobs had a processor, and how long
their rules ran; and what the larger study costs of the smaller one, in processor time on this machine, in wall time on
Slurm. Results of all kinds of runs have the same bytes.
"""

import resource
import sys
import tempfile
from itertools import pairwise
from pathlib import Path

import yaml
from cluster import cluster
from smoke import CPUS, SMOKE, commands, compare, own_seconds, results, run, with_plugin, working_folder

SIZES = (10, 100, 1000)
CELLS_PER_JOB = 200


def overlay(folder: Path, conditions: int) -> Path:
    """Configuration of a study with so many conditions, the tiny one otherwise."""
    study = yaml.safe_load(Path(__file__).with_name("tiny_study.yaml").read_text(encoding="utf-8"))
    frictions = 10 if conditions > 10 else 2
    levels = conditions // frictions
    study["study"] |= {
        "excitations": ["eq10"],
        "discrepancies": [round(0.99 - 0.08 * k / levels, 6) for k in range(levels)],
        "priors": ["wide"],
        "frictions": [round(0.5 + 0.1 * k, 6) for k in range(frictions)],
        "networks": ["posterior"],
        "cells_per_job": CELLS_PER_JOB,
    }
    path = folder / f"{conditions}.yaml"
    path.write_text(yaml.safe_dump(study), encoding="utf-8")
    return path


def processor_seconds() -> float:
    """What the processes that this one started and waited for have used so far."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def print_shares(jobs: list[float], folder: Path) -> None:
    """Print what Slurm's jobs took beyond the rules in them."""
    own = sum(own_seconds(folder).values())
    print(f"{len(jobs)} Slurm jobs: {sum(jobs):.0f} s, the rules in them {own:.0f} s: {sum(jobs) / own - 1:.1%} more")


def main() -> None:
    """Exit code 1 if a byte differs."""
    sizes, environment = [int(size) for size in sys.argv[1:]] or SIZES, with_plugin()
    seconds: dict[tuple[str, int], float] = {}
    with cluster(CPUS) as slurm, tempfile.TemporaryDirectory() as name:
        for size in sizes:
            configs = [SMOKE, overlay(Path(name), size)]
            local, on_slurm = commands(configs, ["study"])
            one_core = ["1" if part == str(CPUS) else part for part in local]
            expected: dict[str, bytes] = {}
            for kind, command in (("one core", one_core), ("two cores", local), ("Slurm", on_slurm)):
                folder = working_folder(Path(name) / f"{kind}, {size} conditions")
                before, jobs = processor_seconds(), len(slurm.job_seconds())
                wall = run(command, folder, environment | (slurm.variables if kind == "Slurm" else {}))
                processor = processor_seconds() - before
                seconds[kind, size] = wall if kind == "Slurm" else processor
                expected = expected or results(folder)
                compare(folder, expected)
                if kind == "Slurm":
                    print_shares(slurm.job_seconds()[jobs:], folder)
                print(f"{kind}, {size} conditions: {wall:.0f} s, of processors {processor:.0f} s", flush=True)
    for kind in dict.fromkeys(kind for kind, _ in seconds):
        for less, more in pairwise(sizes):
            ratio = seconds[kind, more] / seconds[kind, less]
            print(f"{kind}: {more} conditions cost {ratio:.2f} times what {less} cost")


if __name__ == "__main__":
    main()
