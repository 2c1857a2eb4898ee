"""The captures in the repository: whole, and marked as simulated."""

import hashlib
import json

import pytest
from experiment_example import CAPTURES, MOTIONS

from repro.board.capture import read_capture, verify_control

pytestmark = pytest.mark.slow


def test_the_list_of_check_sums_for_other_programs_is_that_of_the_files():
    listed = dict(line.split("  ")[::-1] for line in (CAPTURES / "SHA256SUMS").read_text().splitlines())
    assert sorted(listed) == sorted(f"{m}.{end}" for m in MOTIONS for end in ("bin", "program", "json"))
    assert listed == {name: hashlib.sha256((CAPTURES / name).read_bytes()).hexdigest() for name in listed}


@pytest.mark.parametrize("motion", MOTIONS)
def test_a_capture_is_marked_as_simulated_and_came_over_a_port(motion):
    sidecar = json.loads((CAPTURES / f"{motion}.json").read_text(encoding="utf-8"))
    assert sidecar["source"] == sidecar["board"]["board"] == "simulated"
    assert (sidecar["motion"], sidecar["host"]["baud"]) == (motion, 115200)
    # In real time: all samples took as long as 2.5 ms each, the last chunk holding the last frame.
    received, seconds = sidecar["host"]["chunks"][-1]
    assert received == sidecar["bytes"]
    assert seconds == pytest.approx(0.0025 * sidecar["samples_expected"], abs=0.2)


@pytest.mark.parametrize("motion", MOTIONS)
def test_a_capture_is_without_gaps_and_its_every_torque_follows_from_its_positions(motion):
    capture = read_capture(CAPTURES / f"{motion}.bin")
    assert (capture.complete, capture.gaps, capture.counts.skipped) == (True, (), 0)
    checked, differing = verify_control(capture)
    assert differing.size == 0 and checked == capture.metadata.samples
