"""Methods compared over experiments: the interval and the test it belongs to, the correction, and the conclusions."""

import itertools

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from repro.experiments.monte_carlo import COMPARISON_COLUMNS, comparisons, conclude, holm, interval

FACTORS = {"algorithm1": 1.0, "least-squares": 0.0}


def scores_of(differences, factors=FACTORS):
    """Totals of both joints: over T1 to T4, a method is above a base by its factor of the differences on average."""
    rows = []
    for experiment, d in enumerate(differences):
        for k, (case, joint) in enumerate(itertools.product(("ID", "T1", "T2", "T3", "T4"), (1, 2))):
            uneven = d + 0.01 * (k - 5.5) if case != "ID" else -5.0  # the mean of k = 2 ... 9 is 5.5
            base = 0.9 + 0.03 * experiment + 0.001 * k
            rows += [(case, joint, experiment, method, base + factor * uneven) for method, factor in factors.items()]
    return pd.DataFrame(rows, columns=["case", "joint", "experiment", "method", "total"])


def averages_of(x):
    """Walsh averages, sorted."""
    return np.sort([(a + b) / 2 for a, b in itertools.combinations_with_replacement(x, 2)])


def compared(differences):
    shuffled = scores_of(differences).sample(frac=1.0, random_state=1)
    table = comparisons(shuffled, ["algorithm1"], ["least-squares"])
    assert tuple(table.columns) == COMPARISON_COLUMNS
    return table.iloc[0]


@settings(max_examples=30)
@given(st.lists(st.floats(-1, 1), min_size=6, max_size=15, unique=True), st.sampled_from([0.8, 0.95]))
def test_the_interval_holds_the_centres_that_the_test_does_not_reject(values, level):
    x = np.array(values)
    _, low, high = interval(x, level)
    averages = averages_of(x)
    centres = (0.5 * (averages[1:] + averages[:-1]))[np.diff(averages) > 1e-9]
    p = stats.wilcoxon(x - centres[:, np.newaxis], method="exact", axis=1).pvalue
    np.testing.assert_array_equal(p > 1.0 - level + 1e-12, (low < centres) & (centres < high))


def test_too_few_values_cannot_reach_the_level():
    assert interval(np.array([0.1, 0.2, 0.3, 0.4, 0.5]), 0.95)[1:] == (-np.inf, np.inf)
    assert np.isfinite(interval(np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6]), 0.95)).all()


def test_holm_by_hand():
    np.testing.assert_allclose(holm(np.array([0.01, 0.04, 0.03, 0.005])), [0.03, 0.06, 0.06, 0.02])
    np.testing.assert_allclose(holm(np.array([0.5, 0.9])), [1.0, 1.0])


@pytest.mark.parametrize(
    ("low", "high", "sign", "conclusion"),
    [
        (0.01, 0.03, 1, "better"),
        (-0.03, -0.01, -1, "worse"),
        (-0.01, 0.03, 0, "open"),
        (0.001, 0.0049, 1, "equivalent"),
        (0.001, 0.0051, 1, "better"),
        (-0.0051, 0.004, 0, "open"),
    ],
)
def test_each_conclusion(low, high, sign, conclusion):
    assert conclude(low, high, sign) == conclusion


def test_experiments_are_the_unit_and_id_does_not_count():
    differences = [0.01, 0.03, 0.02, -0.05, 0.04, 0.06, 0.07]
    row = compared(differences)
    assert (row["experiments"], row["wins"]) == (7, 6)
    assert row["difference"] == pytest.approx(np.median(averages_of(differences)))
    assert row["p"] == pytest.approx(stats.wilcoxon(differences).pvalue)


def test_equal_methods_are_no_reason_to_reject():
    row = compared([0.0] * 8)
    assert row["p"] > 0.05
    assert (row["wins"], row["conclusion"]) == (0, "equivalent")


def test_every_pair_of_a_family_is_corrected_together():
    factors = {"algorithm1": 1.0, "algorithm1+refinement": 2.0, "least-squares": 0.0, "bounded": 0.25}
    differences = 0.02 + 0.001 * np.arange(9)
    table = comparisons(scores_of(differences, factors), [*factors][:2], [*factors][2:])
    assert len(table) == 2 * 2
    for row in table.itertuples():
        expected = interval((factors[row.method] - factors[row.opponent]) * differences, 1.0 - 0.05 / 4)
        assert (row.difference, row.low, row.high) == pytest.approx(expected)
        assert (row.experiments, row.wins, row.conclusion) == (9, 9, "better")
        assert (row.p, row.p_holm) == pytest.approx((2 / 2**9, 4 * 2 / 2**9))
