"""From the ideal case to the recording: what each step holds, held against what made it."""

from dataclasses import fields
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from experiment_example import full_config

from repro.cnn.image import ImageSettings
from repro.fpga.frames import RADIANS_PER_COUNT
from repro.identify.algorithm1 import SearchSettings
from repro.identify.least_squares import least_squares
from repro.identify.prepare import Prepared
from repro.identify.refinement import RefinementSettings
from repro.pipeline.experiment import true_parameters
from repro.pipeline.experiment_runs import prepare_recording
from repro.pipeline.methods import Identifier
from repro.pipeline.numeric import mean_training_torque
from repro.pipeline.recordings import read_recording
from repro.pipeline.why import STEPS, dissect, explain, tracked_states
from repro.pipeline.why_table import why_table
from repro.settings import data_settings, signal_settings

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
def steps(recording, tau_mean):
    return dissect(recording, tau_mean, CONFIG, "measured")


def error_of(prepared):
    found = least_squares(prepared.y, prepared.tau).beta
    return np.abs(found - TRUE).max()


def test_the_states_are_those_behind_the_recording(recording):
    q, dq, ddq, motors = tracked_states(recording, CONFIG)
    np.testing.assert_array_equal(np.rint(q / RADIANS_PER_COUNT), np.rint(recording.q / RADIANS_PER_COUNT))
    np.testing.assert_allclose(motors, recording.tau, atol=1e-12)
    h = recording.program.h
    moved = np.diff(q, axis=1)
    np.testing.assert_allclose(moved[:, 400:], h * (dq[:, 400:-1] + dq[:, 401:]) / 2, atol=3e-4)
    assert np.corrcoef(np.diff(dq[1]) / h, ddq[1, :-1])[0, 1] > 0.9


def test_every_step_has_one_cause_more(steps):
    """Least squares knows the parameters in the ideal case, but for what the filter takes from Coulomb friction."""
    assert list(steps) == list(STEPS)
    assert error_of(steps["ideal"]) < 5e-3
    assert error_of(steps["beyond"]) > 3 * error_of(steps["ideal"])
    same = np.abs(steps["beyond"].y - steps["ideal"].y).max()
    assert same == 0.0
    assert 0 < np.abs(steps["quantised"].tau - steps["beyond"].tau).max() < 2 * 2.7314 / 1023
    assert np.abs(steps["loop"].q - steps["ideal"].q).max() > 10 * RADIANS_PER_COUNT
    np.testing.assert_array_equal(steps["loop"].tau, steps["recording"].tau)
    np.testing.assert_array_equal(steps["loop"].q, steps["recording"].q)
    assert np.abs(steps["loop"].ddq - steps["recording"].ddq).max() > 0.1


@pytest.mark.parametrize("image_motion", ["measured", "desired"])
def test_the_last_step_is_the_recording_as_it_is_identified(recording, tau_mean, image_motion):
    found = dissect(recording, tau_mean, CONFIG, image_motion)["recording"]
    expected = prepare_recording(recording, tau_mean, SIGNALS, image_motion)
    for field in fields(Prepared):
        np.testing.assert_allclose(getattr(found, field.name), getattr(expected, field.name), atol=1e-9)


def test_f_of_the_image_is_on_the_motion_that_was_sent(recording, tau_mean, steps):
    desired = dissect(recording, tau_mean, CONFIG, "desired")
    np.testing.assert_array_equal(desired["loop"].model, desired["ideal"].model)
    assert np.abs(steps["loop"].model - steps["ideal"].model).max() > 0.1


def test_a_perfect_reader_is_perfect_where_eq_1_holds(monkeypatch, recording, tau_mean):
    def estimate(self, guess):
        self.images += len(guess)
        return np.tile(TRUE / self.largest, (len(guess), 1))

    class Reader:
        def __init__(self, _network, _image, prepared):
            self.images, self.largest = 0, prepared.largest

    Reader.estimate = estimate
    monkeypatch.setattr("repro.pipeline.why.ResidualReader", Reader)
    config = CONFIG | {"why": {"seeds": [1], "guesses": 3, "near": 0.05}}
    search = SearchSettings(executions=2, inner_limit=2)
    identifier = Identifier("published", None, ImageSettings(), search, RefinementSettings())
    table = explain(identifier, recording, tau_mean, [1, 2], config)
    assert len(table) == 2 * len(STEPS)
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
    np.testing.assert_allclose(first["spread1"], np.std([-0.02, 0.0, 0.02]))
    assert set(table["seeds"]) == {3}
    np.testing.assert_allclose(table["error_uniform"], 0.2)
