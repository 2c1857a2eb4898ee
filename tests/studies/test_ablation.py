"""Interpretations of the paper: each changes only what it names, and the ablation runs end to end on tiny budgets."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from experiment_example import CAPTURES, MOTIONS, changed, full_config

from repro.cnn.architecture import HISTORY_COLUMNS
from repro.config.check import check_config
from repro.config.sections import of_network, plain
from repro.experiments.arm import read_recordings, true_parameters
from repro.experiments.stored_networks import configuration_digest
from repro.files import read_csv
from repro.model.dynamics import rebuild_torque
from repro.signals.metric import metr2ev
from repro_studies import interpretations
from repro_studies.ablation import run_variant, train_variant
from repro_studies.interpretations import HEADLINES, INTERPRETATIONS, configuration_of, network_files

CONFIG = full_config()
TINY = changed(
    CONFIG,
    ablation={"seeds": [1]},
    training={"steps": 3, "batch": 8, "test_samples": 16, "paper": {"images": 10}}
    | {"checkpoint_every": 2, "log_every": 1, "precision": "float32"},
    networks={"paper-recipe-ranges": {"training": {"steps": 3, "batch": 2}}},
    algorithm1={"executions": 5, "inner_limit": 2},
    refinement={"restarts": 20, "keep": 5, "passes": 2},
)


@pytest.mark.slow
@pytest.mark.parametrize("name", INTERPRETATIONS)
def test_an_interpretation_is_a_valid_configuration_that_differs_in_what_it_names(name):
    interpretation = INTERPRETATIONS[name]
    found, own = configuration_of(CONFIG, interpretation), of_network(CONFIG, interpretation.network)
    check_config(plain(found.model_copy(update={"refinement": CONFIG.refinement})))  # as it is run
    assert changed(found, **interpretation.change) == found
    before = {
        section: {key: getattr(getattr(own, section), key) for key in keys}
        for section, keys in interpretation.change.items()
    }
    for section, values in before.items():
        assert all(getattr(getattr(found, section), key) != value for key, value in values.items())
    assert found.training.steps == interpretation.longer * own.training.steps
    assert changed(changed(found, **before), training={"steps": own.training.steps}) == own


@pytest.mark.parametrize("name", [name for name in INTERPRETATIONS if network_files(name)[0].startswith("model/")])
def test_an_interpretation_with_a_network_of_the_tables_would_train_the_same(name):
    weights, history = network_files(name)
    suffix = weights.removeprefix("model/cnn").removesuffix(".safetensors")
    assert history == f"model/training{suffix}.csv"
    own = of_network(CONFIG, suffix.removeprefix("-") or "published")
    assert configuration_digest(configuration_of(CONFIG, INTERPRETATIONS[name])) == configuration_digest(own)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["label-physical", "recipe-ranges"])
def test_an_interpretation_is_trained_and_scored(name, tmp_path):
    weights, history, checkpoint = (tmp_path / part for part in ("w.safetensors", "h.csv", "c.safetensors"))
    train_variant(name, weights, history, Path(), str(checkpoint), TINY)
    assert read_csv(history, HISTORY_COLUMNS)["step"].iloc[-1] == 3
    assert not checkpoint.exists()
    captures = [CAPTURES / f"{motion}.{ext}" for motion in MOTIONS for ext in ("bin", "json")]
    result = run_variant(name, weights, captures, TINY)
    assert all(0 <= result[key] <= 1 for key in (*HEADLINES, "id_lowest"))
    # The true parameters on T1 to T4 of the stored captures, whatever the network.
    regressions = [one.regression(CONFIG.signals) for one in read_recordings(captures, CONFIG)[1:]]
    totals = [metr2ev(r.tau, rebuild_torque(r.y, true_parameters(CONFIG))).total for r in regressions]
    assert result["arm_true"] == pytest.approx(np.mean(totals))
    without = run_variant(name, weights, captures[:4], TINY)  # T2 to T4
    assert [without[key] == result[key] for key in ("id_mean", "validation_mean", "arm_id")] == [True] * 3
    # The search with an untrained network may find nothing possible, so that it has 0 on every motion.
    assert not any(without[key] == result[key] for key in ("arm_refined", "arm_least_squares", "arm_true"))


def test_the_table_has_the_last_held_out_loss():
    numbers = dict.fromkeys(("id_mean", "id_lowest", "validation_mean", *HEADLINES), 0.5)
    rows = [[(1, 0.01, 7.0, 8.0), (k, 0.01, 9.0, k / 10)] for k in range(2, len(INTERPRETATIONS) + 2)]
    histories = [pd.DataFrame(row, columns=list(HISTORY_COLUMNS)) for row in rows]
    table = interpretations.ablation_table([numbers] * len(INTERPRETATIONS), histories)
    assert table["reading"].tolist() == [interpretation.name for interpretation in INTERPRETATIONS.values()]
    assert table["steps"].tolist() == list(range(2, len(INTERPRETATIONS) + 2))
    assert table["held_out_loss"].tolist() == [k / 10 for k in table["steps"]]  # not the loss of the training
    figure = interpretations.ablation_figure(table)
    assert len(figure) == len(INTERPRETATIONS) * len(HEADLINES)
    assert set(figure["quantity"]) == set(HEADLINES)
