"""A sidecar beside the results: which commit, when, with which programs, on a host that computes how."""

import datetime
import importlib.metadata
import json
import os
import platform
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

from repro import __version__
from repro.contract import held
from repro.documents import read_json
from repro.files import write_json

PACKAGES = ("numpy", "scipy", "cvxpy", "clarabel", "torch", "pandas", "matplotlib", "safetensors", "snakemake")


def commit(folder: Path) -> str:
    """Commit of a checkout, with ``-dirty`` if files differ from it; ``unknown`` outside one."""
    command = ["git", "-C", str(folder), "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return "unknown"


def package_versions() -> dict[str, str]:
    """Versions of the programs that results depend on."""
    return {"repro": __version__, **{name: importlib.metadata.version(name) for name in PACKAGES}}


def host_fingerprint() -> dict[str, str]:
    """Fingerprint of this host, from another process: this one may have loaded NumPy before the contract was set."""
    command = [sys.executable, "-m", "repro.fingerprint"]
    made: dict[str, str] = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    return made


def write_provenance(path: Path, folder: Path, cores: int | None, fingerprint: Mapping[str, str]) -> None:
    """Write the sidecar after a run that succeeded."""
    write_json(
        path,
        {
            "commit": commit(folder),
            "cores": cores,
            "finished": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
            "machine": f"{platform.machine()} {platform.system()}",
            "contract": held(os.environ),
            "fingerprint": dict(fingerprint),
            "packages": package_versions(),
            "python": platform.python_version(),
        },
    )


def recorded_fingerprint(results: Path) -> dict[str, str] | None:
    """Fingerprint of the host that made a run, from its sidecar; None if it has none."""
    for path in (results / "logs/provenance.json", results / "provenance.json"):
        if path.exists():
            content = read_json(path)
            found = content.get("fingerprint") if isinstance(content, dict) else None
            return found if isinstance(found, dict) else None
    return None
