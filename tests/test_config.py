"""The configuration files are valid, and whatever is wrong with one is told in one line."""

import re
from pathlib import Path

import pytest
import yaml

from repro.config import check_config
from repro.errors import InputError
from repro.pipeline.start import accept_config
from repro.settings import of_network

ROOT = Path(__file__).resolve().parent.parent
BASE = ROOT / "config" / "config.yaml"
SMOKE = ROOT / "config" / "smoke.yaml"
QUICK = ROOT / "config" / "quick.yaml"
SCHEMA = ROOT / "workflow" / "schemas" / "config.schema.yaml"

ONE_LINE = re.compile(r"(?P<file>[^:]+): (?P<field>[^:]+): found (?P<found>.+), expected (?P<expected>.+)")


def merge(base, overlay):
    """Snakemake's way: sections are merged, everything else is replaced."""
    if isinstance(base, dict) and isinstance(overlay, dict):
        return {**base, **{key: merge(base.get(key), value) for key, value in overlay.items()}}
    return overlay


def load(*files):
    config = {}
    for file in files:
        config = merge(config, yaml.safe_load(file.read_text(encoding="utf-8")))
    return config


def line_of(message):
    match = ONE_LINE.fullmatch(message)
    assert match, f"not one line of file, field, found and expected: {message!r}"
    return match


@pytest.fixture
def overlay(tmp_path):
    def write(text):
        path = tmp_path / "my.yaml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.mark.slow
@pytest.mark.parametrize("files", [(BASE,), (BASE, SMOKE), (BASE, QUICK)], ids=["full", "smoke", "quick"])
def test_the_configuration_in_the_repository_is_valid(files):
    config = load(*files)
    check_config(config, SCHEMA, files)


@pytest.mark.parametrize("overlay", [SMOKE, QUICK], ids=["smoke", "quick"])
def test_another_run_writes_to_folders_of_its_own(overlay):
    full, other = load(BASE), load(BASE, overlay)
    assert other["results"] == f"{full['results']}/{overlay.stem}"
    assert other["figures"] == f"{full['figures']}/{overlay.stem}"


def test_the_quick_run_computes_with_the_settings_of_the_full_one():
    changed = set(leaves(load(QUICK)))
    assert changed == {("results",), ("figures",), ("training", "source")}


def leaves(node, path=()):
    if isinstance(node, dict):
        for key, value in node.items():
            yield from leaves(value, (*path, key))
    else:
        yield path


def test_every_key_is_explained():
    text = (ROOT / "config" / "README.md").read_text(encoding="utf-8")
    parts = re.split(r"^## (\S+)\n", text, flags=re.MULTILINE)
    chapters = dict(zip(parts[1::2], parts[2::2], strict=True))
    for path in leaves(load(BASE)):
        chapter = chapters["Folders"] if len(path) == 1 else chapters[path[0]]
        assert f"`{path[-1]}`" in chapter or path[-2] == "arms", ".".join(path)


def test_the_smoke_run_trains_every_network_briefly():
    config = load(BASE, SMOKE)
    for name in ("published", *config["networks"]):
        assert of_network(config, name)["training"]["steps"] <= 100, name


def test_the_smoke_run_changes_budgets_and_folders_only():
    budgets = {"steps", "batch", "images", "test_samples", "log_every", "checkpoint_every", "seeds", "repeats"}
    budgets |= {"inner_limit", "threshold_numeric", "threshold", "restarts", "keep", "passes", "search_seeds"}
    budgets |= {"arms", "guesses", "results", "figures", "enforce", "specimens", "training_seeds"}
    assert {path[-1] for path in leaves(load(SMOKE))} <= budgets


NINE = "0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1"

