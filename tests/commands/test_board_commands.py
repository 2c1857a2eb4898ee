"""`repro simulate`, `record` and `decode`: what a user types, what comes back, and that no recording is lost."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from cli_with_fake_board import DESIRED, FRAMES, load_config, stub
from experiment_example import full_config, refusal_in
from experiment_example import refused as refused_call
from fake_board import PlayedBoard, metadata, served

from repro.board.capture import read_capture, write_capture
from repro.board.link import most_bytes
from repro.board.messages import MessageKind
from repro.board.server import PtyEndpoint
from repro.cli import main
from repro.commands.boards import program_of

SCRIPT = Path(__file__).parents[1] / "examples/cli_with_fake_board.py"


@pytest.fixture(autouse=True)
def experiment(monkeypatch):
    monkeypatch.setitem(sys.modules, "repro.experiments.arm", stub())
    monkeypatch.setattr("repro.config.check.load_config", load_config)


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
    board, port = started("--once", "--as-fast-as-possible", "--faults", "disconnect_after=1000", "--seed", "0")
    out = tmp_path / "ID.bin"
    assert main(["record", "--port", port, "--trajectory", "ID", "--out", str(out)]) == 1
    board.communicate(timeout=10)
    assert board.returncode == 0
    assert read_capture(out).metadata.end_reason == "disconnected"
    assert read_capture(out).data == FRAMES[:1000]
    assert f"{out}: incomplete (disconnected); what arrived is kept" in capsys.readouterr().err


@pytest.mark.slow
def test_a_closed_terminal_ends_a_recording_and_stops_the_arm(tmp_path):
    board, endpoint, out = PlayedBoard(FRAMES[:800]), PtyEndpoint(), tmp_path / "T4.bin"
    record = ["record", "--port", endpoint.port, "--trajectory", "T4", "--out", out, "--timeout", "60"]
    command = ["env", "--default-signal=HUP", sys.executable, SCRIPT, *record]  # under nohup, too
    with served(board, endpoint, real_time=True), subprocess.Popen(command, stderr=-3) as host:
        while not (board.place or host.poll()):
            time.sleep(0.01)
        host.send_signal(signal.SIGHUP)
    assert (host.returncode, board.messages[-1].kind) == (128 + signal.SIGHUP, MessageKind.STOP)


@pytest.mark.parametrize(
    ("text", "place", "found"),
    [
        ("q1_rad,q2\n0,0\n", "header", "no column q2_rad"),
        ("q1_rad,q2_rad\n", "", "no rows"),
        ("q1_rad,q2_rad\n0,0\n0,x\n", "row 2, q2_rad", "'x'"),
        ("q1_rad,q2_rad\n0,\n", "row 1, q2_rad", "an empty cell"),
        ("q1_rad,q2_rad\n0,0,0\n1,0,0\n", "line 2", "3 fields"),
        ("q1_rad,q2_rad\ninf,0\n", "row 1, q1_rad", "'inf'"),
        ("q1_rad,q2_rad\n" + 8193 * "0,0\n", "", "8193 rows"),
        ("time,q1_rad,q2_rad\n0,0,0\n0.0025,0,0\n0.0125,0,0\n", "row 3, time", "a step of 0.01 s"),
        ("T_s,q1_rad,q2_rad\n0,0,0\nnow,0,0\n", "row 2, T_s", "'now'"),
        ("q1_rad,q2_rad\n0,0\n0,24.5101\n", "row 2, q2_rad", "24.5101 rad"),  # 32768 counts
        ("q1_rad,q2_rad\n0,1.0\n0,1.0\n", "row 1, q2_rad", "1 rad"),  # away from rest
    ],
)
def test_a_table_that_is_no_motion_is_refused(tmp_path, text, place, found):
    path = tmp_path / "wave.csv"
    path.write_text(text)
    error = refused_call(program_of, full_config(), str(path))
    assert error.place == f"{path}: {place}".removesuffix(": ") and error.found.startswith(found)


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
    assert capsys.readouterr() == (table.read_text(), summary)
    frame = pd.read_csv(table)
    np.testing.assert_array_equal(frame[["q1_counts", "q2_counts"]].T, read_capture(stored).position)


def test_nothing_is_overwritten(stored, refused):
    table = stored.with_suffix(".csv")
    table.write_text("mine")
    before = stored.read_bytes()
    for out in (table, stored.parent):
        assert refused("decode", stored, "-o", out).place == str(out)
    assert table.read_text() == "mine"
    nowhere = table.with_name("link.csv")
    nowhere.symlink_to("gone.csv")
    assert refused("decode", stored, "-o", nowhere).place == str(nowhere)
    record = ("record", "--port", "/nowhere", "--trajectory", "T4", "--out", stored)
    for command in (record, ("decode", stored, "-o", stored, "--overwrite")):
        assert refused(*command).place == str(stored)
    assert stored.read_bytes() == before
    assert main(["decode", str(stored), "-o", str(table), "--overwrite"]) == 0
    assert table.read_text().startswith("time_s,")


def test_a_file_or_a_port_that_is_wrong_is_refused_and_nothing_is_written(tmp_path, stored, refused):
    new, table = tmp_path / "new.bin", tmp_path / "table.csv"
    record = ("record", "--trajectory", "T4", "--out")
    assert refused(*record, tmp_path / "new.dat").place == str(tmp_path / "new.dat")
    assert refused(*record, new).place == "port /nowhere"
    for port in ("loop://", "spy://loop://", "socket://127.0.0.1", "socket://:80", "socket://h:99999"):
        error = refused(*record, new, "--port", port)
        assert (error.place, error.found) == ("--port", f"'{port}'")
    assert refused("record", "--trajectory", "T5", "--out", new).place == "--trajectory"
    assert refused("record", "--trajectory", "gone.csv", "--out", new).place == "gone.csv"
    assert refused("decode", new).place == str(new)
    stored.chmod(0o644)
    stored.write_bytes(FRAMES[:-3])
    error = refused("decode", stored, "-o", table)
    assert (error.place, error.found) == (f"{stored}: size", "1597 bytes")
    stored.with_suffix(".json").write_text("{}")
    assert refused("decode", stored, "-o", table).place == f"{stored.with_suffix('.json')}: format"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["T4.bin", "T4.json", "T4.program"]


class Endless(PlayedBoard):
    """Sends what it was given, then the same bytes again and again."""

    def __init__(self, frames, forever):
        super().__init__(frames)
        self.forever = forever

    @property
    def running(self):
        return bool(self.messages) and self.messages[-1].kind == MessageKind.START

    def tick(self):
        return super().tick() if self.place < self.end else self.forever


def record(board, out, *options):
    with served(board, PtyEndpoint(), real_time=False) as port:
        return main(["record", "--port", port, "--trajectory", "T4", "--out", str(out), *options])


def refusal_about(path, capsys):
    """The error of the command, in the one line about a path among what it and the board print."""
    (line,) = (line for line in capsys.readouterr().err.splitlines() if str(path) in line)
    return refusal_in(line)


def test_a_board_that_sends_nothing_leaves_nothing(tmp_path, capsys):
    assert record(PlayedBoard(b""), tmp_path / "T4.bin", "--timeout", "0.2") == 2
    assert "0.2 s" in refusal_in(capsys.readouterr().err.splitlines()[-1]).found
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("forever", [b"\xa5" * 512, bytes(512)], ids=["identifiers", "zeros"])
def test_a_device_that_sends_no_frame_for_ever(tmp_path, capsys, forever):
    assert record(Endless(b"", forever), tmp_path / "T4.bin") == 2
    raw = tmp_path / "T4.bin.part"
    assert list(tmp_path.iterdir()) == [raw]
    data = raw.read_bytes()
    assert 1600 < len(data) <= most_bytes(200)
    assert set(data) == set(forever)
    assert f"{len(data)} bytes" in refusal_about(raw, capsys).expected


def test_garbage_after_half_of_the_frames_is_an_incomplete_recording(tmp_path):
    assert record(Endless(FRAMES[:800], bytes(512)), tmp_path / "T4.bin") == 1
    capture = read_capture(tmp_path / "T4.bin")
    assert (capture.metadata.end_reason, capture.counts.good) == ("overrun", 99)  # nothing closes the last one
    assert capture.data[:800] == FRAMES[:800]
    assert not (tmp_path / "T4.bin.part").exists()


def test_a_disk_without_room_is_noticed_before_the_arm_moves(tmp_path, capsys, limit_files):
    board = PlayedBoard(FRAMES)
    limit_files(20_000)
    assert record(board, tmp_path / "T4.bin") == 2
    assert MessageKind.START not in [message.kind for message in board.messages]
    assert refusal_about(tmp_path, capsys).place == str(tmp_path / "T4.bin")
    assert list(tmp_path.iterdir()) == []


def test_a_disk_that_fills_up_loses_no_byte(tmp_path, capsys, limit_files, monkeypatch):
    board = PlayedBoard(FRAMES)
    monkeypatch.setattr(board, "tick", lambda: limit_files(len(FRAMES)) or PlayedBoard.tick(board))
    assert record(board, tmp_path / "T4.bin") == 2  # a sidecar is longer
    raw = tmp_path / "T4.bin.part"
    assert list(tmp_path.iterdir()) == [raw]
    assert raw.read_bytes() == FRAMES
    error = refusal_about(tmp_path, capsys)
    assert error.place == str(tmp_path / "T4.bin")
    assert f"{len(FRAMES)} bytes" in error.expected and str(raw) in error.expected


def test_what_an_earlier_recording_left_is_replaced_only_on_request(tmp_path, capsys):
    out, raw = tmp_path / "T4.bin", tmp_path / "T4.bin.part"
    raw.write_bytes(b"mine")
    assert record(PlayedBoard(FRAMES), out) == 2
    assert raw.read_bytes() == b"mine"
    assert refusal_about(raw, capsys).place == str(raw)
    for frames in (FRAMES, FRAMES[:80] + bytes(8) + FRAMES[88:]):  # the second one replaces a capture
        assert record(PlayedBoard(frames), out, "--overwrite") == 0
        assert not raw.exists()
        assert read_capture(out).data == frames
