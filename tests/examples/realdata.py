"""Logs of a real arm, which the repository does not hold."""

import os
from pathlib import Path

import pytest

NAMES = ("061157", "060143", "060329")


def folder():
    """Folder of the logs: the environment variable REPRO_REALDATA, or else next to the repository."""
    near = Path(__file__).parents[3] / "shared" / "realdata" / "double_pendulum_A0"
    return Path(os.environ.get("REPRO_REALDATA") or near)


def log_file(name):
    return folder() / f"{name}.csv"


needs_real_data = pytest.mark.skipif(
    not all(log_file(name).is_file() for name in NAMES),
    reason="logs of the real arm are not here: set REPRO_REALDATA to a folder with 061157.csv, 060143.csv, 060329.csv",
)
