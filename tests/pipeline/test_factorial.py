"""The factorial on disk: its cells and blocks, and the search under both metrics against the search under each."""

import copy
import itertools
from dataclasses import replace

import literal
import numpy as np
import pytest
from experiment_example import short_config

from repro.cnn.network import load_network
from repro.cnn.plain import PlainNetwork, load_posterior, read_torque
from repro.files import write_csv
from repro.fpga.controller import simulate
from repro.fpga.frames import RADIANS_PER_COUNT
from repro.fpga.plant import Plant
from repro.identification.algorithm1.preprocessing import filtered, prepare
from repro.identification.algorithm1.search import ResidualEstimator, SearchSettings, search, select
from repro.identification.solve import solve
from repro.model.dynamics import inverse_dynamics, rebuild_torque
from repro.pipeline.experiment import control_constants, disturbance, program_from_config
from repro.pipeline.factorial import CELLS, COLUMNS, configured, score_references
from repro.pipeline.identifications import mean_torque, mean_training_torque, prepare_recording
from repro.pipeline.networks import score_cell, search_under, train_cell
from repro.pipeline.simulated_arms import CONFIRMATION, read_blocks, simulate_blocks
from repro.pipeline.stored_networks import configuration_digest
from repro.settings import data_settings, network_settings, search_settings, signal_settings
from repro.signals.dct import SignalSettings
from repro.signals.metric import TIME_FORMULAS, MetricSettings, metr2ev
from repro.signals.trajectories import identification_trajectory
from repro.streams import Stream, stream

pytestmark = pytest.mark.slow

# --- Cells --------------------------------------------------------------------------------------------------------


def test_every_combination_of_the_factors_has_its_network():
    """Motion of line 18, motions of the training and omega for the image CNN; all but the first for the plain one."""
    combinations = [
        (cell.reader, motion, cell.motions, cell.omega)
        for cell in CELLS.values()
        for motion in cell.image_motions or ("",)
    ]
    expected = itertools.product(("cnn",), ("measured", "desired"), ("ideal", "tracked"), ("rad_per_s", "index"))
    expected = {*expected, *itertools.product(("plain",), ("",), ("ideal", "tracked"), ("rad_per_s", "index"))}
    assert sorted(combinations) == sorted(expected)


@pytest.mark.parametrize("name", CELLS)
def test_a_network_differs_from_the_configuration_by_its_levels_alone(name):
    config, cell = short_config(), CELLS[name]
    levels = {("signals", "frequency_reading"): cell.omega, ("data", "motions"): cell.motions, ("training", "seed"): 7}
    if len(cell.image_motions) == 1:
        levels["algorithm1", "image_motion"] = cell.image_motions[0]
    if cell.reader == "plain":
        levels["data", "unmodelled"] = {**config["data"]["unmodelled"], "noise": 0.03}
    expected = copy.deepcopy(config)
    for (section, key), value in levels.items():
        expected[section][key] = value
    assert configured(config, cell, 7) == expected


# --- Search under both metrics ------------------------------------------------------------------------------------

SIGNALS = SignalSettings(h=0.02, samples=40)
MARGIN = 25
MOTION = identification_trajectory(SIGNALS.duration, SIGNALS.h, MARGIN)
CUT = (MARGIN, MOTION.q.shape[1] - MARGIN)
MEAN = np.random.default_rng(0).normal(size=(2, CUT[1] - CUT[0])) + 2.0
ARM = literal.ARMS["N1"]
TAU = inverse_dynamics(MOTION.q, MOTION.dq, MOTION.ddq, ARM)
PREPARED = prepare(filtered(MOTION.q, TAU, SIGNALS, *CUT), MEAN, SIGNALS)


class Reader:
    """Errs by half of the guess, which a rotation mixes: estimates of all qualities, some of them not possible."""

    def __init__(self, scale):
        self.images, self._scale = 0, scale
        self._mix = np.linalg.qr(np.random.default_rng(8).normal(size=(9, 9)))[0]

    def estimate(self, guess):
        self.images += len(guess)
        return ARM / PREPARED.torque_scale + self._scale * (guess - 0.5) @ self._mix


