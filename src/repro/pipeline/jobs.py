"""The jobs that made a folder of results, as Snakemake recorded them: files read and made, time and memory."""

import base64
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from repro.documents import read_json

#: What is taken from a benchmark, and its unit: wall time, time of the processor as far as seen, largest resident set.
UNITS = {"s": "s", "cpu_time": "s", "max_rss": "MiB"}


@dataclass(frozen=True)
class Job:
    """One job, with the name of its log; of its files those that are still there.

    Attributes
    ----------
    started, ended : float
        Seconds since 1970.
    usage : mapping of str to float
        What it took, in `UNITS`; a job of a blink has its wall time alone.
    """

    name: str
    rule: str
    inputs: tuple[Path, ...]
    outputs: tuple[Path, ...]
    started: float
    ended: float
    usage: Mapping[str, float]


def recorded_jobs(results: Path, state: Path = Path(".snakemake")) -> dict[str, Job]:
    """Jobs that wrote their logs into a folder of results and whose files are there, by name."""
    records: dict[str, dict[Path, Any]] = defaultdict(dict)
    kept = state / "metadata"
    for file in filter(Path.is_file, kept.rglob("*")):
        record: Any = read_json(file)
        # A record's name is its file's in base64; where that is long, folders that begin with @ hold the first parts.
        coded = file.relative_to(kept).as_posix().replace("/", "").replace("@", "")
        output = Path(base64.urlsafe_b64decode(coded).decode())
        for log in map(Path, record.get("log") or ()):
            if log.parent == results / "logs" and output.exists():
                records[log.stem][output] = record
    return {name: _job(name, made, results) for name, made in sorted(records.items())}


def _job(name: str, made: Mapping[Path, Any], results: Path) -> Job:
    inputs = sorted({Path(path) for record in made.values() for path in record["input"]})
    started, ended = min(r["starttime"] for r in made.values()), max(r["endtime"] for r in made.values())
    benchmark = results / f"benchmarks/{name}.tsv"
    row: Any = pd.read_csv(benchmark, sep="\t", na_values="-").iloc[-1].dropna() if benchmark.exists() else {}
    return Job(
        name=name,
        rule=next(iter(made.values()))["rule"],
        inputs=tuple(path for path in inputs if path.exists()),
        outputs=tuple(sorted(made)),
        started=started,
        ended=ended,
        usage={"s": ended - started} | {column: float(row[column]) for column in UNITS if column in row},
    )


def needed(jobs: Mapping[str, Job], name: str) -> dict[str, Job]:
    """A job and all whose files it hangs on, however far."""
    makers = {path: job for job in jobs.values() for path in job.outputs}
    found: dict[str, Job] = {}
    ahead = [jobs[name]]
    while ahead:
        job = ahead.pop()
        if job.name not in found:
            found[job.name] = job
            ahead += [makers[path] for path in job.inputs if path in makers]
    return found
