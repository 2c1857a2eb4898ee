"""The claims ledger: its verdicts, that every published number has a counterpart, and what is asserted."""

import math
import re
import shutil

import numpy as np
import pandas as pd
import pytest
from claims_example import CONFIG, SEEDS, write_results
from experiment_example import changed, refused
from hypothesis import given
from hypothesis import strategies as st

from repro.config.check import load_config
from repro.paper import claims as claims_module
from repro.paper.audit import findings
from repro.paper.claims import Basis, OurValue, broken, causes, higher, judge, judge_all, lower, specificity
from repro.paper.ledger import ASSERTED, compute, refuted_number
from repro.paper.our_results import FILES, Results, estimates_of_test_arm
from repro.paper.published import PublishedValue, load_published

pytestmark = pytest.mark.slow


def printed(value="97.10", relation="is", kind="stochastic", id_="table07/N1/total/joint1", case="N1"):
    return PublishedValue(id_, "Table 7", "total", case, "algorithm1", 1, "", "%", relation, value, "", kind)


def ours(value, spread=0.0, seeds=1, basis=Basis.NUMERIC, **more):
    return OurValue(value, "t", basis, spread, seeds, **more)


#: Five seeds: another run lies within 2.776 x sqrt(1.2) = 3.0414 standard deviations.
FIVE = 3.0414
HALF, SHARE = {"equivalent": 0.5, "cap": 1.0}, {"equivalent": 0.05 * 0.4, "cap": 0.25 * 0.4}
PUBLISHED, SETTINGS = load_published(), load_config(CONFIG)


def ledger(results, config=SETTINGS):
    """The ledger by the ids."""
    return compute(PUBLISHED, config, results).set_index("id")


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    write_results(folder)
    return folder


@pytest.fixture(scope="module")
def claims(stored):
    return ledger(Results(stored))


@pytest.mark.parametrize(
    ("number", "side", "verdict"),
    [
        (printed(), ours(97.1051, better=higher), "better"),
        (printed(), ours(97.0949, better=higher), "differs"),
        # The prediction interval: 3.0414 x 0.2 + 0.005.
        (printed(), ours(97.1 - 0.61, 0.2, 5, better=higher), "reproduced"),
        (printed(), ours(97.1 - 0.62, 0.2, 5, better=higher), "differs"),
        (printed(), ours(97.1 + 0.62, 0.2, 5, better=higher), "better"),
        (printed(), ours(97.1 - 0.61, 0.2, 1), "differs"),  # one seed has no interval
        # The equivalence margin: 0.5 + 0.005, whatever the scatter below it.
        (printed(), ours(97.6, **HALF), "reproduced"),
        (printed(), ours(97.61, **HALF, better=higher), "better"),
        (printed(), ours(96.59, 0.1, 5, **HALF), "differs"),
        # The cap: 3.0414 x 0.33 is more than one point.
        (printed(), ours(97.1, 0.32, 5, **HALF), "reproduced"),
        (printed(), ours(97.1, 0.33, 5, **HALF), "inconclusive"),
        (printed(), ours(99.0, 0.33, 5, **HALF, better=higher), "inconclusive"),
        (printed(), ours(95.0, 0.33, 5, **HALF, better=higher), "differs"),
        # The same as shares of the value: an interval of 0.25 x 0.4.
        (printed("0.4000"), ours(0.45, 0.0328, 5, **SHARE), "reproduced"),
        (printed("0.4000"), ours(0.45, 0.0330, 5, **SHARE), "inconclusive"),
        # Another arm is never better, and nothing but results has to be told from other cases.
        (printed(), ours(99.0, basis=Basis.ARM, better=higher), "not comparable"),
        (printed(), ours(95.0, basis=Basis.ARM, better=higher), "differs"),
        (printed(), ours(97.1001, strict=True), "differs"),
        (printed(relation="above"), ours(99.0, better=higher), "reproduced"),
        (printed(relation="above"), ours(99.0, 2.0, 5, **HALF), "inconclusive"),
        (printed(relation="above"), ours(97.0, better=higher), "differs"),
        (printed(relation="below"), ours(95.0), "reproduced"),
        (printed(relation="below"), ours(98.0), "differs"),
        (printed(relation="up to"), ours(96.0, better=higher), "differs"),
        (printed("1e-3", "about"), ours(1.4e-3, better=lower), "reproduced"),
        (printed("1e-3", "about"), ours(1.4e-3, better=lower, strict=True), "differs"),
        # Bounds of ours from 96 to 98: within them nothing is reproduced.
        (printed(), ours(97.0, bounds=1.0), "inconclusive"),
        (printed("98.01"), ours(97.0, bounds=1.0), "differs"),
        (printed(kind="hardware-only"), OurValue(math.nan, ""), "needs the hardware"),
        (printed(kind="setting"), ours(1.0, unused=True), "not run"),
        # A contradiction of 0.9 explains a difference of 0.9, and no more.
        (printed(), ours(97.1, contradicts="Its factors give 98.", contradiction=0.9), "contradicts itself"),
        (printed(), ours(99.9, better=higher, contradicts="Its factors give 98.", contradiction=0.9), "better"),
        (printed(), ours(38.9, better=higher, contradicts="Its factors give 98.", contradiction=0.9), "differs"),
        (printed(), OurValue(math.nan, "", contradicts="Its factors give 98."), "contradicts itself"),
    ],
)
def test_each_verdict_at_its_edge(number, side, verdict):
    assert judge(number, side)["verdict"] == verdict


