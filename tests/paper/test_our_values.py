"""Where our value of a published number comes from: the grammar of the column ``ours``."""

import importlib.util
import math
from dataclasses import replace

import pytest
from experiment_example import changed, full_config

from repro.paper.our_values import RESULT_SOURCES, training_note, values_of
from repro.paper.published import Published, evaluate, load_published

NAMES = {"arm": {"lengths": [0.2, 0.1], "a-b": {"c": 7}}}
CONFIG = changed(full_config(), training={"paper": {"images": 40}}, arm={"link_lengths_m": (0.2, 0.1)})
NUMBER = load_published()["section3/joints"]


def value_of(ours, note=""):
    number = replace(NUMBER, ours=ours, note=note)
    return values_of(number, Published((number,)), CONFIG, {"check": 2.5}, None)[""]


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("arm.lengths[1]*1e3", 100.0),
        ("len(arm.lengths) - 2**3/4", 0.0),
        ("-sum(arm.lengths)", -0.30000000000000004),
        ("arm['a-b'].c", 7),
        ("(255 >> 4).bit_count()", 4),
        ("round(2.6)", 3),
    ],
)
def test_expressions_are_arithmetic_on_names(expression, value):
    assert evaluate(expression, NAMES) == value


@pytest.mark.parametrize(
    ("ours", "note", "value", "shown"),
    [
        ("config:arm.link_lengths_m[0]", "more", 0.2, "config/config.yaml: arm.link_lengths_m, more"),
        ("config:len(networks['paper-recipe'])", "", 2.0, "config/config.yaml: networks.paper-recipe"),
        ("schedule:training.paper.images", "paper's", 40.0, "config/config.yaml: training.paper.images, paper's"),
        ("const:board.frames:PWM_LIMIT", "counts", 1023.0, "counts; repro.board.frames"),
        ("arithmetic:audit['check']/2", "{audit['check']:.3f} / {printed['section3/joints']}", 1.25, "2.500 / 2"),
        ("bench", "a clock", pytest.approx(math.nan, nan_ok=True), "a clock"),
    ],
)
def test_each_source_has_its_value_and_note(ours, note, value, shown):
    found = value_of(ours, note)
    assert (found.value, found.note) == (value, shown)
    assert found.unused == ours.startswith("schedule")


@pytest.mark.parametrize(
    "ours",
    [
        "config:arm.nothing", "config:arm.link_lengths_m[9]", "const:no.module:X", "const:board.frames:__name__",
        "const:board.frames:PWM_LIMIT.__class__", "config:[1][0]", "config:open('x')", "config:1 +"
    ]
)  # fmt: skip
def test_what_is_no_arithmetic_on_known_names_is_refused(ours):
    with pytest.raises(ValueError, match="section3/joints: ours"):
        value_of(ours)


def test_every_number_of_the_papers_own_has_a_source_that_exists():
    for number in load_published():
        source, _, rest = number.ours.partition(":")
        assert bool(source) == (number.kind != "other-work"), number.id
        if source == "const":
            assert importlib.util.find_spec("repro." + rest.partition(":")[0]), number.id
        if source == "result":
            assert rest.partition(":")[0] in RESULT_SOURCES, number.id


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
    assert training_note(changed(CONFIG, data={"prior": prior}, training={"recipe": recipe})) == note
