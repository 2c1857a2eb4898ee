"""Classes of numbers, and two runs side by side: what may differ, what may not, and where it is."""

import json
import os
import re
from dataclasses import replace
from importlib import import_module

import pandas as pd
import pytest
from experiment_example import ROOT, refused

from repro.cli import main
from repro.comparison import (
    ABSOLUTE,
    LARGEST,
    MARGIN,
    OF_SEEDS,
    RELATIVE,
    Kind,
    Tolerances,
    compare_runs,
    differences,
    origin,
    reproducible,
)
from repro.exhibits.catalogue import tolerances
from repro.files import read_csv


@pytest.fixture
def measure(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "benchmarks")
    return import_module("training_spread").measure


SPREAD = Tolerances(widest={("tables/table10", "algorithm1", "total"): 0.05})
ROWS = [
    {"case": "ID", "method": "algorithm1", "joint": "1", "total": "0.9", "seeds": "5"},
    {"case": "ID", "method": "least-squares", "joint": "1", "total": "0.97", "seeds": "5"},
]


def changed(row, column, text):
    return [{**each, column: text} if k == row else each for k, each in enumerate(ROWS)]


STEADY = Tolerances(widest={("tables/table10", "algorithm1", "total"): 0.0})
TRAINED, LINEAR = ROWS
VERDICT = {**TRAINED, "verdict": "better"}


@pytest.mark.parametrize(
    ("row", "column", "text", "kind", "broken"),
    [
        (LINEAR, "total", "0.9700000001", Kind.COMPUTED, False),
        (LINEAR, "total", "0.97000003", Kind.COMPUTED, True),
        (TRAINED, "total", "0.81", Kind.TRAINED, False),  # twice the measured spread of 0.05
        (TRAINED, "total", "1.01", Kind.TRAINED, True),
        (TRAINED, "total", "nan", Kind.TRAINED, True),
        (TRAINED, "total", "n/a", Kind.TRAINED, True),
        (LINEAR, "total", "-1e999", Kind.COMPUTED, True),
        (LINEAR, "total", "n/a", Kind.COMPUTED, True),
        (TRAINED, "seeds", "4", Kind.COMPUTED, True),  # counts are exact in a trained row too
        (LINEAR, "method", "true", Kind.EXACT, True),
        # Names of rows are exact, also where a network had a part.
        (VERDICT, "case", "other", Kind.EXACT, True),
        (VERDICT, "method", "other", Kind.EXACT, True),
        (VERDICT, "verdict", "other", Kind.EXACT, True),  # which no number of its row explains
        # Numbers near zero are compared absolutely.
        ({"x": "0"}, "x", f"{0.9 * ABSOLUTE:g}", Kind.COMPUTED, False),
        ({"x": "0"}, "x", "-8.881784197e-16", Kind.COMPUTED, False),
        ({"x": "0"}, "x", "2e-12", Kind.COMPUTED, True),
        ({"x": "1e6"}, "x", repr(1e6 * (1 + 2 * RELATIVE)), Kind.COMPUTED, True),
    ],
)
def test_a_changed_cell_is_judged_by_its_class(row, column, text, kind, broken):
    (difference,) = differences("tables/table10", [LINEAR, row], [LINEAR, {**row, column: text}], SPREAD)
    assert (difference.kind, difference.broken) == (kind, broken)
    assert difference.place == f"line 3, {column}"


def test_a_word_may_differ_with_a_trained_number_of_its_row():
    other = {**VERDICT, "verdict": "worse", "total": "0.81"}
    found = {each.place: each for each in differences("tables/table10", [LINEAR, VERDICT], [LINEAR, other], SPREAD)}
    assert {place: each.kind for place, each in found.items()} == dict.fromkeys(
        ("line 3, verdict", "line 3, total"), Kind.TRAINED
    )
    assert not any(each.broken for each in found.values())


def test_a_trained_number_is_judged_by_its_measured_spread():
    def broken(table, spread, text):
        (difference,) = differences(table, ROWS, changed(0, "total", text), spread)
        return difference.broken

    assert not broken("tables/table10", STEADY, "0.9000000001")  # a number that never differed may be rounded
    assert broken("tables/table10", STEADY, "0.90001")
    assert broken("tables/other", SPREAD, "0.799")  # of a similarity nothing allows more than `LARGEST`
    assert not broken("tables/other", SPREAD, "0.801")


@pytest.mark.parametrize(
    ("widest", "deviation", "allowed"),
    [
        (0.34, "0.5", LARGEST),  # as on T3, where a similarity scatters so that the spread alone would allow 0.68
        (0.34, "0.005", OF_SEEDS * 0.005),  # another motion of the same method scatters less
        (0.02, "0.5", MARGIN * 0.02),
        (0.02, "0", MARGIN * 0.02),  # one seed has no deviation
    ],
)
def test_the_smallest_limit_of_a_trained_number_is_allowed(widest, deviation, allowed):
    spread = Tolerances(widest={("tables/table10", "algorithm1", "total"): widest})
    assert spread.allowed("tables/table10", {**TRAINED, "total_sd": deviation}, "total") == pytest.approx(allowed)


