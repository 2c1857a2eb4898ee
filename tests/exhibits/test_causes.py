"""The 2 x 2 of causes: cells and effects against numbers that are computed by hand."""

import itertools

import numpy as np
import pandas as pd
import pytest

from repro.exhibits.causes import crossed, why_table

CELLS = {
    "algorithm1": ("ideal", "measured"),
    "algorithm1+desired": ("ideal", "desired"),
    "algorithm1+tracked-measured": ("tracked", "measured"),
    "algorithm1+tracked": ("tracked", "desired"),
}
#: Mean total of both joints on ID, of seeds 1 and 2.
ON_ID = {
    "algorithm1": (0.55, 0.75),
    "algorithm1+desired": (0.92, 0.92),
    "algorithm1+tracked-measured": (0.61, 0.61),
    "algorithm1+tracked": (0.96, 0.96),
}
#: The same over T1 to T4.
ON_OTHERS = {
    "algorithm1": (0.30, 0.30),
    "algorithm1+desired": (0.40, 0.40),
    "algorithm1+tracked-measured": (0.35, 0.35),
    "algorithm1+tracked": (0.85, 0.85),
}


def scores(seeds=(1, 2)):
    """Totals with these means: joints and motions differ around them."""
    rows = []
    for method, seed in itertools.product(CELLS, seeds):
        on_id, others = ON_ID[method][seed - 1], ON_OTHERS[method][seed - 1]
        rows += [("ID", method, seed, joint, on_id + shift) for joint, shift in ((1, 0.03), (2, -0.03))]
        for motion, shift in (("T1", 0.1), ("T2", -0.04), ("T3", -0.05), ("T4", -0.01)):
            rows += [(motion, method, seed, joint, others + shift + 0.002 * (2 * joint - 3)) for joint in (1, 2)]
    rows += [
        (motion, "least-squares", seed, joint, 0.99) for motion in ("ID", "T1") for seed in seeds for joint in (1, 2)
    ]
    return pd.DataFrame(rows, columns=["case", "method", "seed", "joint", "total"])


def rows_of(table, kind):
    return table[table["row"] == kind].set_index(["training", "image_motion", "response"])


@pytest.mark.parametrize("order", [None, 3])
def test_each_cell_is_the_mean_over_joints_and_motions_of_its_variant(order):
    given = scores() if order is None else scores().sample(frac=1.0, random_state=order)
    cells = crossed(given)
    assert len(cells) == 4 * 2 * 2  # without least squares
    found = cells.set_index(["training", "image_motion", "seed", "response"])["value"]
    for method, cell in CELLS.items():
        for seed in (1, 2):
            assert found[(*cell, seed, "id")] == pytest.approx(ON_ID[method][seed - 1], abs=1e-12)
            assert found[(*cell, seed, "validation")] == pytest.approx(ON_OTHERS[method][seed - 1], abs=1e-12)


def test_cells_and_effects_by_hand():
    table = why_table(crossed(scores()))
    assert len(table) == (4 + 3) * 2
    assert set(table["seeds"]) == {2}
    cells = rows_of(table, "cell")
    first = cells.loc[("ideal", "measured", "id")]
    assert first["value"] == pytest.approx(0.65, abs=1e-12)
    assert first["spread"] == pytest.approx(0.2 / np.sqrt(2), abs=1e-12)
    assert cells.loc[("tracked", "desired", "validation"), "value"] == pytest.approx(0.85, abs=1e-12)
    effects = rows_of(table, "effect").droplevel("image_motion")
    # Seed 1, ID: desired 0.92 and 0.96 over measured 0.55 and 0.61; seed 2: over 0.75 and 0.61.
    by_hand = {"image_motion": (0.36, 0.26), "training": (0.05, -0.05), "both": (-0.01, 0.09)}
    for name, of_seeds in by_hand.items():
        row = effects.loc[(name, "id")]
        assert row["value"] == pytest.approx(np.mean(of_seeds), abs=1e-12)
        assert row["spread"] == pytest.approx(np.std(of_seeds, ddof=1), abs=1e-12)
    # T1 to T4: neither cause alone does much, both together do.
    for name, value in {"image_motion": 0.3, "training": 0.25, "both": 0.2}.items():
        row = effects.loc[(name, "validation")]
        assert row["value"] == pytest.approx(value, abs=1e-12)
        assert row["spread"] == pytest.approx(0.0, abs=1e-12)


def test_one_seed_has_no_spread():
    table = why_table(crossed(scores(seeds=(1,))))
    assert (table["spread"] == 0.0).all()
    assert set(table["seeds"]) == {1}
    assert rows_of(table, "effect").loc[("both", "", "id"), "value"] == pytest.approx(-0.01, abs=1e-12)
