"""The factorial on disk: its cells and blocks, and the search under both metrics against the search under each."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from experiment_example import changed, short_config

from repro.cnn.network import load_network
from repro.cnn.plain import PlainNetwork, load_posterior, read_torque
from repro.files import write_csv
from repro.fpga.controller import simulate
from repro.fpga.frames import RADIANS_PER_COUNT
from repro.fpga.plant import Plant
from repro.identification.algorithm1.search import ResidualEstimator, SearchSettings, search, select
from repro.identification.regression import solve
from repro.model.dynamics import rebuild_torque
from repro.pipeline.experiment import control_constants, disturbance, program_from_config
from repro.pipeline.factorial import CELLS, COLUMNS, configured, score_references
from repro.pipeline.identifications import mean_torque, mean_training_torque, prepare_recording
from repro.pipeline.networks import score_cell, search_under, train_cell
from repro.pipeline.simulated_arms import CONFIRMATION, read_blocks, simulate_blocks
from repro.pipeline.stored_networks import configuration_digest
from repro.settings import data_settings, network_settings, search_settings, signal_settings
from repro.signals.metric import TIME_FORMULAS, MetricSettings, metr2ev
from repro.streams import Stream, stream

pytestmark = pytest.mark.slow

# --- Cells --------------------------------------------------------------------------------------------------------


def test_every_combination_of_the_factors_has_its_network():
    """Motion of line 18, motions of the training and omega for the image CNN; all but the first for the plain one."""
    readers = [("cnn", "measured"), ("cnn", "desired"), ("plain", "")]
    expected = itertools.product(readers, ("ideal", "tracked"), ("rad_per_s", "index"))
    cells = [(cell, motion) for cell in CELLS.values() for motion in cell.image_motions or ("",)]
    assert sorted(expected) == sorted(((cell.reader, motion), cell.motions, cell.omega) for cell, motion in cells)


@pytest.mark.parametrize("name", CELLS)
def test_a_network_differs_from_the_configuration_by_its_levels_alone(name):
    expected, cell = short_config(), CELLS[name]
    expected["signals"]["frequency_reading"] = cell.omega
    expected["data"]["motions"] = cell.motions
    expected["training"]["seed"] = 7
    if len(cell.image_motions) == 1:
        expected["algorithm1"]["image_motion"] = cell.image_motions[0]
    if cell.reader == "plain":
        expected["data"]["unmodelled"]["noise"] = 0.03
    assert configured(short_config(), cell, 7) == expected


# --- Blocks -------------------------------------------------------------------------------------------------------

#: Motions of a few seconds, tiny networks and few guesses.
CONFIG = changed(
    short_config(),
    network={"hidden": [4, 3]},
    training={"steps": 2, "batch": 4, "test_samples": 4, "log_every": 1, "checkpoint_every": 1, "warmup": 0},
    algorithm1={"executions": 4, "inner_limit": 3},
    experiment={"threshold": 0.0},  # which impossible estimates of an untrained network meet
    factorial={"specimens": [4, 9, 6], "plain": {"width": 6, "steps": 2, "batch": 8}},
)
LOW, HIGH = CONFIG["factorial"]["back_emf_nm_s_per_rad"]
BLOCKS = [(name, emf) for name in ("4", "9", "6", CONFIRMATION) for emf in (LOW, HIGH)]


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("factorial") / "recordings.safetensors"
    simulate_blocks(CONFIG, path)
    return path


@pytest.fixture(scope="module")
def blocks(recorded):
    return read_blocks(recorded, CONFIG)


def test_blocks_take_both_arms_in_turn_and_both_back_emfs(blocks):
    assert [(block.labels["block"], block.labels["back_emf"]) for block in blocks] == BLOCKS
    in_turn = np.repeat(["first", "second", "first", CONFIRMATION], 2)
    assert [block.labels["arm"] for block in blocks] == in_turn.tolist()
    f = CONFIG["factorial"]
    arms = {"first": CONFIG["arm"]["parameters"], "second": f["second_arm"], CONFIRMATION: f["confirmation_arm"]}
    for block in blocks:
        back_emf = block.labels["back_emf"] * np.array([0, 0, 0, 0, 0, 1, 1, 0, 0])
        np.testing.assert_allclose(block.true, arms[block.labels["arm"]] + back_emf, rtol=1e-12)


def test_a_block_is_its_specimen_simulated_alone(blocks):
    """Arms of a batch share their substeps, so now and then a position falls on the other side of a count."""
    control, block = control_constants(CONFIG), blocks[3]
    levels, phase = disturbance(CONFIG, 9)
    recording = block.recordings[1]  # T1, which differs between specimens
    program = program_from_config(CONFIG, "T1", 9)
    np.testing.assert_array_equal(recording.program.q, program.q.astype(np.float32))
    position, pwm = simulate(Plant(block.true, program.h, levels, phase), control, program.q)
    apart = np.abs(recording.q / RADIANS_PER_COUNT - position[0])
    assert apart.max() <= 2 and apart.mean() < 0.05
    torque = pwm[0] * control.torque_per_count[:, None]
    assert np.corrcoef(recording.tau.ravel(), torque.ravel())[0, 1] > 0.95


# --- Search under both metrics ------------------------------------------------------------------------------------


class Reader:
    """Errs by a part of the guess, which a rotation mixes: estimates of all qualities, some of them not possible."""

    def __init__(self, block, prepared, scale):
        self.images, self._scale, self._right = 0, scale, block.true / prepared.torque_scale
        self._mix = np.linalg.qr(np.random.default_rng(8).normal(size=(9, 9)))[0]

    def estimate(self, guess):
        return self._right + self._scale * (guess - 0.5) @ self._mix


@pytest.mark.parametrize("feasibility", ["positive", "positive-definite"])
@pytest.mark.parametrize("scale", [0.03, 0.15])
@pytest.mark.parametrize("threshold", [0.0, 0.6, 0.9])
def test_one_reading_gives_what_the_search_gives_under_each_metric(blocks, threshold, scale, feasibility):
    settings = SearchSettings(9, 6, threshold, low=1e-3, high=1.0, feasibility=feasibility)
    prepared = prepare_recording(blocks[1].recordings[0], None, signal_settings(CONFIG))
    reader = Reader(blocks[1], prepared, scale)
    found, first = search_under(reader, prepared, settings, np.random.default_rng(5))
    assert set(found) == set(TIME_FORMULAS)
    for formula, (beta, met) in found.items():
        own = replace(settings, metric=MetricSettings(formula))
        candidates = search(reader, prepared, own, np.random.default_rng(5))
        np.testing.assert_allclose(beta, select(candidates.beta, prepared, own).beta, rtol=1e-12, atol=1e-12)
        ended = np.sum(candidates.similarity >= threshold)
        assert met == (ended if threshold else 9)  # an estimate that is not possible has the similarity 0
    guesses = np.stack([s.uniform(settings.low, settings.high, 9) for s in np.random.default_rng(5).spawn(9)])
    np.testing.assert_allclose(first, reader.estimate(guesses), rtol=1e-12)


# --- Scores -------------------------------------------------------------------------------------------------------


def similarities(block, beta, formula, config):
    """Mean total of both joints on ID, and over T1 to T4, by metr2ev on the rebuilt torques."""
    totals = []
    for recording in block.recordings:
        r = recording.regression(signal_settings(config))
        totals.append(metr2ev(r.tau, rebuild_torque(r.y, beta), MetricSettings(formula)).total.mean())
    return totals[0], np.mean(totals[1:])


def test_references_are_scored_on_every_block_under_both_metrics(recorded, blocks):
    table = score_references(recorded, CONFIG)
    assert len(table) == 2 * len(BLOCKS) * 3 * 2  # omegas, blocks, methods, metrics
    assert table.query("reader == 'bounded'")["id"].between(0.001, 1).all()
    table = table.set_index(["reader", "omega", "metric", "block", "back_emf"])
    assert table.index.is_unique
    block = blocks[3]
    for omega, formula in itertools.product(("rad_per_s", "index"), TIME_FORMULAS):
        c = configured(CONFIG, CELLS[f"plain-ideal-{omega}"], 1)
        regression = block.recordings[0].regression(signal_settings(c))
        own = solve(regression.y, regression.tau)
        for reader, beta in (("true", block.true), ("ordinary", own)):
            row = table.loc[(reader, omega, formula, "9", HIGH)]
            expected = similarities(block, beta, formula, c)
            assert (row["id"], row["validation"]) == pytest.approx(expected, rel=0, abs=1e-7)


@pytest.mark.parametrize("name", ["plain-ideal-index", "cnn-ideal-index"])
def test_a_network_is_scored_on_every_block(name, recorded, blocks, tmp_path):
    """Of an image network each block and motion of line 18, with the block's guesses."""
    cell, seed, weights = CELLS[name], 2, tmp_path / f"{name}.safetensors"
    train_cell(name, 1, weights, str(tmp_path / ".checkpoint"), CONFIG)
    assert [*tmp_path.iterdir()] == [weights]
    write_csv(tmp_path / "mean_torque.csv", mean_torque(CONFIG))
    table = score_cell(name, 1, seed, weights, recorded, tmp_path / "mean_torque.csv", CONFIG)
    assert tuple(table.columns) == COLUMNS
    assert len(table) == len(BLOCKS) * 2 * max(len(cell.image_motions), 1)
    assert set(zip(table["block"], table["back_emf"], strict=True)) == set(BLOCKS)
    table = table.set_index(["block", "back_emf", "metric", "image_motion"])
    assert table.index.is_unique
    c = configured(CONFIG, cell, 1)
    signals = signal_settings(c)
    tau_mean = mean_training_torque(signals, data_settings(c), 1)
    settings = replace(search_settings(c), threshold=CONFIG["experiment"]["threshold"])
    for k, motion, formula in itertools.product((0, 5), cell.image_motions or ("",), TIME_FORMULAS):
        prepared = prepare_recording(blocks[k].recordings[0], tau_mean, signals, motion or "measured")
        if cell.reader == "plain":
            network = load_posterior(weights, PlainNetwork(signals.samples, CONFIG["factorial"]["plain"]["width"]))
            first = read_torque(network, prepared.alpha)[0]
            estimate, met = prepared.torque_scale * first, 0
        else:
            network = load_network(weights, network_settings(c), configuration_digest(c), "float32")
            reader = ResidualEstimator(network, data_settings(c).image, prepared)
            found, first = search_under(reader, prepared, settings, stream(seed, Stream.FACTORIAL_SEARCH, k))
            estimate, met = found[formula]
        row = table.loc[(*BLOCKS[k], formula, motion)]
        totals = similarities(blocks[k], estimate, formula, c)
        assert (row["id"], row["validation"]) == pytest.approx(totals, rel=0, abs=1e-6)
        error = np.sqrt(np.mean((first - blocks[k].true / prepared.torque_scale) ** 2))
        assert row["error"] == pytest.approx(error, rel=1e-5)
        assert (row["reader"], row["training"], row["omega"]) == (cell.reader, "ideal", "index")
        assert (row["search_seed"], row["training_seed"], row["met"]) == (seed, 1, met)
