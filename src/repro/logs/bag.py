"""A bag of ROS as a table; a child process unpacks and reads it, within limits of memory and time."""

import json
import math
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from functools import partial
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from repro.documents import check_size
from repro.errors import InputError, require
from repro.logs.plain_text import MAX_FILE_BYTES
from repro.logs.table import Rows, Table
from repro.model.parameters import Array

_READER = "repro.logs.joint_states"
_ROWS_PER_BLOCK = 2_000  # rows that are written as text at a time


def is_bag(path: Path) -> bool:
    """Whether a path is a file or the folder of a bag."""
    return path.suffix in (".mcap", ".db3", ".bag") or (path / "metadata.yaml").is_file()


def read_bag(path: Path, topic: str | None) -> Table:
    """Read the joint states of a bag: a row for each message, numbered from 1, time in s since the first stamp."""
    if not path.exists():
        raise InputError.at(str(path), "no such file", "a ROS 2 bag")
    files = sorted(file for file in path.iterdir() if not file.is_dir()) if path.is_dir() else [path]
    for file in files:
        check_size(file, MAX_FILE_BYTES, "a file of a ROS 2 bag")
    require("rosbags", "bags", str(path))
    # One thread: libraries reserve memory for each. The folder takes what is unpacked, also if the process is killed.
    with TemporaryDirectory() as folder:
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path)), "TMPDIR": folder}
        environment |= dict.fromkeys(("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"), "1")
        command = [sys.executable, "-P", "-m", _READER, str(path), *([topic] if topic else [])]
        run = subprocess.run(command, capture_output=True, env=environment, check=False)
    if run.returncode == 2:
        raise InputError.at(*json.loads(run.stderr))
    if run.returncode == -signal.SIGXCPU:
        raise InputError.at(str(path), "contents that take too long to read", "a smaller bag, of joint states alone")
    if run.returncode:
        raise InputError.at(str(path), "bytes that are no messages", "a whole bag of ROS")
    with np.load(BytesIO(run.stdout)) as content:
        header, notes = (tuple(map(str, content[name])) for name in ("header", "notes"))
        return Table(str(path), header, partial(_blocks, content["values"]), notes)


def _blocks(values: Array) -> Iterator[Rows]:
    """Write numbers (rows, columns) as the cells of a table; NaN as an empty one."""
    for begin in range(0, len(values), _ROWS_PER_BLOCK):
        block = values[begin : begin + _ROWS_PER_BLOCK].tolist()
        cells = [["" if math.isnan(x) else repr(x) for x in row] for row in block]
        yield list(enumerate(cells, begin + 1))
