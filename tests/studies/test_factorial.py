"""The factorial on disk: its cells, and the search under both metrics against the search under each."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from accepted_example import write_accepted
from experiment_example import changed, short_config

from repro.cnn.network import load_network
from repro.config.sections import data_settings, search_settings
from repro.experiments.accepted import of_this_unit, read_accepted
from repro.experiments.identifications import mean_torque, mean_training_torque, prepare_recording
from repro.experiments.stored_networks import configuration_digest
from repro.files import write_csv
from repro.identification.algorithm1.search import ResidualEstimator, SearchSettings, search, select
from repro.identification.regression import solve
from repro.model.dynamics import rebuild_torque
from repro.signals.metric import TIME_FORMULAS, MetricSettings, metr2ev
from repro.streams import Stream, stream
from repro_studies.factorial import CELLS, COLUMNS, configured, score_references
from repro_studies.factorial_networks import score_cell, search_under, train_cell
from repro_studies.plain import PlainNetwork, load_posterior, read_torque

pytestmark = pytest.mark.slow

# --- Cells --------------------------------------------------------------------------------------------------------


def test_every_combination_of_the_factors_has_its_network():
    """Motion of line 18 and motions of the training for the image CNN; the latter alone for the plain one."""
    readers = [("cnn", "measured"), ("cnn", "desired"), ("plain", "")]
    expected = itertools.product(readers, ("ideal", "tracked"))
    cells = [(cell, motion) for cell in CELLS.values() for motion in cell.image_motions or ("",)]
    assert sorted(expected) == sorted(((cell.reader, motion), cell.motions) for cell, motion in cells)


@pytest.mark.parametrize("name", CELLS)
def test_a_network_differs_from_the_configuration_by_its_levels_alone(name):
    cell = CELLS[name]
    expected = changed(short_config(), data={"motions": cell.motions}, training={"seed": 7})
    if len(cell.image_motions) == 1:
        expected = changed(expected, algorithm1={"image_motion": cell.image_motions[0]})
    if cell.reader == "plain":
        expected = changed(expected, data={"unmodelled": {"noise": 0.03}})
    assert configured(short_config(), cell, 7) == expected


# --- Blocks -------------------------------------------------------------------------------------------------------

#: Motions of a few seconds, tiny networks and few guesses.
CONFIG = changed(
    short_config(),
    network={"hidden": [4, 3]},
    training={"steps": 2, "batch": 4, "test_samples": 4, "log_every": 1, "checkpoint_every": 1, "warmup": 0},
    algorithm1={"executions": 4, "inner_limit": 8},
    experiment={"threshold": 0.0},  # which impossible estimates of an untrained network meet
    factorial={"inner_limit": 3, "plain": {"width": 6, "steps": 2, "batch": 8}},
)
#: Places of the experiments in the kept list; the one in the middle has another unit of omega.
PLACES, BLOCKS = [4, 9, 0], [5, 1]


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    return write_accepted(tmp_path_factory.mktemp("factorial"), CONFIG, PLACES)


@pytest.fixture(scope="module")
def blocks(recorded):
    return of_this_unit(read_accepted(*recorded, CONFIG), CONFIG)


def test_blocks_are_the_experiments_with_the_unit_of_the_configuration(recorded, blocks):
    assert [block.number for block in blocks] == BLOCKS
    other = changed(CONFIG, signals={"frequency_reading": "rad_per_s"})
    assert [block.number for block in of_this_unit(read_accepted(*recorded, other), other)] == [10]


# --- Search under both metrics ------------------------------------------------------------------------------------


class Estimator:
    """Errs by a part of the guess, which a rotation mixes: estimates of all qualities, some of them not possible."""

    def __init__(self, block, prepared, scale):
        self.images, self._scale, self._right = 0, scale, block.true / prepared.torque_scale
        self._mix = np.linalg.qr(np.random.default_rng(8).normal(size=(9, 9)))[0]

    def estimate(self, guess):
        return self._right + self._scale * (guess - 0.5) @ self._mix


@pytest.mark.parametrize("feasibility", ["positive", "positive-definite"])
@pytest.mark.parametrize("scale", [0.03, 0.15])
@pytest.mark.parametrize("threshold", [0.0, 0.6, 0.9])
def test_one_evaluation_gives_what_the_search_gives_under_each_metric(blocks, threshold, scale, feasibility):
    settings = SearchSettings(9, 6, threshold, guess_low=1e-3, guess_high=1.0, feasibility=feasibility)
    prepared = prepare_recording(blocks[1].recordings[0], None, CONFIG.signals)
    estimator = Estimator(blocks[1], prepared, scale)
    found, first = search_under(estimator, prepared, settings, np.random.default_rng(5))
    assert set(found) == set(TIME_FORMULAS)
    for formula, (beta, met) in found.items():
        own = replace(settings, metric=MetricSettings(formula))
        candidates = search(estimator, prepared, own, np.random.default_rng(5))
        np.testing.assert_allclose(beta, select(candidates.beta, prepared, own).beta, rtol=1e-12, atol=1e-12)
        ended = np.sum(candidates.similarity >= threshold)
        assert met == (ended if threshold else 9)  # an estimate that is not possible has the similarity 0
    low, high = settings.guess_low, settings.guess_high
    guesses = np.stack([s.uniform(low, high, 9) for s in np.random.default_rng(5).spawn(9)])
    np.testing.assert_allclose(first, estimator.estimate(guesses), rtol=1e-12)


# --- Scores -------------------------------------------------------------------------------------------------------


def similarities(block, beta, formula, config):
    """Mean total of both joints on ID, and over T1 to T4, by metr2ev on the rebuilt torques."""
    totals = []
    for recording in block.recordings:
        r = recording.regression(config.signals)
        totals.append(metr2ev(r.tau, rebuild_torque(r.y, beta), MetricSettings(formula)).total.mean())
    return totals[0], np.mean(totals[1:])


def test_references_are_scored_on_every_block_under_both_metrics(recorded, blocks):
    table = score_references(*recorded, CONFIG)
    assert len(table) == len(BLOCKS) * 3 * 2  # methods, metrics
    assert table.query("reader == 'bounded'")["id"].between(0.001, 1).all()
    table = table.set_index(["reader", "metric", "experiment"])
    assert table.index.is_unique
    regression = blocks[0].recordings[0].regression(CONFIG.signals)
    own = solve(regression.y, regression.tau)
    for (reader, beta), formula in itertools.product((("true", blocks[0].true), ("ordinary", own)), TIME_FORMULAS):
        row = table.loc[(reader, formula, BLOCKS[0])]
        expected = similarities(blocks[0], beta, formula, CONFIG)
        assert (row["id"], row["validation"]) == pytest.approx(expected, rel=0, abs=1e-7)


@pytest.mark.parametrize("name", ["plain-ideal", "cnn-ideal"])
def test_a_network_is_scored_on_every_block(name, recorded, blocks, tmp_path):
    """Of an image network each block and motion of line 18, with the block's guesses."""
    cell, seed, weights = CELLS[name], 2, tmp_path / f"{name}.safetensors"
    train_cell(name, 1, weights, str(tmp_path / ".checkpoint"), CONFIG)
    assert [*tmp_path.iterdir()] == [weights]
    write_csv(tmp_path / "mean_torque.csv", mean_torque(CONFIG))
    table = score_cell(name, 1, seed, weights, *recorded, tmp_path / "mean_torque.csv", CONFIG)
    assert tuple(table.columns) == COLUMNS
    assert len(table) == len(BLOCKS) * 2 * max(len(cell.image_motions), 1)
    assert set(table["experiment"]) == set(BLOCKS)
    table = table.set_index(["experiment", "metric", "image_motion"])
    assert table.index.is_unique
    c = configured(CONFIG, cell, 1)
    signals = c.signals
    tau_mean = mean_training_torque(signals, data_settings(c), 1)
    settings = replace(search_settings(c), threshold=CONFIG.experiment.threshold, inner_limit=3)
    for k, motion, formula in itertools.product((0, 1), cell.image_motions or ("",), TIME_FORMULAS):
        prepared = prepare_recording(blocks[k].recordings[0], tau_mean, signals, motion or "measured")
        if cell.reader == "plain":
            network = load_posterior(weights, PlainNetwork(signals.image_samples, CONFIG.factorial.plain.width))
            first = read_torque(network, prepared.alpha)[0]
            estimate, met = prepared.torque_scale * first, 0
        else:
            network = load_network(weights, c.network, configuration_digest(c), "float32")
            estimator = ResidualEstimator(network, data_settings(c).image, prepared)
            found, first = search_under(estimator, prepared, settings, stream(seed, Stream.FACTORIAL_SEARCH, BLOCKS[k]))
            estimate, met = found[formula]
        row = table.loc[(BLOCKS[k], formula, motion)]
        totals = similarities(blocks[k], estimate, formula, c)
        assert (row["id"], row["validation"]) == pytest.approx(totals, rel=0, abs=1e-6)
        error = np.sqrt(np.mean((first - blocks[k].true / prepared.torque_scale) ** 2))
        assert row["error"] == pytest.approx(error, rel=1e-5)
        assert (row["reader"], row["training"]) == (cell.reader, "ideal")
        assert (row["search_seed"], row["training_seed"], row["met"]) == (seed, 1, met)
