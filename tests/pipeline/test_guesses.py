"""Algorithm 1 over accepted experiments: a long search contains shorter ones, and scores are those of the metric."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from experiment_example import full_config

from repro.cnn.network import FactoredCNN, save_network
from repro.identification.algorithm1.search import SearchSettings, search_in_turn, select
from repro.pipeline.accepted import experiment_of, read_experiments, recordings_of, simulate_accepted
from repro.pipeline.guesses import search_accepted
from repro.pipeline.identifications import prepare_recording
from repro.settings import network_settings
from repro.signals.metric import metr2ev
from repro.signals.programs import PROGRAMS

ROOT = Path(__file__).resolve().parents[2]
CONFIG = full_config()


@pytest.fixture(scope="module")
def accepted(tmp_path_factory):
    """Two experiments of unequal lengths, cut out of the kept ones, and their recordings."""
    folder = tmp_path_factory.mktemp("accepted")
    table = read_experiments(ROOT / "data/experiments/accepted.csv").iloc[[0, 3]]
    table.to_csv(folder / "accepted.csv", index=False)
    simulate_accepted(folder / "accepted.csv", folder / "counts.safetensors", CONFIG)
    return folder


class Near:
    """Estimator whose estimates are scattered about the truth."""

    def __init__(self, true):
        self.true = true
        self.images = 0

    def estimate(self, guess):
        self.images += len(guess)
        return self.true + 0.1 * (guess - 1.5)


@pytest.fixture(scope="module")
def prepared(accepted):
    row = read_experiments(accepted / "accepted.csv").to_dict("records")[1]
    experiment = experiment_of(row, CONFIG)
    recordings = recordings_of(experiment, 1, accepted / "counts.safetensors", CONFIG)
    return experiment, recordings, prepare_recording(recordings[0], None, experiment.signals)


def test_recordings_are_of_their_own_motions(prepared):
    experiment, recordings, _ = prepared
    assert [r.program.name for r in recordings] == list(PROGRAMS)
    for recording in recordings:
        assert recording.q.shape == experiment.program(recording.program.name).q.shape
        assert np.abs(recording.q - recording.program.q).max() < 0.15


def test_a_long_search_contains_the_shorter_ones(prepared):
    _, _, signals = prepared
    settings = SearchSettings(threshold=0.9999)
    near = Near(np.array([0.5, 0.01, 0.1, 1.1, 0.1, 0.3, 0.1, 0.4, 0.2]))

    def run(budgets):
        found = search_in_turn(near, signals, settings, np.random.default_rng(5), budgets)
        return [select(each.beta, signals, settings) for each in found]

    long, short = run([130, 700, 2100]), run([700])
    assert long[1].similarity == short[0].similarity
    assert np.array_equal(long[1].beta, short[0].beta)
    assert long[0].similarity <= long[1].similarity <= long[2].similarity


def test_a_search_ends_with_its_last_execution(prepared):
    _, _, signals = prepared
    settings = replace(SearchSettings(), threshold=0.0, executions=7)  # every possible estimate ends an execution
    near = Near(np.full(9, 1.0))
    first, second = search_in_turn(near, signals, settings, np.random.default_rng(5), [5, 400])
    assert (first.met, second.met) == (5, 7)
    assert len(second.beta) == 7
    assert near.images == 5 + 100


def test_scores_of_an_experiment(accepted, prepared):
    experiment, recordings, _ = prepared
    number = int(read_experiments(accepted / "accepted.csv")["experiment"].iloc[1])
    torch.manual_seed(3)
    budgets = {"guesses": [20, 60], "further_guesses": [90], "further_experiments": 2, "seeds": [2, 5]}
    config = {**CONFIG, "accepted": {**CONFIG["accepted"], **budgets, "extension_experiments": 2}}
    weights = accepted / "weights.safetensors"
    save_network(weights, FactoredCNN(network_settings(config)), {"made": "by hand"})
    table = search_accepted(number, accepted / "accepted.csv", accepted / "counts.safetensors", weights, config)
    assert set(table["experiment"]) == {number}
    assert table.groupby("method").size().to_dict() == {
        "algorithm1": 60,  # 2 seeds, 3 budgets
        "algorithm1+desired": 40, "least-squares": 10, "bounded": 10, "consistent": 10, "true": 10,
    }  # fmt: skip
    config["accepted"] |= {"further_experiments": 1, "extension_experiments": 1}  # it is the second
    fewer = search_accepted(number, accepted / "accepted.csv", accepted / "counts.safetensors", weights, config)
    assert fewer.groupby("method").size()["algorithm1"] == 40
    assert "algorithm1+desired" not in set(fewer["method"])
    true = table[(table["method"] == "true") & (table["case"] == "T3")].sort_values("joint")
    r = recordings[PROGRAMS.index("T3")].regression(experiment.signals)
    expected = metr2ev(r.tau, r.y @ experiment.true)
    assert true["total"].to_numpy() == pytest.approx(expected.total, abs=1e-9)
