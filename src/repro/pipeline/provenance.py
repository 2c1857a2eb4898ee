"""A sidecar beside the results: which commit, when, with which programs. Results themselves hold none of this."""

import datetime
import importlib.metadata
import platform
import subprocess
from pathlib import Path

from repro import __version__
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


def write_provenance(path: Path, folder: Path, cores: int) -> None:
    """Write the sidecar after a run that succeeded.

    Parameters
    ----------
    path : Path
        Destination.
    folder : Path
        Checkout the run used.
    cores : int
        Cores the run was given.
    """
    write_json(
        path,
        {
            "commit": commit(folder),
            "cores": cores,
            "finished": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
            "machine": f"{platform.machine()} {platform.system()}",
            "packages": package_versions(),
            "python": platform.python_version(),
        },
    )
