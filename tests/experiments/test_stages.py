"""Files that stages hand on: bad input ends in one line that names the place."""

import json
import shutil
from pathlib import Path

import pytest
from experiment_example import full_config, refused

from repro.experiments import identifications
from repro.files import write_csv, write_json

CONFIG = full_config()
SIGNALS, ARMS = CONFIG.signals, dict(CONFIG.numeric.arms)


@pytest.fixture(scope="module")
def original(tmp_path_factory):
    folder = tmp_path_factory.mktemp("stages")
    write_csv(folder / "mean_torque.csv", identifications.mean_torque(CONFIG))
    arms = {name: {"true": beta, "methods": {"algorithm1": {"beta": beta}}} for name, beta in ARMS.items()}
    run = {"seed": 1, "variant": "published", "arms": arms}
    write_json(folder / "numeric-seed1.json", run)
    write_csv(folder / "numeric.csv", identifications.score_estimates([run], CONFIG, CONFIG.metric))
    return folder


@pytest.fixture
def results(original, tmp_path):
    """A copy that a test may damage."""
    return Path(shutil.copytree(original, tmp_path / "results"))


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
    assert refused(identifications.read_mean_torque, path, SIGNALS).place == f"{path}: line 5: joint2"


@pytest.mark.parametrize("rows", [-1, 1], ids=["one short", "one long"])
def test_a_mean_torque_of_another_length_is_refused(results, rows):
    path = results / "mean_torque.csv"
    lines = path.read_text(encoding="utf-8").splitlines()
    lines = lines[:rows] if rows < 0 else [*lines, lines[-1]]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    error = refused(identifications.read_mean_torque, path, SIGNALS)
    assert error.place.startswith(str(path)) and "3770" in error.expected


def edited(change):
    """Damage that changes the content of an identification."""

    def damage(path):
        run = json.loads(path.read_text(encoding="utf-8"))
        change(run)
        path.write_text(json.dumps(run), encoding="utf-8")

    return damage


DAMAGED_JSON = {
    "cut short": lambda path: path.write_bytes(path.read_bytes()[:-50]),
    "a list": lambda path: path.write_text("[1, 2]", encoding="utf-8"),
    "no seed": edited(lambda run: run.pop("seed")),
    "no arms": edited(lambda run: run.pop("arms")),
    "an arm without its truth": edited(lambda run: run["arms"]["N2"].pop("true")),
    "an arm without methods": edited(lambda run: run["arms"]["N2"].pop("methods")),
    "eight parameters": edited(lambda run: run["arms"]["N2"]["methods"]["algorithm1"]["beta"].pop()),
}


@pytest.mark.parametrize("damage", DAMAGED_JSON.values(), ids=DAMAGED_JSON)
def test_a_damaged_identification_is_refused(results, damage):
    path = results / "numeric-seed1.json"
    damage(path)
    assert refused(identifications.read_identifications, [path]).place.startswith(str(path))


@pytest.mark.parametrize("column", ["time", "frequency", "total"])
@pytest.mark.parametrize("value", ["1.2", "nan", "high"])
def test_a_score_that_is_no_fraction_of_one_is_refused_where_it_stands(results, column, value):
    path = results / "numeric.csv"
    set_cell(path, 4, column, value)
    assert refused(identifications.read_scores, [path]).place == f"{path}: line 4: {column}"
