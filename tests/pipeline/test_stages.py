"""The stages on disk: what they write, and that bad input ends in one line with nothing left behind."""

import json
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from scripts_run import run_script

from repro.errors import InputError
from repro.exhibits import catalogue
from repro.exhibits.make import make_exhibit
from repro.pipeline.stored_networks import configuration_digest
from repro.settings import numeric_settings

ROOT = Path(__file__).resolve().parents[2]
EXHIBITS = {e.name: e for e in (*catalogue.TABLES, *catalogue.FIGURES)}  # a figure where both have the name
CONFIG = yaml.safe_load((ROOT / "config" / "config.yaml").read_text(encoding="utf-8"))
CONFIG["network"]["hidden"] = [4, 3]
CONFIG["training"] |= {"steps": 2, "batch": 4, "test_samples": 4, "log_every": 1, "checkpoint_every": 1}
CONFIG["algorithm1"] |= {"executions": 3, "inner_limit": 2, "threshold_numeric": 0.2}
CONFIG["refinement"] |= {"restarts": 4, "passes": 1}
CONFIG["numeric"]["seeds"] = [1]
SCORE_COLUMNS = ["case", "method", "seed", "trajectory", "joint", "time", "frequency", "total"]


def run_all(folder):
    """Every stage up to the scores; the paths of what they wrote."""
    out = {
        "mean_torque": folder / "mean_torque.csv",
        "weights": folder / "cnn.safetensors",
        "history": folder / "training.csv",
        "card": folder / "model-card.md",
        "identification": folder / "numeric-seed1.json",
        "scores": folder / "numeric.csv",
    }
    run_script("mean_torque", {}, {"csv": out["mean_torque"]}, folder, config=CONFIG)
    trained = {name: out[name] for name in ("weights", "history", "card")}
    checkpoint = str(folder / ".checkpoint.safetensors")
    run_script("train", {}, trained, folder, {"suffix": ""}, checkpoint=checkpoint, config=CONFIG)
    identify(out["weights"], out["mean_torque"], out["identification"])
    score(out["identification"], out["scores"])
    return out


def identify(weights, mean_torque, output, config=CONFIG):
    inputs = {"weights": weights, "mean_torque": mean_torque}
    told = {"trained_as": configuration_digest(config), "seeds": [1], "config": config}
    run_script("identify_numeric", inputs, {"json": output}, output.parent, {"suffix": ""}, **told)


def score(identification, output):
    run_script("score_numeric", {"runs": identification}, {"csv": output}, output.parent, config=CONFIG)


@pytest.fixture(scope="module")
def original(tmp_path_factory):
    folder = tmp_path_factory.mktemp("stages")
    run_all(folder)
    return folder


@pytest.fixture
def results(original, tmp_path):
    """A copy that a test may damage."""
    folder = tmp_path / "results"
    shutil.copytree(original, folder)
    return folder


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def refused(call, folder):
    """Message of the one line that `call` ends in, after checking that it left `folder` as it was."""
    before = contents(folder)
    with pytest.raises(InputError) as error:
        call()
    message = str(error.value)
    assert len(message.splitlines()) == 1
    assert ": found " in message
    assert ", expected " in message
    assert contents(folder) == before
    return message


@pytest.mark.slow
def test_the_stages_leave_their_outputs_and_nothing_else(original):
    names = {"mean_torque.csv", "cnn.safetensors", "training.csv", "model-card.md", "numeric-seed1.json", "numeric.csv"}
    assert set(contents(original)) == names
    torque = pd.read_csv(original / "mean_torque.csv")
    assert list(torque.columns) == ["time", "joint1", "joint2"]
    assert len(torque) == 3770
    history = pd.read_csv(original / "training.csv")
    assert history["step"].tolist() == [1, 2]
    run = json.loads((original / "numeric-seed1.json").read_text(encoding="utf-8"))
    assert list(run["arms"]) == list(numeric_settings(CONFIG).arms)
    scores = pd.read_csv(original / "numeric.csv")
    assert list(scores.columns) == SCORE_COLUMNS
    assert len(scores) == 4 * 4 * 2 * 2  # arms, methods, trajectories, joints
    np.testing.assert_allclose(scores["total"], scores["time"] * scores["frequency"], atol=1e-9)


def test_a_second_run_gives_the_same_bytes(original, tmp_path):
    run_all(tmp_path)
    first, second = contents(original), contents(tmp_path)
    assert first.keys() == second.keys()
    assert [name for name in first if first[name] != second[name] and name != "model-card.md"] == []


