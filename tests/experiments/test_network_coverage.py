"""The intervals of a network's estimate on simulated arms, with a reader whose errors are known."""

from functools import partial
from pathlib import Path

import numpy as np
import pytest
from experiment_example import changed, full_config
from safetensors.numpy import load_file

from repro.board.frames import RADIANS_PER_COUNT
from repro.cnn.image import ImageSettings
from repro.config.sections import data_settings, of_network, search_settings
from repro.experiments import coverage as stage
from repro.experiments import simulated_arms
from repro.experiments.arm import acquire, program_from_config, read_recording, true_parameters
from repro.experiments.coverage import distances, novelty_limit
from repro.experiments.identifications import mean_training_torque
from repro.experiments.simulated_arms import sampled_tracks, simulate_tracked, training_motion
from repro.identification.algorithm1.refinement import Algorithm1
from repro.identification.regression import solve
from repro.model.parameters import NAMES

pytestmark = pytest.mark.slow

CONFIG = changed(
    of_network(full_config(), "tracked"),
    signals={"duration_s": 4.7},  # half of the motion
    experiment={"duration_s": 4.7},
    data={"tracked": {"arms": 64}},
    coverage={"arms": 40, "guesses": 20, "levels": [0.5, 0.9], "seed": 3},
)
SIGNALS = CONFIG.signals


class Reader:
    """Errs by a normal 0.1 for each arm, and scatters by 0.02 over the guesses."""

    rng = np.random.default_rng(0)

    def __init__(self, _network, _image, prepared):
        # Least squares stands for a network that knows the arm but for its error.
        self._right = solve(prepared.regression.y, prepared.regression.tau) / prepared.torque_scale

    def estimate(self, guess):
        return self._right + 0.1 * self.rng.standard_normal(9) + 0.02 * self.rng.standard_normal(guess.shape)


@pytest.fixture(scope="module", autouse=True)
def quick():
    """Simulate all arms the quick way, which the study does."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(simulated_arms, "run_loop", partial(simulated_arms.run_loop, quick=True))
        yield


@pytest.fixture(scope="module")
def motions(tmp_path_factory):
    path = tmp_path_factory.mktemp("coverage") / "tracked.safetensors"
    simulate_tracked(CONFIG, path)
    return path


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """The simulated arm on the same motion."""
    path = tmp_path_factory.mktemp("arm") / "ID.bin"
    acquire("ID", path, changed(CONFIG, experiment={"source": "simulated"}))
    return path


@pytest.fixture(scope="module")
def drawn():
    """Parameters of each set of arms that is simulated."""
    return []


@pytest.fixture(scope="module")
def tables(motions, recorded, drawn):
    algorithm1 = Algorithm1("tracked", None, ImageSettings(), search_settings(CONFIG), CONFIG.refinement)
    tau_mean = mean_training_torque(SIGNALS, data_settings(CONFIG), 1)

    def simulate(*arguments):
        result = simulated_arms.simulate_arms(*arguments)
        drawn.append(result[-1])
        return result

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stage, "simulate_arms", simulate)
        patch.setattr(stage, "ResidualEstimator", Reader)
        patch.setattr(stage, "algorithm1_of", lambda *_: algorithm1)
        patch.setattr(stage, "read_mean_torque", lambda *_: tau_mean)
        return stage.check_coverage([recorded], Path(), motions, Path(), "", CONFIG)


def test_calibrated_intervals_cover_where_the_guesses_do_not(tables):
    table = tables[0]
    assert len(table) == 3 * (len(NAMES) + 1) * 2
    each = table[table["parameter"] != "all nine"]
    mean = each.groupby(["arms", "level"])[["raw", "calibrated"]].mean()
    for arms in ("Eq. 1", "unmodelled"):
        assert mean.loc[(arms, 0.9), "raw"] < 0.5
        assert mean.loc[(arms, 0.9), "calibrated"] == pytest.approx(0.9, abs=0.08)
        assert mean.loc[(arms, 0.5), "calibrated"] == pytest.approx(0.5, abs=0.12)
    assert (each["width"] > 0).all()
    assert (each["contraction"] < 1).all()
    assert table["warned"].max() < 0.2


@pytest.mark.usefixtures("tables")
def test_no_arm_that_intervals_are_tested_on_calibrates_them(drawn):
    assert [arms.shape for arms in drawn] == 4 * [(40, 9)]
    assert len(np.unique(np.concatenate(drawn), axis=0)) == 4 * 40


def test_all_nine_are_covered_at_once_by_intervals_stretched_for_it(tables):
    together = tables[0].query("parameter == 'all nine'").set_index(["arms", "level"])
    assert (together["factor"] > 1).all()
    for level, slack in ((0.5, 0.2), (0.9, 0.13)):
        assert together.loc[("unmodelled", level), "calibrated"] == pytest.approx(level, abs=slack)
    assert together["raw"].max() < 0.1  # nine ranges that are each too narrow


def test_joint_factors_by_hand():
    """Four arms, two levels: the worst of nine misses over their factors, 1.5, 0.5, 3 and 2."""
    calibration = np.full((4, 9), 0.1)
    calibration[[0, 1, 2, 3], [4, 8, 0, 2]] = [1.5, 0.5, 3.0, 4.0]
    factors = np.ones((2, 9))
    factors[:, 2] = 2.0
    np.testing.assert_allclose(stage.joint_factors(factors, calibration, (0.4, 0.5)), [1.5, 2.0])


def test_the_recorded_arm_is_like_the_training_motions_and_gets_its_interval(tables, recorded):
    own = tables[2]
    assert list(own["parameter"]) == list(NAMES)
    np.testing.assert_allclose(own["true"], true_parameters(CONFIG), rtol=1e-12)
    assert (own["low"] < own["centre"]).all()
    assert (own["centre"] < own["high"]).all()
    assert own[["warned", "level"]].drop_duplicates().to_numpy().tolist() == [[0, 0.9]]
    # As wide, in units of the largest torque, as those of the arms it was calibrated on; half that at level 0.5.
    largest = np.abs(read_recording(recorded, CONFIG).regression(SIGNALS).tau).max()
    half = (own["high"] - own["low"]).to_numpy() / 2 / largest
    known = tables[0].query("arms == 'unmodelled' and level == 0.9")["width"].dropna().to_numpy()
    assert 0.7 < np.median(half / known) < 1.4


def test_another_motion_is_unlike(motions):
    """The mirror image of a motion that arms track: as large, as fast, and none of them."""
    training, position = training_motion(CONFIG, motions).torque, load_file(motions)["position"]
    mirrored = sampled_tracks(position[:3, ::-1] * RADIANS_PER_COUNT, program_from_config(CONFIG, "ID"), SIGNALS)
    assert (distances(mirrored.torque, training) > novelty_limit(training)).all()
