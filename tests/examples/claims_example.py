"""A small project with made-up results: everything that a ledger is made from, in a folder of its own."""

import shutil
from dataclasses import replace
from pathlib import Path

import pandas as pd
import yaml

from repro.config.check import load_config
from repro.files import read_csv, write_csv
from repro.model.parameters import NAMES
from repro.paper.ledger import write_ledger
from repro.paper.published import PUBLISHED_FILE, Published, load_published

ROOT = Path(__file__).resolve().parents[2]
CONFIG = ROOT / "config" / "config.yaml"
NUMERIC, EXPERIMENT = ("N1", "N2", "N3", "N4"), ("ID", "T1", "T2", "T3", "T4")
METHODS = {"algorithm1": 0.975, "algorithm1+refinement": 0.99, "algorithm1+tracked": 0.97, "least-squares": 0.98}
#: Totals of the seeds about the one that a table shows: their standard deviation is 0.002.
SEEDS = {1: -0.002, 2: 0.0, 3: 0.002}
LOSS = 2.5e-4
#: Table 9 by method: Algorithm 1 as Section V-C describes the paper's, b2 of least squares below that of Algorithm 1.
ARM = {
    "algorithm1": (0.12, 0.02, 0.05, 0.6, 0.04, 0.08, 0.1, 0.4, 0.25),
    "least-squares": (0.1, -0.01, 0.03, 0.8, 0.06, 0.32, 0.05, 0.3, 0.2),
}
#: What the arm of the appendix gives, to more digits than printed.
APPENDIX = {
    "Potential energy (Eq. 17)": (0.00719567, 0.0),
    "Energy (Eq. 17)": (6.20199e-05, 0.0),
    "Dissipation (Eq. 18)": (1.36587e-07, 7.12356e-08),
    "Rate (Eq. 19)": (3.44216e-06, 1.89856e-06),
}


def printed_as(printed):
    """Numbers of the paper with some of them printed otherwise."""
    return Published(tuple(replace(v, printed=printed.get(v.id, v.printed)) for v in load_published()))


def similarities(cases, methods):
    """Table of similarities: the frequency factor is 1, so totals are the time factors."""
    rows = [(c, m, j, v, 1.0, v, 0.01, 3) for c in cases for m, v in methods.items() for j in (1, 2)]
    return pd.DataFrame(rows, columns=["case", "method", "joint", "time", "frequency", "total", "total_sd", "seeds"])


def scores(table):
    """Scores of every seed behind such a table."""
    frames = [table.assign(seed=k, time=table["time"] + off, total=table["total"] + off) for k, off in SEEDS.items()]
    return pd.concat(frames)[["case", "method", "seed", "joint", "time", "frequency", "total"]]


def parameters(*sets):
    """Table of parameters from cases, methods, true values and estimates."""
    rows = [
        (case, method, name, "SI", true, estimate, 0.0)
        for case, method, of_arm, estimates in sets
        for name, true, estimate in zip(NAMES, of_arm, estimates, strict=True)
    ]
    return pd.DataFrame(rows, columns=["case", "method", "parameter", "unit", "true", "estimate", "estimate_sd"])


def write_results(folder):
    """Write every result file that a ledger needs."""
    arms = yaml.safe_load(CONFIG.read_text(encoding="utf-8"))["numeric"]["arms"]
    # One per cent too high.
    estimated = [(case, "algorithm1", arms[case], [1.01 * value for value in arms[case]]) for case in NUMERIC]
    numeric, experiment = similarities(NUMERIC, METHODS), similarities(EXPERIMENT, METHODS)
    bounds = ["method", "quantity", "symbol", "value", "bound", "holds"]
    stability = [
        (method, quantity, "", scale * value, scale * bound, True)
        for method, scale in (("algorithm1", 2.0), ("true", 3.0), ("appendix", 1.0))
        for quantity, (value, bound) in APPENDIX.items()
    ]
    history = {"step": [100, 200], "learning_rate": 1e-3, "train_loss": 0.1, "test_loss": [0.02, LOSS]}
    files = {
        "tables/table04.csv": parameters(*estimated[:2]),
        "tables/table05.csv": parameters(*estimated[2:]),
        "tables/table06.csv": numeric,
        "tables/table07.csv": numeric,
        "tables/table08.csv": similarities(["tracking"], {"pd": 0.9967}),
        "tables/table09.csv": parameters(*(("ID", method, [1.0] * 9, found) for method, found in ARM.items())),
        "tables/table10.csv": experiment,
        "tables/stability.csv": pd.DataFrame(stability, columns=bounds),
        "tables/board_size.csv": read_csv(ROOT / "docs/reference/tables/board_size.csv"),
        "model/training.csv": pd.DataFrame(history),
        "validation/numeric.csv": pd.concat([scores(numeric).assign(trajectory=name) for name in ("ID", "validation")]),
        "validation/experiment.csv": scores(experiment),
    }
    for name, frame in files.items():
        write_csv(folder / name, frame)


def make_project(root):
    """Write a project with results and their ledger, and a copy of the published numbers."""
    (root / "config").mkdir()
    shutil.copy(CONFIG, root / "config")
    shutil.copytree(ROOT / "workflow/schemas", root / "workflow/schemas")
    captures = root / "data" / "captures"
    captures.mkdir(parents=True)
    (captures / "ID.bin").write_bytes(bytes(range(64)))
    (captures / "ID.json").write_text('{"motion": "ID"}', encoding="utf-8")
    shutil.copy(PUBLISHED_FILE, root / "published.csv")
    results = root / "results"
    write_results(results)
    shutil.copy(CONFIG, results)
    write_ledger(results, load_config(CONFIG), [], root, folders=[Path("results")])
