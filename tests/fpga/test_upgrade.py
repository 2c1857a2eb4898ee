"""Captures of the first format get what was sent; their bytes stay; another motion is refused."""

import hashlib
import json

import numpy as np
import pytest
from experiment_example import CAPTURES

from repro.cli import main
from repro.fpga.capture import read_capture
from repro.fpga.checksums import verify_folder, write_sums

NAMES = ("bin", "program", "json")


@pytest.fixture
def old(tmp_path):
    """T3 as the first format had it, with the list of its folder."""
    data, sent, said = ((CAPTURES / f"T3.{end}").read_bytes() for end in NAMES)
    content = json.loads(said)
    del content["program"]
    desired = read_capture(CAPTURES / "T3.bin").about.desired
    content["format"] = 1
    content["trajectory"]["sha256"] = hashlib.sha256(desired.T.astype(">f4").tobytes()).hexdigest()
    (tmp_path / "T3.bin").write_bytes(data)
    (tmp_path / "T3.json").write_text(json.dumps(content))
    write_sums(tmp_path)
    return tmp_path / "T3.bin", sent


def test_an_old_capture_is_refused_with_the_command_that_mends_it(old, capsys):
    path, _ = old
    assert main(["decode", str(path)]) == 2
    assert f"`repro upgrade {path}`" in capsys.readouterr().err


def test_an_upgraded_capture_holds_the_same_bytes_and_is_read(old, capsys):
    path, sent = old
    before = path.read_bytes()
    assert main(["upgrade", str(path)]) == 0
    assert "8192 of 8192 torques" in capsys.readouterr().out
    assert path.read_bytes() == before
    capture = read_capture(path)
    given = np.frombuffer(sent, np.uint8)
    np.testing.assert_allclose(capture.about.desired, read_capture(CAPTURES / "T3.bin").about.desired, atol=1e-6)
    assert len(capture.about.program) == given.size
    assert verify_folder(path.parent) == ("T3.bin", "T3.json", "T3.program")
    assert main(["upgrade", str(path)]) == 0
    assert "already" in capsys.readouterr().out


def test_last_bits_of_another_processor_upgrade_by_the_control_law(old, capsys):
    path, _ = old
    content = json.loads(path.with_suffix(".json").read_text())
    content["trajectory"]["sha256"] = "0" * 64  # as if the motion had been computed elsewhere
    path.with_suffix(".json").write_text(json.dumps(content))
    write_sums(path.parent)
    assert main(["upgrade", str(path)]) == 0
    assert "last bits apart" in capsys.readouterr().out
    assert json.loads(path.with_suffix(".json").read_text())["program"]["recomputed"]


@pytest.mark.slow
@pytest.mark.parametrize("motion", ["T1", "ID"])
def test_a_recording_of_another_motion_is_not_upgraded(old, motion, capsys):
    path, _ = old
    sidecar = path.with_suffix(".json")
    sidecar.write_text(sidecar.read_text().replace('"T3"', f'"{motion}"'))
    write_sums(path.parent)
    before = {each.name: each.read_bytes() for each in path.parent.iterdir()}
    assert main(["upgrade", str(path)]) == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert str(path) in told
    assert {each.name: each.read_bytes() for each in path.parent.iterdir()} == before
