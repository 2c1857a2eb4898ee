"""The experiment over many specimens: recordings kept and read back, and the verdict with its intervals."""

import copy
import itertools

import numpy as np
import pandas as pd
import pytest
from experiment_example import short_config, spread_table
from safetensors.numpy import load_file, save_file

from repro.errors import InputError
from repro.exhibits.study import verdict
from repro.fpga.frames import RADIANS_PER_COUNT
from repro.fpga.loop import simulate
from repro.fpga.plant import Plant
from repro.pipeline.experiment import control_constants, mechanical_parameters, program_from_config, true_parameters
from repro.pipeline.specimen import disturbance
from repro.pipeline.spread import read_spread, simulate_spread, spread_arms
from repro.signals.limits import peaks

pytestmark = pytest.mark.slow

MOTIONS = ["ID", "T1", "T2", "T3", "T4"]


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
            assert list(one.recordings) == MOTIONS
            for name, recording in one.recordings.items():
                program = program_from_config(CONFIG, name, one.seed, duration)
                assert (recording.program.q == program.q.astype(np.float32)).all()  # as the board was sent it
                assert (recording.program.n1, recording.program.n2) == (program.n1, program.n2)
                assert recording.q.shape == recording.tau.shape == program.q.shape
                assert np.abs(recording.q - program.q).max() < 0.3
                assert np.ptp(recording.tau, axis=1).min() > 0
        proper = found[0].recordings["ID"].program
        assert proper.n2 - proper.n1 == round(duration / 0.0025)


def test_specimens_differ_and_the_random_motion_with_them(recorded):
    first, second = (one.recordings for one in read_spread(recorded, CONFIG, 0))
    for name in MOTIONS:
        assert (first[name].tau != second[name].tau).any()
        assert (first[name].program.q == second[name].program.q).all() == (name != "T1")


def test_an_arm_that_is_too_heavy_for_a_motion_is_left_out(monkeypatch):
    config, true = copy.deepcopy(CONFIG), true_parameters(CONFIG)
    motions = [program_from_config(config, name, seed) for name in MOTIONS for seed in config["spread"]["seeds"]]
    torque = np.max([peaks(motion, true)[1] for motion in motions], axis=0)
    config["board"]["full_torque_nm"] = (1.2 * torque / config["experiment"]["torque_share"]).tolist()
    mechanical = mechanical_parameters(config)
    able = np.append(0.9 * mechanical[:5], mechanical[5:])
    monkeypatch.setattr("repro.pipeline.spread.draw_arms", lambda *_: np.stack([1.5 * mechanical, able]))
    same_motors = able + (true - mechanical)
    np.testing.assert_allclose(spread_arms(config), [true, same_motors], rtol=1e-15)


@pytest.mark.parametrize("name", ["ID", "T1"])
def test_a_specimen_is_the_arm_simulated_alone(recorded, name):
    """Arms of a batch share their substeps, so now and then a position falls on the other side of a count.

    With these coarse motors the loop makes some counts of one on the lighter arm that was drawn.
    """
    control = control_constants(CONFIG)
    for one in read_spread(recorded, CONFIG, 1):
        levels, phase = disturbance(CONFIG, one.seed)
        recording = one.recordings[name]
        position, _ = simulate(Plant(one.true, 0.0025, levels, phase), control, recording.program.q)
        counts = np.rint(recording.q / RADIANS_PER_COUNT)
        apart = np.abs(counts - position[0])
        assert apart.max() <= (1 if one.arm == 0 else 5)
        assert apart.mean() < (0.05 if one.arm == 0 else 0.5)
        np.testing.assert_allclose(recording.q, counts * RADIANS_PER_COUNT, atol=1e-12)


def refused(path, config=CONFIG, index=0):
    with pytest.raises(InputError) as error:
        read_spread(path, config, index)
    message = str(error.value)
    assert "\n" not in message
    assert message.startswith(str(path))
    assert ": found " in message
    assert ", expected " in message
    return message


DAMAGE = {
    "missing": lambda path: path.unlink(),
    "empty": lambda path: path.write_bytes(b""),
    "cut short": lambda path: path.write_bytes(path.read_bytes()[:-100]),
    "something else": lambda path: path.write_bytes(b"not recordings" * 100),
}


@pytest.mark.parametrize("damage", DAMAGE.values(), ids=DAMAGE)
def test_a_damaged_file_is_refused_in_one_line(recorded, tmp_path, damage):
    path = tmp_path / "recordings.safetensors"
    path.write_bytes(recorded.read_bytes())
    damage(path)
    refused(path)


