"""The numbers behind figures and tables: right, and in the form that the drawing asks for."""

import itertools
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import torch
import yaml
from exhibit_examples import EXHIBITS, laid_out
from factorial_example import factorial_references, factorial_scores
from kept import same

from repro.cnn.architecture import NetworkSettings
from repro.cnn.dataset import DataSettings
from repro.cnn.network import SignalCNN
from repro.cnn.priors import sample_beta
from repro.exhibits import catalogue, network_training, numeric_tests, style
from repro.exhibits.declare import make_exhibit
from repro.files import write_csv
from repro.model.dynamics import inverse_dynamics
from repro.pipeline.stored_networks import architecture
from repro.settings import numeric_settings, signal_settings
from repro.signals.programs import PROGRAMS
from repro.signals.trajectories import identification_trajectory
from repro.streams import Stream, stream

ROOT = Path(__file__).resolve().parents[2]
CONFIG = yaml.safe_load((ROOT / "config" / "config.yaml").read_text(encoding="utf-8"))
CONFIG["network"]["hidden"] = [4, 3]
SIGNALS, NUMERIC = signal_settings(CONFIG), numeric_settings(CONFIG)
N = 3770
RECIPES = ("algorithm1", "algorithm1+paper-recipe", "algorithm1+paper-recipe-ranges")
H = 2.5e-3


def test_every_table_and_figure_of_the_paper_is_there_once_in_its_order():
    labels = [exhibit.label for exhibit in catalogue.EXHIBITS if exhibit.label[-1].isdigit()]
    assert labels == [*(f"Table {n}" for n in range(1, 11)), *(f"Figure {n}" for n in range(1, 25))]
    names = [(exhibit.kind, exhibit.name) for exhibit in catalogue.EXHIBITS]
    assert len(set(names)) == len(names)
    assert len({exhibit.target for exhibit in catalogue.EXHIBITS}) == len(names)


@pytest.fixture(scope="module")
def optional(tmp_path_factory):
    """Inputs of the exhibits that the golden run leaves out."""
    folder = tmp_path_factory.mktemp("optional")
    cells = itertools.product(("N1", "N2", "N3", "N4", *PROGRAMS), RECIPES, (1, 2, 3), ("ID", "validation"), (1, 2))
    scores = pd.DataFrame(cells, columns=["case", "method", "seed", "trajectory", "joint"])
    totals = 0.1 * scores["seed"] + 0.3 * (scores["trajectory"] != "ID")
    scores = scores.assign(time=totals, frequency=1.0, total=totals)
    of_arm = scores["case"].isin(PROGRAMS)
    history = {"step": [100, 200], "learning_rate": 0.1, "train_loss": [0.02, 0.01], "test_loss": [0.03, 0.015]}
    frames = {
        "factorial": factorial_scores(),
        "references": factorial_references(),
        "scores": scores[~of_arm],
        "arm": scores[of_arm & (scores["trajectory"] == "ID")],
        "history": pd.DataFrame(history),
    }
    for name, frame in frames.items():
        write_csv(folder / f"{name}.csv", frame)
    files = {name: [folder / f"{name}.csv"] for name in frames}
    factorial = {"scores": files["factorial"], "references": files["references"]}
    recipe = {"scores": files["scores"], "experiment": files["arm"], "histories": 3 * files["history"]}
    return {"factorial": factorial, "factorial_cells": factorial, "paper_recipe": recipe}


@pytest.mark.parametrize(
    ("kind", "name", "rows"),
    [
        ("table", "factorial", 57),
        ("figure", "factorial", 57),
        ("table", "factorial_cells", 72),
        ("table", "paper_recipe", 54),
        ("figure", "paper_recipe", 6),
    ],
)
def test_optional_exhibits_are_computed_and_drawn(optional, tmp_path, file_regression, kind, name, rows):
    exhibit = EXHIBITS[kind, name]
    frame = exhibit.numbers(optional[name], {section: CONFIG[section] for section in exhibit.sections})
    assert len(frame) == rows
    if name == "paper_recipe" and kind == "table":
        assert frame["total"].tolist() == [0.2] * 54  # the median seed on the identification trajectory
    with style.house_style():
        words = laid_out(tmp_path, name, frame) if kind == "table" else (str(exhibit.draw(frame)),)
    kept = "\n".join([frame.to_csv(index=False, float_format="%.5e"), *words])
    file_regression.check(kept, check_fn=same, basename=f"{kind}-{name}")