BAD = {
    "unknown key": ("stepz: 1", "stepz", "unknown", "training"),
    "unknown key in a section": ("training: {stepz: 1}", "training.stepz", "unknown", "steps"),
    "a long folder": (f"results: {'a' * 10_000}", "results", "aaa", "at most 200 characters"),
    "unknown key two deep": ("training: {paper: {stepz: 1}}", "training.paper.stepz", "unknown", "images"),
    "unknown network": ("networks: {third: {image: {scale: constant}}}", "networks.third", "unknown", "tracked"),
    "unknown section of a network": (
        "networks: {tracked: {metric: {exponent: 1.0}}}",
        "networks.tracked.metric",
        "unknown",
        "image",
    ),
    "unknown key of a network": (
        "networks: {tracked: {image: {scales: 1}}}",
        "networks.tracked.image.scales",
        "unknown",
        "scale",
    ),
    "a network's NaN": (
        "networks: {tracked: {image: {constant: .nan}}}",
        "networks.tracked.image.constant",
        "nan",
        "finite",
    ),
    "unknown arm": (f"numeric: {{arms: {{N5: [{NINE}, 1.0]}}}}", "numeric.arms.N5", "unknown", "N4"),
    "emptied section": ("training:", "training", "None", "object"),
    "value for a section": ("metric: 3", "metric", "3", "object"),
    "text for a number": ("training: {steps: many}", "training.steps", "many", "integer"),
    "number that YAML reads as text": (
        "signals: {filter_coefficient: 1e-4}",
        "signals.filter_coefficient",
        "1e-4",
        "n",
    ),
    "part of a step": ("training: {steps: 1.5}", "training.steps", "1.5", "integer"),
    "budget written as a fraction": ("training: {steps: 60.0}", "training.steps", "60.0", "integer"),
    "truth for a number": ("training: {batch: true}", "training.batch", "True", "integer"),
    "number for a truth": ("signals: {normalise_motion: 1}", "signals.normalise_motion", "1", "boolean"),
    "negative budget": ("training: {steps: -5}", "training.steps", "-5", "at least 1"),
    "no budget": ("algorithm1: {executions: 0}", "algorithm1.executions", "0", "at least 1"),
    "negative restarts": ("refinement: {restarts: -1}", "refinement.restarts", "-1", "at least 0"),
    "moves of no length": ("refinement: {reach: 0.0}", "refinement.reach", "0.0", "more than 0"),
    "negative jitter": ("refinement: {jitter: -1.0e-4}", "refinement.jitter", "-0.0001", "at least 0"),
    "key of an earlier version": ("refinement: {spread_low: 0.1}", "refinement.spread_low", "unknown", "reach"),
    "NaN": ("signals: {filter_coefficient: .nan}", "signals.filter_coefficient", "nan", "finite"),
    "infinity": ("signals: {duration_s: .inf}", "signals.duration_s", "inf", "at most 1000000000"),
    "infinite budget": ("training: {steps: .inf}", "training.steps", "inf", "integer"),
    "NaN in a list": (f"numeric: {{arms: {{N2: [{NINE}, .nan]}}}}", "numeric.arms.N2[8]", "nan", "finite"),
    "negative parameter": (f"numeric: {{arms: {{N2: [{NINE}, -1]}}}}", "numeric.arms.N2[8]", "-1", "more than 0"),
    "short arm": ("numeric: {arms: {N1: [0.1, 0.2, 0.3]}}", "numeric.arms.N1", "[0.1, 0.2, 0.3]", "9 values"),
    "long arm": (f"numeric: {{arms: {{N1: [{NINE}, 1, 1]}}}}", "numeric.arms.N1", "1, 1]", "9 values"),
    "no seeds": ("numeric: {seeds: []}", "numeric.seeds", "[]", "at least 1"),
    "seed given twice": ("numeric: {seeds: [2, 2]}", "numeric.seeds", "[2, 2]", "differ"),
    "seed too large": ("training: {seed: 4294967296}", "training.seed", "4294967296", "at most 4294967295"),
    "negative seed": ("numeric: {seeds: [1, -2]}", "numeric.seeds[1]", "-2", "at least 0"),
    "unknown choice": ("data: {prior: normal}", "data.prior", "normal", "log-uniform"),
    "size that the network does not take": ("signals: {image_samples: 64}", "signals.image_samples", "64", "100"),
    "percent for a fraction": (
        "algorithm1: {threshold_numeric: 92.82}",
        "algorithm1.threshold_numeric",
        "92",
        "most 1",
    ),
    "nothing left to test with": ("training: {paper: {train_share: 1}}", "training.paper.train_share", "1", "than 1"),
    "arm with eight parameters": (f"arm: {{parameters: [{NINE}]}}", "arm.parameters", "0.1", "9 values"),
    "parameter of the arm that is zero": (f"arm: {{parameters: [{NINE}, 0]}}", "arm.parameters[8]", "0", "more than 0"),
    "one link": ("arm: {link_lengths_m: [0.2]}", "arm.link_lengths_m", "[0.2]", "2 values"),
    "dead band in parts of a count": ("arm: {dead_band_counts: 0.5}", "arm.dead_band_counts", "0.5", "integer"),
    "dead band that is all of the PWM": ("arm: {dead_band_counts: 1023}", "arm.dead_band_counts", "1023", "most 1022"),
    "negative ripple": ("arm: {ripple_nm: [0.1, -0.1]}", "arm.ripple_nm[1]", "-0.1", "at least 0"),
    "one ripple for two joints": ("arm: {ripple_nm: 0.1}", "arm.ripple_nm", "0.1", "array"),
    "three Stribeck levels": ("arm: {stribeck: [1.0, 1.0, 1.0]}", "arm.stribeck", "[1.0, 1.0, 1.0]", "at most 2"),
    "negative back-EMF": ("arm: {back_emf_nm_s_per_rad: -0.1}", "arm.back_emf_nm_s_per_rad", "-0.1", "at least 0"),
    "range of something else": ("experiment: {random_range_of: all}", "experiment.random_range_of", "all", "numbers"),
    "no bands": ("experiment: {random_bands: 0}", "experiment.random_bands", "0", "more than 0"),
    "one sample to validate on": ("numeric: {validation_samples: 1}", "numeric.validation_samples", "1", "at least 2"),
    "one level of back-EMF": (
        "factorial: {back_emf_nm_s_per_rad: [0.1, 0.1]}",
        "factorial.back_emf_nm_s_per_rad",
        "0.1",
        "differ",
    ),
    "eight parameters of an arm": (f"factorial: {{second_arm: [{NINE}]}}", "factorial.second_arm", "0.1", "at least 9"),
    "plain network without a layer": ("factorial: {plain: {width: 0}}", "factorial.plain.width", "0", "at least 1"),
    "variation beyond everything": ("arm: {variation: 1.1}", "arm.variation", "1.1", "at most 1"),
    "gain of zero": ("board: {kp_nm_per_rad: [1.0, 0]}", "board.kp_nm_per_rad[1]", "0", "more than 0"),
    "unknown source": ("experiment: {source: live}", "experiment.source", "live", "stored"),
    "captures elsewhere": ("experiment: {captures: /tmp}", "experiment.captures", "/tmp", "a folder of the project"),
    "port without a name": ("experiment: {port: ''}", "experiment.port", "''", "minLength"),
    "baud of zero": ("experiment: {baud: 0}", "experiment.baud", "0", "at least 1"),
    "more than the memory": ("experiment: {validation_samples: 8193}", "experiment.validation_samples", "93", "8192"),
    "more than full torque": ("experiment: {torque_share: 1.01}", "experiment.torque_share", "1.01", "at most 1"),
    "threshold of 92": ("experiment: {threshold: 92.37}", "experiment.threshold", "92.37", "at most 1"),
    "no duration": ("spread: {durations_s: []}", "spread.durations_s", "[]", "at least 1"),
    "duration given twice": ("spread: {durations_s: [3.0, 3.0]}", "spread.durations_s", "3.0", "differ"),
    "absolute folder": ("results: /tmp/results", "results", "/tmp/results", "a folder of the project"),
    "folder outside": ("results: ../x", "results", "../x", "a folder of the project"),
    "folder outside by a detour": ("figures: a/../../x", "figures", "a/../../x", "a folder of the project"),
    "folder with a space": ("figures: my figures", "figures", "my figures", "a folder of the project"),
    "folder without a name": ("figures: ''", "figures", "''", "a folder of the project"),
    "layer of a hundred million": ("network: {hidden: [100, 100000000]}", "network.hidden[1]", "100000000", "4096"),
    "batch of a billion": ("training: {batch: 1000000000}", "training.batch", "1000000000", "at most 4096"),
    "steps for ever": ("training: {steps: 100000000000000000}", "training.steps", "100000000000000000", "10000000"),
    "parameter without end": (f"arm: {{parameters: [{NINE}, 1.0e+308]}}", "arm.parameters[8]", "1e+308", "1000000000"),
    "results among the sources": ("results: src/mine", "results", "src/mine", "results/mine"),
    "results over the reference": ("results: docs/reference", "results", "docs/reference", "results/mine"),
    "results over the captures": ("results: data", "results", "data", "results/mine"),
    "figures over the settings": ("figures: config", "figures", "config", "paper_figures/mine"),
    "results of a tool": ("results: .snakemake/x", "results", ".snakemake/x", "results/mine"),
    "one folder for both": ("results: out\nfigures: out", "results", "out", "two folders"),
}


