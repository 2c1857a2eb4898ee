"""Simulated arms that a network is trained on, kept and read back."""

import os

import numpy as np
import pytest
from experiment_example import ROOT, changed, full_config, refused
from safetensors.numpy import load_file

from repro.board.frames import RADIANS_PER_COUNT
from repro.config.sections import of_network
from repro.experiments import simulated_arms
from repro.experiments.accepted import read_experiments
from repro.experiments.arm import program_from_config, true_parameters
from repro.experiments.simulated_arms import simulate_tracked, training_motion
from repro.model.parameters import NAMES, is_positive_definite

pytestmark = pytest.mark.slow

CONFIG = full_config()
#: Half of the motion that networks are trained on.
TRACKED = changed(of_network(CONFIG, "tracked"), signals={"duration_s": 4.7})


def small(arms=6, **tracked):
    return changed(TRACKED, data={"tracked": {"arms": arms, **tracked}})


@pytest.fixture(scope="module")
def motions(tmp_path_factory):
    path = tmp_path_factory.mktemp("tracked") / "tracked.safetensors"
    simulate_tracked(small(), path)
    return path


def test_arms_of_both_laws_are_physical_and_the_motors_carry_them(monkeypatch):
    full = np.array(CONFIG.board.full_torque_nm)
    correlation = []
    for draw in (simulated_arms.draw_arms, simulated_arms.draw_built_arms):
        beta = draw(np.random.default_rng(0), 500, CONFIG)
        assert is_positive_definite(beta).all()
        assert (np.stack([beta[:, [3, 4, 7]].sum(1), beta[:, [4, 8]].sum(1)], axis=1) <= 0.8 * full).all()
        assert (beta[:, [0, 2]] >= [0.01, 0.004]).all()
        assert len(np.unique(beta, axis=0)) == 500
        correlation.append(np.corrcoef(np.log(beta[:, [3, 7]]).T)[0, 1])
    # Friction follows gravity in the arms as they are built, which it does not in those that train.
    assert correlation[1] > correlation[0] + 0.2
    monkeypatch.setattr(simulated_arms, "MOST_REFUSED", 10_000)
    none = changed(CONFIG, data={"tracked": {"load_share": 0.0}})
    assert "load_share" in refused(draw, np.random.default_rng(0), 500, none).place


def test_an_arm_tracks_if_it_is_near_in_the_trajectory_proper():
    program = program_from_config(CONFIG, "ID")
    counts = np.rint(np.tile(program.q, (3, 1, 1)) / RADIANS_PER_COUNT)
    far = int(2.0 * CONFIG.data.tracked.largest_error_rad / RADIANS_PER_COUNT)
    counts[0, 0, : program.n1] += far
    counts[1, 1, program.n2 - 1] -= far
    assert simulated_arms.tracks(CONFIG, counts.astype(np.int16), program).tolist() == [True, False, True]


def test_a_motion_is_within_the_limits_of_both_joints():
    program, own = program_from_config(CONFIG, "ID"), true_parameters(CONFIG)
    load1, load2 = (own + np.where(np.arange(9) == place, 50.0, 0.0) for place in (7, 8))
    within = simulated_arms.is_within_limits(CONFIG, np.stack([load1, own, load2]), program)
    assert within.tolist() == [False, True, False]


def test_no_arm_that_trains_is_one_that_is_tested(motions):
    accepted = read_experiments(ROOT / "data/experiments/accepted.csv")[list(NAMES)].to_numpy()
    tested, trained = [*accepted, *dict(CONFIG.numeric.arms).values()], load_file(motions)["parameters"]
    assert len(np.unique(trained, axis=0)) == 6
    assert np.abs(trained[:, np.newaxis] / tested - 1).max(-1).min() > 0.05


def test_torques_are_of_each_motion_and_f_is_of_the_one_that_was_sent(motions):
    desired = training_motion(small(), motions)
    assert (desired.torque.shape, desired.model.shape) == ((6, 2, 100, 9), (2, 100, 9))
    measured = training_motion(changed(small(), algorithm1={"image_motion": "measured"}), motions)
    assert measured.model.shape == (6, 2, 100, 9)
    np.testing.assert_array_equal(measured.torque, desired.torque)
    # Gravity hardly knows how well the arm tracks; the acceleration of joint 2 does.
    gap = np.abs(measured.model - desired.model).max((0, 1, 2)) / np.abs(desired.model).max((0, 1))
    assert gap[3] < 0.15 and gap[2] > 0.2


def test_a_file_of_fewer_motions_is_refused(motions):
    assert refused(training_motion, small(7), motions).place == f"{motions}: position"
    os.mkfifo(pipe := motions.with_name("pipe"))
    for path in (motions.with_name("none"), pipe):
        assert refused(training_motion, small(), path).place == str(path)


def test_arms_that_do_not_track_end_in_one_line(tmp_path):
    config = changed(small(largest_error_rad=1e-6), signals={"duration_s": 0.5}, experiment={"lead_in_s": 0.1})
    refused(simulate_tracked, config, tmp_path / "out.safetensors")
    assert not list(tmp_path.iterdir())
