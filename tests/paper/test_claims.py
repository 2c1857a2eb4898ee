"""The claims ledger: its verdicts, that every published number has a counterpart, and what is promised."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pandas as pd
import pytest
from claims_example import APPENDIX, CONFIG, LOSS, METHODS, NUMERIC, write_results
from hypothesis import given
from hypothesis import strategies as st

from repro.errors import InputError
from repro.paper.audit import findings
from repro.paper.claims import (
    BETTER,
    CAPPED,
    COLUMNS,
    CONTRADICTS,
    DIFFERS,
    HARDWARE,
    NONE,
    NOT_RUN,
    PRINT,
    REPRODUCED,
    SEEDS,
    VERDICTS,
    Ours,
    broken,
    higher,
    judge,
    ledger,
    lower,
)
from repro.paper.ledger.constants import second_harmonic
from repro.paper.ledger.counterparts import MUST_REFINED, about, compute, counterparts
from repro.paper.ledger.results import FILES, Results
from repro.paper.ledger.text import markdown, summary
from repro.paper.published import load_published
from repro.paper.published_value import PublishedValue
from repro.pipeline.experiment import load_config


def printed(value="97.10", relation="is", kind="stochastic", id_="table07/N1/total/joint1"):
    return PublishedValue(id_, "Table 7", "total", "N1", "algorithm1", 1, "", "%", relation, value, "", kind)


@pytest.fixture(scope="module")
def published():
    return load_published()


@pytest.fixture(scope="module")
def config():
    return load_config(CONFIG)


@pytest.fixture
def folder(tmp_path):
    write_results(tmp_path)
    return tmp_path


@pytest.fixture
def claims(published, config, folder):
    return compute(published, config, Results(folder)).set_index("id")


@pytest.mark.parametrize(
    ("number", "ours", "verdict"),
    [
        (printed(), Ours(97.1, "t"), REPRODUCED),
        (printed(), Ours(97.1049, "t"), REPRODUCED),
        (printed(), Ours(97.1051, "t"), DIFFERS),
        (printed(), Ours(97.1051, "t", better=higher), BETTER),
        (printed(), Ours(97.0949, "t", better=higher), DIFFERS),
        (printed(), Ours(96.5, "t", spread=0.3, better=higher), REPRODUCED),
        (printed(), Ours(96.49, "t", spread=0.3, better=higher), DIFFERS),
        (printed(), Ours(97.7, "t", spread=0.3, better=higher), REPRODUCED),
        (printed(), Ours(97.71, "t", spread=0.3, better=higher), BETTER),
        (printed(), Ours(92.2, "t", spread=30.0, widest=5.0), REPRODUCED),
        (printed(), Ours(92.0, "t", spread=30.0, widest=5.0), DIFFERS),
        (printed(), Ours(97.1001, "t", strict=True), DIFFERS),
        (printed(relation="above"), Ours(99.0, "t"), REPRODUCED),
        (printed(relation="above"), Ours(99.0, "t", better=higher), BETTER),
        (printed(relation="above"), Ours(97.0, "t", better=higher), DIFFERS),
        (printed(relation="above"), Ours(97.096, "t", better=higher), REPRODUCED),
        (printed(relation="below"), Ours(95.0, "t"), REPRODUCED),
        (printed(relation="below"), Ours(97.104, "t"), REPRODUCED),
        (printed(relation="below"), Ours(98.0, "t"), DIFFERS),
        (printed(relation="up to"), Ours(96.0, "t", better=higher), DIFFERS),
        (printed("1e-3", "about"), Ours(2e-4, "t", better=lower), BETTER),
        (printed("1e-3", "about"), Ours(1.4e-3, "t", better=lower), REPRODUCED),
        (printed("1e-3", "about"), Ours(1.4e-3, "t", better=lower, strict=True), DIFFERS),
        (printed("1e-3", "about"), Ours(1e-3, "t", better=lower, strict=True), REPRODUCED),
        (printed(kind="hardware-only"), Ours(None, ""), HARDWARE),
        (printed(), Ours(97.1, "t", contradicts="Its factors give 98."), CONTRADICTS),
        (printed(), Ours(99.9, "t", better=higher, contradicts="Its factors give 98."), CONTRADICTS),
        (printed(), Ours(None, "", contradicts="Its factors give 98."), CONTRADICTS),
    ],
)
def test_each_verdict_at_its_edge(number, ours, verdict):
    assert judge(number, ours)["verdict"] == verdict


@given(
    published=st.floats(-1e6, 1e6).map(lambda x: f"{x:.4f}"),
    ours=st.floats(-1e6, 1e6),
    spread=st.floats(0, 10),
)
def test_a_row_adds_up(published, ours, spread):
    row = judge(printed(published), Ours(ours, "t", spread=spread))
    assert row["published"] == published
    assert row["difference"] == pytest.approx(ours - float(published), abs=1e-9)
    assert row["tolerance"] == pytest.approx(5e-5 + 2 * spread)
    assert row["tolerance_from"] == (SEEDS if spread else PRINT)
    clear = abs(abs(row["difference"]) - row["tolerance"]) > 1e-2
    if clear:
        assert (row["verdict"] == REPRODUCED) == (abs(row["difference"]) < row["tolerance"])


def test_without_a_number_of_ours_nothing_is_compared():
    row = judge(printed(kind="hardware-only"), Ours(None, "", note="a clock"))
    assert all(math.isnan(row[name]) for name in ("ours", "difference", "tolerance"))
    assert (row["tolerance_from"], row["note"], row["must"]) == ("", "a clock", False)


def test_a_number_on_one_side_only_is_refused():
    number, ours = printed(), Ours(1.0, "t")
    with pytest.raises(ValueError, match="table07/N1/total/joint1 has no counterpart"):
        ledger([number], {})
    with pytest.raises(ValueError, match="table99 has no published number"):
        ledger([number], {number.id: ours, "table99": ours})
    with pytest.raises(ValueError, match="has no counterpart"):  # an extension does not stand for the method itself
        ledger([number], {f"{number.id}@refinement": ours})


def test_an_extension_has_a_row_of_its_own_below_the_number():
    first, second = printed(), printed(id_="table07/N1/total/joint2")
    sides = {second.id: Ours(1, "t"), f"{first.id}@refinement": Ours(98, "t", better=higher), first.id: Ours(97.1, "t")}
    rows = ledger([first, second], sides)
    assert sorted(rows["id"][:2]) == [first.id, f"{first.id}@refinement"]
    assert rows.set_index("id")["verdict"].to_dict() == {
        first.id: REPRODUCED, f"{first.id}@refinement": BETTER, second.id: DIFFERS,
    }  # fmt: skip


@pytest.mark.slow
def test_every_published_number_of_the_papers_own_is_there_once(published, config, folder):
    rows = compute(published, config, Results(folder))
    assert tuple(rows.columns) == COLUMNS
    own = [number.id for number in published if number.kind != "other-work"]
    assert [name for name in rows["id"] if "@" not in name] == own
    assert len(own) >= 190 and rows["id"].is_unique
    extended = [name for name in rows["id"] if "@" in name]
    # Totals of Table 7 and of Algorithm 1 in Table 10, and five statements about all of them.
    assert sum(name.endswith("@refinement") for name in extended) == 8 + 10 + 5
    # Of the arm alone.
    assert sum(name.endswith("@tracked") for name in extended) == 10 + 3
    assert len(extended) == 23 + 13
    assert set(rows["verdict"]) <= set(VERDICTS)
    assert rows.loc[rows["verdict"] != HARDWARE, "target"].str.len().gt(0).all()
    known = rows[rows["verdict"].isin([REPRODUCED, BETTER, DIFFERS])]
    assert known[["ours", "difference", "tolerance"]].notna().all(axis=None)
    assert set(known["tolerance_from"]) == {PRINT, SEEDS, NONE}


@pytest.mark.slow
def test_promises_follow_the_rule(claims, published):
    kinds = {number.id: number.kind for number in published}
    compared = ~claims["verdict"].isin([HARDWARE, CONTRADICTS, NOT_RUN])
    for name, row in claims.iterrows():
        by_kind = kinds[name.partition("@")[0]] in ("setting", "exact", "deterministic") and compared[name]
        assert row["must"] == (by_kind or name in MUST_REFINED or name == "section5a/loss"), name
    assert claims["must"].sum() > 150


@pytest.mark.slow
def test_only_numbers_of_the_bench_need_the_hardware(claims, published):
    kinds = {number.id: number.kind for number in published}
    needed = claims.index[claims["verdict"] == HARDWARE]
    assert {kinds[name] for name in needed} == {"hardware-only"}
    assert 5 <= len(needed) <= 12 and not any(name.startswith("table") for name in needed)


@pytest.mark.slow
def test_every_setting_is_adopted_as_printed(claims):
    settings = claims[(claims["kind"] == "setting") & (claims["verdict"] != CONTRADICTS)]
    assert set(settings["verdict"]) == {REPRODUCED, NOT_RUN}
    # The paper's own training is a target of its own: what it is set to is not what the default run was made with.
    unused = settings.index[settings["verdict"] == NOT_RUN]
    assert {name.partition("/")[0] for name in unused} == {"section4b", "section5a", "section6"}
    assert len(unused) == 11
    np.testing.assert_allclose(settings["ours"].astype(float), settings["published"].astype(float), rtol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("section", "key", "value", "broken_id"),
    [
        ("algorithm1", "threshold_numeric", 0.93, "section6/numeric/threshold"),
        ("signals", "filter_coefficient", 2e-4, "table08/cf/joint1"),
        ("board", "kp_nm_per_rad", [180.4818, 30.6819], "table08/kp/joint1"),
        ("experiment", "random_range_rad", 1.3, "section6/T1/range-high"),
    ],
)
def test_another_setting_breaks_its_promise(published, config, folder, section, key, value, broken_id):
    changed = {**config, section: {**config[section], key: value}}
    rows = compute(published, changed, Results(folder))
    assert broken_id in broken(rows)["id"].tolist()


@pytest.mark.slow
def test_arithmetic_and_the_appendix_come_out(claims):
    for name in ("section3/encoder-step", "section3/logic-share", "section3/position-turns", "section3/torque-unit"):
        assert claims.loc[name, "verdict"] == REPRODUCED, name
    appendix = claims[claims["kind"] == "deterministic"]
    assert len(appendix) == 6 and set(appendix["verdict"]) == {REPRODUCED}
    assert claims.loc["appendix/coupling", "ours"] == APPENDIX["Dissipation (Eq. 18)"][1]
    assert claims.loc["section3/memory-share", "ours"] == pytest.approx(100 * 8192 * 2 * 32 / 608256)


@pytest.mark.slow
def test_numbers_of_the_results_are_where_they_belong(claims):
    assert claims.loc["section5a/loss", "ours"] == LOSS and claims.loc["section5a/loss", "verdict"] == BETTER
    row = claims.loc["table10/T1/least-squares/total/joint1"]
    assert row["ours"] == pytest.approx(100 * METHODS["least-squares"])
    assert row["tolerance"] == pytest.approx(0.005 + 2.0) and row["tolerance_from"] == SEEDS
    assert row["verdict"] == REPRODUCED and "simulated" in row["note"]
    refined = claims.loc["table10/T1/algorithm1/total/joint1@refinement"]
    assert refined["ours"] == pytest.approx(99.0) and refined["verdict"] == BETTER
    assert "extension of ours" in refined["note"]
    tracked = claims.loc["table10/T1/algorithm1/total/joint1@tracked"]
    assert tracked["ours"] == pytest.approx(97.0) and not tracked["must"]
    assert claims.loc["table08/ID/total/joint1", "verdict"] == REPRODUCED
    simulated = claims[claims.index.str.match(r"table10|table08/ID|(abstract|section\d)/experimental/total")]
    assert simulated["note"].str.contains("simulated").all() and len(simulated) == 60 + 2 * 10 + 2 + 3 * 3


@pytest.mark.slow
def test_a_result_that_scatters_reproduces_nothing(published, config, folder):
    """Twice the spread would let 40 % pass for 93.91 %."""
    path = folder / "validation" / "experiment.csv"
    scores = pd.read_csv(path)
    table = pd.read_csv(folder / "tables" / "table10.csv")
    ours = (table["case"] == "T3") & (table["method"] == "algorithm1") & (table["joint"] == 1)
    table.loc[ours, "total"] = 0.4
    table.to_csv(folder / "tables" / "table10.csv", index=False)
    seeds = (scores["case"] == "T3") & (scores["method"] == "algorithm1") & (scores["joint"] == 1)
    scores.loc[seeds, "total"] = [0.1, 0.4, 0.7]
    scores.to_csv(path, index=False)
    row = compute(published, config, Results(folder)).set_index("id").loc["table10/T3/algorithm1/total/joint1"]
    assert (row["verdict"], row["tolerance_from"]) == (DIFFERS, CAPPED)
    assert row["tolerance"] == pytest.approx(5.005)
    assert "scatters over the seeds by 30.0" in row["note"]


@pytest.mark.slow
def test_a_parameter_nearer_the_truth_is_better(claims, config):
    for case in NUMERIC:
        table = "table04" if case in NUMERIC[:2] else "table05"
        for name, true in zip(("I1", "g1"), (config["numeric"]["arms"][case][k] for k in (0, 3)), strict=True):
            row = claims.loc[f"{table}/{case}/algorithm1/{name}"]
            nearer = 0.01 * true < abs(float(row["published"]) - true)
            within = abs(row["difference"]) <= row["tolerance"]
            assert row["verdict"] == (REPRODUCED if within else BETTER if nearer else DIFFERS)


@pytest.mark.slow
def test_statements_about_all_cases_hold_for_the_worst_or_the_best(published, config, folder):
    path = folder / "tables" / "table10.csv"
    table = pd.read_csv(path)
    t3 = (table["case"] == "T3") & (table["method"] == "algorithm1") & (table["joint"] == 2)
    on_id = (table["case"] == "ID") & (table["method"] == "algorithm1") & (table["joint"] == 1)
    table.loc[t3, "total"], table.loc[on_id, "total"] = 0.97, 0.6
    table.to_csv(path, index=False)
    rows = compute(published, config, Results(folder)).set_index("id")
    assert rows.loc["section7/experimental/total", "ours"] == pytest.approx(97.0)
    assert rows.loc["abstract/experimental/total", "ours"] == pytest.approx(60.0)
    assert rows.loc["abstract/experimental/total", "verdict"] == DIFFERS


IN_WORDS = {
    "gravity-over-inertia/algorithm1": 0.6 / 0.12,
    "gravity-over-inertia/least-squares": 0.8 / 0.1,
    "viscous-over-coulomb/algorithm1": 0.1 / 0.25,
    "viscous-over-algorithm1": 0.05 / 0.1,
}


@pytest.mark.slow
def test_comparisons_of_table_9_in_words_are_ratios_of_its_parameters(claims):
    rows = claims[claims["place"].eq("Section V-C") & claims["quantity"].str.contains(" over |/")]
    assert {name.removeprefix("section5c/"): row["ours"] for name, row in rows.iterrows()} == pytest.approx(IN_WORDS)
    differing = {"section5c/viscous-over-algorithm1"}  # b2 of least squares is the lower one
    assert set(rows.index[rows["verdict"] == DIFFERS]) == differing
    assert set(rows["verdict"]) == {REPRODUCED, DIFFERS}
    assert not rows["must"].any()
    assert rows["note"].str.contains("simulated").all()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("method", "parameter", "value", "differing", "ratio"),
    [
        ("algorithm1", "I3", 0.61, "gravity-over-inertia/algorithm1", 0.6 / 0.61),  # not I1 alone counts
        ("least-squares", "I2", 1.6, "gravity-over-inertia/least-squares", 0.5),
        ("algorithm1", "k1", 0.064, "viscous-over-coulomb/algorithm1", 1.25),  # the worse joint
        ("algorithm1", "k2", 0.0, "viscous-over-coulomb/algorithm1", math.inf),
        ("least-squares", "b1", -0.04, "viscous-over-algorithm1", -0.5),
    ],
)
def test_a_comparison_in_words_fails_for_one_parameter_that_violates_it(
    published, config, folder, method, parameter, value, differing, ratio
):
    path = folder / "tables" / "table09.csv"
    table = pd.read_csv(path)
    table.loc[(table["method"] == method) & (table["parameter"] == parameter), "estimate"] = value
    table.to_csv(path, index=False)
    row = compute(published, config, Results(folder)).set_index("id").loc[f"section5c/{differing}"]
    assert (row["verdict"], row["must"]) == (DIFFERS, False)
    assert row["ours"] == pytest.approx(ratio)


@pytest.mark.slow
def test_least_squares_with_higher_viscous_friction_in_both_joints_is_as_published(published, config, folder):
    path = folder / "tables" / "table09.csv"
    table = pd.read_csv(path)
    higher_b2 = (table["method"] == "least-squares") & (table["parameter"] == "b2")
    table.loc[higher_b2, "estimate"] = 0.3
    table.to_csv(path, index=False)
    row = compute(published, config, Results(folder)).set_index("id").loc["section5c/viscous-over-algorithm1"]
    assert (row["verdict"], row["ours"]) == (REPRODUCED, pytest.approx(3.0))  # b1: 0.32 over 0.08


@pytest.mark.slow
@pytest.mark.parametrize(
    ("prior", "recipe", "words"),
    [
        ("mixture", "streamed", "training ranges and schedule of the network: ours"),
        ("published", "streamed", "training schedule of the network: ours"),
        ("mixture", "paper", "training ranges of the network: ours"),
        ("published", "paper", ""),
    ],
)
def test_numeric_similarities_say_what_of_the_training_is_ours(published, config, folder, prior, recipe, words):
    changed = {**config, "data": {**config["data"], "prior": prior}}
    changed["training"] = {**config["training"], "recipe": recipe}
    notes = compute(published, changed, Results(folder)).set_index("id")["note"]
    for name in ("table07/N3/time/joint2", "abstract/numeric/total", "section6/numeric/total"):
        assert ("of the network: ours" in notes[name]) == bool(words)
        assert words in notes[name]
    assert not notes[notes.index.str.startswith("table10")].str.contains("of the network: ours").any()


@pytest.mark.slow
def test_what_the_audit_contradicts_says_so_with_its_arithmetic(claims, published):
    contradicted = claims[claims["verdict"] == CONTRADICTS]
    assert set(contradicted.index) == {
        "section1a/random-trajectories",
        "section4a/band-high",
        "table07/N1/total/joint2",
        "table10/T2/algorithm1/total/joint2",
        "table10/T2/least-squares/total/joint2",
        "appendix/domain",
    }
    assert "98.65 % x 89.69 % = 88.479 %" in contradicted.loc["table10/T2/least-squares/total/joint2", "note"]
    assert not contradicted["must"].any()
    # A contradiction between several numbers paints over none of them.
    assert {about(f) for f in findings(published)} - {""} == set(contradicted.index)
    assert claims.loc["table04/N2/true/I1", "verdict"] == REPRODUCED
    assert "not possible" in claims.loc["table04/N2/true/I1", "note"]


def test_a_broken_promise_is_found_and_told(published, config, folder):
    path = folder / "model" / "training.csv"
    path.write_text(path.read_text().replace(f"{LOSS:g}", "0.00101"), encoding="utf-8")
    rows = compute(published, config, Results(folder))
    assert broken(rows)["id"].tolist() == ["section5a/loss"]
    assert "promise broken: section5a/loss: published 1e-3, ours 0.00101" in summary(rows)
    assert "| section5a/loss |" in markdown(rows).split("## What differs")[0]


def test_the_extension_must_reach_the_published_number_without_a_tolerance(published, config, folder):
    path = folder / "tables" / "table06.csv"
    table = pd.read_csv(path)
    table.loc[(table["case"] == "N3") & (table["method"] == "algorithm1+refinement"), "total"] = 0.9737
    table.to_csv(path, index=False)
    found = broken(compute(published, config, Results(folder)))["id"].tolist()
    assert set(found) == set(MUST_REFINED)


@pytest.mark.slow
def test_the_page_holds_every_number_under_its_place(published, config, folder):
    rows = compute(published, config, Results(folder))
    text = markdown(rows)
    whole = text.split("## Every number")[1]
    for name in rows["id"]:
        assert whole.count(f"| {name} |") == 1
    places = [line.removeprefix("### ") for line in whole.splitlines() if line.startswith("### ")]
    assert places == list(dict.fromkeys(rows["place"]))
    setting, extension = rows["kind"] == "setting", rows["id"].str.contains("@")
    for verdict in VERDICTS:
        of_it = rows["verdict"] == verdict
        counts = (of_it & ~setting & ~extension, of_it & ~setting & extension, of_it & setting)
        assert f"| {verdict} | {' | '.join(str(int(c.sum())) for c in counts)} |" in text
    assert all(line.count("|") >= 3 for line in text.splitlines() if line.startswith("|"))


@pytest.mark.parametrize("name", FILES)
def test_a_missing_result_is_named(folder, name):
    (folder / name).unlink()
    with pytest.raises(InputError, match=name):
        Results(folder)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "old", "new", "named"),
    [
        ("tables/table10.csv", "T4,algorithm1,2", "T5,algorithm1,2", "case T4, method algorithm1, joint 2"),
        ("tables/table07.csv", "N1,algorithm1,1,0.95", "N1,algorithm1,1,", "time of case N1"),
        ("tables/stability.csv", "appendix,Rate", "appendix,Race", "quantity Rate"),
        ("tables/table09.csv", "ID,least-squares,b2", "ID,least-squares,b3", "method least-squares, parameter b2"),
        ("tables/table04.csv", "estimate,", "estimation,", "no column estimate"),
    ],
)
def test_a_damaged_result_is_named(published, config, folder, name, old, new, named):
    path = folder / name
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InputError, match=named) as caught:
        counterparts(published, config, Results(folder))
    assert name in str(caught.value) and "\n" not in str(caught.value)


@given(
    amplitude=st.floats(0.05, 2).flatmap(lambda a: st.sampled_from([a, -a])),
    frequency=st.floats(0.5, 5),
    phase=st.floats(0.05, 1.5) | st.floats(1.65, 3.1),
)
def test_a_sinusoid_is_taken_apart(amplitude, frequency, phase):
    t = np.linspace(0, 9.4, 2000)
    wave = amplitude * np.cos(frequency * t + phase)
    found = second_harmonic(wave, -(frequency**2) * wave, t)
    np.testing.assert_allclose(found, (amplitude, frequency, phase), rtol=1e-6)


def test_better_is_the_right_way_round():
    for a, b in pairwise((1.0, 2.0, 3.0)):
        assert higher(a, b) and lower(b, a) and not higher(b, a) and not lower(a, b)
    assert judge(printed(), replace(Ours(98.0, "t"), better=lower))["verdict"] == DIFFERS
