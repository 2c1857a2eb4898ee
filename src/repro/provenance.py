"""What made a result: commit, host and programs."""

import datetime
import importlib.metadata
import json
import os
import platform
import subprocess
import sys
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from repro import __version__
from repro.contract import held
from repro.documents import read_json
from repro.files import write_json

PACKAGES = ("numpy", "scipy", "clarabel", "torch", "pandas", "matplotlib", "safetensors", "snakemake")


def git(folder: Path, *arguments: str) -> str | None:
    """What git prints about a checkout; None if it fails."""
    try:
        run = subprocess.run(["git", "-C", str(folder), *arguments], capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return None
    return run.stdout.strip()


def commit(folder: Path) -> str:
    """Commit of a checkout, with ``-dirty`` if files differ from it; ``unknown`` outside one."""
    return git(folder, "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*") or "unknown"


def package_versions() -> dict[str, str]:
    """Versions of the programs that results depend on."""
    versions = {"repro": __version__}
    for name in PACKAGES:
        with suppress(importlib.metadata.PackageNotFoundError):
            versions[name] = importlib.metadata.version(name)
    return versions


def host_fingerprint() -> dict[str, str]:
    """Fingerprint of this host, from another process: this one may have loaded NumPy before the contract was set."""
    command = [sys.executable, "-m", "repro.fingerprint"]
    fingerprint: dict[str, str] = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    return fingerprint


def write_provenance(path: Path, folder: Path, cores: int | None, fingerprint: Mapping[str, str]) -> None:
    """Write the sidecar after a run that succeeded."""
    made = {"commit": commit(folder), "finished": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")}
    host = {"machine": f"{platform.machine()} {platform.system()}", "cores": cores, "fingerprint": dict(fingerprint)}
    programs = {"contract": held(os.environ), "packages": package_versions(), "python": platform.python_version()}
    write_json(path, made | host | programs)  # with sorted keys


def recorded_fingerprint(results: Path) -> dict[str, str] | None:
    """Fingerprint of the host that made a run, from its sidecar; None if it has none."""
    paths = [path for path in (results / "logs/provenance.json", results / "provenance.json") if path.exists()]
    content = read_json(paths[0]) if paths else None
    found = content.get("fingerprint") if isinstance(content, dict) else None
    return found if isinstance(found, dict) else None
