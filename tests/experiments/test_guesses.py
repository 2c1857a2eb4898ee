"""Algorithm 1 over accepted experiments: a long search contains shorter ones, and scores are those of the metric."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from accepted_example import write_accepted
from experiment_example import changed, full_config

from repro.cnn.network import FactoredCNN, save_network
from repro.experiments.accepted import read_accepted
from repro.experiments.arm import program_from_config
from repro.experiments.guesses import search_accepted
from repro.experiments.identifications import prepare_recording
from repro.identification.algorithm1.search import SearchSettings, search_in_turn, select
from repro.signals.metric import metr2ev
from repro.signals.programs import PROGRAMS

CONFIG = full_config()


@pytest.fixture(scope="module")
def accepted(tmp_path_factory):
    """Two experiments of unequal lengths, and their recordings."""
    return write_accepted(tmp_path_factory.mktemp("accepted"), CONFIG, [0, 3])


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
    experiment = read_accepted(*accepted, CONFIG)[1]
    return experiment, prepare_recording(experiment.recordings[0], None, experiment.config.signals)


def test_recordings_are_of_their_own_motions(prepared):
    experiment, _ = prepared
    assert experiment.number == 4
    assert [r.program.name for r in experiment.recordings] == list(PROGRAMS)
    for recording in experiment.recordings:
        assert recording.q.shape == program_from_config(experiment.config, recording.program.name).q.shape
        assert np.abs(recording.q - recording.program.q).max() < 0.15


def test_a_long_search_contains_the_shorter_ones(prepared):
    _, signals = prepared
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
    _, signals = prepared
    settings = replace(SearchSettings(), threshold=0.0, executions=7)  # every possible estimate ends an execution
    near = Near(np.full(9, 1.0))
    first, second = search_in_turn(near, signals, settings, np.random.default_rng(5), [5, 400])
    assert (first.met, second.met) == (5, 7)
    assert len(second.beta) == 7
    assert near.images == 5 + 100


def test_scores_of_an_experiment(accepted, prepared, tmp_path):
    experiment, _ = prepared
    torch.manual_seed(3)
    budgets = {"guesses": [20, 60], "further_guesses": [90], "seeds": [2, 5], "detailed_experiments": 2}
    config = changed(CONFIG, accepted=budgets)
    weights = [tmp_path / name for name in ("ideal.safetensors", "tracked.safetensors")]
    for path in weights:
        save_network(path, FactoredCNN(config.network), {"made": "by hand"})
    table = search_accepted(4, *accepted, weights, config)
    assert set(table["experiment"]) == {4}
    assert table.groupby("method").size().to_dict() == {
        "algorithm1": 50,  # a seed with 3 budgets, another one with 2
        "algorithm1+desired": 50, "algorithm1+tracked-measured": 50,
        "least-squares": 10, "bounded": 10, "consistent": 10, "true": 10,
    }  # fmt: skip
    second = changed(config, accepted={"detailed_experiments": 1})
    fewer = search_accepted(4, *accepted, weights[:1], second)
    assert fewer.groupby("method").size()["algorithm1"] == 40
    assert set(fewer["seed"]) == {0, 2, 5}
    assert not [method for method in fewer["method"] if "+" in method]
    true = table[(table["method"] == "true") & (table["case"] == "T3")].sort_values("joint")
    r = experiment.recordings[PROGRAMS.index("T3")].regression(experiment.config.signals)
    expected = metr2ev(r.tau, r.y @ experiment.true)
    assert true["total"].to_numpy() == pytest.approx(expected.total, abs=1e-9)