@pytest.mark.parametrize(
    ("value", "cap", "others", "note"),
    [
        (97.4, 0.1, (), "our runs scatter too widely"),
        (99.9, 0.1, (), "outside but better, and our runs scatter too widely"),
        (97.4, math.inf, (97.5,), "another case would match too"),
        (97.4, math.inf, (90.0,), ""),
    ],
)
def test_a_note_says_why_a_number_is_inconclusive(value, cap, others, note):
    side = ours(value, 0.2, 5, cap=cap, better=higher, note="mean of 8")
    row = judge(printed(), side, others)
    assert row["note"] == "; ".join(filter(None, (note, "mean of 8")))
    assert (row["verdict"] == "inconclusive") == bool(note)


@pytest.mark.parametrize(
    ("basis", "others", "verdict"),
    [
        (Basis.NUMERIC, (95.0, 97.61), "reproduced"),
        (Basis.NUMERIC, (95.0, 97.6), "inconclusive"),
        (Basis.ARM, (96.6,), "inconclusive"),
        (Basis.CONSTRUCTION, (96.6,), "reproduced"),
        (Basis.NUMERIC, (96.49, 97.61), "reproduced"),  # another case within 0.505 of either number would pass as well
        (Basis.NUMERIC, (96.5,), "inconclusive"),
    ],
)
def test_a_match_that_another_case_would_pass_too_is_no_evidence(basis, others, verdict):
    assert judge(printed(), ours(97.0, basis=basis, **HALF), others)["verdict"] == verdict


def test_the_ledger_takes_the_other_cases_from_the_published_numbers():
    cases = {"N1": "97.10", "N2": "97.50", "N4": "99.10"}
    numbers = [printed(value, id_=f"table07/{case}/total/joint1", case=case) for case, value in cases.items()]
    sides = {number.id: ours(float(number.printed) + 0.1, **HALF) for number in numbers}
    rows = judge_all(numbers, sides)
    assert rows["verdict"].tolist() == ["inconclusive", "inconclusive", "reproduced"]
    counts = {"basis": "numeric", "what": "similarities", "rows": 1, "pairs": 2, "refused": 2}
    assert specificity(rows, numbers).to_dict("records") == [counts]
    # A ledger that calls everything reproduced: N1 and N2 pass for each other.
    wrong = rows.assign(verdict="reproduced")
    assert specificity(wrong, numbers).to_dict("records") == [counts | {"rows": 3, "pairs": 6, "refused": 4}]


