"""Our values of the published numbers: each has one, from the function of its place, and names where it is from."""

import importlib.util
from dataclasses import replace

import pytest
from claims_example import CONFIG, write_results
from experiment_example import changed, refused

from repro.config.check import load_config
from repro.paper import our_values
from repro.paper.audit import findings
from repro.paper.ledger import compute
from repro.paper.our_results import Results, training_note
from repro.paper.our_settings import arithmetic, constant, literal, of_paper_recipe, setting
from repro.paper.published import Published, load_published
from repro.signals import trajectories

PUBLISHED, SETTINGS = load_published(), load_config(CONFIG)
OWN = {number.id for number in PUBLISHED if number.kind != "other-work"}


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    write_results(folder)
    return Results(folder)


@pytest.fixture(scope="module")
def values(results):
    found = {finding.id: finding.found for finding in findings(PUBLISHED)}
    return our_values.our_values(PUBLISHED, SETTINGS, found, results)


def test_every_number_of_the_papers_own_has_a_value_from_the_function_of_its_place(values):
    numbers = {name.partition("@")[0] for name in values}
    assert numbers == OWN
    assert all(callable(getattr(our_values, name.partition("/")[0])) for name in OWN)


def test_the_table_of_a_number_is_computed_by_the_function_of_its_name(values, results):
    table = our_values.table10(results)
    assert table == {name: values[name] for name in values if name.startswith("table10/")}
    cell = table["table10/ID/algorithm1/total/joint1"]
    assert (cell.value, cell.seeds) == (pytest.approx(97.5), 3)
    assert table["table10/T3/algorithm1/total/joint2@refinement"].value == pytest.approx(99.0)
    assert "table10/T3/algorithm1/time/joint2@refinement" not in table


@pytest.mark.parametrize(
    ("number", "section", "change", "value"),
    [
        ("section3/tip-speed", "board", {"speed_limit_rad_s": 6.0}, 6.0 * 0.315),
        ("section4a/band-high", "signals", {"image_samples": 201}, 200 / (2 * 0.0025 * 3770)),
        ("section4b/test-images", "training", {"paper": {"images": 50}}, 10.0),
        ("section4b/iterations", "networks", {"paper-recipe": {"training": {"steps": 7}}}, 7.0),
        ("table05/N3/true/g2", "numeric", {"arms": {"N3": [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]}}, 5.0),
        ("table08/kv/joint2", "board", {"kv_nm_per_rad": [1270.7266, 90.0]}, 90.0),
        ("section6/T1/range-low", "experiment", {"t1": {"range_rad": 1.3}}, -1.3),
    ],
)
def test_a_value_follows_the_configuration(results, number, section, change, value):
    config = changed(SETTINGS, **{section: change})
    row = compute(PUBLISHED, config, results).set_index("id").loc[number]
    assert row["ours"] == pytest.approx(value, rel=1e-12)


def test_keys_and_modules_that_notes_name_exist(values):
    keys = {v.note.partition(": ")[2].partition(",")[0] for v in values.values() if v.note.startswith("config/config")}
    assert len(keys) >= 30
    for key in keys:
        section = SETTINGS
        for name in key.replace("-", "_").split("."):
            section = section[name] if isinstance(section, dict) else getattr(section, name)
    modules = {v.note.rpartition("; ")[2] for v in values.values() if v.note.rpartition("; ")[2].startswith("repro.")}
    assert len(modules) > 8
    assert all(importlib.util.find_spec(name) for name in modules)


@pytest.mark.parametrize(
    ("ours", "value", "note"),
    [
        (setting("arm.link_lengths_m", 0.2, "more"), 0.2, "config/config.yaml: arm.link_lengths_m, more"),
        (setting("arm.link_lengths_m", 2), 2.0, "config/config.yaml: arm.link_lengths_m"),
        (constant(trajectories, 3, "counts"), 3.0, "counts; repro.signals.trajectories"),
        (constant(trajectories, 3), 3.0, "repro.signals.trajectories"),
        (arithmetic(1.25, "2.5 / 2"), 1.25, "2.5 / 2"),
    ],
)
def test_each_source_has_its_value_and_note(ours, value, note):
    assert (ours.value, ours.note, ours.unused, ours.literal) == (value, note, False, False)
    assert literal(ours).literal


def test_only_the_papers_own_training_uses_its_settings():
    own, papers = SETTINGS, changed(SETTINGS, training={"recipe": "paper"})
    assert [of_paper_recipe(config, "training.paper.images", 1).unused for config in (own, papers)] == [True, False]


def test_a_number_without_a_value_of_ours_is_named(results):
    more = replace(PUBLISHED["section3/joints"], id="section3/fingers")
    assert "'section3/fingers'" in str(refused(compute, Published((*PUBLISHED, more)), SETTINGS, results))


@pytest.mark.parametrize(
    ("prior", "recipe", "note"),
    [
        ("mixture", "streamed", "training ranges and schedule of the network: ours"),
        ("published", "streamed", "training schedule of the network: ours"),
        ("mixture", "paper", "training ranges of the network: ours"),
        ("published", "paper", ""),
    ],
)
def test_a_note_says_what_of_the_training_is_ours(prior, recipe, note):
    assert training_note(changed(SETTINGS, data={"prior": prior}, training={"recipe": recipe})) == note