@pytest.mark.parametrize("feasibility", ["positive", "positive-definite"])
@pytest.mark.parametrize("scale", [0.03, 0.15])
@pytest.mark.parametrize("threshold", [0.0, 0.6, 0.8, 0.9])
def test_one_reading_gives_what_the_search_gives_under_each_metric(threshold, scale, feasibility):
    settings = SearchSettings(9, 6, threshold, low=1e-3, high=1.0, feasibility=feasibility)
    found, first = search_under(Reader(scale), PREPARED, settings, np.random.default_rng(5))
    assert set(found) == set(TIME_FORMULAS)
    for formula, (beta, met) in found.items():
        own = replace(settings, metric=MetricSettings(formula))
        candidates = search(Reader(scale), PREPARED, own, np.random.default_rng(5))
        expected = select(candidates.beta, PREPARED, own)
        np.testing.assert_allclose(beta, expected.beta, rtol=1e-12, atol=1e-12)
        ended = {*candidates.execution[candidates.similarity >= threshold]}
        assert met == (len(ended) if threshold else 9)  # an estimate that is not possible has the similarity 0
    guesses = np.stack([s.uniform(settings.low, settings.high, 9) for s in np.random.default_rng(5).spawn(9)])
    np.testing.assert_allclose(first, Reader(scale).estimate(guesses), rtol=1e-12)


# --- Blocks -------------------------------------------------------------------------------------------------------


def brief_config():
    """Motions of a few seconds, tiny networks and few guesses."""
    config = short_config()
    config["network"]["hidden"] = [4, 3]
    config["training"] |= {"steps": 2, "batch": 4, "test_samples": 4, "log_every": 1, "checkpoint_every": 1}
    config["training"]["warmup"] = 0
    config["algorithm1"] |= {"executions": 4, "inner_limit": 3}
    config["factorial"] |= {"specimens": [4, 9, 6], "training_seeds": [1], "search_seeds": [1]}
    config["factorial"]["plain"] |= {"width": 6, "steps": 2, "batch": 8}
    return config


CONFIG = brief_config()
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


@pytest.fixture(scope="module")
def mean_torque_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("mean") / "mean_torque.csv"
    write_csv(path, mean_torque(CONFIG))
    return path


def test_blocks_take_both_arms_in_turn_and_both_back_emfs(blocks):
    assert [(block.labels["block"], block.labels["back_emf"]) for block in blocks] == BLOCKS
    assert [block.labels["arm"] for block in blocks] == [
        *["first"] * 2,
        *["second"] * 2,
        *["first"] * 2,
        *[CONFIRMATION] * 2,
    ]
    f = CONFIG["factorial"]
    arms = {"first": CONFIG["arm"]["parameters"], "second": f["second_arm"], CONFIRMATION: f["confirmation_arm"]}
    for block in blocks:
        back_emf = block.labels["back_emf"] * np.array([0, 0, 0, 0, 0, 1, 1, 0, 0])
        np.testing.assert_allclose(block.true, arms[block.labels["arm"]] + back_emf, rtol=1e-12)


def test_a_block_is_its_specimen_simulated_alone(blocks):
    """Arms of a batch share their substeps, so now and then a position falls on the other side of a count."""
    control, block = control_constants(CONFIG), blocks[3]
    levels, phase = disturbance(CONFIG, 9)
    for recording in block.recordings:
        program = program_from_config(CONFIG, recording.program.name, 9)
        np.testing.assert_array_equal(recording.program.q, program.q.astype(np.float32))
        position, pwm = simulate(Plant(block.true, program.h, levels, phase), control, program.q)
        apart = np.abs(recording.q / RADIANS_PER_COUNT - position[0])
        assert apart.max() <= 2 and apart.mean() < 0.05
        torque = pwm[0] * control.torque_per_count[:, None]
        assert np.corrcoef(recording.tau.ravel(), torque.ravel())[0, 1] > 0.95


# --- Scores -------------------------------------------------------------------------------------------------------


def similarities(block, beta, formula, config):
    """Mean total of both joints on ID, and over T1 to T4, by metr2ev on the rebuilt torques."""
    totals = []
    for recording in block.recordings:
        r = recording.regression(signal_settings(config))
        totals.append(metr2ev(r.tau, rebuild_torque(r.y, beta), MetricSettings(formula)).total.mean())
    return totals[0], np.mean(totals[1:])