@pytest.mark.slow
@pytest.mark.parametrize(("text", "field", "found", "expected"), BAD.values(), ids=BAD)
def test_a_fault_is_one_line_that_names_the_overlay(overlay, text, field, found, expected):
    file = overlay(text)
    with pytest.raises(InputError) as error:
        check_config(load(BASE, file), SCHEMA, [BASE, file])
    line = line_of(str(error.value))
    assert line["file"] == str(file)
    assert line["field"] == field
    assert found in line["found"]
    assert expected in line["expected"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "fields"),
    [
        ("data: {guess_low: 5.0}", ("data.guess_low", "data.guess_high")),
        ("data: {near_high: 1.0e-4}", ("data.near_low", "data.near_high")),
        ("data: {exact_share: 0.6, near_share: 0.6}", ("data.exact_share", "data.near_share")),
        ("algorithm1: {guess_high: 1.0e-4}", ("algorithm1.guess_low", "algorithm1.guess_high")),
        ("signals: {duration_s: 0.1}", ("signals.duration_s", "signals.sampling_period_s")),
        ("training: {paper: {images: 10, train_share: 0.01}}", ("training.paper.images", "training.paper.train_share")),
        ("networks: {tracked: {data: {guess_low: 5.0}}}", ("networks.tracked.data.guess_low",)),
    ],
    ids=[
        "guesses",
        "near guesses",
        "shares",
        "guesses of Algorithm 1",
        "too short",
        "empty training set",
        "a network's",
    ],
)
def test_values_that_contradict_each_other_are_one_line_that_names_the_overlay(overlay, capsys, text, fields):
    file = overlay(text)
    with pytest.raises(SystemExit) as stop:
        accept_config(load(BASE, file), SCHEMA, [BASE, file])
    assert stop.value.code == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.endswith("\n")
    line = line_of(said.err[:-1])
    assert line["file"] == str(file)
    assert line["field"] in fields