def test_a_similarity_in_percent_may_differ_by_a_hundred_times_as_much():
    row = {**TRAINED, "total_sd": "50", "unit": "%"}
    assert Tolerances(widest={}).allowed("tables/table10", row, "total") == pytest.approx(100.0 * LARGEST)


def test_of_a_number_whose_scatter_is_not_known_a_difference_is_named_but_not_judged(tmp_path, capsys):
    loss = [{"step": "1", "test_loss": "0.5"}]
    a, b = (tmp_path / name for name in "ab")
    for folder, rows in ((a, loss), (b, [{**loss[0], "test_loss": "0.7"}])):
        run_of(folder, ROWS)
        (folder / "coverage").mkdir()
        (folder / "coverage/other.csv").write_text(pd.DataFrame(rows).to_csv(index=False))
    runs = ["compare", str(a), str(b)]
    assert main(runs) == 0
    out = capsys.readouterr().out.splitlines()
    assert "not judged, as no limit is known: cells of coverage/other.csv" in out
    assert [int(number) for number in re.findall(r"\d+", out[-1])] == [0, 0, 0, 1]
    assert main([*runs, "--strict"]) == 3
    (b / "tables/table10.csv").write_text(pd.DataFrame(changed(1, "total", "0.96")).to_csv(index=False))
    assert main([*runs, "--strict"]) == 1  # what is more than is allowed comes first
    assert [int(number) for number in re.findall(r"\d+", capsys.readouterr().out.splitlines()[-1])] == [0, 0, 1, 1]
    (b / "tables/table10.csv").write_text(pd.DataFrame(changed(1, "total", "0.9700000001")).to_csv(index=False))
    (b / "coverage/other.csv").unlink()
    assert main([*runs, "--strict"]) == 0
    assert [int(number) for number in re.findall(r"\d+", capsys.readouterr().out.splitlines()[-1])] == [1, 0, 0, 0]


HOST = {"dot": "1", "torch matmul": "2"}


def test_hosts_of_one_fingerprint_make_the_same_bits():
    other = {**HOST, "torch matmul": "3"}
    assert reproducible(HOST, HOST) == {Kind.SIMULATED, Kind.TRAINED}
    assert reproducible(HOST, other) == {Kind.SIMULATED}  # arms are simulated without a network
    assert not reproducible(HOST, {**HOST, "dot": "3"})
    assert reproducible(HOST, {"dot": "1"}) == {Kind.SIMULATED}  # a run that did not record how networks compute
    assert not reproducible(HOST, {"torch matmul": "2"})
    assert not reproducible(HOST, None)


@pytest.mark.parametrize("other", [HOST, {**HOST, "torch matmul": "3"}])
def test_on_a_host_with_the_same_fingerprint_a_trained_number_is_compared_as_a_computed_one(tmp_path, other):
    a, b = run_of(tmp_path / "a", ROWS), run_of(tmp_path / "b", changed(0, "total", "0.90001"))
    for folder, fingerprint in ((a, HOST), (b, other)):
        (folder / "provenance.json").write_text(json.dumps({"fingerprint": fingerprint}))
    assert main(["compare", str(a), str(b)]) == int(other == HOST)


def test_a_pair_of_methods_without_a_network_does_not_scatter_as_the_trained_pairs_of_its_table():
    pair = {"method": "bounded", "opponent": "least-squares", "difference": "0.01"}
    for opponent, kind in (("least-squares", Kind.SIMULATED), ("algorithm1", Kind.TRAINED)):
        assert tolerances().kind("tables/verdict", {**pair, "opponent": opponent}, "difference") is kind
    alike = replace(tolerances(), reproducible=frozenset({Kind.SIMULATED}))
    (difference,) = differences("tables/verdict", [pair], [{**pair, "difference": "0.0100001"}], alike)
    assert difference.broken


