"""Before the first rule: locks of runs that were killed are cleared, those of living runs are not."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from repro.pipeline.start import hold_folder

HOLDER = """
import fcntl, sys
handle = open(sys.argv[1], "w")
fcntl.flock(handle, fcntl.LOCK_SH)
print("held", flush=True)
sys.stdin.read()
"""


@pytest.fixture
def state(tmp_path):
    """State folder with the locks that a run leaves when it is killed."""
    folder = tmp_path / ".snakemake"
    lock(folder)
    return folder


def lock(folder: Path) -> Path:
    path = folder / "locks" / "0.output.lock"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("results/model/cnn.safetensors\n", encoding="utf-8")
    return path


@pytest.fixture
def holder(state):
    """Another process that holds the folder."""
    command = [sys.executable, "-c", HOLDER, str(state / "alive")]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "held\n"
        yield process
        process.stdin.close()


def locked(folder):
    return (folder / "locks").exists() and any((folder / "locks").iterdir())


def test_a_stale_lock_is_removed(state):
    held = hold_folder(state)
    assert held is not None
    assert not locked(state)
    held.close()


def test_a_new_folder_is_made(tmp_path):
    held = hold_folder(tmp_path / ".snakemake")
    assert (tmp_path / ".snakemake").is_dir()
    held.close()


def test_nothing_else_in_the_folder_is_touched(state):
    other = state / "metadata" / "record"
    other.parent.mkdir()
    other.write_text("kept", encoding="utf-8")
    hold_folder(state).close()
    assert other.read_text(encoding="utf-8") == "kept"


def test_the_locks_of_a_living_run_stay(state, holder):
    held = hold_folder(state)
    assert locked(state)
    if held is not None:
        held.close()


def test_the_locks_of_a_killed_run_go(state, holder):
    os.kill(holder.pid, signal.SIGKILL)
    holder.wait()
    held = hold_folder(state)
    assert held is not None
    assert not locked(state)
    held.close()


def test_a_folder_is_free_again_when_its_run_ends(state):
    hold_folder(state).close()
    lock(state)
    held = hold_folder(state)
    assert held is not None
    assert not locked(state)
    held.close()


def test_a_run_that_began_beside_another_is_alive_after_the_other_ends(state):
    """For example a long run started during the two seconds of a dry run."""
    first = hold_folder(state)
    second = hold_folder(state)  # the handle, if any, is kept for as long as the run lasts
    first.close()
    lock(state)
    third = hold_folder(state)
    assert locked(state), "the locks of the second run are gone"
    for handle in (second, third):
        if handle is not None:
            handle.close()
