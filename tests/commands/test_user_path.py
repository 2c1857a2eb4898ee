"""The path a user takes: a board in one shell, a recording in another, the bytes of a simulation in process."""

import subprocess
import sys
from pathlib import Path

import pytest

from repro.config import load_config
from repro.fpga.capture import read_capture
from repro.fpga.recording import recording_of, verify_control
from repro.pipeline.experiment import program_from_config, simulate_capture

pytestmark = pytest.mark.slow

CONFIG = Path(__file__).resolve().parents[2] / "config" / "config.yaml"


def test_the_identification_run_over_a_pseudo_terminal(tmp_path):
    repro, chosen = [sys.executable, "-m", "repro"], ["--config", str(CONFIG)]
    options = ["--link", str(tmp_path / "board"), "--as-fast-as-possible", "--once"]
    board = subprocess.Popen([*repro, "simulate", *options, *chosen], stdout=subprocess.PIPE, text=True)
    port = board.stdout.readline().strip()
    out = tmp_path / "ID.bin"
    command = [*repro, "record", "--port", port, "--trajectory", "ID", "--out", str(out), *chosen]
    recorded = subprocess.run(command, capture_output=True, text=True, check=False)
    assert recorded.returncode == 0, recorded.stderr
    board.communicate(timeout=10)
    assert board.returncode == 0
    capture = read_capture(out)
    config = load_config(CONFIG)
    program = program_from_config(config, "ID")
    simulated = simulate_capture(tmp_path / "simulated" / "ID.bin", program, config)
    assert capture.data == simulated.data
    assert capture.metadata.board == simulated.metadata.board
    assert recording_of(capture).n_interpolated == 0
    check = verify_control(capture)
    assert check.agree == check.checked == program.q.shape[1]