@pytest.mark.parametrize(
    ("table", "name", "column", "kind"),
    [
        ("tables/table06", "differential-evolution", "total", Kind.TRAINED),  # a random search without a network
        ("tables/table06", "algorithm1/one-run", "total", Kind.TRAINED),
        ("tables/table04", "algorithm1", "true", Kind.COMPUTED),
        ("tables/table06", "bounded", "total", Kind.COMPUTED),
        *((f"{folder}/scores", "bounded", "total", Kind.SIMULATED) for folder in ("accepted", "factorial")),
        ("tables/accepted", "least-squares", "mean_median", Kind.SIMULATED),
        ("tables/study", "posterior", "validation", Kind.TRAINED),
        # A claim is trained if its table is.
        ("table10", "table10/ID/algorithm1/total/joint1", "ours", Kind.TRAINED),
        ("table10", "table10/ID/algorithm1/total/joint1", "published", Kind.COMPUTED),
        ("table10", "table10/ID/least-squares/total/joint1", "ours", Kind.COMPUTED),
        ("stability", "appendix/energy", "ours", Kind.COMPUTED),
        ("training", "section5a/loss", "ours", Kind.TRAINED),
        ("table09", "section5c/gravity-over-inertia/least-squares", "ours", Kind.COMPUTED),
        ("table09", "section5c/viscous-over-algorithm1", "ours", Kind.TRAINED),  # of least squares over Algorithm 1
    ],
)
def test_a_random_search_is_compared_as_a_network_is(table, name, column, kind):
    claim = {"id": name, "target": table, "published": "1", "ours": "2"}
    place, row = ("claims", claim) if column in claim else (table, {"method": name, column: "0.99"})
    assert tolerances().kind(place, row, column) is kind


def test_rows_and_columns_must_be_the_same():
    other = [{("sum" if k == "total" else k): v for k, v in row.items()} for row in ROWS]
    for rows, place in ((ROWS[:1], "number of rows"), (other, "header")):
        (difference,) = differences("tables/table10", ROWS, rows, SPREAD)
        assert difference.place == place and difference.broken


@pytest.mark.parametrize(
    ("name", "column"),
    [
        ("table10/ID/algorithm1/time/joint2", "table10/algorithm1/time"),
        ("table10/T3/algorithm1/total/joint1@tracked", "table10/algorithm1/total@tracked"),
        ("table08/total/joint1", "table08/total/joint1"),
        ("section5a/loss", "section5a/loss"),
        ("abstract/numeric/total@refinement", "abstract/numeric/total@refinement"),
    ],
)
def test_a_claim_scatters_as_the_column_of_its_table(name, column):
    assert origin({"id": name, "published": "1"}) == column


def run_of(folder, rows, recording=b"\xa5" * 16):
    for name in ("tables", "experiment"):
        (folder / name).mkdir(parents=True)
    (folder / "tables/table10.csv").write_text(pd.DataFrame(rows).to_csv(index=False))
    (folder / "experiment/ID.bin").write_bytes(recording)
    return folder


def test_the_command_reports_the_largest_difference_and_ends_with_1_if_a_class_is_broken(tmp_path, capsys):
    a = run_of(tmp_path / "a", ROWS)
    assert main(["compare", str(a), str(run_of(tmp_path / "same", ROWS))]) == 0
    assert "2 the same to the last digit" in capsys.readouterr().out
    assert main(["compare", str(a), str(run_of(tmp_path / "b", changed(1, "total", "0.96")))]) == 1
    out = capsys.readouterr().out
    assert "largest computed: tables/table10.csv: computed: line 3, total: 0.97 and 0.96, by 0.01" in out
    assert "broken: tables/table10.csv" in out
    assert main(["compare", str(a), str(run_of(tmp_path / "c", ROWS, b"\xa5" * 15 + b"\0"))]) == 1
    assert "broken: experiment/ID.bin" in capsys.readouterr().out


@pytest.mark.parametrize(("count", "rest"), [(5, "\n"), (7, ", 2 more\n")])
def test_tables_of_one_folder_alone_are_named(tmp_path, capsys, count, rest):
    a, b = (run_of(tmp_path / name, ROWS) for name in ("a", "b"))
    for number in range(count):
        a.joinpath(f"tables/table0{number}.csv").write_text("x\n1\n")
    b.joinpath("tables/new.csv").write_text("x\n1\n")
    assert main(["compare", str(a), str(b)]) == 0
    names, out = ", ".join(f"tables/table0{number}.csv" for number in range(5)), capsys.readouterr().out
    assert f"{count} in the first folder alone: {names}{rest}" in out
    assert "1 in the second folder alone: tables/new.csv\n" in out
    (b / "validation").symlink_to("validation")
    assert main(["compare", str(a), str(b)]) == 2
    assert f"{b / 'validation'}: found a link that leads nowhere" in capsys.readouterr().err


def test_what_is_no_run_is_one_line(tmp_path, capsys):
    a = run_of(tmp_path / "a", ROWS)
    (tmp_path / "empty").mkdir()
    for other in ("empty", "none"):
        assert main(["compare", str(a), str(tmp_path / other)]) == 2
        assert capsys.readouterr().err.count("\n") == 1
    (a / "tables/table10.csv").write_text("case,total\nID\n")
    assert main(["compare", str(a), str(a)]) == 2
    assert "line 2: found 1 fields, expected 2, as in the header" in capsys.readouterr().err


