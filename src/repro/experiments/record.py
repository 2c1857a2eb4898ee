"""The record of a run: the settings kept with it, its jobs, what each claim costs, and all of it as an RO-Crate."""

import base64
import datetime
import hashlib
import json
import math
import os
import re
import shutil
from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote, unquote

import pandas as pd
import yaml

from repro.comparison import LEDGER
from repro.documents import read_json, read_yaml
from repro.files import write_csv, write_json, write_text
from repro.provenance import git

#: Targets that `all` does not make: what they made is kept from their own run if another one has none.
ASKED_FOR = ("ablation", "paper_recipe", "factorial", "accepted")


def config_digest(config: Mapping[str, Any]) -> str:
    """Compute the SHA-256 of a configuration's values."""
    return hashlib.sha256(json.dumps(config, sort_keys=True).encode()).hexdigest()


def changed_settings(results: Path, config: Mapping[str, Any], root: Path) -> list[str]:
    """List how the settings that are kept with results differ from a configuration.

    They are a copy, ``config.yaml``, and for targets of `ASKED_FOR` commit and digest in ``TARGET.json``:
    of the same configuration, or of that of the commit, where the repository has it.
    """
    problems, copy = [], results / "config.yaml"
    if copy.exists():
        kept, given = (_leaves(each) for each in (read_yaml(copy, "a configuration file"), config))
        for place in sorted({*kept, *given}):
            theirs, ours = (leaves.get(place, "nothing") for leaves in (kept, given))
            if theirs != ours:
                problems.append(f"{copy}: {place}: found {theirs}, expected {ours}, as in the configuration")
    for path in (results / f"{target}.json" for target in ASKED_FOR):
        if not path.exists():
            continue
        content: Any = read_json(path)
        made = content if isinstance(content, dict) else {}
        found, digest = str(made.get("commit")), made.get("config_sha256")
        is_commit = re.fullmatch("[0-9a-f]{40}(-dirty)?", found)  # as `commit` gives it
        of_commit = _config_of(found.removesuffix("-dirty"), root) if is_commit else {}
        if of_commit == {}:
            problems.append(f"{path}: commit: found {found[:60]!r}, expected a commit of the project")
        allowed = [config_digest(each) for each in (config, of_commit) if each]
        if digest not in allowed and of_commit is not None:  # else the commit may have had another configuration
            problems.append(f"{path}: config_sha256: found {str(digest)[:80]!r}, expected {' or '.join(allowed)}")
    return problems


def _leaves(node: object, place: str = "") -> dict[str, str]:
    """Give the values of a configuration by their places, as text."""
    if not isinstance(node, Mapping):
        return {place: repr(node)}
    sections = (_leaves(value, f"{place}.{key}".removeprefix(".")) for key, value in node.items())
    return {key: value for section in sections for key, value in section.items()}


def _config_of(name: str, root: Path) -> dict[str, Any] | None:
    """Read the configuration of a commit: empty if the whole history has none, None if only a part of it is here."""
    text = git(root, "show", f"{name}:./config/config.yaml")
    if text is not None:
        return dict(yaml.safe_load(text))
    return {} if git(root, "rev-parse", "--is-shallow-repository") == "false" else None


#: What each claim costs, in a folder of results.
COSTS = "logs/costs.csv"
#: What is taken from a benchmark, and its unit: wall time, time of the processor as far as seen, largest resident set.
UNITS = {"s": "s", "cpu_time": "s", "max_rss": "MiB"}


@dataclass(frozen=True)
class Job:
    """One job, with the name of its log; of its files those that are still there."""

    name: str
    rule: str
    inputs: tuple[Path, ...]
    outputs: tuple[Path, ...]
    started: float  # seconds since 1970
    ended: float
    usage: Mapping[str, float]  # in `UNITS`; a job of a blink has its wall time alone


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
    return {name: _job(name, outputs, results) for name, outputs in sorted(records.items())}


