"""From the ideal case to the recording: what each step holds, held against what made it."""

import copy
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from experiment_example import full_config

from repro.cnn.image import ImageSettings
from repro.exhibits.study import why_table
from repro.fpga.frames import RADIANS_PER_COUNT
from repro.identification.algorithm1.refinement import RefinementSettings
from repro.identification.algorithm1.run import Algorithm1
from repro.identification.algorithm1.search import SearchSettings
from repro.identification.solve import solve
from repro.model.dynamics import rebuild_torque, regressor
from repro.pipeline.experiment import true_parameters
from repro.pipeline.experiment_runs import prepare_recording
from repro.pipeline.numeric import mean_training_torque
from repro.pipeline.recordings import read_recording
from repro.pipeline.why import beyond, dissect, explain, simulate_states
from repro.render.why import STEPS
from repro.settings import data_settings, signal_settings

pytestmark = pytest.mark.slow

CONFIG = full_config()
SIGNALS = signal_settings(CONFIG)
TRUE = true_parameters(CONFIG)


@pytest.fixture(scope="module")
def recording():
    return read_recording(Path(CONFIG["experiment"]["captures"]) / "ID.bin", CONFIG)


@pytest.fixture(scope="module")
def tau_mean():
    return mean_training_torque(SIGNALS, data_settings(CONFIG), 1)


@pytest.fixture(scope="module")
def steps(tau_mean):
    return dissect(tau_mean, CONFIG, "measured")


def error_of(prepared):
    found = solve(prepared.regression.y, prepared.regression.tau)
    return np.abs(found - TRUE).max()


def test_the_simulated_run_is_the_stored_recording(recording):
    states = simulate_states(CONFIG)
    np.testing.assert_allclose(states.recording.q, recording.q, atol=RADIANS_PER_COUNT)
    assert (np.abs(states.recording.q - recording.q) < 1e-9).mean() > 0.999
    np.testing.assert_array_equal(states.recording.program.q, recording.program.q)
    np.testing.assert_array_equal(states.motors, states.recording.tau)  # no dead band
    h = recording.program.h
    moved = np.diff(recording.q, axis=1)
    dq = states.dq
    np.testing.assert_allclose(moved[:, 400:], h * (dq[:, 400:-1] + dq[:, 401:]) / 2, atol=1.1 * RADIANS_PER_COUNT)
    assert np.corrcoef(np.diff(dq[1]) / h, states.ddq[1, :-1])[0, 1] > 0.9


def test_what_eq_1_leaves_out_is_the_rest_of_the_motors_torque():
    """But for the rounding of the position, which moves gravity by a thousandth of a newton metre."""
    states = simulate_states(CONFIG)
    q = states.recording.q
    rest = states.motors - rebuild_torque(regressor(q, states.dq, states.ddq), TRUE)
    np.testing.assert_allclose(beyond(q, states.dq, CONFIG), rest, atol=5e-3)
    assert np.abs(rest).max() > 0.05


def test_a_dead_band_is_what_the_motors_do_not_see():
    config = copy.deepcopy(CONFIG)
    config["arm"]["dead_band_counts"] = 20
    states = simulate_states(config)
    gap = np.abs(states.recording.tau - states.motors).max(axis=1)
    np.testing.assert_allclose(gap, 20 * np.array(config["board"]["full_torque_nm"]) / 1023)


def test_every_step_has_one_cause_more(steps):
    """Least squares knows the parameters in the ideal case, but for what the filter takes from Coulomb friction."""
    assert tuple(steps) == tuple(STEPS)
    assert error_of(steps["ideal"]) < 5e-3
    assert error_of(steps["beyond"]) > 3 * error_of(steps["ideal"])
    ideal, beyond, quantised, loop, recorded = (step.regression for step in steps.values())
    for name in ("q", "dq", "ddq"):  # torque alone
        np.testing.assert_array_equal(getattr(beyond, name), getattr(ideal, name))
    for name in ("dq", "ddq"):  # rounding alone
        np.testing.assert_array_equal(getattr(quantised, name), getattr(beyond, name))
    assert 0 < np.abs(quantised.tau - beyond.tau).max() < 2 * 2.7314 / 1023
    assert 0 < np.abs(quantised.q - beyond.q).max() <= 0.5 * RADIANS_PER_COUNT + 1e-12
    assert np.abs(loop.q - quantised.q).max() > 10 * RADIANS_PER_COUNT
    np.testing.assert_array_equal(loop.tau, recorded.tau)  # derivatives alone
    np.testing.assert_array_equal(loop.q, recorded.q)
    assert np.abs(loop.ddq - recorded.ddq).max() > 0.1