def test_the_kept_size_of_the_board_is_laid_out_as_kept(tmp_path):
    exhibit, kinds = EXHIBITS["table", "board_size"], ("csv", "tex", "md")
    out = {kind: tmp_path / f"board_size.{kind}" for kind in kinds}
    make_exhibit(exhibit, {"synthesis": [ROOT / "data/board/size.csv"]}, out, {})
    for kind in kinds:
        assert out[kind].read_bytes() == (ROOT / f"docs/reference/tables/board_size.{kind}").read_bytes()
    sizes = pd.read_csv(out["csv"]).set_index(["block", "quantity"])
    tables, flip_flops = sizes.loc["board", "least"][["lut", "flip_flops"]]
    assert sizes.loc["board", :].loc["elements"].tolist() == [max(tables, flip_flops), tables + flip_flops]


def curve(frame, panel, series):
    rows = frame[(frame["panel"] == panel) & (frame["series"] == series)]
    return rows["x"].to_numpy(), rows["y"].to_numpy()


def band(x, k):
    """Coefficient k, from 0, of Eq. 5, summed as printed."""
    n = x.size
    a = np.sqrt(0.5) if k == 0 else 1.0
    return np.sqrt(2 / n) * a * np.sum(x * np.cos(np.pi * k * (2 * np.arange(n) + 1) / (2 * n)))


def test_subsampling_shows_the_torque_its_spectrum_and_what_the_first_bands_keep():
    frame = numeric_tests.subsampling_curves(SIGNALS, NUMERIC.arms["N1"])
    time, x = curve(frame, "signal", "x")
    motion = identification_trajectory()
    np.testing.assert_allclose(time, H * np.arange(N), rtol=1e-12)
    np.testing.assert_allclose(x, inverse_dynamics(motion.q, motion.dq, motion.ddq, NUMERIC.arms["N1"])[0], rtol=1e-12)
    (k, kept), (j, dropped) = curve(frame, "spectrum", "kept"), curve(frame, "spectrum", "dropped")
    np.testing.assert_array_equal(np.concatenate([k, j]), np.arange(N))
    assert k.size == 100
    for number in (0, 1, 7, 99):
        assert kept[number] == pytest.approx(band(x, number), abs=1e-9)
    assert dropped[0] == pytest.approx(band(x, 100), abs=1e-9)
    assert np.sum(kept**2) + np.sum(dropped**2) == pytest.approx(np.sum(x**2), rel=1e-12)
    time_sub, xs = curve(frame, "subsampled", "xs")
    assert xs.size == 100
    # The bands kept hold nearly all of it, so the subsampled torque lies on the torque.
    error = xs - np.interp(time_sub, time, x)
    assert np.sqrt(np.mean(error**2)) < 0.02 * np.sqrt(np.mean(x**2))


def test_example_images_of_right_guesses_are_symmetric_and_those_of_wrong_ones_are_not():
    frame = network_training.example_pixels(SIGNALS, DataSettings(), seed=1)
    assert len(frame) == 2 * 9 * 100 * 100
    asymmetry = {}
    for (kind, name), pixels in frame.groupby(["kind", "image"]):
        colours = pixels.sort_values(["row", "column"])[["red", "green", "blue"]].to_numpy().reshape(100, 100, 3)
        assert colours.min() >= 0.0
        assert colours.max() <= 1.0
        # psi = alpha for a right guess, so both parts of Eq. 9 are symmetric.
        asymmetry[kind, name] = np.abs(colours - colours.transpose(1, 0, 2)).mean()
    assert {kind: len([k for k in asymmetry if k[0] == kind]) for kind in ("Mp", "Mn")} == {"Mp": 9, "Mn": 9}
    right, wrong = ([v for k, v in asymmetry.items() if k[0] == kind] for kind in ("Mp", "Mn"))
    assert max(right) < 0.02
    assert np.median(wrong) > 5 * max(right)


