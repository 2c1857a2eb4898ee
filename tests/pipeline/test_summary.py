"""Tables 4 to 7 from the runs of all seeds: one seed stands for a case, the others give the spread."""

import itertools

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from repro.errors import InputError
from repro.model.parameters import NAMES, UNITS
from repro.pipeline.summary import experiment_table, median_cells, median_seeds, parameter_table

CASES = ("N1", "N2")
TWO = ("algorithm1", "algorithm1+refinement")
SIMILARITY = ["case", "method", "joint", "time", "frequency", "total", "total_sd", "seeds"]
PARAMETERS = ["case", "method", "parameter", "unit", "true", "estimate", "estimate_sd"]


def make_scores(seeds, level, methods=TWO):
    """Scores whose factors `level` gives from case, method, seed, trajectory and joint, in any order."""
    rows = []
    for key in itertools.product(CASES, methods, seeds, ("ID", "validation"), (1, 2)):
        time, frequency = level(*key)
        rows.append((*key, time, frequency, time * frequency))
    columns = ["case", "method", "seed", "trajectory", "joint", "time", "frequency", "total"]
    return pd.DataFrame(rows, columns=columns).sample(frac=1.0, random_state=5)


def by_seed(totals):
    """Level with the given mean ID total for each seed, unlike on validation."""
    return lambda case, method, seed, trajectory, joint: (1.0, totals[seed] if trajectory == "ID" else 1 - totals[seed])


@pytest.mark.parametrize(
    ("totals", "expected"),
    [
        ({7: 0.9}, 7),
        ({1: 0.2, 2: 0.9, 3: 0.5}, 3),
        ({1: 0.9, 2: 0.1, 3: 0.2, 4: 0.8, 5: 0.3}, 5),
        ({1: 0.9, 2: 0.1}, 1),  # even: the better of the two in the middle
        ({1: 0.4, 2: 0.1, 3: 0.9, 4: 0.6}, 4),
    ],
)
def test_the_median_seed_on_the_identification_trajectory_stands_for_a_case(totals, expected):
    chosen = median_seeds(make_scores(totals, by_seed(totals)))
    assert chosen == {(case, method): expected for case in CASES for method in TWO}


@pytest.mark.slow
@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1), st.integers(1, 6), st.sampled_from(["ID", "validation"]))
def test_a_row_is_one_seed_s_own_so_that_total_is_time_times_frequency(seed, count, trajectory):
    rng = np.random.default_rng(seed)
    scores = make_scores(range(1, count + 1), lambda *_: tuple(rng.uniform(0.5, 1.0, 2)))
    scores = scores[scores["trajectory"] == trajectory]
    table = median_cells(scores)
    assert list(table.columns) == SIMILARITY
    assert len(table) == len(CASES) * len(TWO) * 2
    for row in table.itertuples():
        own = scores[(scores[["case", "method", "joint"]] == [row.case, row.method, row.joint]).all(axis=1)]
        assert row.seeds == count
        assert row.total_sd == pytest.approx(np.std(own["total"], ddof=1) if count > 1 else 0.0, rel=1e-12)
        # The cell's own median; of an even number, the upper of the two in the middle.
        own = own[own["total"] == sorted(own["total"])[count // 2]]
        assert own[["time", "frequency", "total"]].to_numpy().tolist() == [[row.time, row.frequency, row.total]]


def test_equal_values_have_no_spread():
    """Whatever rounding makes of their mean."""
    table = median_cells(make_scores((1, 2, 3), lambda *_: (0.9983, 0.1)).query("trajectory == 'ID'"))
    assert (table["total_sd"] == 0.0).all()
    assert (table["seeds"] == 3).all()


#: Totals of Algorithm 1 by motion and seed. The mean of both joints on ID puts seed 2 in the middle; the median of
#: joint 1 on ID is that of seed 1, and the median on T1 that of seed 3.
TOTALS = {"ID": {1: (0.5, 0.2), 2: (0.3, 0.8), 3: (0.9, 0.9)}, "T1": {1: (0.1, 0.7), 2: (0.9, 0.1), 3: (0.4, 0.4)}}


def test_a_block_of_one_run_is_of_the_seed_that_is_the_median_on_id_and_medians_stay():
    rows = [
        (case, method, seed, joint, 2.0 * both[joint - 1], 0.5, both[joint - 1])
        for case, of_case in TOTALS.items()
        for method in ("least-squares", "algorithm1")
        for seed, both in of_case.items()
        for joint in (2, 1)
    ]
    columns = ["case", "method", "seed", "joint", "time", "frequency", "total"]
    table = experiment_table(pd.DataFrame(rows, columns=columns))
    assert list(table.columns) == SIMILARITY
    expected = {
        "algorithm1": (0.5, 0.8, 0.4, 0.4),
        "algorithm1/one-run": (0.3, 0.8, 0.9, 0.1),
        "least-squares": (0.5, 0.8, 0.4, 0.4),
    }
    places = [("ID", 1), ("ID", 2), ("T1", 1), ("T1", 2)]
    rows = [(method, *place) for method in expected for place in places]
    assert list(table[["method", "case", "joint"]].itertuples(index=False, name=None)) == rows
    assert table["total"].tolist() == [total for totals in expected.values() for total in totals]
    np.testing.assert_allclose(table["time"], 2.0 * table["total"])
    one = table["method"] == "algorithm1/one-run"
    assert (table.loc[one, "seeds"] == 1).all()
    assert (table.loc[one, "total_sd"] == 0.0).all()
    assert (table.loc[~one, "seeds"] == 3).all()
    assert (table.loc[~one, "total_sd"] > 0).all()


def test_a_method_without_a_place_in_the_tables_is_refused_in_one_line():
    with pytest.raises(InputError, match=r"^results: method: found guessing, expected one of algorithm1, "):
        median_cells(make_scores((1,), lambda *_: (0.9, 0.8), methods=("guessing",)))


def run_of(seed):
    """Estimates of the true parameters plus a tenth of the seed, and 1 more by the second method."""
    arms = {}
    for k, case in enumerate(CASES):
        true = 0.1 * (k + 1) + 0.01 * np.arange(9)
        methods = {method: {"beta": (true + 0.1 * seed + m).tolist()} for m, method in enumerate(TWO)}
        arms[case] = {"true": true.tolist(), "methods": methods}
    return {"variant": "published", "seed": seed, "arms": arms}


def test_parameters_are_those_of_the_seed_that_the_similarity_is_of():
    totals = {1: 0.3, 2: 0.9, 3: 0.5}
    table = parameter_table([run_of(seed) for seed in totals], make_scores(totals, by_seed(totals)), CASES)
    assert list(table.columns) == PARAMETERS
    assert len(table) == len(CASES) * len(TWO) * 9
    offset = 0.3 + table["method"].map({TWO[0]: 0, TWO[1]: 1})
    np.testing.assert_allclose(table["estimate"], table["true"] + offset, rtol=1e-12)
    np.testing.assert_allclose(table["estimate_sd"], 0.1, rtol=1e-9)  # of 0.1, 0.2 and 0.3
    for _, group in table.groupby(["case", "method"]):
        assert tuple(group["parameter"]) == NAMES
        assert tuple(group["unit"]) == UNITS
