"""The numbers behind figures and tables: right, and in the form that the drawing asks for."""

import itertools

import numpy as np
import pandas as pd
import pytest
import torch
from exhibit_examples import EXHIBITS, RECIPES, laid_out
from experiment_example import ROOT, changed, full_config
from factorial_example import factorial_references, factorial_scores
from kept import same

from repro.cnn.architecture import NetworkSettings
from repro.cnn.network import FactoredCNN
from repro.config.sections import job_configuration, stated
from repro.drawing import style
from repro.exhibits import catalogue, network_training
from repro.exhibits.arm_experiment import stability_table
from repro.exhibits.declare import make_exhibit
from repro.experiments.arm import true_parameters
from repro.files import write_csv
from repro.signals.programs import PROGRAMS

CONFIG = changed(full_config(), network={"hidden": (4, 3)})


def test_every_table_and_figure_of_the_paper_is_there_once_in_its_order():
    labels = [exhibit.label for exhibit in catalogue.EXHIBITS if exhibit.label[-1].isdigit()]
    assert labels == [*(f"Table {n}" for n in range(1, 11)), *(f"Figure {n}" for n in range(1, 25))]
    names = [(exhibit.kind, exhibit.name) for exhibit in catalogue.EXHIBITS]
    assert len(set(names)) == len({exhibit.target for exhibit in catalogue.EXHIBITS}) == len(names)


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
        ("table", "factorial", 26), ("figure", "factorial", 26), ("table", "factorial_cells", 18),
        ("table", "paper_recipe", 54), ("figure", "paper_recipe", 6),
    ],
)  # fmt: skip
def test_optional_exhibits_are_computed_and_drawn(optional, tmp_path, file_regression, kind, name, rows):
    exhibit = EXHIBITS[kind, name]
    frame = exhibit.numbers(optional[name], job_configuration(stated(CONFIG, *exhibit.sections), 1))
    assert len(frame) == rows
    if name == "paper_recipe" and kind == "table":
        assert frame["total"].tolist() == [0.2] * 54  # the median seed on the identification trajectory
    with style.house_style():
        words = laid_out(tmp_path, name, frame) if kind == "table" else (str(exhibit.draw(frame)),)
    kept = "\n".join([frame.to_csv(index=False, float_format="%.5e"), *words])
    file_regression.check(kept, check_fn=same, basename=f"{kind}-{name}")


def test_the_kept_synthesis_gives_the_kept_size_of_the_board(tmp_path):
    out = {kind: tmp_path / f"board_size.{kind}" for kind in ("csv", "tex", "md")}
    make_exhibit(EXHIBITS["table", "board_size"], {"synthesis": [ROOT / "data/board/size.csv"]}, out, {})
    assert out["csv"].read_bytes() == (ROOT / "docs/reference/tables/board_size.csv").read_bytes()
    sizes = pd.read_csv(out["csv"]).set_index(["block", "quantity"])
    tables, flip_flops = sizes.loc["board", "least"][["lut", "flip_flops"]]
    assert sizes.loc["board", :].loc["elements"].tolist() == [max(tables, flip_flops), tables + flip_flops]


def test_the_stability_table_names_a_condition_that_does_not_hold():
    slack = np.where(np.arange(9) < 5, true_parameters(CONFIG), 1e-9)
    table = stability_table({"true": slack}, ["true"]).set_index("quantity")
    assert not table["holds"]["Dissipation (Eq. 18)"]


def test_kernel_power_peaks_at_the_frequency_of_the_kernel():
    net = FactoredCNN(NetworkSettings(hidden=(4, 3)))
    rows, columns = np.indices((9, 9))
    waves = {
        (0, 0): np.ones((9, 9)),  # zero frequency
        (1, 0): np.cos(2 * np.pi * 3 * columns / 9),  # 3 cycles across
        (2, 1): -5.0 * np.cos(2 * np.pi * (2 * rows + columns) / 9),  # 2 cycles down, 1 across, any level
    }
    with torch.no_grad():
        for (output, given), wave in waves.items():
            net.conv1.weight[output, given] = torch.from_numpy(wave)
    weights = {name: weight.numpy() for name, weight in net.state_dict().items()}
    kernels = network_training.kernel_spectra(weights).groupby(["layer", "output", "input"])
    peaks = {(0, 0): {(4, 4)}, (1, 0): {(4, 1), (4, 7)}, (2, 1): {(6, 5), (2, 3)}}
    for key, expected in peaks.items():
        power = kernels.get_group(("conv1", *key)).pivot(index="row", columns="column", values="power").to_numpy()
        assert {tuple(place) for place in np.argwhere(power > 0.5).tolist()} == expected
        np.testing.assert_allclose([power[place] for place in expected], 1.0, rtol=1e-5)
        assert np.sort(power.ravel())[-len(expected) - 1] < 1e-9
