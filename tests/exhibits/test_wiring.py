"""Which number stands in which cell and curve: every input is unlike every other one, and known places are checked."""

import itertools
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

from repro.exhibits import catalogue
from repro.files import write_csv, write_json
from repro.model.dynamics import inverse_dynamics
from repro.pipeline.numeric import motion_of
from repro.settings import numeric_settings, signal_settings
from repro.signals.dct import spectrum

ROOT = Path(__file__).resolve().parents[2]
CONFIG = yaml.safe_load((ROOT / "config" / "config.yaml").read_text(encoding="utf-8"))
SIGNALS, NUMERIC = signal_settings(CONFIG), numeric_settings(CONFIG)
MADE = {(e.kind, e.name): e for e in catalogue.EXHIBITS}
SEEDS, MEDIAN = (1, 2, 3), 2
METHODS = ("algorithm1", "algorithm1+refinement", "algorithm1+local-search")
ARM = ("ID", "T1", "T2", "T3", "T4")


def score(case, method, trajectory, joint, seed):
    """Time and frequency of a run, both unlike those of any other; seed 2 is the median."""
    cases, trajectories = (*NUMERIC.arms, *ARM), ("ID", "validation")
    place = (cases.index(case), METHODS.index(method), trajectories.index(trajectory), joint - 1)
    k = np.ravel_multi_index(place, (len(cases), len(METHODS), 2, 2))
    offset = {1: -0.1, 2: 0.0, 3: 0.1}[seed]
    return 0.5 + 1e-3 * k + offset, 0.8 + 7e-4 * k


def scores(cases, with_trajectory):
    rows = []
    trajectories = ("ID", "validation") if with_trajectory else ("ID",)
    for case, method, trajectory, joint, seed in itertools.product(cases, METHODS, trajectories, (1, 2), SEEDS):
        time, frequency = score(case, method, trajectory, joint, seed)
        rows.append((case, method, seed, trajectory, joint, time, frequency, time * frequency))
    columns = ["case", "method", "seed", "trajectory", "joint", "time", "frequency", "total"]
    frame = pd.DataFrame(rows, columns=columns)
    return frame if with_trajectory else frame.drop(columns="trajectory")


def estimate(case, method, seed):
    """A parameter set of its own for each."""
    return (NUMERIC.arms[case] * (1.0 + 0.01 * seed + 0.1 * METHODS.index(method))).tolist()


def test_every_table_and_figure_of_the_paper_is_there_once_in_its_order():
    labels = [exhibit.label for exhibit in catalogue.EXHIBITS if exhibit.label[-1].isdigit()]
    assert labels == [*(f"Table {n}" for n in range(1, 11)), *(f"Figure {n}" for n in range(1, 25))]
    names = [(exhibit.kind, exhibit.name) for exhibit in catalogue.EXHIBITS]
    assert len(set(names)) == len(names)
    assert len({exhibit.target for exhibit in catalogue.EXHIBITS}) == len(names)


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wiring")
    write_csv(folder / "numeric.csv", scores(NUMERIC.arms, with_trajectory=True))
    write_csv(folder / "arm.csv", scores(ARM, with_trajectory=False))
    for seed in SEEDS:
        arms = {
            case: {"true": beta.tolist(), "methods": {m: {"beta": estimate(case, m, seed)} for m in METHODS}}
            for case, beta in NUMERIC.arms.items()
        }
        write_json(folder / f"run{seed}.json", {"seed": seed, "variant": "published", "arms": arms})
    return {
        "scores": [folder / "numeric.csv"],
        "identifications": sorted(folder.glob("run*.json")),
        "arm": folder / "arm.csv",
    }