def test_the_spread_is_the_widest_range_of_a_cell_over_the_runs(tmp_path, measure):
    totals = (("0.9", "0.5"), ("0.91", "0.46"), ("0.89", "0.49"))  # of ID and T1
    tables = [[*changed(0, "total", first), {**TRAINED, "case": "T1", "total": second}] for first, second in totals]
    runs = [run_of(tmp_path / str(k), rows) for k, rows in enumerate(tables)]
    measured = measure(runs).set_index(["table", "origin", "column"])
    row = measured.loc[("tables/table10", "algorithm1", "total")]
    assert (row["runs"], row["cells"], row["widest"]) == (3, 2, pytest.approx(0.04))
    assert list(measured.index) == [("tables/table10", "algorithm1", "total")]
    spread = Tolerances(widest={key: row["widest"] for key, row in measured.iterrows()})
    for a in runs:
        for b in runs:
            assert not any(each.broken for each in compare_runs(a, b, spread)[0])
    assert spread.allowed("tables/table10", ROWS[0], "total") == pytest.approx(MARGIN * 0.04)


def test_runs_that_differ_in_more_than_their_networks_measure_nothing(tmp_path, measure):
    runs = [run_of(tmp_path / "a", ROWS), run_of(tmp_path / "b", changed(1, "total", "0.96"))]
    error = refused(measure, runs)
    assert (error.place, error.found) == (f"{tmp_path / 'b/tables/table10.csv'}: line 3, total", "0.96")


def test_a_pipe_or_a_large_file_in_a_results_folder_does_not_hang(tmp_path):
    a, b = (run_of(tmp_path / name, ROWS) for name in ("a", "b"))
    os.mkfifo(b / "tables/table02.csv")
    assert refused(compare_runs, a, b, Tolerances()).place.endswith("table02.csv")
    assert refused(read_csv, b / "tables/table02.csv").place == str(b / "tables/table02.csv")
    (b / "tables/table02.csv").unlink()
    os.truncate(b / "tables/table10.csv", 2**30)
    assert refused(compare_runs, a, b, Tolerances()).place.endswith("size")


REFERENCE = ROOT / "docs/reference"


def copied(folder, name, old="", new="", fingerprint=None):
    """A table of the reference alone in a folder, one text of it changed, made by a host of this fingerprint."""
    text = (REFERENCE / name).read_text(encoding="utf-8")
    assert old in text
    (folder / name).parent.mkdir(parents=True)
    (folder / name).write_text(text.replace(old, new, 1), encoding="utf-8")
    provenance = json.loads((REFERENCE / "provenance.json").read_text(encoding="utf-8"))
    made = {**provenance, "fingerprint": fingerprint or provenance["fingerprint"]}
    (folder / "provenance.json").write_text(json.dumps(made), encoding="utf-8")
    return str(folder)


def test_the_reference_agrees_with_itself(capsys):
    assert main(["compare", str(REFERENCE), str(REFERENCE)]) == 0
    assert "no class is broken" in capsys.readouterr().out


def changed_line(name, start, column, by):
    """The line of a table of the reference that begins so, and the same with another number in a column."""
    header, *lines = (REFERENCE / name).read_text(encoding="utf-8").splitlines()
    (old,) = (line for line in lines if line.startswith(start))
    cells = old.split(",")
    place = header.split(",").index(column)
    cells[place] = f"{float(cells[place]) + by:.10g}"
    return old, ",".join(cells)


@pytest.mark.parametrize(
    ("name", "start", "column", "by"),
    [
        ("tables/table10.csv", "T3,algorithm1,2,", "total", -0.3),
        ("tables/table06.csv", "N1,algorithm1,1,", "time", -1e-6),
        ("tables/verdict.csv", "algorithm1+refinement,least-squares,", "difference", 1e-3),
        ("tables/accepted.csv", "all,algorithm1,1000000,", "mean_median", -1e-2),
        ("study/cells/eq10-wide-0.csv", "eq10,0.99,wide,1,0,0.98535,true,", "validation", 1e-3),
    ],
)
def test_a_changed_digit_of_the_reference_is_named(tmp_path, capsys, name, start, column, by):
    a, b = copied(tmp_path / "a", name), copied(tmp_path / "b", name, *changed_line(name, start, column, by))
    assert main(["compare", a, b]) == 1
    assert f"broken: {name}" in capsys.readouterr().out


def test_on_another_host_a_total_of_algorithm_1_may_not_differ_by_0_3(tmp_path, capsys):
    name = "tables/table10.csv"
    a = copied(tmp_path / "a", name)
    for by, broken in ((-0.3, True), (-0.01, False)):
        other = copied(tmp_path / f"{by}", name, *changed_line(name, "T3,algorithm1,2,", "total", by), HOST)
        assert main(["compare", a, other]) == int(broken)