def test_torque_percentiles_are_ordered_fractions_of_the_largest_torque():
    frame = network_training.torque_percentiles(SIGNALS, DataSettings(), seed=1, arms=500)
    motion = identification_trajectory()
    beta = sample_beta(stream(1, Stream.TRAINING_ARMS), 500)
    for j, joint in enumerate(("joint1", "joint2")):
        levels = [curve(frame, joint, f"p{p:02d}")[1] for p in (5, 25, 50, 75, 95)]
        assert all((low <= high).all() for low, high in itertools.pairwise(levels))
        assert max(np.abs(level).max() for level in levels) <= 1.0
        time, mean = curve(frame, joint, "mean")
        assert ((levels[0] <= mean) & (mean <= levels[-1])).all()
        # The same without filter and subsampling, at the nearest full-rate samples.
        pick = np.rint(time / H).astype(int)
        tau = inverse_dynamics(motion.q, motion.dq, motion.ddq, beta)
        tau = (tau / np.abs(tau).max((-2, -1), keepdims=True))[:, j, pick]
        # Friction turns round within a few samples; there the filter and the exact instant matter.
        assert np.median(np.abs(np.median(tau, 0) - levels[2])) < 0.02
        assert np.median(np.abs(tau.mean(0) - mean)) < 0.02


def arrays(net):
    """Weights of a network by name."""
    return {name: weight.numpy() for name, weight in net.state_dict().items()}


def kernel(frame, layer, output, given):
    here = (frame["layer"] == layer) & (frame["output"] == output) & (frame["input"] == given)
    pixels = frame[here].sort_values(["row", "column"])
    side = int(np.sqrt(len(pixels)))
    return pixels["power"].to_numpy().reshape(side, side)


def test_kernel_power_peaks_at_the_frequency_of_the_kernel():
    net = SignalCNN(NetworkSettings(hidden=(4, 3)))
    rows, columns = np.indices((9, 9))
    waves = {
        (0, 0): np.ones((9, 9)),  # zero frequency
        (1, 0): np.cos(2 * np.pi * 3 * columns / 9),  # 3 cycles across
        (2, 1): -5.0 * np.cos(2 * np.pi * (2 * rows + columns) / 9),  # 2 cycles down, 1 across, any level
    }
    with torch.no_grad():
        for (output, given), wave in waves.items():
            net.conv1.weight[output, given] = torch.from_numpy(wave)
    frame = network_training.kernel_spectra(arrays(net))
    peaks = {(0, 0): {(4, 4)}, (1, 0): {(4, 1), (4, 7)}, (2, 1): {(6, 5), (2, 3)}}
    for key, expected in peaks.items():
        power = kernel(frame, "conv1", *key)
        assert {tuple(place) for place in np.argwhere(power > 0.5).tolist()} == expected
        np.testing.assert_allclose([power[place] for place in expected], 1.0, rtol=1e-5)
        assert np.sort(power.ravel())[-len(expected) - 1] < 1e-9


def test_the_architecture_is_that_of_the_paper():
    layers = architecture(NetworkSettings()).set_index("layer")
    assert layers["parameters"].to_dict() == {
        "input": 0,
        "conv1": 9 * 9 * 2 * 10 + 10,
        "pool1": 0,
        "conv2": 5 * 5 * 10 * 10 + 10,
        "pool2": 0,
        "conv3": 3 * 3 * 10 * 10 + 10,
        "fc4": 19 * 19 * 10 * 100 + 100,
        "fc5": 100 * 50 + 50,
        "output": 50 * 9 + 9,
    }
