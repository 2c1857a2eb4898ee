"""The record of a run as RO-Crate 1.1, profile Provenance Run Crate: which job made which file from which.

The results folder is the crate, and holds a copy of the workflow. A file elsewhere in the project is identified by its
path below `PROJECT`. All terms are defined in the record, so that it is read without a network.
"""

import datetime
import hashlib
import os
import shutil
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any
from urllib.parse import quote

from repro.documents import read_json
from repro.files import write_json
from repro.pipeline.jobs import UNITS, Job

RECORD = "ro-crate-metadata.json"
PROJECT = "arcp://name,repro/"
LICENCE = "https://creativecommons.org/licenses/by/4.0/"
#: What the record says, in words of schema.org and a few of others.
SCHEMA = (
    *("ComputerLanguage", "CreateAction", "CreativeWork", "Dataset", "PropertyValue", "SoftwareApplication"),
    *("SoftwareSourceCode", "about", "contentSize", "datePublished", "description", "endTime", "hasPart", "instrument"),
    *("license", "mainEntity", "mentions", "name", "object", "programmingLanguage", "propertyID", "result"),
    *("softwareRequirements", "startTime", "unitText", "value", "version"),
)
CONTEXT = {name: f"http://schema.org/{name}" for name in SCHEMA} | {
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


def _graph(results: Path, snakefile: Path, configs: set[Path], jobs: list[Job]) -> list[Entity]:
    sidecar = results / "logs/provenance.json"
    provenance: Any = read_json(sidecar)
    commit, packages = provenance["commit"], provenance["packages"]
    made = {path for job in jobs for path in job.outputs}
    given = {path for job in jobs for path in job.inputs} - made | configs
    files = {path: _file(path, results) for path in sorted(made | given | {snakefile, sidecar})}
    programs = [_entity(f"#package-{name}", "SoftwareApplication", name, version=v) for name, v in packages.items()]
    rules = [_entity(f"#rule-{rule}", "SoftwareApplication", rule, version=commit) for rule in {j.rule for j in jobs}]
    files[snakefile] |= {
        "@type": ["File", "SoftwareSourceCode", "ComputationalWorkflow"],
        "programmingLanguage": {"@id": "#snakemake"},
        "hasPart": _refs(rules),
        "softwareRequirements": _refs(programs),
        "version": commit,
    }
    usages = {job.name: _usage(job) for job in jobs}
    actions = [
        _entity(
            f"#job-{job.name}",
            "CreateAction",
            job.name,
            instrument={"@id": f"#rule-{job.rule}"},
            object=_refs(files[path] for path in job.inputs),
            result=_refs(files[path] for path in job.outputs),
            startTime=_time(job.started),
            endTime=_time(job.ended),
            resourceUsage=_refs(usages[job.name]),
        )
        for job in jobs
    ]
    run = _entity(
        "#run",
        "CreateAction",
        f"run of commit {commit}",
        instrument={"@id": files[snakefile]["@id"]},
        object=_refs(files[path] for path in given),
        result=_refs(files[path] for path in made | {sidecar}),
        startTime=_time(min(job.started for job in jobs)),
        endTime=_time(max(job.ended for job in jobs)),
    )
    profiles = [_entity(key, "CreativeWork", name, version=key.split("/")[-1]) for key, name in PROFILES.items()]
    root = _entity(
        "./",
        "Dataset",
        "Results of a reproduction",
        description="Tables, figures and numbers, with the jobs that made them and what these took.",
        datePublished=provenance["finished"],
        license={"@id": LICENCE},
        conformsTo=_refs(profiles),
        mainEntity={"@id": files[snakefile]["@id"]},
        hasPart=_refs(files.values()),
        mentions=_refs([run, *actions]),
    )
    conforms = {"@id": "https://w3id.org/ro/crate/1.1"}
    graph = [
        _entity(RECORD, "CreativeWork", "Record of the run", about={"@id": "./"}, conformsTo=conforms),
        _entity(LICENCE, "CreativeWork", "CC BY 4.0", description="Creative Commons Attribution 4.0 International"),
        _entity("#snakemake", "ComputerLanguage", "Snakemake", version=packages["snakemake"]),
        *(root, run, *actions, *profiles, *programs, *rules, *files.values()),
        *(entity for each in usages.values() for entity in each),
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
    key = absolute.as_uri() if name is None else PROJECT + quote(name)
    if absolute.is_relative_to(crate):
        key = quote(absolute.relative_to(crate).as_posix())
    with path.open("rb") as content:
        digest = hashlib.file_digest(content, "sha256").hexdigest()
    return _entity(key, "File", name or str(path), contentSize=str(path.stat().st_size), sha256=digest)


def _usage(job: Job) -> list[Entity]:
    return [
        _entity(f"#job-{job.name}-{name}", "PropertyValue", name, propertyID=name, value=value, unitText=UNITS[name])
        for name, value in job.usage.items()
    ]


def _time(seconds: float) -> str:
    return datetime.datetime.fromtimestamp(seconds, datetime.UTC).isoformat(timespec="seconds")
