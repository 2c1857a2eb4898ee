"""The headline of a run, and what a run ends with on the screen."""

import numpy as np
import pandas as pd
import pytest
from exhibit_examples import ROOT
from experiment_example import refused
from report_example import make_example

from repro.files import read_csv, write_csv
from repro.report.headline import (
    COLUMNS,
    answer,
    closing_lines,
    headline,
    longer_searches,
    means,
    published_headline,
)

REFERENCE = ROOT / "docs/reference"


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    return make_example(tmp_path_factory.mktemp("report"))


def test_means_are_over_the_cases_and_joints_of_their_column():
    found = headline(REFERENCE / "tables")
    for column, (name, cases) in COLUMNS.items():
        cells = read_csv(REFERENCE / f"tables/{name}.csv").query("method == 'bounded'").set_index(["case", "joint"])
        expected = sum(cells.loc[(case, joint), "total"] for case in cases for joint in (1, 2)) / (2 * len(cases))
        np.testing.assert_allclose(found.loc["bounded", column], expected, rtol=1e-12)


def test_a_method_that_lacks_a_cell_has_no_mean():
    scores = read_csv(REFERENCE / "tables/table10.csv")
    lost = scores.query("method == 'bounded' and case == 'T3' and joint == 2")
    found = means(scores.drop(lost.index), "arm, T1 to T4")
    assert np.isnan(found["bounded"]) and found["least-squares"] > 0.0


def test_published_means_are_those_of_the_printed_tables():
    expected = [["above 97.38", "97.45", "94.03", "91.74"], ["", "", "94.06", "89.17"]]
    assert published_headline().loc[["algorithm1", "least-squares"]].to_numpy().tolist() == expected


def test_a_run_ends_with_its_headline(inputs):
    lines = closing_lines(inputs.results, inputs.figures)
    own = headline(inputs.results / "tables").loc["least-squares"]
    (line,) = (line for line in lines if line.startswith("  Least squares  "))
    assert line.split()[2:] == [f"{100 * number:.2f}" for number in own]
    (line,) = (line for line in lines if line.startswith("  Published, least squares  "))
    assert line.split()[3:] == ["94.06", "89.17"]
    assert len({len(line) for line in lines if line.startswith("  ") and "quares" in line}) == 1


def test_a_run_ends_with_the_command_that_verifies_it(inputs):
    for files, option in ((("a.yaml",), ""), (("a.yaml", "b.yaml"), " --config a.yaml b.yaml")):
        last = closing_lines(inputs.results, inputs.figures, files)[-1]
        assert last == f"check: .venv/bin/repro verify --results {inputs.results}{option}"


def test_a_run_without_a_ledger_ends_silently(tmp_path):
    assert closing_lines(tmp_path, tmp_path) == []


@pytest.mark.parametrize(
    ("conclusion", "word"), [("better", "Yes"), ("worse", "No"), ("open", "Undecided"), ("equivalent", "Neither")]
)
def test_the_answer_follows_the_conclusion(inputs, conclusion, word, tmp_path):
    rows = read_csv(inputs.results / "tables" / "verdict.csv")
    asked = (rows["method"] == "algorithm1") & (rows["opponent"] == "least-squares")
    rows.loc[asked, "conclusion"] = conclusion
    write_csv(tmp_path / "tables" / "verdict.csv", rows)
    found = answer(tmp_path, 30)
    assert found.word == word and "30 guesses" in found.why and len(found.pairs) == len(rows)
    write_csv(tmp_path / "tables" / "verdict.csv", rows[~asked])
    assert refused(answer, tmp_path, 30).place.endswith("verdict.csv: method")


def test_longer_searches_are_those_that_all_experiments_have(tmp_path):
    table = {"unit": "all", "experiments": 7, "mean_median": 0.5}
    rows = [
        {**table, "method": "algorithm1", "guesses": 1000, "mean_median": 0.61},
        {**table, "method": "algorithm1", "guesses": 20_000, "mean_median": 0.724},
        {**table, "method": "algorithm1", "guesses": 300_000, "experiments": 2},
        {**table, "method": "least-squares", "guesses": 0, "mean_median": 0.888},
        {**table, "method": "least-squares", "guesses": 0, "experiments": 5, "unit": "index"},
    ]
    write_csv(tmp_path / "accepted.csv", pd.DataFrame(rows))
    expected = {"guesses": "20,000", "experiments": "7", "algorithm1": "72.4", "least_squares": "88.8"}
    assert longer_searches(tmp_path / "accepted.csv") == expected
