"""What Slurm's jobs of the default study take beyond the rules in them: one job of each kind.

Usage: ``python benchmarks/slurm/study_job.py``, as root, in an environment that has the extra ``slurm``; 20 minutes.
One job identifies arms from Eq. 10 with the wide prior. It needs three trainings, and one job that simulates arms.
Prints how long each job had a processor, and how long its rule ran.
"""

import tempfile
from pathlib import Path

from cluster import cluster
from smoke import CPUS, ROOT, commands, own_seconds, run, with_plugin, working_folder

TARGET = "results/study/cells/eq10-wide-0.csv"


def main() -> None:
    """Print a line for each job."""
    environment = with_plugin()
    _, on_slurm = commands([ROOT / "config" / "config.yaml"], [TARGET])
    with cluster(CPUS) as slurm, tempfile.TemporaryDirectory() as name:
        folder = working_folder(Path(name) / "study")
        wall = run(on_slurm, folder, environment | slurm.variables)
        jobs = sorted(slurm.job_seconds())
        rules = own_seconds(folder)
    # A job has one rule; they are paired by their length. Only the two trainings of Algorithm 1 may be exchanged.
    for seconds, (rule, alone) in zip(jobs, sorted(rules.items(), key=lambda item: item[1]), strict=True):
        print(f"{rule}: {seconds:.0f} s, its rule {alone:.0f} s: {seconds / alone - 1:.1%} more")
    print(f"all: {wall:.0f} s; jobs {sum(jobs):.0f} s, their rules {sum(rules.values()):.0f} s")


if __name__ == "__main__":
    main()
