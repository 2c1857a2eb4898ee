"""Tables of the accepted experiments: medians, ranges, whether the print is inside, and who is above least squares."""

import pandas as pd
import pytest
from print_compatible_example import guess_scores

from repro.exhibits import print_compatible
from repro.files import write_csv
from repro.paper.published import load_published


@pytest.fixture(scope="module")
def scores(tmp_path_factory):
    folder, frame = tmp_path_factory.mktemp("scores"), guess_scores()
    for experiment, own in frame.groupby("experiment"):
        write_csv(folder / f"experiment-{experiment}.csv", own)
    return {"scores": sorted(folder.glob("*.csv"))}


def test_rows_of_methods_and_budgets(scores):
    table = print_compatible.accepted_table.numbers(scores, {}).set_index(["unit", "method", "guesses"])
    listed = table.loc["all", "algorithm1", 100_000]
    assert listed["experiments"] == 4
    assert listed["id1_median"] == pytest.approx(0.88)
    assert listed["id2_median"] == pytest.approx(0.89)
    # Experiments 3, 5, 8 and 9 are at 0.88 - 0.008, 0, + 0.012 and + 0.016.
    assert listed["mean_median"] == pytest.approx(0.886)
    assert listed["wins"] == 1  # least squares is at 0.895, the mean of its joints
    assert (listed["wins_low"], listed["wins_high"]) == pytest.approx((0.0063, 0.8059), abs=1e-4)  # Clopper and Pearson
    assert listed["met"] == pytest.approx(4.0)  # seeds 2, 6, 7
    assert table.loc[("index", "algorithm1", 100_000), "wins"] == 0
    assert table.loc[("rad_per_s", "algorithm1+desired", 100_000), "wins"] == 2
    assert table.loc[("all", "algorithm1", 1_000_000), "experiments"] == 1
    assert ("rad_per_s", "algorithm1", 1_000_000) not in table.index
    assert table.loc[("all", "least-squares", 0), "wins"] == 0


def test_cells_next_to_the_print(scores):
    cells = print_compatible.accepted_cells.numbers(scores, {}).set_index(["method", "guesses", "case", "joint"])
    published = load_published()
    t1 = cells.loc["algorithm1+desired", 100_000, "T1", 2]
    assert t1["published"] == pytest.approx(published["table10/T1/algorithm1/total/joint2"].value / 100)
    assert (t1["low"], t1["high"]) == pytest.approx((0.915 - 0.008 + 0.0006, 0.915 + 0.016 - 0.0003), abs=1e-4)
    assert t1["inside"]
    assert not cells.loc["algorithm1", 1000, "T1", 2]["inside"]
    of_squares = cells.loc["least-squares", 0, "T2", 1]
    assert of_squares["published"] == pytest.approx(published["table10/T2/least-squares/total/joint1"].value / 100)
    mean = cells.loc["bounded", 0, print_compatible.MEAN, 0]
    assert mean["published"] == pytest.approx(0.9174, abs=1e-4)


def test_hypotheses_are_counted(tmp_path):
    rows = [("index", True, "printed", True, 50.0), ("index", True, "printed", False, 90.0)]
    rows += [("rad_per_s", False, "swapped", False, 130.0)]
    starts = pd.DataFrame(rows, columns=[*print_compatible.HYPOTHESIS, "accepted", "misfit"])
    write_csv(tmp_path / "starts.csv", starts)
    table = print_compatible.hypotheses.numbers({"starts": [tmp_path / "starts.csv"]}, {})
    found = table.set_index("unit")[["starts", "accepted", "smallest", "median"]]
    assert found.loc["index"].tolist() == [2, 1, 50.0, 70.0]
    assert found.loc["rad_per_s"].tolist() == [1, 0, 130.0, 130.0]
