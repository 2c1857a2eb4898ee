"""`repro record` ends and loses nothing: with a device that sends no frames, and with a disk that is full."""

import resource
import sys

import pytest
from cli_with_fake_board import FRAMES, stub
from fake_board import PlayedBoard, served

from repro.cli import main
from repro.fpga.capture import read_capture
from repro.fpga.link import most_bytes
from repro.fpga.messages import MessageKind
from repro.fpga.server import PtyEndpoint


@pytest.fixture(autouse=True)
def experiment(monkeypatch):
    monkeypatch.setitem(sys.modules, "repro.pipeline.experiment", stub())


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


class LimitedDisk(PlayedBoard):
    """From the start on no file may be longer than this."""

    def __init__(self, frames, largest):
        super().__init__(frames)
        self.largest = largest

    def tick(self):
        if self.running and not self.place:
            resource.setrlimit(resource.RLIMIT_FSIZE, (self.largest, resource.RLIM_INFINITY))
        return super().tick()


@pytest.fixture
def any_length():
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))


def record(board, out, *options):
    with served(board, PtyEndpoint(), real_time=False) as port:
        return main(["record", "--port", port, "--trajectory", "T4", "--out", str(out), *options])


def line_about(path, capsys):
    """The one line of the command among what it and the board print."""
    (line,) = (line for line in capsys.readouterr().err.splitlines() if str(path) in line)
    return line


@pytest.mark.parametrize("forever", [b"\xa5" * 512, bytes(512)], ids=["identifiers", "zeros"])
def test_a_device_that_sends_no_frame_for_ever(tmp_path, capsys, forever):
    assert record(Endless(b"", forever), tmp_path / "T4.bin") == 2
    raw = tmp_path / "T4.bin.part"
    assert list(tmp_path.iterdir()) == [raw]
    data = raw.read_bytes()
    assert 1600 < len(data) <= most_bytes(200)
    assert set(data) == set(forever)
    line = line_about(raw, capsys)
    assert f"{len(data)} bytes" in line


def test_garbage_after_half_of_the_frames_is_an_incomplete_recording(tmp_path, capsys):
    assert record(Endless(FRAMES[:800], bytes(512)), tmp_path / "T4.bin") == 1
    capture = read_capture(tmp_path / "T4.bin")
    assert (capture.metadata.end_reason, capture.counts.good) == ("overrun", 99)  # nothing closes the last one
    assert capture.data[:800] == FRAMES[:800]
    assert not (tmp_path / "T4.bin.part").exists()


@pytest.mark.usefixtures("any_length")
def test_a_disk_without_room_is_noticed_before_the_arm_moves(tmp_path, capsys):
    board = PlayedBoard(FRAMES)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, resource.RLIM_INFINITY))
    assert record(board, tmp_path / "T4.bin") == 2
    assert MessageKind.START not in [message.kind for message in board.messages]
    assert line_about(tmp_path, capsys).startswith(f"{tmp_path / 'T4.bin'}: found ")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("any_length")
def test_a_disk_that_fills_up_loses_no_byte(tmp_path, capsys):
    assert record(LimitedDisk(FRAMES, len(FRAMES)), tmp_path / "T4.bin") == 2  # what was sent is longer
    raw = tmp_path / "T4.bin.part"
    assert list(tmp_path.iterdir()) == [raw]
    assert raw.read_bytes() == FRAMES
    line = line_about(tmp_path, capsys)
    assert line.startswith(f"{tmp_path / 'T4.bin'}: found File too large")
    assert line.endswith(f"the {len(FRAMES)} bytes received are in {raw}")


def test_bytes_that_an_earlier_recording_left_are_kept(tmp_path, capsys):
    raw = tmp_path / "T4.bin.part"
    raw.write_bytes(b"mine")
    assert record(PlayedBoard(FRAMES), tmp_path / "T4.bin") == 2
    assert raw.read_bytes() == b"mine"
    assert line_about(raw, capsys).startswith(f"{raw}: found ")
    assert record(PlayedBoard(FRAMES), tmp_path / "T4.bin", "--overwrite") == 0
    assert not raw.exists()
    assert read_capture(tmp_path / "T4.bin").data == FRAMES


@pytest.mark.parametrize("port", ["loop://", "spy://loop://", "socket://127.0.0.1", "socket://:80", "socket://h:99999"])
def test_a_url_behind_which_no_board_is_is_refused(tmp_path, capsys, port):
    assert main(["record", "--port", port, "--trajectory", "T4", "--out", str(tmp_path / "T4.bin")]) == 2
    assert line_about(port, capsys).startswith(f"--port: found '{port}', expected a device")
    assert list(tmp_path.iterdir()) == []
