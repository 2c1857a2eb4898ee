"""The headline rows under both time factors, against similarities that are computed one by one."""

import itertools

import numpy as np
import pytest
from experiment_example import MOTIONS, crossed_identification, least_squares_run, recording, short_config

from repro.model.dynamics import inverse_dynamics, rebuild_torque
from repro.pipeline.experiment import true_parameters
from repro.pipeline.numeric import motion_of
from repro.pipeline.summary import BOTH_METRICS, both_metrics
from repro.settings import numeric_settings, signal_settings
from repro.signals.metric import TIME_FORMULAS, MetricSettings, metr2ev

pytestmark = pytest.mark.slow

CONFIG = short_config()
SIGNALS, NUMERIC = signal_settings(CONFIG), numeric_settings(CONFIG)
TRUE = true_parameters(CONFIG)
SEEDS = (1, 2, 3)
#: Estimate of each seed over the true parameters; the third is the median one under either formula.
FACTOR = {1: 0.6, 2: 0.98, 3: 0.9}


def of_arm(seed):
    run = crossed_identification(seed, TRUE, "+desired")
    run["arms"]["ID"]["methods"] |= {"algorithm1": {"beta": (FACTOR[seed] * TRUE).tolist()}}
    return run


def of_numbers(seed):
    arms = {
        name: {"true": beta.tolist(), "methods": {"algorithm1": {"beta": (FACTOR[seed] * beta).tolist()}}}
        for name, beta in NUMERIC.arms.items()
    }
    return {"seed": seed, "variant": "published", "arms": arms}


@pytest.fixture(scope="module")
def recordings():
    return [recording(motion, CONFIG) for motion in MOTIONS]


@pytest.fixture(scope="module")
def table(recordings):
    arm = [*map(of_arm, SEEDS), least_squares_run(TRUE)]
    return both_metrics([*map(of_numbers, SEEDS)], arm, recordings, CONFIG)


def test_every_method_of_the_arm_has_both_formulas(table):
    assert tuple(table.columns) == BOTH_METRICS
    methods = ("algorithm1", "algorithm1+desired", "least-squares", "bounded", "consistent", "true")
    rows = [*zip(table["method"], table["formula"], strict=True)]
    assert sorted(rows) == sorted(itertools.product(methods, TIME_FORMULAS))


@pytest.mark.parametrize("formula", TIME_FORMULAS)
def test_a_row_is_of_the_median_seed_in_every_cell(table, recordings, formula):
    (row,) = table[(table["method"] == "algorithm1") & (table["formula"] == formula)].to_dict("records")
    metric = MetricSettings(formula)
    cells = []
    for one in recordings:
        r = one.regression(SIGNALS)
        cells.append(metr2ev(r.tau, rebuild_torque(r.y, FACTOR[3] * TRUE), metric))
    np.testing.assert_allclose([row["id1"], row["id2"]], cells[0].total, atol=1e-7)
    assert row["validation"] == pytest.approx(np.mean([cell.total for cell in cells[1:]]), abs=1e-7)
    assert row["frequency_id"] == pytest.approx(cells[0].frequency.mean(), abs=1e-7)
    assert row["frequency_validation"] == pytest.approx(np.mean([cell.frequency for cell in cells[1:]]), abs=1e-7)
    # On the numeric arms each seed has a validation motion of its own.
    on_id, others = [], []
    for beta in NUMERIC.arms.values():
        for trajectory, totals in (("ID", on_id), ("validation", others)):
            of_seeds = []
            for seed in SEEDS:
                motion = motion_of(trajectory, SIGNALS, NUMERIC, seed)
                tau = inverse_dynamics(motion.q, motion.dq, motion.ddq, beta)
                of_seeds.append(metr2ev(tau, FACTOR[seed] * tau, metric).total)
            totals.append(np.median(of_seeds, axis=0).mean())
    assert row["numeric_id"] == pytest.approx(np.mean(on_id), abs=1e-6)
    assert row["numeric_validation"] == pytest.approx(np.mean(others), abs=1e-6)


def test_the_frequency_factor_does_not_depend_on_the_formula(table):
    both = table.set_index(["method", "formula"])[["frequency_id", "frequency_validation"]]
    energy, mean_square = (both.xs(formula, level="formula") for formula in ("energy", "mean-square"))
    np.testing.assert_allclose(energy, mean_square, rtol=1e-12)


def test_methods_of_the_arm_alone_have_no_numeric_cells(table):
    alone = table[table["method"] != "algorithm1"]
    assert alone[["numeric_id", "numeric_validation"]].isna().all(axis=None)
    assert table[["id1", "id2", "validation"]].notna().all(axis=None)
