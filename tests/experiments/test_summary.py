"""Tables 4 to 7 from the runs of all seeds: one seed stands for a case, the others give the spread."""

import itertools

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from repro.errors import InputError
from repro.experiments.summary import median_cells, median_seeds

CASES = ("N1", "N2")
TWO = ("algorithm1", "algorithm1+refinement")
SIMILARITY = ["case", "method", "joint", "time", "frequency", "total", "total_sd", "seeds"]


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
    assert table[["total_sd", "seeds"]].drop_duplicates().to_numpy().tolist() == [[0.0, 3]]


def test_a_method_without_a_place_in_the_tables_is_refused_in_one_line():
    with pytest.raises(InputError, match=r"^results: method: found guessing, expected one of algorithm1, "):
        median_cells(make_scores((1,), lambda *_: (0.9, 0.8), methods=("guessing",)))
