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


def make_scores(seeds, level, cases=CASES, methods=TWO):
    """Scores whose factors `level` gives from case, method, seed, trajectory and joint."""
    rows = []
    for key in itertools.product(cases, methods, seeds, ("ID", "validation"), (1, 2)):
        time, frequency = level(*key)
        rows.append((*key, time, frequency, time * frequency))
    columns = ["case", "method", "seed", "trajectory", "joint", "time", "frequency", "total"]
    return pd.DataFrame(rows, columns=columns)


def random_scores(seeds, seed=0, **more):
    rng = np.random.default_rng(seed)
    return make_scores(seeds, lambda *_: tuple(rng.uniform(0.5, 1.0, 2)), **more)


def cell(scores, row, trajectory):
    """Scores of all seeds behind a row of a table."""
    same = (scores["case"] == row.case) & (scores["method"] == row.method) & (scores["joint"] == row.joint)
    return scores[same & (scores["trajectory"] == trajectory)]


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
@given(st.integers(0, 2**32 - 1), st.integers(1, 6))
def test_the_order_of_the_rows_does_not_matter(seed, count):
    scores = random_scores(range(1, count + 1), seed)
    shuffled = scores.sample(frac=1.0, random_state=seed % 1000)
    assert median_seeds(scores) == median_seeds(shuffled)
    for trajectory in ("ID", "validation"):
        both = (each[each["trajectory"] == trajectory] for each in (scores, shuffled))
        one, other = (median_cells(each).reset_index(drop=True) for each in both)
        pd.testing.assert_frame_equal(one, other)


@pytest.mark.slow
@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1), st.integers(1, 6), st.sampled_from(["ID", "validation"]))
def test_a_row_is_one_seed_s_own_so_that_total_is_time_times_frequency(seed, count, trajectory):
    scores = random_scores(range(1, count + 1), seed)
    table = median_cells(scores[scores["trajectory"] == trajectory])
    assert list(table.columns) == SIMILARITY
    assert len(table) == len(CASES) * len(TWO) * 2
    np.testing.assert_allclose(table["total"], table["time"] * table["frequency"], rtol=1e-12)
    for row in table.itertuples():
        own = cell(scores, row, trajectory)
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


def arm_totals(methods, totals):
    rows = [
        (case, method, seed, joint, 2.0 * total, 0.5, total)
        for case, by_seed in totals.items()
        for method in methods
        for seed, both in by_seed.items()
        for joint, total in zip((2, 1), reversed(both), strict=True)
    ]
    return pd.DataFrame(rows, columns=["case", "method", "seed", "joint", "time", "frequency", "total"])


def test_a_block_of_one_run_is_of_the_seed_that_is_the_median_on_id_and_medians_stay():
    table = experiment_table(arm_totals(("least-squares", "algorithm1"), TOTALS), "ID")
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
        median_cells(random_scores((1,), methods=("guessing",)))


def make_runs(seeds, methods=TWO, cases=CASES, variant="published"):
    """Runs whose estimates are the true parameters plus a tenth of the seed."""
    true = {case: (0.1 * (k + 1) + 0.01 * np.arange(9)).tolist() for k, case in enumerate(cases)}
    return [
        {
            "variant": variant,
            "seed": seed,
            "arms": {
                case: {
                    "true": true[case],
                    "methods": {m: {"beta": [x + 0.1 * seed + k for x in true[case]]} for k, m in enumerate(methods)},
                }
                for case in cases
            },
        }
        for seed in seeds
    ]


def test_parameters_are_those_of_the_seed_that_the_similarity_is_of():
    totals = {1: 0.3, 2: 0.9, 3: 0.5}
    table = parameter_table(make_runs(totals), make_scores(totals, by_seed(totals)), CASES)
    assert list(table.columns) == PARAMETERS
    assert len(table) == len(CASES) * len(TWO) * 9
    offset = 0.3 + table["method"].map({TWO[0]: 0, TWO[1]: 1})
    np.testing.assert_allclose(table["estimate"], table["true"] + offset, rtol=1e-12)
    np.testing.assert_allclose(table["estimate_sd"], 0.1, rtol=1e-9)  # of 0.1, 0.2 and 0.3
    for _, group in table.groupby(["case", "method"]):
        assert tuple(group["parameter"]) == NAMES
        assert tuple(group["unit"]) == UNITS