def _job(name: str, records: Mapping[Path, Any], results: Path) -> Job:
    inputs = sorted({Path(path) for record in records.values() for path in record["input"]})
    started, ended = min(r["starttime"] for r in records.values()), max(r["endtime"] for r in records.values())
    benchmark = results / f"benchmarks/{name}.tsv"
    row: Any = pd.read_csv(benchmark, sep="\t", na_values="-").iloc[-1].dropna() if benchmark.exists() else {}
    usage = {"s": ended - started} | {column: float(row[column]) for column in UNITS if column in row}
    rule = next(iter(records.values()))["rule"]
    return Job(name, rule, tuple(filter(Path.exists, inputs)), tuple(sorted(records)), started, ended, usage)


def write_costs(results: Path, jobs: Mapping[str, Job]) -> None:
    """Write one row for each claim, if the ledger is there, beside the provenance: times differ from run to run."""
    claims = results / "claims.csv"
    if LEDGER in jobs and claims in jobs[LEDGER].outputs:
        ledger = pd.read_csv(claims, keep_default_na=False)[["id", "target"]]
        costs = {target: _cost(jobs, target) for target in ledger["target"].unique()}
        columns = ["jobs", "minutes", "cpu_minutes", "memory_mib", "disk_mb"]
        rows = pd.DataFrame([costs[target] for target in ledger["target"]], columns=columns)
        write_csv(results / COSTS, ledger.join(rows))


def _cost(jobs: Mapping[str, Job], target: str) -> tuple[float, ...]:
    """Number of jobs, their minutes one after another, the largest memory, and what their files fill on disk.

    What no job of its own makes, a setting or arithmetic, costs the ledger's own job; what only hardware can tell, NaN.
    """
    if not target:
        return (math.nan,) * 5
    own = [job for job in jobs.values() if target in {job.name, *(path.stem for path in job.outputs)}]
    makers = {path: job for job in jobs.values() for path in job.outputs} if own and target != LEDGER else {}
    ahead, found = [own[0] if makers else jobs[LEDGER]], dict[str, Job]()
    while ahead:
        job = ahead.pop()
        if job.name not in found:
            found[job.name] = job
            ahead += [makers[path] for path in job.inputs if path in makers]
    wall, cpu, memory = ([job.usage.get(column, 0.0) for job in found.values()] for column in UNITS)
    size = sum(path.stat().st_size for job in found.values() for path in job.outputs)
    return len(found), sum(wall) / 60, sum(cpu) / 60, max(memory), size / 1e6


RECORD, SEAL = "ro-crate-metadata.json", "ro-crate-metadata.sha256"
#: Begin of the names of files of the project in the record, and the largest record that is read, bytes.
OF_THE_PROJECT, LARGEST_RECORD = "arcp://name,repro/", 64 << 20
LICENCE = "https://creativecommons.org/licenses/by/4.0/"
#: What the record says, in words of schema.org and a few of others.
SCHEMA = """
ComputerLanguage CreateAction CreativeWork Dataset PropertyValue SoftwareApplication SoftwareSourceCode about
contentSize datePublished description endTime hasPart instrument license mainEntity mentions name object
programmingLanguage propertyID result softwareRequirements startTime unitText value version
"""
CONTEXT = {name: f"http://schema.org/{name}" for name in SCHEMA.split()} | {
    "ComputationalWorkflow": "https://bioschemas.org/ComputationalWorkflow",
    "File": "http://schema.org/MediaObject",
    "conformsTo": "http://purl.org/dc/terms/conformsTo",
    "resourceUsage": "https://w3id.org/ro/terms/workflow-run#resourceUsage",
    "sha256": "https://w3id.org/ro/terms/workflow-run#sha256",
}
PROFILES = {
    "https://w3id.org/ro/wfrun/process/0.5": "Process Run Crate",
    "https://w3id.org/ro/wfrun/workflow/0.5": "Workflow Run Crate",
    "https://w3id.org/ro/wfrun/provenance/0.5": "Provenance Run Crate",
    "https://w3id.org/workflowhub/workflow-ro-crate/1.0": "Workflow RO-Crate",
}