def test_recordings_of_another_configuration_are_refused_by_the_motion(recorded, tmp_path):
    more = copy.deepcopy(CONFIG)
    more["spread"]["seeds"] = [4, 9, 11, 12]
    assert "parameters" in refused(recorded, more)
    longer = copy.deepcopy(CONFIG)
    longer["experiment"]["validation_samples"] = 2300
    assert "T1" in refused(recorded, longer)
    counts = load_file(recorded)
    del counts["T3/pwm"]
    path = tmp_path / "recordings.safetensors"
    save_file(counts, path)
    assert "T3" in refused(path)


# --- Verdict ------------------------------------------------------------------------------------------------------


def scores_of(differences, base=0.9, arms=1):
    """Scores of one motion, joint and duration with these differences to least squares."""
    rows = [
        ("T1", 1, method, 3.0, seed % arms, seed, base + (d if method == "algorithm1" else 0.0))
        for seed, d in enumerate(differences)
        for method in ("algorithm1", "least-squares")
    ]
    return pd.DataFrame(rows, columns=["case", "joint", "method", "duration", "arm", "seed", "total"])


def verdict_of(differences, base=0.0, arms=1):
    (row,) = verdict(scores_of(differences, base, arms), ["algorithm1"], ["least-squares"]).to_dict("records")
    return row


def test_wins_and_the_median_difference_of_every_motion_joint_and_duration():
    config = short_config()
    config["spread"]["seeds"] = [1, 2, 3, 4]
    table = verdict(spread_table(config, 0.02), ["algorithm1", "algorithm1+refinement"], ["least-squares", "bounded"])
    assert len(table) == 2 * 2 * 5 * 2 * 2
    assert list(table.columns[:7]) == ["motion", "joint", "duration", "method", "opponent", "arms", "runs"]
    for row in table.itertuples():
        amount = {"algorithm1": 0.02, "algorithm1+refinement": 0.04}[row.method]
        amount -= 0.005 * (row.opponent == "bounded")
        won = row.motion != "ID"
        assert (row.arms, row.runs, row.wins, row.win_share) == (2, 4, 4 * won, float(won))
        assert row.difference_median == pytest.approx(amount if won else -amount)
        assert row.difference_low == pytest.approx(row.difference_median)
        assert row.difference_high == pytest.approx(row.difference_median)


def test_a_draw_is_no_win():
    row = verdict_of([0.1, 0.0, 0.0, -0.1])
    assert (row["runs"], row["wins"], row["win_share"]) == (4, 1, 0.25)


def test_differences_are_paired_by_the_seed():
    """Whatever a seed does to both methods falls out, and the order of the rows does not matter."""
    scores = scores_of([0.01, 0.03, 0.02])
    scores["total"] += 0.05 * scores["seed"]
    (row,) = verdict(scores.sample(frac=1.0, random_state=1), ["algorithm1"], ["least-squares"]).to_dict("records")
    assert row["difference_median"] == pytest.approx(0.02)
    assert row["wins"] == 3


def test_the_interval_of_the_median_is_that_of_all_resamples():
    """Five values have 3125 resamples: the exact distribution, against the drawn one."""
    values = [-0.02, 0.01, 0.03, 0.07, 0.2]
    row = verdict_of(values)
    medians = np.sort([np.median(sample) for sample in itertools.product(values, repeat=5)])
    assert row["difference_median"] == pytest.approx(0.03)
    assert row["difference_low"] == pytest.approx(np.quantile(medians, 0.025), abs=1e-12)
    assert row["difference_high"] == pytest.approx(np.quantile(medians, 0.975), abs=1e-12)


def test_arms_that_differ_widen_the_interval():
    """Specimens of an arm agree and arms do not: as many runs say less, and the interval spans the arms."""
    values = [0.01 * (seed % 4) + 1e-4 * seed for seed in range(16)]
    as_one, as_four = verdict_of(values), verdict_of(values, arms=4)
    assert as_four["arms"] == 4
    assert as_four["difference_median"] == as_one["difference_median"]
    assert as_four["difference_high"] - as_four["difference_low"] > as_one["difference_high"] - as_one["difference_low"]


def test_the_bootstrap_gives_the_same_numbers_every_time():
    values = np.random.default_rng(3).normal(size=12)
    pd.testing.assert_frame_equal(*(verdict(scores_of(values), ["algorithm1"], ["least-squares"]) for _ in range(2)))


@pytest.mark.parametrize("values", [[0.04], [0.04] * 7])
def test_a_single_value_or_equal_ones_are_their_own_interval(values):
    row = verdict_of(values)
    assert row["difference_low"] == row["difference_median"] == row["difference_high"] == pytest.approx(0.04)
    assert row["wins"] == row["runs"] == len(values)
