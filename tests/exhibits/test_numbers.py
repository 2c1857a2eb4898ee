"""The numbers behind figures and tables: right, and in the form that the drawing asks for."""

import itertools
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import torch
import yaml
from experiment_example import experiment_inputs, short_config

from repro.cnn.architecture import NetworkSettings
from repro.cnn.dataset import DataSettings
from repro.cnn.network import FactoredCNN, SignalCNN, save_network
from repro.cnn.priors import sample_beta
from repro.exhibits import catalogue, network_training, numeric_tests, style, variants
from repro.files import read_csv, write_csv, write_json
from repro.model.dynamics import inverse_dynamics
from repro.paper.metric_search import RandomMotion, band_number_motion, compare_motions, rank_candidates, score_motions
from repro.pipeline.model_card import architecture
from repro.pipeline.numeric import score_estimates, validation_motion
from repro.pipeline.variants import VARIANTS
from repro.settings import metric_settings, numeric_settings, signal_settings
from repro.signals.trajectories import identification_trajectory
from repro.streams import Stream, stream

ROOT = Path(__file__).resolve().parents[2]
CONFIG = yaml.safe_load((ROOT / "config" / "config.yaml").read_text(encoding="utf-8"))
CONFIG["network"]["hidden"] = [4, 3]
EXPERIMENT = short_config()
SIGNALS, NUMERIC = signal_settings(CONFIG), numeric_settings(CONFIG)
N = 3770
H = 2.5e-3

#: What the estimate of each seed is to the true parameters; seed 3 is the median.
ERROR = {1: 0.5, 2: 0.99, 3: 0.9}
MEDIAN = 3


def identification(seed, suffix=""):
    arms = {}
    for name, beta in NUMERIC.arms.items():
        estimate = (ERROR[seed] * beta).tolist()
        methods = {f"algorithm1{suffix}": estimate}
        if not suffix:
            methods["algorithm1+refinement"] = beta.tolist()
        arms[name] = {"true": beta.tolist(), "methods": {m: {"beta": b} for m, b in methods.items()}}
    return {"seed": seed, "variant": suffix, "arms": arms}


RUNS = [identification(seed) for seed in ERROR]


@pytest.fixture(scope="module")
def scores():
    return score_estimates(RUNS, SIGNALS, NUMERIC, metric_settings(CONFIG))


@pytest.fixture(scope="module")
def inputs(tmp_path_factory, scores):
    """Every input that a figure or a table may ask for, as the stages before would leave it."""
    folder = tmp_path_factory.mktemp("results")
    runs = [*RUNS, *(identification(seed, "+tracked") for seed in ERROR)]
    for k, run in enumerate(runs):
        write_json(folder / f"run{k}.json", run)
    tracked = score_estimates(runs[3:], SIGNALS, NUMERIC, metric_settings(CONFIG))
    write_csv(folder / "numeric.csv", scores)
    write_csv(folder / "tracked.csv", tracked)
    history = pd.DataFrame(
        {"step": [100, 200], "learning_rate": 0.1, "train_loss": [0.02, 0.01], "test_loss": [0.03, 0.015]}
    )
    write_csv(folder / "training.csv", history)
    torch.manual_seed(0)
    save_network(folder / "cnn.safetensors", FactoredCNN(NetworkSettings(hidden=(4, 3))), {})
    searched = score_motions(0, repeats=1, motions=(RandomMotion(3770, 10.0), band_number_motion(2000)))
    write_csv(folder / "search.csv", rank_candidates(searched))
    write_csv(folder / "motions.csv", compare_motions(searched))
    files = sorted(folder.glob("run*.json"))
    numbers = {"id_mean": 0.97, "id_lowest": 0.96, "validation_mean": 0.98}
    numbers |= {"arm_id": 0.5, "arm_validation": 0.4, "arm_refined": 0.94, "arm_least_squares": 0.93, "arm_true": 0.95}
    paper = pd.concat([scores.assign(method="algorithm1+paper-recipe", total=0.5), scores.assign(method="other")])
    write_csv(folder / "paper.csv", paper)
    arm = scores.query("trajectory == 'ID' and case == 'N1'").drop(columns="trajectory")
    write_csv(folder / "arm.csv", pd.concat([arm.assign(case=case) for case in ("ID", "T1", "T2", "T3", "T4")]))
    write_csv(folder / "later.csv", history.assign(step=history["step"] * 100, test_loss=history["test_loss"] * 2))
    for name in VARIANTS:
        write_json(folder / "results" / f"{name}.json", numbers)
    results, losses = sorted((folder / "results").glob("*.json")), [folder / "training.csv"] * len(VARIANTS)
    write_csv(folder / "ablation.csv", variants.readings_table.numbers({"results": results, "losses": losses}, CONFIG))
    shared = {
        "history": [folder / "training.csv"],
        "weights": [folder / "cnn.safetensors"],
        "search": [folder / "search.csv"],
        "motions": [folder / "motions.csv"],
        "results": results,
        "losses": losses,
        "table": [folder / "ablation.csv"],
        "experiment": [folder / "arm.csv"],
        "histories": [folder / "training.csv", folder / "later.csv"],
    }
    figures = {"identifications": files[:3], "scores": [folder / "numeric.csv"], **shared}
    tables = {"identifications": files, "scores": [folder / "numeric.csv", folder / "tracked.csv"], **shared}
    return {"figures": figures, "tables": tables}