@given(st.floats(-1e6, 1e6).map("{:.4f}".format), st.floats(-1e6, 1e6), st.just(0.0) | st.floats(0.001, 10))
def test_a_row_adds_up(published, value, spread):
    row = judge(printed(published), ours(value, spread, 5, cause="another network"))
    assert row["published"] == published
    assert row["difference"] == pytest.approx(value - float(published), abs=1e-9)
    assert row["tolerance"] == pytest.approx(5e-5 + FIVE * spread, rel=1e-4)
    assert row["tolerance_from"] == ("95 % prediction interval" if spread else "print precision")
    if abs(abs(row["difference"]) - row["tolerance"]) > 1e-2:  # clear of the edge
        assert (row["verdict"] == "reproduced") == (abs(row["difference"]) < row["tolerance"])
        assert (row["cause"] == "another network") == (row["verdict"] == "differs")


CENTRAL = "section5c/validation/algorithm1-over-least-squares"


#: Numbers whose other side is a literal, so that no change of ours can break them.
LITERAL = {
    *("eq09/torque-factor", "section4b/output-low", "section4b/output-high", "algorithm1/joint-weight"),
    *("section4a/band-low", "section3/position-low", "section3/position-high"),
}


def test_what_is_asserted_follows_the_rule(claims):
    kinds = {number.id: number.kind for number in PUBLISHED}
    compared = ~claims["verdict"].isin(["needs the hardware", "contradicts itself", "not run"])
    differing = claims["verdict"] == "differs"
    assert claims.loc[differing, "cause"].isin(causes()).all() and (claims.loc[~differing, "cause"] == "").all()
    settings = claims[(claims["kind"] == "setting") & (claims["verdict"] != "contradicts itself")]
    assert set(settings["verdict"]) == {"reproduced", "not run"}
    assert set(claims.loc[claims["kind"] == "deterministic", "verdict"]) == {"reproduced"}
    for name, row in claims.iterrows():
        by_kind = kinds[name.partition("@")[0]] in ("setting", "exact", "deterministic") and compared[name]
        expected = "reproduced" if by_kind and name not in LITERAL else ASSERTED.get(name, "")
        assert row["asserted"] == ("differs" if name == CENTRAL else expected), name
        assert row["must"] == (row["asserted"] in ("reproduced", "reproduced or inconclusive"))
    cells = ["table08/ID/total/joint1", "table10/T3/least-squares/time/joint2"]
    assert claims.loc[cells, "basis"].tolist() == ["by construction", "by construction"]
    # Algorithm 1 itself, on the paper's arms and on the simulated one.
    assert {"abstract/numeric/total", CENTRAL} <= set(claims.index[claims["asserted"] != ""])


def test_another_setting_breaks_its_claim(stored):
    changes = {
        "section6/numeric/threshold": ("algorithm1", "threshold", 0.93),
        "table08/cf/joint1": ("signals", "filter_coefficient", 2e-4),
        "table08/kp/joint1": ("board", "kp_nm_per_rad", [180.4818, 30.6819]),
        "section6/T1/range-high": ("experiment", "t1", {"range_rad": 1.3}),
    }
    config = changed(SETTINGS, **{section: {key: value} for section, key, value in changes.values()})
    assert changes.keys() <= set(broken(ledger(Results(stored), config).reset_index())["id"])


def test_what_the_audit_contradicts_says_so_with_its_arithmetic(claims):
    noted = {refuted_number(f) for f in findings(PUBLISHED)} - {""}
    totals = {"table07/N1/total/joint2", "table10/T2/algorithm1/total/joint2", "table10/T2/least-squares/total/joint2"}
    assert noted == totals | {"section1a/random-trajectories", "section4a/band-high", "appendix/domain"}
    assert (claims.loc[sorted(noted), "asserted"] == "").all()
    # What ours differs by is all that the paper contradicts itself by; a difference of many points stays one.
    assert set(claims.index[claims["verdict"] == "contradicts itself"]) == noted - totals
    assert not claims.loc[sorted(totals), "verdict"].isin(["contradicts itself"]).any()


def alter(results, name, column, value, **wanted):
    """Set the cells of a column in the rows of a result file that match."""
    frame = results.frames[name].astype(object)
    rows = pd.Series(True, frame.index)
    for key, allowed in wanted.items():
        rows &= frame[key].isin([str(each) for each in np.atleast_1d(allowed)])
    assert rows.any()
    frame.loc[rows, column] = value
    results.frames[name] = frame.astype(str)


