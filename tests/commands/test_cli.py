"""The ``repro`` command: what a user types, what comes back, and one line with exit code 2 for what is wrong."""

import io
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from cli_with_fake_board import DESIRED, FRAMES, load_config, stub
from fake_board import PlayedBoard, metadata, served

from repro.cli import COMMANDS, main
from repro.commands.boards import parse_faults, program_of, read_program
from repro.errors import InputError
from repro.fpga.capture import read_capture, write_capture
from repro.fpga.server import PtyEndpoint

SCRIPT = Path(__file__).parents[1] / "cli_with_fake_board.py"


@pytest.fixture(autouse=True)
def experiment(monkeypatch):
    monkeypatch.setitem(sys.modules, "repro.pipeline.experiment", stub())
    monkeypatch.setattr("repro.config.load_config", load_config)


@pytest.fixture
def stored(tmp_path):
    write_capture(tmp_path / "T4.bin", FRAMES, metadata(DESIRED))
    return tmp_path / "T4.bin"


def started(*options):
    """`repro simulate` as a process, and what pyserial opens."""
    command = [sys.executable, str(SCRIPT), "simulate", *options]
    board = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    return board, board.stdout.readline().strip()


@pytest.mark.slow
@pytest.mark.parametrize(("listen", "sent"), [("pty", signal.SIGTERM), ("socket", signal.SIGINT)])
def test_simulate_in_one_shell_and_record_in_another(tmp_path, capsys, listen, sent):
    link = tmp_path / "board"
    options = ["--link", str(link)] if listen == "pty" else ["--listen", "socket"]
    board, port = started("--as-fast-as-possible", *options)
    out = tmp_path / "T1.bin"
    try:
        assert port == str(link) or port.startswith("socket://127.0.0.1:")
        assert main(["record", "--port", port, "--trajectory", "T1", "--out", str(out)]) == 0
    finally:
        board.send_signal(sent)
        _, log = board.communicate(timeout=10)
    assert board.returncode == 0
    assert not link.is_symlink()
    assert f"listening on {port}" in log
    assert "motion finished: 200 samples" in log
    capture = read_capture(out)
    assert (capture.data, capture.metadata.end_reason, capture.metadata.source) == (FRAMES, "", "simulated")
    assert (capture.metadata.motion, capture.metadata.n1, capture.metadata.n2) == ("T1", 10, 190)
    assert (capture.metadata.host.port, capture.metadata.host.baud) == (port, 115200)
    assert f"{out}: T1, source simulated, complete" in capsys.readouterr().out


@pytest.mark.slow
def test_a_board_that_serves_once_with_faults(tmp_path, capsys):
    board, port = started("--once", "--as-fast-as-possible", "--faults", "disconnect_after=1000", "--seed", "3")
    out = tmp_path / "ID.bin"
    assert main(["record", "--port", port, "--trajectory", "ID", "--out", str(out)]) == 1
    board.communicate(timeout=10)
    assert board.returncode == 0
    assert read_capture(out).metadata.end_reason == "disconnected"
    assert read_capture(out).data == FRAMES[:1000]
    assert f"{out}: incomplete (disconnected); what arrived is kept" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("q1_rad,q2\n0,0\n", "header: found no column q2_rad"),
        ("q1_rad,q2_rad\n", "found no rows"),
        ("q1_rad,q2_rad\n0,0\n0,x\n", "row 2, q2_rad: found 'x', expected a finite number"),
        ("q1_rad,q2_rad\n0,\n", "row 1, q2_rad: found an empty cell, expected a finite number"),
        ("q1_rad,q2_rad\n0,0,0\n1,0,0\n", "line 2: found 3 fields, expected 2"),
        ("q1_rad,q2_rad\ninf,0\n", "row 1, q1_rad: found .*inf.*, expected a finite number"),
        ("q1_rad,q2_rad\n" + 8193 * "0,0\n", "wave.csv: found 8193 rows, expected a motion of 2 to 8192"),
        ("time,q1_rad,q2_rad\n0,0,0\n0.0025,0,0\n0.0125,0,0\n", "row 3, time: found a step of 0.01 s"),
        ("T_s,q1_rad,q2_rad\n0,0,0\nnow,0,0\n", "row 2, T_s: found 'now'"),
        ("q1_rad,q2_rad\n0,0\n0,-30\n", "row 2, q2_rad"),
    ],
)
def test_a_table_that_is_no_motion_is_refused(tmp_path, text, expected):
    path = tmp_path / "wave.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=expected) as caught:
        read_program(path)
    assert "\n" not in str(caught.value)