#: Other kernels and another order of sums move what is computed, and what a hundred thousand rows sum up, by less.
COMPUTED = {"rtol": 1e-6, "atol": 1e-9}


def some_of(frame):
    """A few rows of each curve of a long table, with the number of its rows; the whole of a short one."""
    frame = frame.reset_index(drop=True)
    if len(frame) > 120:
        text = [column for column in frame if not pd.api.types.is_numeric_dtype(frame[column])]
        groups = frame.groupby(text, sort=False) if text else [((), frame)]
        n = {key: len(rows) for key, rows in groups}
        places = [rows.index[[0, int(0.37 * (n[key] - 1)), int(0.71 * (n[key] - 1)), -1]] for key, rows in groups]
        frame = frame.loc[np.concatenate(places)].assign(rows=np.repeat(list(n.values()), 4))
        frame = frame.iloc[:: -(-len(frame) // 400)]
    return frame.reset_index(drop=True)


def through_csv(frame, folder):
    write_csv(folder / "frame.csv", frame)
    return read_csv(folder / "frame.csv")


@pytest.fixture(scope="module")
def experiment(tmp_path_factory):
    """Inputs of the experiment's outputs, by name."""
    return experiment_inputs(tmp_path_factory.mktemp("experiment"), EXPERIMENT)


@pytest.mark.slow
@pytest.mark.parametrize("exhibit", catalogue.EXHIBITS, ids=lambda each: each.target)
def test_each_exhibit_shows_the_numbers_of_its_inputs_and_of_its_sections(
    inputs, experiment, tmp_path, dataframe_regression, exhibit
):
    whole = EXPERIMENT if exhibit.name in experiment else CONFIG
    given = experiment.get(exhibit.name, inputs[f"{exhibit.kind}s"])
    frame = exhibit.numbers(given, {section: whole[section] for section in exhibit.sections})
    dataframe_regression.check(some_of(frame), f"{exhibit.kind}-{exhibit.name}", default_tolerance=COMPUTED)
    with style.house_style():
        shown = exhibit.draw(through_csv(frame, tmp_path))
    assert "\\toprule" in shown.tex("") if exhibit.kind == "table" else shown.axes or shown.subfigs


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


def test_trajectory_is_eq_10_and_its_derivatives():
    frame = numeric_tests.motion_curves(identification_trajectory())
    for joint in ("joint1", "joint2"):
        t, q = curve(frame, "position", joint)
        expected = {
            "joint1": np.sin(t) + 0.1 * np.cos(2.5 * t + 3),
            "joint2": -np.cos(t) - 0.1 * np.sin(2.5 * t + 3),
        }
        np.testing.assert_allclose(q, expected[joint], atol=1e-12)
        velocity, acceleration = curve(frame, "velocity", joint)[1], curve(frame, "acceleration", joint)[1]
        np.testing.assert_allclose(velocity[1:-1], (q[2:] - q[:-2]) / (2 * H), atol=1e-5)
        np.testing.assert_allclose(acceleration[1:-1], (velocity[2:] - velocity[:-2]) / (2 * H), atol=1e-4)


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


def test_example_images_depend_on_the_seed_alone():
    one, again, other = (network_training.example_pixels(SIGNALS, DataSettings(), seed, count=1) for seed in (1, 1, 2))
    pd.testing.assert_frame_equal(one, again)
    assert not one.equals(other)


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


CASES = ("N1", "N2", "N3", "N4")


def test_a_cosine_of_one_hertz_shows_at_one_hertz():
    """The frequency axis: a DCT-II band k is k half periods over the signal."""
    duration = N * H
    k = round(2 * 1.0 * duration)
    assert k / (2 * duration) == pytest.approx(1.0, abs=0.03)
    x = np.cos(np.pi * k * (np.arange(N) + 0.5) / N)
    assert np.argmax([abs(band(x, j)) for j in range(60)]) == k


def test_the_validation_trajectory_drawn_is_that_of_the_seed_that_stands_for_n1(inputs):
    frame = numeric_tests.fig16.numbers(inputs["figures"], CONFIG)
    motion = validation_motion(SIGNALS, NUMERIC, MEDIAN)
    for j in (0, 1):
        np.testing.assert_allclose(curve(frame, "position", f"joint{j + 1}")[1], motion.q[j], rtol=1e-12)
        np.testing.assert_allclose(curve(frame, "acceleration", f"joint{j + 1}")[1], motion.ddq[j], rtol=1e-12)


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
    sides = {"input": 100, "conv1": 92, "pool1": 46, "conv2": 42, "pool2": 21, "conv3": 19}
    assert {name: layers["height"][name] for name in sides} == sides
    assert (layers["height"] == layers["width"]).all()
    assert layers["kernel"]["conv1"] == "9x9x2x10"