@pytest.fixture(scope="module")
def altered(stored):
    """The ledger of results that were altered."""
    results = Results(stored)
    listed = {"method": "algorithm1"}
    alter(results, "tables/table10.csv", "total", 0.985, case="T3", joint=2, **listed)
    alter(results, "tables/table10.csv", "total", 0.6, case="ID", joint=1, **listed)
    alter(results, "tables/table06.csv", "total", [0.90, 0.92, 0.94, 0.96, 0.95, 0.97, 0.98, 0.90], **listed)
    alter(results, "tables/table06.csv", "total", 0.9, method="algorithm1+refinement")
    alter(results, "tables/table10.csv", "total", 0.4, case="T4", joint=1, **listed)
    alter(results, "validation/experiment.csv", "total", [0.1, 0.4, 0.7], case="T4", joint=1, **listed)
    alter(results, "validation/numeric.csv", "seed", 1, case=["N1", "N3"])  # no scatter, so no interval
    for table, case, factor in (("table04", "N1", 1.05), ("table05", "N3", 0.8)):
        estimate = factor * getattr(SETTINGS.numeric.arms, case)[0]
        alter(results, f"tables/{table}.csv", "estimate", estimate, case=case, parameter="I1")
    alter(results, "tables/table09.csv", "estimate", 0.61, method="algorithm1", parameter="I3")
    alter(results, "tables/table09.csv", "estimate", 1.6, method="least-squares", parameter="I2")
    alter(results, "tables/table09.csv", "estimate", 0.064, method="algorithm1", parameter="k1")
    alter(results, "tables/table09.csv", "estimate", -0.04, method="least-squares", parameter="b1")
    return ledger(results)


def test_statements_about_all_cases_use_the_worst_the_best_or_the_mean(altered):
    assert altered.loc["section7/experimental/total", "ours"] == pytest.approx(98.5)
    assert altered.loc["abstract/experimental/total", ["ours", "verdict"]].tolist() == [pytest.approx(60.0), "differs"]
    for name in ("abstract/numeric/total", "section6/numeric/total"):
        assert altered.loc[name, ["ours", "verdict", "basis"]].tolist() == [pytest.approx(94.0), "differs", "numeric"]
    assert set(broken(altered.reset_index())["id"]) == set(ASSERTED)


@pytest.mark.parametrize(("level", "lost"), [(0.985, set()), (0.92, {"abstract/numeric/total"})])
def test_runs_that_scatter_break_the_claim_of_the_numeric_tests_only_below_it(stored, level, lost):
    """Five runs whose standard deviation is 0.8 points call nothing reproduced: no fault of the host that made them."""
    results = Results(stored)
    alter(results, "tables/table06.csv", "total", level, method="algorithm1")
    scores = results.frames["validation/numeric.csv"]
    seeds = scores["seed"].astype(int).map(dict(zip(range(1, 6), (-0.010, -0.004, 0.0, 0.005, 0.009), strict=True)))
    scores.loc[scores["method"] == "algorithm1", "total"] = (level + seeds).astype(str)
    rows = ledger(results)
    assert rows.loc["abstract/numeric/total", "verdict"] == ("differs" if lost else "inconclusive")
    assert set(broken(rows.reset_index())["id"]) == lost


def test_a_result_that_scatters_is_inconclusive(altered):
    """Its interval would let 40 % pass for the published number."""
    row = altered.loc["table10/T4/algorithm1/total/joint1"]
    assert (row["verdict"], row["tolerance_from"]) == ("inconclusive", "95 % prediction interval")
    assert row["tolerance"] == pytest.approx(0.005 + 4.9683 * 30.0, rel=1e-4)


def test_an_estimate_nearer_the_truth_than_the_published_one_is_better(altered):
    verdicts = altered.loc[["table04/N1/algorithm1/I1", "table05/N3/algorithm1/I1"], "verdict"]
    assert verdicts.tolist() == ["better", "differs"]


