"""Who works in a folder: locks of runs that are proven dead are cleared, those of all others are not."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from repro.pipeline import alive
from repro.pipeline.alive import RUN, begin_run, join_run

SRC = Path(__file__).resolve().parents[2] / "src"
INTERRUPTED = """
import os, signal, subprocess, sys, time
from pathlib import Path
from repro.pipeline.alive import begin_run
signal.signal(signal.SIGINT, signal.default_int_handler)  # a process in the background ignores it
begin_run(Path(sys.argv[1]), os.environ)
job = subprocess.Popen([sys.executable, "-c", sys.argv[2]], stdout=subprocess.PIPE, start_new_session=True)
job.stdout.readline()  # it has signed in
try:
    print("ready", flush=True)
    time.sleep(60)
except KeyboardInterrupt:
    pass
began = time.monotonic()
print(job.wait(), time.monotonic() - began)
"""
LONG_JOB = """
import os, sys, time
from repro.pipeline.alive import join_run
join_run(os.environ)
try:
    print("in", flush=True)
    time.sleep(60)
except KeyboardInterrupt:
    sys.exit(7)
"""
RUNNING = """
import os, sys
from pathlib import Path
from repro.pipeline.alive import begin_run, join_run
begin_run(Path(sys.argv[1]), os.environ) if len(sys.argv) > 1 else join_run(os.environ)
print(os.environ["REPRO_RUN"], flush=True)
sys.stdin.read()
"""


@pytest.fixture(autouse=True)
def at_exit(monkeypatch):
    """What was to be done at the end of this process: done at the end of the test instead."""
    later = []
    monkeypatch.setattr(alive.atexit, "register", lambda call, *a, **k: later.append(lambda: call(*a, **k)))
    yield later
    for call in later:
        call()


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


def locked(folder):
    return (folder / "locks").exists() and any((folder / "locks").iterdir())


@pytest.fixture
def start():
    """Start a run in a folder, or a job of a run, as a process of its own; all are killed in the end."""
    started = []

    def start_one(*arguments, run=None):
        environment = {**os.environ, "PYTHONPATH": str(SRC)} | ({} if run is None else {RUN: run})
        command = [sys.executable, "-c", RUNNING, *map(str, arguments)]
        process = subprocess.Popen(command, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        started.append(process)
        return process, process.stdout.readline().strip()

    yield start_one
    for process in started:
        process.kill()
        process.communicate()


def kill(process):
    os.kill(process.pid, signal.SIGKILL)
    process.wait()


def begin(state):
    """Begin a run in this process; its folder."""
    environment = {}
    begin_run(state, environment)
    return Path(environment[RUN])


def test_a_new_folder_is_made_and_removed_in_the_end(tmp_path, at_exit):
    run = begin(tmp_path / ".snakemake")
    assert run.is_dir()
    at_exit.pop()()
    assert not run.exists()


def test_a_run_that_ends_leaves_nothing(state, start):
    process, run = start(state)
    assert Path(run).is_dir()
    process.communicate()
    assert list((state / "runs").iterdir()) == []


def test_nothing_else_in_the_folder_is_touched(state):
    other = state / "metadata" / "record"
    other.parent.mkdir()
    other.write_text("kept", encoding="utf-8")
    begin(state)
    assert not locked(state)
    assert other.read_text(encoding="utf-8") == "kept"


def test_the_locks_of_a_living_run_stay(state, start):
    start(state)
    lock(state)
    begin(state)
    assert locked(state)


def test_the_locks_of_a_killed_run_go_with_all_that_it_left(state, start):
    process, run = start(state)
    lock(state)
    kill(process)
    own = begin(state)
    assert not locked(state)
    assert list((state / "runs").iterdir()) == [own]
    assert Path(run) != own


def test_a_killed_run_is_dead_even_if_its_parent_has_not_looked(state, start):
    process, _ = start(state)
    lock(state)
    os.kill(process.pid, signal.SIGKILL)
    os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)  # ended, but still in the table of processes
    begin(state)
    assert not locked(state)


def test_a_run_that_began_beside_another_is_alive_after_the_other_ends(state, start, at_exit):
    """For example a long run started during the two seconds of a dry run."""
    begin(state)
    start(state)
    at_exit.pop()()
    lock(state)
    begin(state)
    assert locked(state), "the locks of the second run are gone"


def test_a_job_that_outlives_its_run_keeps_the_locks(state, start):
    process, run = start(state)
    job, _ = start(run=run)
    lock(state)
    kill(process)
    begin(state)
    assert locked(state)
    job.communicate()
    begin(state)
    assert not locked(state)


def test_a_killed_job_of_a_killed_run_keeps_nothing(state, start):
    process, run = start(state)
    job, _ = start(run=run)
    lock(state)
    kill(process)
    kill(job)
    begin(state)
    assert not locked(state)


@pytest.mark.parametrize("follower", ["a later run", "nobody"])
def test_a_job_whose_run_is_over_does_not_begin(state, start, capsys, follower):
    process, run = start(state)
    if follower == "nobody":
        process.communicate()
    else:
        kill(process)
        begin(state)
    with pytest.raises(SystemExit) as stop:
        join_run({RUN: run})
    assert stop.value.code == 1
    assert len(capsys.readouterr().err.splitlines()) == 1
    assert not Path(run).exists()


def test_a_job_of_no_run_begins(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    join_run({})
    assert list(tmp_path.iterdir()) == []


COMPUTER, BOOT, SPACE, PID, STARTED = range(5)


def renamed(run, part, text):
    """The folder of a run as if one part of its name were another."""
    parts = run.name.rsplit("_", 4)
    parts[part] = text
    return run.rename(run.with_name("_".join(parts)))


@pytest.mark.parametrize(
    ("part", "text", "proven"),
    [
        (COMPUTER, "other_node-0123", False),
        (BOOT, "01234567-89ab-cdef-0123-456789abcdef", True),
        (SPACE, "1", False),
        (STARTED, "1", True),
    ],
    ids=["another computer", "before a restart", "another container", "its number taken by another process"],
)
def test_a_run_is_dead_only_if_this_computer_can_tell(state, start, part, text, proven):
    process, run = start(state)
    lock(state)
    if part in (COMPUTER, SPACE):  # not even if it has ended
        kill(process)
    left = renamed(Path(run), part, text)
    begin(state)
    assert locked(state) is not proven
    assert left.exists() is not proven


def test_a_job_on_another_computer_keeps_the_locks(state, start):
    process, run = start(state)
    Path(run, "node07-0123_01234567-89ab-cdef-0123-456789abcdef_1_2_3").touch()
    lock(state)
    kill(process)
    begin(state)
    assert locked(state)


def test_what_cannot_be_proven_goes_with_the_locks_if_the_user_says_so(state, start):
    process, run = start(state)
    kill(process)
    left = renamed(Path(run), COMPUTER, "other")
    lock(state)
    begin_run(state, {}, unlock=True)
    assert not left.exists()
    assert locked(state)  # these are Snakemake's to remove


def test_what_another_program_left_is_no_run(state):
    (state / "runs").mkdir()
    (state / "runs" / "notes").touch()
    begin(state)
    assert locked(state)


def test_one_interrupt_of_the_run_alone_ends_its_jobs(tmp_path):
    """Snakemake waits for its jobs, and a signal to one process does not reach them."""
    command = [sys.executable, "-c", INTERRUPTED, str(tmp_path), LONG_JOB]
    environment = {**os.environ, "PYTHONPATH": str(SRC)}
    run = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment)
    assert run.stdout.readline() == "ready\n"
    run.send_signal(signal.SIGINT)
    output, _ = run.communicate(timeout=30)
    code, seconds = output.split()
    assert code == "7"
    assert float(seconds) < 15.0
    assert not list((tmp_path / "runs").iterdir())
