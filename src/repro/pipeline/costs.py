"""What each claim of the ledger costs to make again: time, memory and disk of the jobs that its number hangs on."""

import math
from collections.abc import Mapping
from pathlib import Path

import pandas as pd

from repro.comparison.tolerances import LEDGER
from repro.files import write_csv
from repro.pipeline.jobs import UNITS, Job, needed

COLUMNS = ("jobs", "minutes", "cpu_minutes", "memory_mib", "disk_mb")


def write_costs(results: Path, jobs: Mapping[str, Job]) -> None:
    """Write one row for each claim, if the ledger is there, beside the provenance: times differ from run to run."""
    claims = results / "claims.csv"
    if LEDGER in jobs and claims in jobs[LEDGER].outputs:
        ledger = pd.read_csv(claims, keep_default_na=False)[["id", "target"]]
        costs = {target: cost(jobs, target) for target in ledger["target"].unique()}
        rows = pd.DataFrame([costs[target] for target in ledger["target"]], columns=list(COLUMNS))
        write_csv(results / "logs/costs.csv", ledger.join(rows))


def cost(jobs: Mapping[str, Job], target: str) -> tuple[float, ...]:
    """Number of jobs, their minutes one after another, the largest memory, and what their files fill on disk.

    What no job of its own makes, a setting or arithmetic, costs the ledger's own job; what only hardware can tell, NaN.
    """
    if not target:
        return (math.nan,) * len(COLUMNS)
    makers = [job for job in jobs.values() if target in {job.name, *(path.stem for path in job.outputs)}]
    found = needed(jobs, makers[0].name) if makers and target != LEDGER else {LEDGER: jobs[LEDGER]}
    wall, cpu, memory = ([job.usage.get(column, 0.0) for job in found.values()] for column in UNITS)
    size = sum(path.stat().st_size for job in found.values() for path in job.outputs)
    return len(found), sum(wall) / 60, sum(cpu) / 60, max(memory), size / 1e6
