"""The 2 x 2 of causes: cells and effects against numbers that are computed by hand."""

import itertools

import numpy as np
import pandas as pd
import pytest

from repro.exhibits.causes import cells_and_effects, crossed

#: Training and motion of line 18, mean total of both joints on ID (of seeds 1 and 2) and over T1 to T4.
MEANS = {
    "algorithm1": (("ideal", "measured"), (0.55, 0.75), 0.30),
    "algorithm1+desired": (("ideal", "desired"), (0.92, 0.92), 0.40),
    "algorithm1+tracked-measured": (("tracked", "measured"), (0.61, 0.61), 0.35),
    "algorithm1+tracked": (("tracked", "desired"), (0.96, 0.96), 0.85),
}
KEYS = ("training", "image_motion", "response")


def scores():
    """Totals with these means: joints and motions differ around them."""
    rows = []
    for (method, (_, on_id, others)), seed in itertools.product(MEANS.items(), (1, 2)):
        rows += [("ID", method, seed, joint, on_id[seed - 1] + shift) for joint, shift in ((1, 0.03), (2, -0.03))]
        for motion, shift in (("T1", 0.1), ("T2", -0.04), ("T3", -0.05), ("T4", -0.01)):
            rows += [(motion, method, seed, joint, others + shift + 0.002 * (2 * joint - 3)) for joint in (1, 2)]
        rows += [(motion, "least-squares", seed, joint, 0.99) for motion in ("ID", "T1") for joint in (1, 2)]
    return pd.DataFrame(rows, columns=["case", "method", "seed", "joint", "total"]).sample(frac=1.0, random_state=3)


def test_cells_and_effects_by_hand():
    table = cells_and_effects(crossed(scores()))
    assert len(table) == (4 + 3) * 2
    assert set(table["seeds"]) == {2}
    cells, effects = (table[table["row"] == kind].set_index(list(KEYS)) for kind in ("cell", "effect"))
    for cell, on_id, others in MEANS.values():
        found = cells.loc[(*cell, "id"), ["value", "spread"]].tolist()
        assert found == pytest.approx([np.mean(on_id), np.std(on_id, ddof=1)], abs=1e-12)
        assert cells.loc[(*cell, "validation"), "value"] == pytest.approx(others, abs=1e-12)
    effects = effects.droplevel("image_motion")
    # Seed 1, ID: desired 0.92 and 0.96 over measured 0.55 and 0.61; seed 2: over 0.75 and 0.61.
    by_hand = {"image_motion": (0.36, 0.26), "training": (0.05, -0.05), "both": (-0.01, 0.09)}
    for name, of_seeds in by_hand.items():
        found = effects.loc[(name, "id"), ["value", "spread"]].tolist()
        assert found == pytest.approx([np.mean(of_seeds), np.std(of_seeds, ddof=1)], abs=1e-12)
    for name, value in {"image_motion": 0.3, "training": 0.25, "both": 0.2}.items():
        assert effects.loc[(name, "validation"), ["value", "spread"]].tolist() == pytest.approx([value, 0.0], abs=1e-12)
