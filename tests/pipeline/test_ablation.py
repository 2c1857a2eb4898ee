"""Readings of the paper: each changes what it names alone, and the ablation runs end to end on tiny budgets."""

import copy
from pathlib import Path

import pytest
import yaml

from repro.cnn.schedule import HISTORY_COLUMNS
from repro.cnn.train import train
from repro.config import check_config
from repro.files import read_json
from repro.pipeline.ablation import run_reading, train_reading
from repro.pipeline.readings import HEADLINES, READINGS, ablation_figure, ablation_table, read_as
from repro.pipeline.stored_networks import configuration_digest
from repro.pipeline.tracked import training_motion
from repro.settings import data_settings, network_settings, of_network, training_settings

ROOT = Path(__file__).resolve().parents[2]
CONFIG = yaml.safe_load((ROOT / "config/config.yaml").read_text(encoding="utf-8"))
TINY = copy.deepcopy(CONFIG)
TINY["ablation"] = {"seeds": [1]}
TINY["training"] |= {"steps": 3, "batch": 8, "test_samples": 16, "checkpoint_every": 2, "log_every": 1}
TINY["training"] |= {"precision": "float32"}
TINY["training"]["paper"] |= {"images": 10}
TINY["networks"]["paper-recipe"]["training"] |= {"steps": 3, "batch": 2}
TINY["networks"]["scale-aware"]["training"] |= {"steps": 3}
TINY["algorithm1"] |= {"executions": 5, "inner_limit": 2}
TINY["refinement"] |= {"restarts": 20, "keep": 5, "passes": 2}
CAPTURES = [
    str(ROOT / f"data/captures/{name}.{ext}") for name in ("ID", "T1", "T2", "T3", "T4") for ext in ("bin", "json")
]


@pytest.mark.slow
@pytest.mark.parametrize("name", READINGS)
def test_a_reading_is_a_valid_configuration_that_differs_in_what_it_names(name):
    reading = READINGS[name]
    changed = read_as(CONFIG, reading)
    whole = {**changed, "refinement": CONFIG["refinement"]}  # as it is run
    check_config(whole, ROOT / "workflow/schemas/config.schema.yaml")
    of_its_network = of_network(CONFIG, reading.network)
    for section, values in of_its_network.items():
        named = reading.change.get(section, {})
        for key, value in values.items() if isinstance(values, dict) else ():
            if (section, key) == ("training", "steps"):
                continue
            expected = {**value, **named[key]} if isinstance(named.get(key), dict) else named.get(key, value)
            assert changed[section][key] == expected
            assert key not in named or expected != value  # a reading that changes nothing is none
    assert changed["training"]["steps"] == reading.longer * of_its_network["training"]["steps"]


@pytest.mark.parametrize("name", [name for name, reading in READINGS.items() if not reading.trained])
def test_a_reading_without_a_network_of_its_own_would_train_the_one_it_takes(name):
    own, taken = (read_as(CONFIG, READINGS[which]) for which in (name, READINGS[name].of))
    assert configuration_digest(own) == configuration_digest(taken)


def test_every_open_question_of_the_notes_has_a_reading():
    questions = {reading.question for reading in READINGS.values()}
    for word in ("omega", "motion", "ranges", "label", "time factor", "physically", "recipe", "L_exe"):
        assert any(word in question for question in questions), word


@pytest.mark.slow
@pytest.mark.parametrize("name", ["label-physical", "recipe-paper"])
def test_a_reading_is_trained_and_scored(name, tmp_path):
    weights = tmp_path / f"{name}.safetensors"
    train_reading(name, str(weights), "", str(tmp_path / "checkpoint.safetensors"), TINY)
    run_reading(name, str(weights), CAPTURES, str(tmp_path / "out.json"), TINY)
    loss, result = read_json(weights.with_suffix(".json")), read_json(tmp_path / "out.json")
    assert loss["steps"] == 3
    c = read_as(TINY, READINGS[name])
    again = train(training_motion(c), data_settings(c), network_settings(c), training_settings(c))
    assert loss["held_out_loss"] == pytest.approx(again.history[-1, HISTORY_COLUMNS.index("test_loss")], rel=1e-5)
    assert all(0 <= result[key] <= 1 for key in (*HEADLINES, "id_lowest"))
    assert result["arm_true"] == pytest.approx(0.9475, abs=2e-4)  # of the stored captures, whatever the network
    assert not (tmp_path / "checkpoint.safetensors").exists()


def test_a_reading_without_a_network_shows_the_default_ones_loss():
    numbers = dict.fromkeys(("id_mean", "id_lowest", "validation_mean", *HEADLINES), 0.5)
    losses = {name: {"steps": k, "held_out_loss": k / 10} for k, name in enumerate(READINGS, start=1)}
    table = ablation_table(dict.fromkeys(READINGS, numbers), losses)
    assert len(table) == len(READINGS)
    by_name = dict(zip(READINGS, table["steps"], strict=True))
    assert by_name["limit-20"] == by_name["default"] == 1
    assert by_name["omega-index"] == losses["omega-index"]["steps"]
    figure = ablation_figure(table)
    assert len(figure) == len(READINGS) * len(HEADLINES)
    assert set(figure["quantity"]) == set(HEADLINES)