def rows_of(table, **levels):
    return table[np.logical_and.reduce([table[name] == level for name, level in levels.items()])]


def test_references_are_scored_on_every_block_under_both_metrics(recorded, blocks):
    table = score_references(recorded, CONFIG)
    assert len(table) == 2 * len(BLOCKS) * 3 * 2  # omegas, blocks, methods, metrics
    assert not table.duplicated(["reader", "omega", "back_emf", "metric", "block"]).any()
    block = blocks[3]
    for omega, formula in itertools.product(("rad_per_s", "index"), TIME_FORMULAS):
        c = configured(CONFIG, CELLS[f"plain-ideal-{omega}"], 1)
        regression = block.recordings[0].regression(signal_settings(c))
        own = solve(regression.y, regression.tau)
        for reader, beta in (("true", block.true), ("ordinary", own)):
            levels = {"omega": omega, "metric": formula, "block": "9", "back_emf": HIGH, "reader": reader}
            (row,) = rows_of(table, **levels).to_dict("records")
            expected = similarities(block, beta, formula, c)
            np.testing.assert_allclose([row["id"], row["validation"]], expected, rtol=0, atol=1e-7)
    bounded = rows_of(table, reader="bounded")
    assert (bounded["id"] <= 1).all()
    assert (bounded["id"] > 0).all()


@pytest.mark.parametrize("name", ["plain-ideal-index", "cnn-ideal-index"])
def test_a_network_is_scored_on_every_block(name, recorded, blocks, mean_torque_file, tmp_path):
    """Of an image network each block and motion of line 18 against `search` and `select` with the block's guesses."""
    cell, seed, weights = CELLS[name], 2, tmp_path / f"{name}.safetensors"
    train_cell(name, 1, weights, str(tmp_path / ".checkpoint"), CONFIG)
    table = score_cell(name, 1, seed, weights, recorded, mean_torque_file, CONFIG)
    assert tuple(table.columns) == COLUMNS
    assert len(table) == len(BLOCKS) * 2 * max(len(cell.image_motions), 1)
    assert set(zip(table["block"], table["back_emf"], strict=True)) == set(BLOCKS)
    c = configured(CONFIG, cell, 1)
    signals, p = signal_settings(c), CONFIG["factorial"]["plain"]
    tau_mean = mean_training_torque(signals, data_settings(c), 1)
    settings = replace(search_settings(c), threshold=CONFIG["experiment"]["threshold"])
    for k, motion, formula in itertools.product((0, 5), cell.image_motions or ("",), TIME_FORMULAS):
        prepared = prepare_recording(blocks[k].recordings[0], tau_mean, signals, motion or "measured")
        if cell.reader == "plain":
            network = load_posterior(weights, PlainNetwork(signals.samples, p["width"]))
            first = read_torque(network, prepared.alpha)[0]
            estimate = prepared.torque_scale * first
        else:
            network = load_network(weights, network_settings(c), configuration_digest(c), "float32")
            reader, own = ResidualEstimator(network, data_settings(c).image, prepared), MetricSettings(formula)
            candidates = search(reader, prepared, replace(settings, metric=own), guesses_of(seed, k))
            estimate = select(candidates.beta, prepared, replace(settings, metric=own)).beta
            first = reader.estimate(np.stack([s.uniform(1e-3, 3.0, 9) for s in guesses_of(seed, k).spawn(4)]))
        levels = {**blocks[k].labels, "metric": formula, "image_motion": motion}
        (row,) = rows_of(table, **levels).to_dict("records")
        totals = similarities(blocks[k], estimate, formula, c)
        np.testing.assert_allclose([row["id"], row["validation"]], totals, rtol=0, atol=1e-6)
        error = np.sqrt(np.mean((first - blocks[k].true / prepared.torque_scale) ** 2))
        assert row["error"] == pytest.approx(error, rel=1e-5)
        assert (row["reader"], row["training"], row["omega"]) == (cell.reader, "ideal", "index")
        assert (row["search_seed"], row["training_seed"]) == (seed, 1)


def guesses_of(seed, block):
    return stream(seed, Stream.FACTORIAL_SEARCH, block)
