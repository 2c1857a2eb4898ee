"""Readings of the paper: each changes what it names alone, and the ablation runs end to end on tiny budgets."""

import copy
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

from repro.cnn.architecture import HISTORY_COLUMNS
from repro.config import check_config
from repro.files import read_csv
from repro.model.dynamics import rebuild_torque
from repro.pipeline.experiment import read_recordings, true_parameters
from repro.pipeline.interpretations import (
    HEADLINES,
    VARIANTS,
    ablation_figure,
    ablation_table,
    configuration_of,
    network_files,
)
from repro.pipeline.networks import run_variant, train_variant
from repro.pipeline.stored_networks import configuration_digest
from repro.settings import of_network, signal_settings
from repro.signals.metric import metr2ev

ROOT = Path(__file__).resolve().parents[2]
CONFIG = yaml.safe_load((ROOT / "config/config.yaml").read_text(encoding="utf-8"))
TINY = copy.deepcopy(CONFIG)
TINY["ablation"] = {"seeds": [1]}
TINY["training"] |= {"steps": 3, "batch": 8, "test_samples": 16, "checkpoint_every": 2, "log_every": 1}
TINY["training"] |= {"precision": "float32"}
TINY["training"]["paper"] |= {"images": 10}
for name in ("paper-recipe", "paper-recipe-ranges"):
    TINY["networks"][name]["training"] |= {"steps": 3, "batch": 2}
TINY["algorithm1"] |= {"executions": 5, "inner_limit": 2}
TINY["refinement"] |= {"restarts": 20, "keep": 5, "passes": 2}
CAPTURES = [ROOT / f"data/captures/{name}.{ext}" for name in ("ID", "T1", "T2", "T3", "T4") for ext in ("bin", "json")]


@pytest.mark.slow
@pytest.mark.parametrize("name", VARIANTS)
def test_a_reading_is_a_valid_configuration_that_differs_in_what_it_names(name):
    reading = VARIANTS[name]
    changed = configuration_of(CONFIG, reading)
    whole = {**changed, "refinement": CONFIG["refinement"]}  # as it is run
    check_config(whole)
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


@pytest.mark.parametrize("name", [name for name, reading in VARIANTS.items() if reading.of])
def test_a_reading_without_a_network_of_its_own_would_train_the_one_it_takes(name):
    own, taken = (configuration_of(CONFIG, VARIANTS[which]) for which in (name, VARIANTS[name].of))
    assert configuration_digest(own) == configuration_digest(taken)


@pytest.mark.parametrize("name", [name for name in VARIANTS if network_files(name)[0].startswith("model/")])
def test_a_reading_that_takes_a_network_of_the_tables_would_train_the_same(name):
    weights, history = network_files(name)
    suffix = weights.removeprefix("model/cnn").removesuffix(".safetensors")
    assert history == f"model/training{suffix}.csv"
    own = of_network(CONFIG, suffix.removeprefix("-") or "published")
    assert configuration_digest(configuration_of(CONFIG, VARIANTS[name])) == configuration_digest(own)


def true_on_validation():
    """Mean total of the true parameters on T1 to T4."""
    true, signals = true_parameters(CONFIG), signal_settings(CONFIG)
    regressions = [recording.regression(signals) for recording in read_recordings(CAPTURES, CONFIG)[1:]]
    return np.mean([metr2ev(r.tau, rebuild_torque(r.y, true)).total for r in regressions])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["label-physical", "recipe-paper", "recipe-ranges"])
def test_a_reading_is_trained_and_scored(name, tmp_path):
    weights, history, checkpoint = (tmp_path / part for part in ("w.safetensors", "h.csv", "c.safetensors"))
    train_variant(name, weights, history, Path(), str(checkpoint), TINY)
    table, result = read_csv(history, HISTORY_COLUMNS), run_variant(name, weights, CAPTURES, TINY)
    assert table["step"].iloc[-1] == 3
    assert all(0 <= result[key] <= 1 for key in (*HEADLINES, "id_lowest"))
    assert result["arm_true"] == pytest.approx(true_on_validation())  # of the stored captures, whatever the network
    assert not checkpoint.exists()


def test_the_table_has_each_readings_last_held_out_loss():
    numbers = dict.fromkeys(("id_mean", "id_lowest", "validation_mean", *HEADLINES), 0.5)
    rows = [[(1, 0.01, 7.0, 8.0), (k, 0.01, 9.0, k / 10)] for k in range(2, len(VARIANTS) + 2)]
    histories = [pd.DataFrame(row, columns=list(HISTORY_COLUMNS)) for row in rows]
    table = ablation_table([numbers] * len(VARIANTS), histories)
    assert table["reading"].tolist() == [reading.name for reading in VARIANTS.values()]
    assert table["steps"].tolist() == list(range(2, len(VARIANTS) + 2))
    assert table["held_out_loss"].tolist() == [k / 10 for k in table["steps"]]  # not the loss of the training
    figure = ablation_figure(table)
    assert len(figure) == len(VARIANTS) * len(HEADLINES)
    assert set(figure["quantity"]) == set(HEADLINES)
