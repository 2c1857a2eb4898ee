"""The report of a run: every result in one page, with what it was made by."""

import hashlib
import json
import platform
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from repro.pipeline.named import Config
from repro.pipeline.provenance import commit, package_versions
from repro.report.inputs import ReportInputs
from repro.report.page import write_report

#: How a reader makes one output again.
COMMAND = "snakemake --cores 2"
#: Where the networks come from, by ``training.source``.
NETWORKS = {"trained": "trained in this run", "stored": "networks that come with the project, not trained in this run"}


def make_report(captures: str, caption: str, overlays: Sequence[str], config: Config) -> None:
    """Write ``report/index.html`` in the results folder."""
    captions = Path(caption).parent
    digest = hashlib.sha256(json.dumps(config, sort_keys=True).encode()).hexdigest()
    # No times: the same commit, configuration and results give the same page.
    provenance: Mapping[str, Any] = {
        "commit": commit(captions),
        "networks": NETWORKS[config["training"]["source"]],
        "packages": package_versions(),
        "python": platform.python_version(),
    }
    names = ", ".join(Path(name).name for name in overlays)
    notice = f"Made with the settings of {names}, not those of the full reproduction." if overlays else ""
    if config["training"]["source"] == "stored":
        notice = f"{notice} {NETWORKS['stored'].capitalize()}.".strip()
    folders = (Path(config["results"]), Path(config["figures"]), captions, Path(captures))
    write_report(ReportInputs(*folders, digest, COMMAND, provenance, notice))
