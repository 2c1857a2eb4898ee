"""Simulated arms: those that a network is trained on, and many specimens, kept and read back."""

import os
from dataclasses import replace

import numpy as np
import pytest
from experiment_example import MOTIONS, changed, full_config, refused, short_config
from safetensors.numpy import load_file, save_file

from repro.errors import InputError
from repro.fpga.frames import RADIANS_PER_COUNT
from repro.model.parameters import is_positive_definite
from repro.pipeline import simulated_arms
from repro.pipeline.experiment import program_from_config, true_parameters
from repro.pipeline.monte_carlo import chatters
from repro.pipeline.simulated_arms import read_spread, simulate_spread, simulate_tracked, spread_arms, training_motion
from repro.settings import of_network
from repro.signals.programs import peaks

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
    full = np.array(CONFIG["board"]["full_torque_nm"])
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
    with pytest.raises(InputError, match=r"load_share.*: found none of"):
        draw(np.random.default_rng(0), 500, changed(CONFIG, data={"tracked": {"load_share": 0.0}}))


def test_an_arm_tracks_if_it_is_near_in_the_trajectory_proper():
    program = program_from_config(CONFIG, "ID")
    counts = np.rint(np.tile(program.q, (3, 1, 1)) / RADIANS_PER_COUNT)
    far = int(2.0 * CONFIG["data"]["tracked"]["largest_error_rad"] / RADIANS_PER_COUNT)
    counts[0, 0, : program.n1] += far
    counts[1, 1, program.n2 - 1] -= far
    assert simulated_arms.tracks(CONFIG, counts.astype(np.int16), program).tolist() == [True, False, True]


def test_a_motion_is_within_the_limits_of_both_joints():
    program, own = program_from_config(CONFIG, "ID"), true_parameters(CONFIG)
    load1, load2 = (own + np.where(np.arange(9) == place, 50.0, 0.0) for place in (7, 8))
    within = simulated_arms.is_within_limits(CONFIG, np.stack([load1, own, load2]), program)
    assert within.tolist() == [False, True, False]


def test_no_arm_that_trains_is_one_that_is_tested(motions, monkeypatch):
    """Compared without viscous friction, to which arms that are tested add their back-EMF."""
    monkeypatch.setattr(simulated_arms, "run_loop", lambda _, beta, __: [beta])
    monkeypatch.setattr(simulated_arms, "tracks", lambda _, beta, __: np.ones(len(beta), dtype=bool))
    arms = spread_arms(changed(CONFIG, spread={"arms": 2, "seeds": [1, 2]}))
    tested = np.delete([*arms, *CONFIG["numeric"]["arms"].values()], [5, 6], axis=1)
    trained = np.delete(load_file(motions)["parameters"], [5, 6], axis=1)
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
    assert "position: found another shape" in refused(training_motion, small(7), motions)
    assert "no readable safetensors file" in refused(training_motion, small(), motions.with_name("none"))
    os.mkfifo(pipe := motions.with_name("pipe"))
    assert "a pipe or a device" in refused(training_motion, small(), pipe)


def test_arms_that_do_not_track_end_in_one_line(tmp_path):
    config = changed(small(largest_error_rad=1e-6), signals={"duration_s": 0.5}, experiment={"lead_in_s": 0.1})
    assert "arms that track" in refused(simulate_tracked, config, tmp_path / "out.safetensors")
    assert not list(tmp_path.iterdir())


# --- Specimens ----------------------------------------------------------------------------------------------------

#: Two specimens, motions of a few seconds, motors that can do it.
BRIEF = changed(
    short_config(),
    board={"full_torque_nm": [60.0, 60.0], "speed_limit_rad_s": 200.0},
    experiment={"validation_samples": 2200, "random_range_rad": 0.01, "lead_in_s": 0.5},
    # Light enough for those motors, and heavy enough that the simulation of no drawn arm diverges.
    data={"tracked": {"load_share": 0.03, "least_inertia_kg_m2": [0.1, 0.02]}},
    spread={"arms": 2, "seeds": [4, 9], "durations_s": [2.0, 1.5]},
)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("spread") / "recordings.safetensors"
    simulate_spread(BRIEF, path)
    return path


def test_every_seed_and_motion_comes_back(recorded):
    for index, duration in enumerate(BRIEF["spread"]["durations_s"]):
        found = read_spread(recorded, BRIEF, index)
        assert [(one.seed, one.labels["arm"]) for one in found] == [(4, 0), (9, 1)]
        for one in found:
            for name, recording in zip(MOTIONS, one.recordings, strict=True):
                program = program_from_config(BRIEF, name, one.seed, duration)
                assert (recording.program.q == program.q.astype(np.float32)).all()  # as the board was sent it
                assert (recording.program.n1, recording.program.n2) == (program.n1, program.n2)
                assert recording.q.shape == recording.tau.shape == program.q.shape
                assert np.abs(recording.q - program.q).max() < 0.3
                assert np.ptp(recording.tau, axis=1).min() > 0


def test_an_arm_that_is_too_heavy_for_a_motion_is_left_out(monkeypatch):
    true, mechanical = true_parameters(BRIEF), np.array(BRIEF["arm"]["parameters"])
    motions = [program_from_config(BRIEF, name, seed) for name in MOTIONS for seed in BRIEF["spread"]["seeds"]]
    torque = np.max([peaks(motion, true)[1] for motion in motions], axis=0)
    full = (1.2 * torque / BRIEF["experiment"]["torque_share"]).tolist()
    able = np.append(0.9 * mechanical[:5], mechanical[5:])
    monkeypatch.setattr(simulated_arms, "draw_arms", lambda *_: np.stack([1.5 * mechanical, able]))
    expected = [true, able + (true - mechanical)]  # with the same motors
    np.testing.assert_allclose(spread_arms(changed(BRIEF, board={"full_torque_nm": full})), expected, rtol=1e-15)


def test_recordings_of_another_configuration_are_refused_by_the_motion(recorded, tmp_path):
    more = changed(BRIEF, spread={"seeds": [4, 9, 11, 12]})
    assert f"{recorded}: parameters: " in refused(read_spread, recorded, more, 0)
    longer = changed(BRIEF, experiment={"validation_samples": 2300})
    assert f"{recorded}: T1/position: " in refused(read_spread, recorded, longer, 0)
    counts = load_file(recorded)
    del counts["T3/pwm"]
    save_file(counts, path := tmp_path / "recordings.safetensors")
    assert f"{path}: T3/pwm: " in refused(read_spread, path, BRIEF, 0)


# --- Chatter ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("fast", "expected"), [(0.0, False), (1.6, False), (1.9, True)])
def test_a_loop_chatters_if_three_quarters_of_a_torque_are_fast(recorded, fast, expected):
    """A sinusoid of 1 Hz and amplitude 1 on both joints, and one of 40 Hz on joint 2: a power of 3.6 to 1 at 1.9."""
    recording = read_spread(recorded, BRIEF, 0)[0].recordings[0]
    t = recording.program.h * np.arange(4000)
    slow = np.sin(2 * np.pi * t)
    tau = np.stack([slow, slow + fast * np.sin(2 * np.pi * 40.0 * t) + 3.0])
    assert chatters(replace(recording, tau=tau)) == expected
