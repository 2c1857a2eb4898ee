"""The experiment over many specimens: recordings kept and read back, and loops that chatter."""

import copy
from dataclasses import replace

import numpy as np
import pytest
from experiment_example import MOTIONS, refused, short_config
from safetensors.numpy import load_file, save_file

from repro.pipeline.experiment import (
    mechanical_parameters,
    program_from_config,
    true_parameters,
)
from repro.pipeline.monte_carlo import chatters
from repro.pipeline.simulated_arms import read_spread, simulate_spread, spread_arms
from repro.signals.programs import peaks

pytestmark = pytest.mark.slow


def brief_config():
    """Two specimens, motions of a few seconds, motors that can do it."""
    config = short_config()
    config["board"] |= {"full_torque_nm": [60.0, 60.0], "speed_limit_rad_s": 200.0}
    config["experiment"] |= {"validation_samples": 2200, "random_range_rad": 0.01, "lead_in_s": 0.5}
    # Light enough for those motors, and heavy enough that the simulation of no drawn arm diverges.
    config["data"]["tracked"] |= {"load_share": 0.03, "least_inertia_kg_m2": [0.1, 0.02]}
    config["spread"] |= {"arms": 2, "seeds": [4, 9], "durations_s": [2.0, 1.5]}
    return config


CONFIG = brief_config()


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("spread") / "recordings.safetensors"
    simulate_spread(CONFIG, path)
    return path


def test_every_seed_and_motion_comes_back(recorded):
    for index, duration in enumerate(CONFIG["spread"]["durations_s"]):
        found = read_spread(recorded, CONFIG, index)
        assert [(one.seed, one.arm) for one in found] == [(4, 0), (9, 1)]
        for one in found:
            assert tuple(one.recordings) == MOTIONS
            for name, recording in one.recordings.items():
                program = program_from_config(CONFIG, name, one.seed, duration)
                assert (recording.program.q == program.q.astype(np.float32)).all()  # as the board was sent it
                assert (recording.program.n1, recording.program.n2) == (program.n1, program.n2)
                assert recording.q.shape == recording.tau.shape == program.q.shape
                assert np.abs(recording.q - program.q).max() < 0.3
                assert np.ptp(recording.tau, axis=1).min() > 0
        proper = found[0].recordings["ID"].program
        assert proper.n2 - proper.n1 == round(duration / 0.0025)


def test_an_arm_that_is_too_heavy_for_a_motion_is_left_out(monkeypatch):
    config, true = copy.deepcopy(CONFIG), true_parameters(CONFIG)
    motions = [program_from_config(config, name, seed) for name in MOTIONS for seed in config["spread"]["seeds"]]
    torque = np.max([peaks(motion, true)[1] for motion in motions], axis=0)
    config["board"]["full_torque_nm"] = (1.2 * torque / config["experiment"]["torque_share"]).tolist()
    mechanical = mechanical_parameters(config)
    able = np.append(0.9 * mechanical[:5], mechanical[5:])
    monkeypatch.setattr("repro.pipeline.simulated_arms.draw_arms", lambda *_: np.stack([1.5 * mechanical, able]))
    same_motors = able + (true - mechanical)
    np.testing.assert_allclose(spread_arms(config), [true, same_motors], rtol=1e-15)


def test_recordings_of_another_configuration_are_refused_by_the_motion(recorded, tmp_path):
    more = copy.deepcopy(CONFIG)
    more["spread"]["seeds"] = [4, 9, 11, 12]
    assert f"{recorded}: parameters: " in refused(read_spread, recorded, more, 0)
    longer = copy.deepcopy(CONFIG)
    longer["experiment"]["validation_samples"] = 2300
    assert f"{recorded}: T1/position: " in refused(read_spread, recorded, longer, 0)
    counts = load_file(recorded)
    del counts["T3/pwm"]
    path = tmp_path / "recordings.safetensors"
    save_file(counts, path)
    assert f"{path}: T3/pwm: " in refused(read_spread, path, CONFIG, 0)


# --- Chatter ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("fast", "expected"), [(0.0, False), (1.6, False), (1.9, True)])
def test_a_loop_chatters_if_three_quarters_of_a_torque_are_fast(recorded, fast, expected):
    """A sinusoid of 1 Hz and amplitude 1 on both joints, and one of 40 Hz on joint 2: a power of 3.6 to 1 at 1.9."""
    recording = read_spread(recorded, CONFIG, 0)[0].recordings["ID"]
    t = recording.program.h * np.arange(4000)
    slow = np.sin(2 * np.pi * t)
    tau = np.stack([slow, slow + fast * np.sin(2 * np.pi * 40.0 * t) + 3.0])
    assert chatters(replace(recording, tau=tau)) == expected