def edit(path, old, new, count=1):
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, count), encoding="utf-8")


def set_cell(path, line, column, value):
    """Replace one cell of a CSV; lines count from 1, the header."""
    lines = path.read_text(encoding="utf-8").splitlines()
    cells = lines[line - 1].split(",")
    cells[lines[0].split(",").index(column)] = value
    lines[line - 1] = ",".join(cells)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


@pytest.mark.parametrize("value", ["inf", "twelve"])
def test_a_mean_torque_that_is_not_finite_is_refused_where_it_stands(results, value):
    path = results / "mean_torque.csv"
    set_cell(path, 5, "joint2", value)
    message = refused(lambda: identify(results / "cnn.safetensors", path, results / "out.json"), results)
    assert message.startswith(f"{path}: line 5: joint2: ")


@pytest.mark.parametrize("rows", [-1, -2000, 1], ids=["one short", "half", "one long"])
def test_a_mean_torque_of_another_length_is_refused(results, rows):
    path = results / "mean_torque.csv"
    lines = path.read_text(encoding="utf-8").splitlines()
    lines = lines[:rows] if rows < 0 else [*lines, lines[-1]]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    message = refused(lambda: identify(results / "cnn.safetensors", path, results / "out.json"), results)
    assert message.startswith(str(path))
    assert "3770" in message


def test_weights_of_another_network_are_refused_by_the_layer_that_differs(results):
    other = {**CONFIG, "network": {**CONFIG["network"], "hidden": [5, 3]}}
    path = results / "cnn.safetensors"
    message = refused(lambda: identify(path, results / "mean_torque.csv", results / "out.json", other), results)
    assert message.startswith(f"{path}: fc4.")


def test_weights_of_another_training_are_refused(results):
    other = {**CONFIG, "training": {**CONFIG["training"], "seed": 2}}
    path = results / "cnn.safetensors"
    message = refused(lambda: identify(path, results / "mean_torque.csv", results / "out.json", other), results)
    digests = (configuration_digest(config) for config in (CONFIG, other))
    assert message == "{}: header: found {}, expected {}, of the network asked for".format(path, *digests)


def test_weights_that_are_not_finite_are_refused(results):
    path = results / "cnn.safetensors"
    data = path.read_bytes()
    path.write_bytes(data[:-4] + np.float32(np.nan).tobytes())
    message = refused(lambda: identify(path, results / "mean_torque.csv", results / "out.json"), results)
    assert message.startswith(str(path))
    assert "finite" in message


def drop(*keys):
    """Damage that deletes one field of an identification."""

    def damage(path):
        run = json.loads(path.read_text(encoding="utf-8"))
        node = run
        for key in keys[:-1]:
            node = node[key]
        del node[keys[-1]]
        path.write_text(json.dumps(run), encoding="utf-8")

    return damage


def short_beta(path):
    run = json.loads(path.read_text(encoding="utf-8"))
    run["arms"]["N2"]["methods"]["algorithm1"]["beta"].pop()
    path.write_text(json.dumps(run), encoding="utf-8")


DAMAGED_JSON = {
    "cut short": lambda path: path.write_bytes(path.read_bytes()[:-50]),
    "a list": lambda path: path.write_text("[1, 2]", encoding="utf-8"),
    "no seed": drop("seed"),
    "no arms": drop("arms"),
    "an arm without its truth": drop("arms", "N2", "true"),
    "an arm without methods": drop("arms", "N2", "methods"),
    "eight parameters": short_beta,
}


@pytest.mark.parametrize("damage", DAMAGED_JSON.values(), ids=DAMAGED_JSON)
def test_a_damaged_identification_is_refused(results, damage):
    path = results / "numeric-seed1.json"
    damage(path)
    message = refused(lambda: score(path, results / "out.csv"), results)
    assert message.startswith(str(path))


def make_table06(folder):
    outputs = {e: folder / f"table06.{e}" for e in ("csv", "tex", "md")}
    make_exhibit(EXHIBITS["table06"], {"scores": [folder / "numeric.csv"]}, outputs, {})


@pytest.mark.parametrize("column", ["time", "frequency", "total"])
@pytest.mark.parametrize("value", ["1.2", "nan", "high"])
def test_a_score_that_is_no_fraction_of_one_is_refused_where_it_stands(results, column, value):
    path = results / "numeric.csv"
    set_cell(path, 4, column, value)
    message = refused(lambda: make_table06(results), results)
    assert message.startswith(f"{path}: line 4: {column}: ")
