"""Motions that a network of tracked motions is trained on."""

import copy
import hashlib
import os
from pathlib import Path

import numpy as np
import pytest
from experiment_example import full_config
from safetensors.numpy import load_file

from repro.errors import InputError
from repro.fpga.capture import read_capture
from repro.model.parameters import is_positive_definite
from repro.pipeline.simulated_arms import draw_arms, simulate_spread, simulate_tracked, training_motion
from repro.settings import of_network

pytestmark = pytest.mark.slow

CONFIG = full_config()
TRACKED = of_network(CONFIG, "tracked")


def small(arms=6, **tracked):
    config = copy.deepcopy(TRACKED)
    config["data"]["tracked"] |= {"arms": arms, **tracked}
    return config


@pytest.fixture(scope="module")
def motions(tmp_path_factory):
    path = tmp_path_factory.mktemp("tracked") / "tracked.safetensors"
    simulate_tracked(small(), path)
    return path


def test_the_arms_are_physical_and_the_motors_carry_them():
    beta = draw_arms(np.random.default_rng(0), 500, CONFIG)
    assert is_positive_definite(beta).all()
    full = np.array(CONFIG["board"]["full_torque_nm"])
    assert (beta[:, [3, 4]].sum(1) + beta[:, 7] <= 0.8 * full[0]).all()
    assert (beta[:, 4] + beta[:, 8] <= 0.8 * full[1]).all()
    assert (beta[:, 0] >= 0.01).all()
    assert (beta[:, 2] >= 0.004).all()
    assert len(np.unique(beta, axis=0)) == 500


def test_every_motion_is_eq_10_as_an_arm_tracks_it(motions):
    kept = load_file(motions)
    error = np.abs(kept["position"] * (2 * np.pi / 8400) - kept["desired"])[..., 340:-40]  # the trajectory proper
    assert error.max() <= CONFIG["data"]["tracked"]["largest_error_rad"]
    assert (error.max((1, 2)) > 0.01).all()  # and not Eq. 10 itself


def test_no_arm_is_one_that_is_tested(tmp_path, motions, monkeypatch):
    """By hash of what was recorded, and by parameters."""
    monkeypatch.setattr("repro.pipeline.simulated_arms.VALIDATION", {})  # no network is trained on them
    config = copy.deepcopy(CONFIG)
    config["spread"] = {"arms": 2, "seeds": [1, 2], "durations_s": [CONFIG["signals"]["duration_s"]]}
    simulate_spread(config, tmp_path / "spread.safetensors")
    tested = [*load_file(tmp_path / "spread.safetensors")["ID0/position"]]
    tested.append(read_capture(Path(CONFIG["experiment"]["captures"]) / "ID.bin").position)

    def digests(positions):
        return {hashlib.sha256(np.ascontiguousarray(p, dtype=np.int16).tobytes()).hexdigest() for p in positions}

    kept = load_file(motions)
    assert len(digests(kept["position"])) == 6
    assert not digests(kept["position"]) & digests(tested)
    arms = np.array([CONFIG["arm"]["parameters"], *CONFIG["numeric"]["arms"].values()])
    assert np.abs(kept["parameters"][:, np.newaxis] / arms - 1).max(-1).min() > 0.05


def test_torques_are_of_each_motion_and_f_is_of_the_one_that_was_sent(motions):
    desired = training_motion(small(), motions)
    assert desired.torque.shape == (6, 2, 100, 9)
    assert desired.model.shape == (2, 100, 9)
    listed = small()
    listed["algorithm1"]["image_motion"] = "measured"
    measured = training_motion(listed, motions)
    assert measured.model.shape == (6, 2, 100, 9)
    np.testing.assert_array_equal(measured.torque, desired.torque)
    # Gravity hardly knows how well the arm tracks; the acceleration of joint 2 does.
    gap = np.abs(measured.model - desired.model).max((0, 1, 2)) / np.abs(desired.model).max((0, 1))
    assert gap[3] < 0.15
    assert gap[2] > 0.2


def test_a_file_of_fewer_motions_is_refused(motions):
    with pytest.raises(InputError, match="position: found another shape"):
        training_motion(small(7), motions)
    with pytest.raises(InputError, match="no readable safetensors file"):
        training_motion(small(), motions.with_name("none"))
    os.mkfifo(pipe := motions.with_name("pipe"))
    with pytest.raises(InputError, match="a pipe or a device"):
        training_motion(small(), pipe)


def test_arms_that_do_not_track_end_in_one_line(tmp_path):
    with pytest.raises(InputError, match="arms that track"):
        simulate_tracked(small(largest_error_rad=1e-6), tmp_path / "out.safetensors")
    assert not list(tmp_path.iterdir())
