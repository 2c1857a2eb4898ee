"""A rule's work: bad input is one line and exit code 2, any other failure keeps its traceback to the log."""

import errno
import logging
import signal
import subprocess
import sys
from types import SimpleNamespace

import pytest
import torch

from repro.errors import InputError
from repro.experiments.job import ALLOCATOR, job, set_allocator, share_lock


@pytest.fixture(autouse=True)
def as_before():
    """Leave torch and the root logger as they were."""
    threads, deterministic = torch.get_num_threads(), torch.are_deterministic_algorithms_enabled()
    level = logging.getLogger("repro").level
    yield
    torch.set_num_threads(threads)
    torch.use_deterministic_algorithms(deterministic)
    logging.getLogger("repro").setLevel(level)


@pytest.fixture
def log(tmp_path):
    return tmp_path / "logs" / "rule.log"


def test_bad_input_is_one_line_and_exit_code_2(log, capsys):
    message = "mean_torque.csv: line 3: joint1: found no finite number, expected a torque in N m"
    with pytest.raises(SystemExit) as stop, job(str(log)):
        raise InputError(message)
    assert stop.value.code == 2
    assert capsys.readouterr() == ("", message + "\n")
    text = log.read_text(encoding="utf-8")
    assert message in text and "Traceback" not in text


@pytest.mark.parametrize("error", [ValueError("shapes"), MemoryError(), KeyboardInterrupt(), SystemExit(143)])
def test_any_other_failure_has_its_traceback_in_the_log_alone(log, capsys, error):
    def fail():
        if isinstance(error, SystemExit):
            signal.raise_signal(signal.SIGTERM)
        raise error

    with pytest.raises(SystemExit) as stop, job(str(log)):
        fail()
    assert stop.value.code == 1
    printed, errors = capsys.readouterr()
    (line,) = errors.splitlines()
    assert printed == "" and str(log) in line
    text = log.read_text(encoding="utf-8")
    for part in ("Traceback (most recent call last)", "in fail", type(error).__name__):
        assert part in text


def test_progress_goes_to_the_log_and_the_terminal(log, capsys):
    for line in ("of an earlier run", "half done"):
        with job(str(log)):
            logging.getLogger("repro.anything").info(line)
    assert capsys.readouterr().err == "of an earlier run\nhalf done\n"
    assert [line.endswith("half done") for line in log.read_text(encoding="utf-8").splitlines()] == [True]


@pytest.mark.parametrize("threads", [1, 2])
def test_threads_are_those_of_the_rule(log, threads):
    with job(str(log), threads):
        assert torch.get_num_threads() == threads
        assert torch.are_deterministic_algorithms_enabled()


HOLDER = """
import sys
from pathlib import Path
from types import SimpleNamespace
from repro.experiments.job import share_lock
lock = share_lock(Path(sys.argv[1]))
print("held", flush=True)
sys.stdin.read()
"""


def test_locks_of_a_run_are_removed_once_it_and_its_jobs_are_dead(tmp_path):
    locks, half, checkpoint = tmp_path / "locks", tmp_path / "a/.fig-x1.partial.png", tmp_path / "a/.checkpoint.png"
    half.parent.mkdir()
    half.touch()
    checkpoint.touch()
    share_lock(tmp_path).close()
    with subprocess.Popen([sys.executable, "-c", HOLDER, tmp_path], stdin=-1, stdout=-1) as holder:
        assert holder.stdout.readline() == b"held\n"
        locks.mkdir()
        share_lock(tmp_path, clear=[tmp_path]).close()
        assert locks.exists() and half.exists()
        holder.kill()
    share_lock(tmp_path).close()
    assert locks.exists() and half.exists()  # a job removes nothing
    share_lock(tmp_path, clear=[tmp_path]).close()
    assert not locks.exists() and not half.exists()
    assert checkpoint.exists()


def test_locks_of_a_run_on_another_host_stay(tmp_path, monkeypatch):
    half = tmp_path / ".fig-x1.partial.png"
    share_lock(tmp_path, clear=[tmp_path]).close()
    half.touch()
    for host, left in (("other", True), ("other", False)):
        with monkeypatch.context() as context:
            context.setattr("socket.gethostname", lambda host=host: host)
            share_lock(tmp_path, clear=[tmp_path]).close()
        assert half.exists() == left


def test_what_the_user_has_set_of_the_allocator_stays():
    environment = {"MALLOC_TOP_PAD_": "5"}
    set_allocator(environment)
    assert environment == {**ALLOCATOR, "MALLOC_TOP_PAD_": "5"}


def test_a_folder_that_cannot_be_written_ends_the_run_with_one_line(tmp_path, capsys):
    (tmp_path / "file").touch()
    with pytest.raises(SystemExit) as ended:
        share_lock(tmp_path / "file" / ".snakemake", clear=[tmp_path])
    assert ended.value.code == 2
    assert capsys.readouterr().err.startswith(f"{tmp_path}/file/.snakemake: found Not a directory, expected a folder ")


def test_a_full_disk_ends_a_run_and_a_job_with_one_line(tmp_path, log, capsys, monkeypatch):
    with pytest.raises(SystemExit) as ended, job(str(log)):
        raise OSError(errno.ENOSPC, "No space left on device", "results/model/cnn.safetensors")
    assert ended.value.code == 2
    expected = "results/model/cnn.safetensors: found No space left on device, expected room on the disk\n"
    assert capsys.readouterr().err == expected
    monkeypatch.setattr("shutil.disk_usage", lambda path: SimpleNamespace(free=(16 << 20) - 1))
    share_lock(tmp_path).close()  # a job goes on
    with pytest.raises(SystemExit) as ended:
        share_lock(tmp_path, clear=[tmp_path])
    assert ended.value.code == 2
    assert capsys.readouterr().err.startswith(f"{tmp_path}: found No space left on device, expected ")