Entity = dict[str, Any]


def write_crate(results: Path, workflow: Path, configs: Iterable[Path], jobs: Mapping[str, Job]) -> None:
    """Write the record beside the results, after their provenance; nothing if no job is known."""
    if jobs:
        copy = results / "workflow"
        shutil.rmtree(copy, ignore_errors=True)
        shutil.copytree(workflow, copy, ignore=shutil.ignore_patterns("__pycache__"))
        graph = _graph(results, copy / "Snakefile", set(configs), list(jobs.values()))
        write_json(results / RECORD, {"@context": CONTEXT, "@graph": graph})
        write_text(results / SEAL, f"{_digest(results / RECORD)}  {RECORD}\n")


def changed_files(results: Path, root: Path) -> list[str]:
    """List files of a run that are not as its record has them: changed, missing, or next to its own without being its.

    Of the files of the project that the run read, those that are still there, and of the figures, if their folder is.
    Logs and benchmarks of jobs are no results. Whoever changes a file and writes record and seal again is not seen:
    only another run of the same commit shows that.
    """
    record, seal = results / RECORD, results / SEAL
    if not record.exists():
        return []
    found = seal.read_text(encoding="utf-8", errors="replace").split(" ")[0] if seal.exists() else "no such file"
    problems = [] if found == _digest(record) else [f"{record}: SHA-256: found {_digest(record)}, {seal} has {found}"]
    content: Any = read_json(record, LARGEST_RECORD)
    graph = content.get("@graph") if isinstance(content, dict) else None
    entities = _by_id(graph)
    made = _by_id(entities.get("#run", {}).get("result")).keys()
    own = set()
    for key, entity in entities.items():
        if "sha256" not in entity:
            continue
        within = not key.startswith((OF_THE_PROJECT, "file:"))
        path = results / unquote(key) if within else root / unquote(key.removeprefix(OF_THE_PROJECT))
        ours = within or (key in made and path.parent.is_dir())
        own |= {path} if ours else set()
        now = _digest(path) if path.is_file() else ""
        if now and now != entity["sha256"]:
            problems.append(f"{path}: SHA-256: found {now}, {record} has {entity['sha256']}")
        elif ours and not now:
            problems.append(f"{path}: found no file, {record} has one")
    figures = {path.parent for path in own if not path.is_relative_to(results)}
    there = {path for folder in figures for path in folder.glob("*") if path.is_file() and path.name != "README.md"}
    unknown = (there | _files_of_run(results)) - own - {record, seal}
    return sorted(problems) + [f"{path}: found a file, {record} has none" for path in sorted(unknown)]


def _by_id(entities: object) -> dict[str, Entity]:
    listed = entities if isinstance(entities, list) else []
    return {str(each["@id"]): each for each in listed if isinstance(each, dict) and "@id" in each}


def _files_of_run(results: Path) -> set[Path]:
    """Files in a folder of results but logs, benchmarks and the folders of other runs."""
    others = {
        folder for folder in results.iterdir() if any((folder / name).exists() for name in ("logs", "claims.csv"))
    }
    left_out = {results / "logs", results / "benchmarks", *others}
    return {
        path
        for path in results.rglob("*")
        if path.is_file() and left_out.isdisjoint(path.parents) and path != results / "README.md"
    }