@pytest.mark.slow
@pytest.mark.parametrize("section", [name for name, value in load(BASE).items() if isinstance(value, dict)])
def test_a_missing_section_is_one_line_that_names_the_file(tmp_path, section):
    file = tmp_path / "config.yaml"
    config = load(BASE)
    del config[section]
    file.write_text(yaml.safe_dump(config), encoding="utf-8")
    with pytest.raises(InputError) as error:
        check_config(load(file), SCHEMA, [file])
    line = line_of(str(error.value))
    assert (line["file"], line["field"], line["found"]) == (str(file), section, "nothing")


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("training:\n  steps: 5\n  steps: 50\n", "line 3"),
        ("training: {1: 2}\n", "line 1"),
        ("training:\n  steps: 1:30\n", "line 2: training.steps"),
        (f"arm:\n  back_emf_nm_s_per_rad: 1{'0' * 400}\n", "line 2: arm.back_emf_nm_s_per_rad"),
        (f"a: &a [x, x]\nb: &b {[['*a'] * 9] * 9}\n".replace("'", "") + "training: {steps: &c [*c]}\n", "line 3"),
    ],
    ids=["key twice", "key that is no text", "base of 60", "400 digits", "alias to itself"],
)
def test_what_yaml_would_accept_in_silence_is_refused(overlay, text, place):
    """Snakemake's loader has accepted the file before it is checked."""
    file = overlay(text)
    with pytest.raises(InputError) as error:
        check_config(load(BASE), SCHEMA, [BASE, file])
    assert str(error.value).startswith(f"{file}: {place}: found ")


def test_a_missing_key_is_named(tmp_path):
    file = tmp_path / "config.yaml"
    config = load(BASE)
    del config["training"]["paper"]["images"]
    file.write_text(yaml.safe_dump(config), encoding="utf-8")
    with pytest.raises(InputError) as error:
        check_config(load(file), SCHEMA, [file])
    line = line_of(str(error.value))
    assert (line["file"], line["field"], line["found"]) == (str(file), "training.paper.images", "nothing")


def test_the_base_file_is_named_when_the_overlay_is_innocent(tmp_path, overlay):
    base = tmp_path / "config.yaml"
    config = load(BASE)
    config["training"]["steps"] = -1
    base.write_text(yaml.safe_dump(config), encoding="utf-8")
    file = overlay("training: {batch: 8}")
    with pytest.raises(InputError) as error:
        check_config(load(base, file), SCHEMA, [base, file])
    assert line_of(str(error.value))["file"] == str(base)


def test_a_value_that_no_file_holds_is_not_blamed_on_one():
    """Snakemake's --config sets values that stand in no file."""
    config = merge(load(BASE), {"training": {"steps": -1}})
    with pytest.raises(InputError) as error:
        check_config(config, SCHEMA, [BASE])
    line = line_of(str(error.value))
    assert str(BASE) not in line["file"]
    assert (line["field"], line["found"]) == ("training.steps", "-1")


@pytest.mark.slow
def test_of_several_faults_the_same_one_is_told_every_time(overlay):
    file = overlay("training: {steps: -1, batch: -1}\nalgorithm1: {executions: x}\nnumeric: {seeds: []}")
    messages = set()
    for _ in range(3):
        with pytest.raises(InputError) as error:
            check_config(load(BASE, file), SCHEMA, [BASE, file])
        messages.add(str(error.value))
    assert len(messages) == 1
    line_of(messages.pop())


def test_a_valid_configuration_is_accepted_in_silence(capsys):
    accept_config(load(BASE, SMOKE), SCHEMA, [BASE, SMOKE])
    said = capsys.readouterr()
    assert (said.out, said.err) == ("", "")


@pytest.mark.parametrize("place", ["top", "arms"])
def test_a_key_that_is_not_text_is_refused_in_one_line(place):
    config = load(BASE)
    (config if place == "top" else config["numeric"]["arms"])[1] = [1.0] * 9
    with pytest.raises(InputError, match="the key 1, expected text") as caught:
        check_config(config, SCHEMA, [BASE])
    assert "\n" not in str(caught.value)