def test_a_motion_that_begins_away_from_rest_is_refused(tmp_path):
    path = tmp_path / "wave.csv"
    path.write_text("q1_rad,q2_rad\n0,1.0\n0,1.0\n")
    with pytest.raises(InputError, match=r"wave\.csv: row 1, q2_rad: found 1 rad"):
        program_of({"board": {"speed_limit_rad_s": 8.0}}, str(path))


@pytest.mark.parametrize(
    "text",
    [
        b"time,q1_rad,q2_rad\n1.0,0.1,0.2\n1.0025,0.3,0.4\n",
        b"\xef\xbb\xbfq1_rad,q2_rad\r\n0.1,0.2\r\n0.3,0.4\r\n",
    ],
    ids=["with the board's time", "of a spreadsheet"],
)
def test_a_table_of_a_motion_is_read(tmp_path, text):
    (tmp_path / "wave.csv").write_bytes(text)
    assert read_program(tmp_path / "wave.csv").q.tolist() == [[0.1, 0.3], [0.2, 0.4]]


def test_an_output_behind_a_link_that_leads_nowhere_is_refused_before_any_work(tmp_path, capsys):
    (tmp_path / "loop").symlink_to("loop")
    out = tmp_path / "loop/new"
    for argv in (
        ("record", "--port", "none", "--trajectory", "ID", "--out", f"{out}.bin"),
        ("identify", "gone.csv", "-o", str(out)),
        ("excite", "--arm", "gone.yaml", "-o", str(out)),
    ):
        assert main(argv) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert line.startswith(str(out)) and "gone" not in line


def test_decode_summarises_and_writes_a_table(stored, capsys):
    table = stored.with_suffix(".csv")
    assert main(["decode", str(stored)]) == 0
    summary = capsys.readouterr().out
    assert summary.splitlines() == [
        f"{stored}: T4, source simulated, complete",
        "frames: 200 good of 200 expected (0.5 s)",
        "gaps: 0, about 0 frames lost, 0 bytes skipped",
    ]
    assert not table.exists()
    assert main(["decode", str(stored), "-o", str(table)]) == 0
    assert capsys.readouterr().out == summary
    assert main(["decode", str(stored), "-o", "-"]) == 0
    printed, repeated = capsys.readouterr()
    assert printed == table.read_text()
    assert repeated == summary
    frame = pd.read_csv(io.StringIO(printed))
    np.testing.assert_array_equal(frame[["q1_counts", "q2_counts"]].T, read_capture(stored).position)