def _graph(results: Path, snakefile: Path, configs: set[Path], jobs: list[Job]) -> list[Entity]:
    sidecar = results / "logs/provenance.json"
    provenance: Any = read_json(sidecar)
    commit, packages = provenance["commit"], provenance["packages"]
    produced = {path for job in jobs for path in job.outputs}
    given = {path for job in jobs for path in job.inputs} - produced | configs
    copied = set(filter(Path.is_file, snakefile.parent.rglob("*")))
    described = {sidecar, *filter(Path.exists, [results / COSTS])}
    files = {path: _file(path, results) for path in sorted(produced | given | copied | described)}
    programs = [_entity(f"#package-{name}", "SoftwareApplication", name, version=v) for name, v in packages.items()]
    rules = [_entity(f"#rule-{rule}", "SoftwareApplication", rule, version=commit) for rule in {j.rule for j in jobs}]
    files[snakefile] |= {"@type": ["File", "SoftwareSourceCode", "ComputationalWorkflow"], "version": commit}
    files[snakefile] |= {"programmingLanguage": {"@id": "#snakemake"}}
    files[snakefile] |= {"hasPart": _refs(rules), "softwareRequirements": _refs(programs)}

    def action(key: str, title: str, by: str, job: Job) -> Entity:
        times = (datetime.datetime.fromtimestamp(t, datetime.UTC) for t in (job.started, job.ended))
        start, end = (time.isoformat(timespec="seconds") for time in times)
        read, made = (_refs(files[path] for path in paths) for paths in (job.inputs, job.outputs))
        done = _entity(key, "CreateAction", title, instrument={"@id": by}, object=read, result=made)
        return done | {"startTime": start, "endTime": end}

    main, times = files[snakefile]["@id"], [time for job in jobs for time in (job.started, job.ended)]
    run = Job("run", "", tuple(given), (*produced, sidecar), min(times), max(times), {})
    actions, usages = [action("#run", f"run of commit {commit}", main, run)], []
    for job in jobs:
        key = f"#job-{job.name}"
        used = [
            _entity(f"{key}-{name}", "PropertyValue", name, propertyID=name, value=value, unitText=UNITS[name])
            for name, value in job.usage.items()
        ]
        actions.append({**action(key, job.name, f"#rule-{job.rule}", job), "resourceUsage": _refs(used)})
        usages += used
    profiles = [_entity(key, "CreativeWork", name, version=key.split("/")[-1]) for key, name in PROFILES.items()]
    what = "Tables, figures and numbers, with the jobs that made them and what these took."
    root = _entity("./", "Dataset", "Results of a reproduction", description=what, license={"@id": LICENCE})
    root |= {"datePublished": provenance["finished"], "conformsTo": _refs(profiles), "mainEntity": {"@id": main}}
    root |= {"hasPart": _refs(files.values()), "mentions": _refs(actions)}
    conforms = {"@id": "https://w3id.org/ro/crate/1.1"}
    graph = [
        _entity(RECORD, "CreativeWork", "Record of the run", about={"@id": "./"}, conformsTo=conforms),
        _entity(LICENCE, "CreativeWork", "CC BY 4.0", description="Creative Commons Attribution 4.0 International"),
        _entity("#snakemake", "ComputerLanguage", "Snakemake", version=packages["snakemake"]),
        *(root, *actions, *usages, *profiles, *programs, *rules, *files.values()),
    ]
    return sorted(graph, key=lambda entity: str(entity["@id"]))


def _entity(key: str, kind: str, name: str, **fields: object) -> Entity:
    return {"@id": key, "@type": kind, "name": name, **fields}


def _refs(entities: Iterable[Entity]) -> list[dict[str, str]]:
    return [{"@id": key} for key in sorted(entity["@id"] for entity in entities)]


def _file(path: Path, results: Path) -> Entity:
    """A file by the name that the project knows it by."""
    absolute, crate, project = (Path(os.path.abspath(p)) for p in (path, results, ""))  # noqa: PTH100 - links stay
    name = absolute.relative_to(project).as_posix() if absolute.is_relative_to(project) else None
    key = absolute.as_uri() if name is None else f"{OF_THE_PROJECT}{quote(name)}"
    if absolute.is_relative_to(crate):
        key = quote(absolute.relative_to(crate).as_posix())
    return _entity(key, "File", name or str(path), contentSize=str(path.stat().st_size), sha256=_digest(path))


def _digest(path: Path) -> str:
    with path.open("rb") as content:
        return hashlib.file_digest(content, "sha256").hexdigest()
