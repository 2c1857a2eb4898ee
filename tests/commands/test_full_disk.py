"""Disks that are full and names that no file can have: one line, exit code 2, and nothing left behind."""

import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest

from repro.cli import main

ROOT = Path(__file__).resolve().parents[2]
CAPTURE = ROOT / "data" / "captures" / "T4.bin"


def refused(capsys, *argv):
    assert main([str(each) for each in argv]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    (line,) = captured.err.splitlines()
    assert ": found " in line and ", expected " in line
    return line


@pytest.fixture
def small_disk():
    """No file may be longer than 100 kB."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, resource.RLIM_INFINITY))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))


@pytest.mark.usefixtures("small_disk")
def test_decode_onto_a_full_disk(tmp_path, capsys):
    assert refused(capsys, "decode", CAPTURE, "-o", tmp_path / "T4.csv").startswith(f"{tmp_path / 'T4.csv'}: ")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("small_disk")
def test_identify_onto_a_full_disk_is_refused_before_any_work(tmp_path, capsys):
    line = refused(capsys, "identify", tmp_path / "no-such-log.csv", "-o", tmp_path / "out")
    assert line.startswith(f"{tmp_path / 'out'}: found File too large")
    assert list(tmp_path.iterdir()) == []


def test_standard_output_that_is_full():
    with Path("/dev/full").open("w") as full:
        command = [sys.executable, "-m", "repro", "decode", str(CAPTURE), "-o", "-"]
        run = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert run.returncode == 2
    assert run.stderr.splitlines()[-1].startswith("output: found No space left on device")
    assert "Traceback" not in run.stderr


def test_a_capture_is_not_overwritten_by_its_own_table(tmp_path, capsys):
    for suffix in (".bin", ".program", ".json"):
        (tmp_path / "T4").with_suffix(suffix).write_bytes(CAPTURE.with_suffix(suffix).read_bytes())
    before = (tmp_path / "T4.bin").read_bytes()
    line = refused(capsys, "decode", tmp_path / "T4.bin", "-o", tmp_path / "T4.bin", "--overwrite")
    assert line.startswith(f"{tmp_path / 'T4.bin'}: found a file of the capture")
    assert (tmp_path / "T4.bin").read_bytes() == before


@pytest.mark.parametrize("name", ["x" * 5000, "\udcff", "a\nb", "\x1b[31m"], ids=["long", "byte", "n", "esc"])
def test_names_that_no_file_can_have(tmp_path, capsys, name):
    for argv in (
        ["identify", f"{name}.csv", "-o", tmp_path / "out"],
        ["identify", CAPTURE, "--validate", f"{name}.csv", "-o", tmp_path / "out"],
        ["decode", CAPTURE, "-o", tmp_path / f"{name}.csv"],
        ["excite", "--arm", f"{name}.yaml", "-o", tmp_path / "out"],
    ):
        assert len(refused(capsys, *argv)) < 11_000
    assert list(tmp_path.iterdir()) == []


def test_what_is_no_file_is_refused_by_every_command(tmp_path, capsys):
    pipe = tmp_path / "pipe.csv"
    os.mkfifo(pipe)
    out = tmp_path / "out"
    for argv in (
        ["identify", pipe, "-o", out],
        ["identify", CAPTURE, "--arm", pipe, "-o", out],
        ["identify", CAPTURE, "--validate", pipe, "-o", out],
        ["excite", "--arm", pipe, "-o", out],
        ["excite", "--arm", ROOT / "none.yaml", "--guess", pipe, "-o", out],
        ["check", pipe, "--config", ROOT / "config" / "config.yaml"],
        ["record", "--trajectory", pipe, "--out", tmp_path / "x.bin", "--config", ROOT / "config" / "config.yaml"],
    ):
        refused(capsys, *argv)
    assert [path.name for path in tmp_path.iterdir()] == ["pipe.csv"]