@pytest.fixture(scope="module")
def failing(stored):
    """The ledger of results for which two claims fail."""
    results = Results(stored)
    alter(results, "tables/table10.csv", "total", 1.01 * 0.98, method="algorithm1", case=["T1", "T2", "T3", "T4"])
    alter(results, "tables/table06.csv", "total", 0.94, method="algorithm1")
    alter(results, "tables/table09.csv", "estimate", 0.0, method="algorithm1", parameter="k2")
    alter(results, "tables/table09.csv", "estimate", 0.3, method="least-squares", parameter="b2")
    alter(results, "tables/table09.csv", "estimate", -0.08, method="algorithm1", parameter="b1")
    return ledger(results)


def test_claims_that_do_not_hold_are_named(failing, claims):
    assert claims.loc[CENTRAL, ["ours", "verdict"]].tolist() == [pytest.approx(0.975 / 0.98), "differs"]
    assert broken(claims.reset_index()).empty
    assert failing.loc[CENTRAL, ["ours", "verdict"]].tolist() == [pytest.approx(1.01), "reproduced"]
    rows = failing.reset_index()
    assert set(broken(rows)["id"]) == {CENTRAL, "abstract/numeric/total"}
    lines = [line for line in claims_module.summary(rows) if line.startswith("not as asserted: abstract/numeric/total")]
    assert len(lines) == 1 and all(part in lines[0] for part in ("differs", "reproduced", "97.38", "94"))
    page = claims_module.markdown(rows, specificity(rows, PUBLISHED))
    assert "| abstract/numeric/total |" in page.split("## What differs")[0]


@pytest.mark.parametrize(
    ("rows", "name", "ratio"),
    [
        ("altered", "gravity-over-inertia/algorithm1", 0.6 / 0.61),  # not I1 alone counts
        ("altered", "gravity-over-inertia/least-squares", 0.5),
        ("altered", "viscous-over-coulomb/algorithm1", 1.25),  # the worse joint
        ("failing", "viscous-over-coulomb/algorithm1", math.inf),
        ("altered", "viscous-over-algorithm1", -0.5),
        ("failing", "viscous-over-algorithm1", 3.0),  # b2; b1 of Algorithm 1 is negative
    ],
)
def test_a_comparison_in_words_follows_one_parameter(request, rows, name, ratio):
    row = request.getfixturevalue(rows).loc[f"section5c/{name}"]
    assert row["ours"] == pytest.approx(ratio) and row["asserted"] == ""
    assert row["verdict"] == ("reproduced" if ratio == pytest.approx(3.0) else "differs")


def test_a_missing_result_is_named(stored, tmp_path):
    folder = shutil.copytree(stored, tmp_path / "results")
    for name in reversed(FILES):
        (folder / name).unlink()
        assert name in refused(Results, folder).place


@pytest.mark.parametrize(
    ("name", "old", "new", "named"),
    [
        ("table10", "T4,algorithm1,2", "T5,algorithm1,2", "case T4, .*, joint 2"),
        ("table07", "N1,algorithm1,1,0.975", "N1,algorithm1,1,", "time of case N1.* nothing"),
        ("table07", "N3,algorithm1,2,0.975", "N3,algorithm1,2,n/a", "time of case N3.* n/a"),
        ("stability", "appendix,Rate", "appendix,Race", "quantity Rate"),
        ("table09", "least-squares,b2", "least-squares,b3", "parameter b2"),
        ("table04", "estimate,", "estimation,", "no column estimate"),
    ],
)
def test_a_damaged_table_is_named(stored, tmp_path, name, old, new, named):
    file = shutil.copytree(stored, tmp_path / "results") / f"tables/{name}.csv"
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new, 1), encoding="utf-8")
    error = refused(lambda: compute(PUBLISHED, SETTINGS, Results(tmp_path / "results")))
    assert str(file) in error.place and re.search(named, str(error))


def test_a_parameter_has_the_seeds_of_its_arm_and_not_twice_for_its_joints(stored):
    values = estimates_of_test_arm("table04", "N1", PUBLISHED, Results(stored))
    assert values["table04/N1/algorithm1/I1"].seeds == len(SEEDS)