@pytest.mark.parametrize("image_motion", ["measured", "desired"])
def test_the_last_step_is_the_recording_as_it_is_identified(recording, tau_mean, image_motion):
    found = dissect(tau_mean, CONFIG, image_motion)["recording"]
    expected = prepare_recording(recording, tau_mean, SIGNALS, image_motion)
    for name in ("c_p", "largest", "alpha", "model", "y_sub", "pace"):
        np.testing.assert_allclose(getattr(found, name), getattr(expected, name), atol=1e-9)
    for name in ("q", "dq", "ddq", "tau", "y"):
        np.testing.assert_allclose(getattr(found.regression, name), getattr(expected.regression, name), atol=1e-9)


def test_f_of_the_image_is_on_the_motion_that_was_sent(tau_mean, steps):
    desired = dissect(tau_mean, CONFIG, "desired")
    np.testing.assert_array_equal(desired["loop"].model, desired["ideal"].model)
    assert np.abs(steps["loop"].model - steps["ideal"].model).max() > 0.1


def test_a_perfect_reader_is_perfect_where_eq_1_holds(monkeypatch, tau_mean):
    seen = []

    def estimate(self, guess):
        self.images += len(guess)
        seen.append(guess)
        return np.tile(TRUE / self.largest, (len(guess), 1))

    class Reader:
        def __init__(self, _network, _image, prepared):
            self.images, self.largest = 0, prepared.largest

    Reader.estimate = estimate
    monkeypatch.setattr("repro.pipeline.why.ResidualReader", Reader)
    config = CONFIG | {"why": {"seeds": [1], "guesses": 30, "near": 0.05}}
    search = SearchSettings(executions=2, inner_limit=2)
    algorithm1 = Algorithm1("published", None, ImageSettings(), search, RefinementSettings())
    table = explain(algorithm1, tau_mean, [1, 2], config)
    assert len(table) == 2 * len(STEPS)
    uniform, near = seen[-2:]
    assert uniform.shape == near.shape == (30, 9)
    assert search.low <= uniform.min() < search.low + 0.05 * (search.high - search.low)
    assert search.high - 0.05 * (search.high - search.low) < uniform.max() <= search.high
    assert (
        np.abs(near - TRUE / Reader(None, None, dissect(tau_mean, config, "measured")["recording"]).largest).std()
        < 0.05
    )
    assert table["error_uniform"].max() < 1e-12
    assert table["error_near"].max() < 1e-12
    ideal = table[table["step"] == "ideal"]
    assert ideal[["total1", "total2"]].min(axis=None) > 0.997
    last = table[table["step"] == "recording"]
    assert last["total1"].max() < 0.99


def test_the_table_says_what_each_step_costs():
    rows = [
        (network, step, seed, 0.9 - 0.1 * k + bump, 0.8 - 0.1 * k, 0.1 * seed, 0.5)
        for network in ("published", "tracked")
        for k, step in enumerate(STEPS)
        for seed, bump in ((1, -0.02), (2, 0.0), (3, 0.02))
    ]
    columns = ["network", "step", "seed", "total1", "total2", "error_uniform", "error_near"]
    table = why_table(pd.DataFrame(rows, columns=columns))
    assert len(table) == 2 * len(STEPS)
    first = table[table["network"] == "published"]
    np.testing.assert_allclose(first["lost"], [0.0, 0.1, 0.1, 0.1, 0.1], atol=1e-12)
    np.testing.assert_allclose(first["total1"], [0.9, 0.8, 0.7, 0.6, 0.5])
    np.testing.assert_allclose(first["spread1"], 0.02)
    assert set(table["seeds"]) == {3}
    np.testing.assert_allclose(table["error_uniform"], 0.2)
