"""Networks that come with the project: taken as they are, and refused if they are another configuration's."""

import hashlib
import shutil
from pathlib import Path

import pandas as pd
import pytest
import torch
from experiment_example import ROOT, changed, full_config, refused

from repro.config.sections import of_network
from repro.experiments import networks
from repro.experiments.networks import algorithm1_of
from repro.experiments.stored_networks import check_stored, configuration_digest, model_card, stored_files, take_stored

NETWORKS = ROOT / "data" / "networks"
CONFIG = changed(full_config(), training={"networks": str(NETWORKS)})


def taken(folder, network="published", config=CONFIG):
    suffix = "" if network == "published" else f"-{network}"
    stored, out = (stored_files(place, suffix) for place in (config.training.networks, folder))
    take_stored(suffix, out, config.training.networks, digest(config, network))
    return stored, out


def digest(config, network):
    return configuration_digest(of_network(config, network))


@pytest.mark.parametrize("network", ["published", "tracked-measured", "tracked"])
def test_the_networks_of_the_default_configuration_are_there(tmp_path, network):
    stored, out = taken(tmp_path, network)
    assert out["weights"].read_bytes() == stored["weights"].read_bytes()
    assert out["history"].read_bytes() == stored["history"].read_bytes()
    card = out["card"].read_text()
    assert card.startswith(stored["card"].read_text()) and "This run did not train it" in card


def test_the_card_states_when_the_loss_was_a_thousandth(tmp_path):
    (tmp_path / "weights").write_bytes(b"")
    losses = {"step": [1, 2, 3], "train_loss": 0.1, "test_loss": [5e-3, 9e-4, 8e-4]}
    history = pd.DataFrame({**losses, "seconds": [1.0, 20.0, 30.0]})
    card = model_card(tmp_path / "weights", history, "float32", CONFIG)
    assert "1e-3: step 2, after 20 s" in card


def test_the_reference_was_made_with_these_networks():
    weights = hashlib.sha256((NETWORKS / "cnn.safetensors").read_bytes()).hexdigest()
    assert weights in (ROOT / "docs/reference/model/model-card.md").read_text()


OTHERS = {"training": {"seed": 2}, "signals": {"filter_coefficient": 2e-4}}
OTHERS |= {"data": {"prior": "uniform"}, "image": {"scale": "channel-max"}}


@pytest.mark.parametrize("section", OTHERS)
def test_a_network_of_another_configuration_is_refused_in_one_line(tmp_path, section):
    config = changed(CONFIG, **{section: OTHERS[section]})
    assert refused(taken, tmp_path, "published", config).place == f"{NETWORKS}/cnn.safetensors"
    assert not list(tmp_path.iterdir())


def test_stored_networks_of_another_configuration_are_refused_before_any_work():
    stored = {"training": {"source": "stored"}}
    check_stored(changed(CONFIG, **stored))
    check_stored(changed(CONFIG, network={"hidden": [80, 40]}))  # these are trained
    error = refused(check_stored, changed(CONFIG, **stored, network={"hidden": [80, 40]}))
    assert error.place.endswith("cnn.safetensors")


def test_what_does_not_decide_a_network_does_not_refuse_it():
    same = changed(CONFIG, training={"source": "stored", "networks": "elsewhere"}, image={"constant": 5.0})
    assert digest(same, "published") == digest(CONFIG, "published")
    divided = changed(CONFIG, image={"scale": "constant", "constant": 5.0})
    assert digest(divided, "tracked") != digest(CONFIG, "tracked")
    paper = changed(CONFIG, training={"paper": {"images": 500}})
    assert digest(paper, "published") == digest(CONFIG, "published")
    assert digest(paper, "paper-recipe") != digest(CONFIG, "paper-recipe")


@pytest.mark.parametrize(
    "damage",
    [
        lambda weights: weights.unlink(),
        lambda weights: shutil.copy(weights.with_name("cnn-tracked.safetensors"), weights),
        lambda weights: weights.write_bytes(weights.read_bytes()[:-1] + b"?"),
        lambda weights: stored_files(weights.parent, "")["card"].write_text(""),
    ],
    ids=["missing", "swapped", "a changed byte", "an empty card"],
)
def test_a_damaged_network_is_refused(tmp_path, damage):
    folder = Path(shutil.copytree(NETWORKS, tmp_path / "networks"))
    damage(folder / "cnn.safetensors")
    stored = changed(CONFIG, training={"networks": str(folder)})
    assert refused(taken, tmp_path / "out", "published", stored).place.startswith(f"{folder}/cnn.safetensors")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("precision", ["float32", "bfloat16"])
def test_weights_are_read_in_the_arithmetic_that_is_asked_for_and_refused_if_they_say_another_configuration(precision):
    weights, said = NETWORKS / "cnn.safetensors", digest(CONFIG, "published")
    asked = changed(CONFIG, training={"precision": precision})
    assert algorithm1_of("published", weights, asked, said).network.dtype == getattr(torch, precision)
    error = refused(algorithm1_of, "published", weights, asked, "other")
    assert (error.place, error.found) == (f"{weights}: header", said)


def test_the_arm_is_searched_with_the_threshold_of_the_experiment(monkeypatch):
    monkeypatch.setattr(networks, "read_mean_torque", lambda *_: None)
    monkeypatch.setattr(networks, "identify_recording", lambda algorithm1, *_: algorithm1.search.threshold)
    config = changed(CONFIG, experiment={"threshold": 0.31})
    files = [ROOT / "data/captures/ID.bin"], NETWORKS / "cnn.safetensors", Path()
    found = networks.identify_experiment("", *files, [1, 4], digest(config, "published"), config)
    assert found == [0.31, 0.31]
