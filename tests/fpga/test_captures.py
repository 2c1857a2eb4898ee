"""The captures in the repository: whole, marked as simulated, and followed closely."""

import hashlib
import json

import numpy as np
import pytest
from experiment_example import CAPTURES, MOTIONS, full_config

from repro.fpga.capture import read_capture, verify_control
from repro.identification.least_squares import METHODS
from repro.model.dynamics import rebuild_torque
from repro.model.stability import stability_constants
from repro.paper.appendix import reproduced
from repro.paper.metric_search import least_squares_torque
from repro.paper.published import load_published
from repro.pipeline.experiment import read_recording, true_parameters
from repro.pipeline.identifications import tracking
from repro.settings import metric_settings, signal_settings
from repro.signals.metric import metr2ev

pytestmark = pytest.mark.slow

CONFIG = full_config()


def test_every_file_has_its_listed_checksum():
    listed = dict(line.split("  ")[::-1] for line in (CAPTURES / "SHA256SUMS").read_text().splitlines())
    assert sorted(listed) == sorted(f"{m}.{end}" for m in MOTIONS for end in ("bin", "program", "json"))
    assert listed == {name: hashlib.sha256((CAPTURES / name).read_bytes()).hexdigest() for name in listed}


@pytest.mark.parametrize("motion", MOTIONS)
def test_a_capture_is_marked_as_simulated_and_came_over_a_port(motion):
    sidecar = json.loads((CAPTURES / f"{motion}.json").read_text(encoding="utf-8"))
    assert sidecar["source"] == sidecar["board"]["board"] == "simulated"
    assert sidecar["motion"] == motion
    assert sidecar["host"]["baud"] == 115200
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


def test_the_identification_trajectory_is_tracked_as_in_table_8():
    """99.67 and 99.02 % as published.

    Back-EMF, k2 and the unmodelled levels are solved for, and joint 2's number is one of the conditions, so it agrees
    to the rounding of the configuration. Joint 1's number is a prediction: with the gains as read, the arm tracks 0.6
    points worse than the paper prints.
    """
    recording = read_recording(CAPTURES / "ID.bin", CONFIG)
    similarity = tracking(recording, metric_settings(CONFIG)).set_index("joint")["total"]
    assert similarity[2] == pytest.approx(0.9902, abs=3e-4)
    assert similarity[1] == pytest.approx(0.9967, abs=0.007)


def test_least_squares_scores_on_the_stored_run_what_table_10_prints():
    """94.27 and 93.86 %, and the mean-square torque of joint 1: the arm is solved from them."""
    signals, published = signal_settings(CONFIG), load_published()
    regression = read_recording(CAPTURES / "ID.bin", CONFIG).regression(signals)
    beta = METHODS["ordinary"].estimate(regression).beta
    rebuilt = metr2ev(regression.tau, rebuild_torque(regression.y, beta), metric_settings(CONFIG))
    printed = [published[f"table10/ID/least-squares/total/joint{j}"].value for j in (1, 2)]
    np.testing.assert_allclose(100 * rebuilt.total, printed, rtol=0, atol=0.05)
    needed = least_squares_torque(published).set_index("joint")["mean_square"][1]
    assert np.mean(regression.tau[0] ** 2) == pytest.approx(needed, rel=0.01)


def test_the_arm_has_the_six_numbers_of_the_appendix():
    mechanical = np.array(CONFIG["arm"]["parameters"])
    assert list(reproduced(mechanical).values()) == [True] * 6
    assert f"{stability_constants(mechanical).lambda_q_min:.3f}" == "0.072"
    # Back-EMF is damping that Appendix A does not count: with it the printed numbers would be others.
    assert not all(reproduced(true_parameters(CONFIG)).values())