@pytest.mark.parametrize(
    ("name", "trajectory", "cases"),
    [("table06", "ID", tuple(NUMERIC.arms)), ("table07", "validation", tuple(NUMERIC.arms)), ("table10", "ID", ARM)],
)
def test_each_cell_of_a_table_of_similarities_is_its_own(inputs, name, trajectory, cases):
    given = {"scores": [inputs["arm"]]} if name == "table10" else inputs
    made = MADE["table", name]
    table = made.numbers(given, {})
    cells = table.set_index(["case", "method", "joint"])
    # One seed is the median of every cell, so that it is the one run too.
    one_run = ("algorithm1/one-run",) if name == "table10" else ()
    blocks = (METHODS[0], *one_run, *METHODS[1:])
    assert len(cells) == len(cases) * len(blocks) * 2
    for case, method, joint in itertools.product(cases, blocks, (1, 2)):
        time, frequency = score(case, method.removesuffix("/one-run"), trajectory, joint, MEDIAN)
        row = cells.loc[(case, method, joint)]
        assert row["time"] == pytest.approx(time, abs=1e-9)
        assert row["frequency"] == pytest.approx(frequency, abs=1e-9)
        assert row["total"] == pytest.approx(time * frequency, abs=1e-9)
    # In the layout: a block a method, in it three rows a joint, a column a case.
    lines = [line for line in made.draw(table).md("").splitlines() if line.startswith("| Total")]
    for (method, joint), line in zip(itertools.product(blocks, (1, 2)), lines, strict=True):
        shown = [float(cell.split()[0]) for cell in line.strip("| ").split(" | ")[1:]]
        of_method = method.removesuffix("/one-run")
        totals = [100.0 * np.prod(score(case, of_method, trajectory, joint, MEDIAN)) for case in cases]
        np.testing.assert_allclose(shown, totals, atol=0.0051)
        assert ("±" in line) == (method == of_method)


@pytest.mark.parametrize(("name", "cases"), [("table04", ("N1", "N2")), ("table05", ("N3", "N4"))])
def test_each_parameter_is_that_of_its_arm_method_and_median_seed(inputs, name, cases):
    table = MADE["table", name].numbers(inputs, {}).set_index(["case", "method"])
    for case, method in itertools.product(cases, METHODS):
        rows = table.loc[(case, method)]
        np.testing.assert_allclose(rows["true"], NUMERIC.arms[case], rtol=1e-9)
        np.testing.assert_allclose(rows["estimate"], estimate(case, method, MEDIAN), rtol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "trajectory", "cases", "in_frequency"),
    [
        ("fig12", "ID", ("N1", "N2"), False),
        ("fig13", "ID", ("N3", "N4"), False),
        ("fig14", "ID", ("N1", "N2", "N3", "N4"), True),
        ("fig15", "validation", ("N1", "N2", "N3", "N4"), False),
        ("fig17", "validation", ("N1", "N2", "N3", "N4"), True),
    ],
)
def test_each_curve_is_the_torque_of_its_arm_joint_and_motion(inputs, name, trajectory, cases, in_frequency):
    frame = MADE["figure", name].numbers(inputs, CONFIG)
    assert set(frame["panel"]) == {f"{case}/joint{j}" for case in cases for j in (1, 2)}
    motion = motion_of(trajectory, SIGNALS, NUMERIC, MEDIAN)
    for case, (series, beta) in itertools.product(
        cases, (("actual", NUMERIC.arms.get), ("rebuilt", lambda case: np.array(estimate(case, "algorithm1", MEDIAN))))
    ):
        tau = inverse_dynamics(motion.q, motion.dq, motion.ddq, beta(case))
        for j in (0, 1):
            curve = frame[(frame["panel"] == f"{case}/joint{j + 1}") & (frame["series"] == series)]
            expected = spectrum(tau[j]) if in_frequency else tau[j]
            np.testing.assert_allclose(curve["y"], expected, rtol=1e-9, atol=1e-9)
            highest = 1 / (2 * SIGNALS.h) * (1 - 1 / tau.shape[1]) if in_frequency else motion.time[-1]
            assert curve["x"].iloc[-1] == pytest.approx(highest)