def refused(capsys, *argv):
    """The one line of a refusal."""
    assert main([str(each) for each in argv]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    (line,) = captured.err.splitlines()
    assert "found" in line and "expected" in line
    return line


def test_nothing_is_overwritten(stored, capsys):
    table = stored.with_suffix(".csv")
    table.write_text("mine")
    before = stored.read_bytes()
    assert "T4.csv: found a file" in refused(capsys, "decode", stored, "-o", table)
    assert table.read_text() == "mine"
    nowhere = table.with_name("link.csv")
    nowhere.symlink_to("gone.csv")
    assert "link.csv: found a file" in refused(capsys, "decode", stored, "-o", nowhere)
    record = ["record", "--port", "/nowhere", "--trajectory", "T4", "--out", stored]
    assert "T4.bin: found a file" in refused(capsys, *record)
    assert stored.read_bytes() == before
    assert main(["decode", str(stored), "-o", str(table), "--overwrite"]) == 0
    assert table.read_text().startswith("time_s,")
    with served(PlayedBoard(FRAMES), PtyEndpoint(), real_time=False) as port:
        options = ["--port", port, "--trajectory", "ID", "--out", str(stored), "--overwrite"]
        assert main(["record", *options]) == 0
    assert read_capture(stored).metadata.motion == "ID"


def test_what_is_wrong_is_reported_and_writes_nothing(tmp_path, stored, capsys):
    new = tmp_path / "new.bin"
    record = ("record", "--trajectory", "T4", "--out")
    assert "new.dat: found the suffix '.dat'" in refused(capsys, *record, tmp_path / "new.dat")
    assert "port /nowhere: found one that cannot be opened" in refused(capsys, *record, new)
    assert "--trajectory: found 'T5'" in refused(capsys, "record", "--trajectory", "T5", "--out", new)
    assert "gone.csv: found No such file" in refused(capsys, "record", "--trajectory", "gone.csv", "--out", new)
    assert "--link: found --listen socket" in refused(capsys, "simulate", "--listen", "socket", "--link", new)
    assert "new.bin: found No such file" in refused(capsys, "decode", new)
    table = tmp_path / "table.csv"
    stored.chmod(0o644)
    stored.write_bytes(FRAMES[:-3])
    assert "T4.bin: size: found 1597 bytes" in refused(capsys, "decode", stored, "-o", table)
    stored.with_suffix(".json").write_text("{}")
    assert "T4.json: format: found nothing" in refused(capsys, "decode", stored, "-o", table)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["T4.bin", "T4.json", "T4.program"]


def test_no_board_writes_nothing(tmp_path, capsys):
    with served(PlayedBoard(b""), PtyEndpoint(), real_time=False) as port:
        options = ["--port", port, "--trajectory", "T4", "--out", str(tmp_path / "T4.bin"), "--timeout", "0.2"]
        assert main(["record", *options]) == 2
    assert "found nothing in the 0.2 s after the start" in capsys.readouterr().err.splitlines()[-1]
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("drop", "--faults: drop: found '', expected a number of 0 to 1"),
        ("drop=1e-4,drop=1e-4", "--faults: found 'drop=1e-4', expected each once"),
        ("flip=-0.1", "--faults: flip: found '-0.1', expected a number of 0 to 1"),
        ("drop=0.4,flip=0.4,insert=0.4", "--faults: found drop=0.4,flip=0.4,insert=0.4, expected drop"),
        ("disconnect_after=1.5", "--faults: disconnect_after: found '1.5'"),
    ],
)
def test_faults_that_make_no_sense_are_refused(text, expected):
    with pytest.raises(InputError, match=expected) as caught:
        parse_faults(text)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "argv",
    [
        [],
        ["record", "--out", "x.bin"],
        ["record", "--trajectory", "ID", "--out", "x.bin", "--timeout", "0"],
        ["record", "--trajectory", "ID", "--out", "x.bin", "--timeout", "soon"],
        ["simulate", "--seed", "-1"],
    ],
)
def test_options_that_make_no_sense_are_refused(argv, capsys):
    with pytest.raises(SystemExit) as caught:
        main(argv)
    assert caught.value.code == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "repro" in line


@pytest.mark.parametrize("error", [InputError("a: found b, expected c"), KeyboardInterrupt(), RuntimeError("ours")])
def test_exit_codes(monkeypatch, stored, error):
    def fail(arguments):
        raise error

    monkeypatch.setitem(COMMANDS, "decode", (COMMANDS["decode"][0], fail))
    if isinstance(error, RuntimeError):  # a fault of ours keeps its traceback
        with pytest.raises(RuntimeError):
            main(["decode", str(stored)])
    else:
        assert main(["decode", str(stored)]) == (2 if isinstance(error, InputError) else 130)


@pytest.mark.slow
def test_python_m_repro_and_a_reader_that_has_seen_enough(stored):
    module = [sys.executable, "-m", "repro"]
    run = subprocess.run([*module, "--help"], capture_output=True, text=True, check=True)
    assert all(name in run.stdout for name in COMMANDS)
    pipe = f"{sys.executable} -m repro decode {stored} -o - | head -n 1"
    run = subprocess.run(pipe, shell=True, capture_output=True, text=True, check=True)
    assert run.stdout.startswith("time_s,")
    assert "Traceback" not in run.stderr


def test_help_needs_nothing_heavy():
    code = "import sys, repro.cli; repro.cli.parser(); print({'torch', 'pandas', 'scipy', 'serial'} & {*sys.modules})"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "set()"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["identify", "data/captures/ID.bin", "-o", ""], "found '', expected a folder"),
        (["decode", "ID.bin", "-o", "table.xlsx"], "--out: found 'table.xlsx', expected FILE.csv, or -"),
        (["simulate", "--host", "127.0.0.1"], "--host: found --listen pty, expected --listen socket"),
        (["identify", "LOG.csv", "-o", "new", "--trajectory", "T1"], "--trajectory: found 'T1', expected none, or"),
    ],
)
def test_an_output_without_a_name_or_of_another_kind_is_refused(capsys, arguments, words):
    try:
        code = main(arguments)
    except SystemExit as stop:
        code = stop.code
    assert code == 2
    assert words in capsys.readouterr().err
