"""The configuration files are valid, their reference is up to date, and each fault is reported in one line."""

import copy
import re
import runpy
from contextlib import nullcontext
from dataclasses import fields, is_dataclass
from functools import cache

import pytest
import yaml
from experiment_example import ROOT, refused
from pydantic import BaseModel

from repro.cli import main
from repro.config.check import accept_config, check_config, load_config, merged
from repro.config.model import Configuration
from repro.config.sections import of_network
from repro.documents import read_yaml
from repro.errors import InputError
from repro.signals.programs import MEMORY_SAMPLES

BASE, SMOKE, QUICK = (ROOT / "config" / f"{name}.yaml" for name in ("config", "smoke", "quick"))
REFERENCE = runpy.run_path(str(ROOT / "config/reference.py"))

#: Reads a file of the repository once, which takes a tenth of a second.
READ_ONCE = cache(read_yaml)


def load(*files):
    config = {}
    for file in files:
        config = merged(config, yaml.safe_load(file.read_text(encoding="utf-8")))
    return config


def refusal(config, *files):
    """File, field, found and expected of the error that a configuration ends in."""
    error = refused(check_config, config, files)
    return *error.place.split(": "), error.found, error.expected


# --- The files of the repository ----------------------------------------------------------------------------------


@pytest.mark.parametrize("overlays", [(), (SMOKE,), (QUICK,)], ids=["full", "smoke", "quick"])
def test_the_configuration_in_the_repository_is_valid(overlays, capsys):
    accept_config(load(BASE, *overlays), [BASE, *overlays])
    assert capsys.readouterr() == ("", "")
    assert load_config(BASE, *overlays) == Configuration.model_validate(load(BASE, *overlays))
    assert main(["check", "--config", *map(str, (BASE, *overlays))]) == 0
    assert capsys.readouterr().out.endswith(".yaml: valid\n")


def test_the_schema_is_that_of_the_model():
    assert REFERENCE["SCHEMA"].read_text("utf-8") == REFERENCE["schema_text"](), "run python config/reference.py"


def test_the_page_has_the_tables_of_the_model():
    text = REFERENCE["README"].read_text("utf-8")
    assert text == REFERENCE["readme_text"](text), "run python config/reference.py"
    tables = set(re.findall(r"<!-- keys of ([\w.]+) -->\n\| key", text))
    assert tables == {".".join(path) or "configuration" for path, _ in sections(Configuration)} - {"numeric.arms"}


def test_the_quick_run_computes_with_the_settings_of_the_full_one():
    folders = {"results": "results/quick", "figures": "paper_figures/quick"}
    assert load(QUICK) == folders | {"training": {"source": "stored"}}
    assert load(SMOKE)["claims"] == {"enforce": False}


def leaves(node):
    """Keys whose values are no sections."""
    for key, value in node.items():
        yield from leaves(value) if isinstance(value, dict) else [key]


def test_the_smoke_run_changes_budgets_and_folders_only():
    budgets = {"steps", "batch", "images", "test_samples", "log_every", "checkpoint_every", "seeds", "repeats"}
    budgets |= {"inner_limit", "threshold", "restarts", "keep", "passes", "search_seeds"}
    budgets |= {"arms", "guesses", "results", "figures", "enforce", "specimens", "training_seeds"}
    assert set(leaves(load(SMOKE))) <= budgets
    config = load(BASE, SMOKE)
    assert (config["results"], config["figures"]) == ("results/smoke", "paper_figures/smoke")
    for name in ("published", *config["networks"]):
        assert of_network(load_config(BASE, SMOKE), name).training.steps <= 100, name


# --- Every key of the model ---------------------------------------------------------------------------------------


def sections(model, path=()):
    """Places of all sections with their models."""
    yield path, model
    if is_dataclass(model):
        inner = {field.name: field.type for field in fields(model)}
    else:
        inner = {name: field.annotation for name, field in model.model_fields.items()}
    for name, kind in inner.items():
        if path != ("networks",) and (is_dataclass(kind) or (isinstance(kind, type) and issubclass(kind, BaseModel))):
            yield from sections(kind, (*path, name))


def keys():
    """Place and JSON schema of every key that is no section."""
    schema = Configuration.model_json_schema()
    for path, model in sections(Configuration):
        for name, key in schema["$defs"].get(model.__name__, schema)["properties"].items():
            if "$ref" not in key and "allOf" not in key:
                yield (*path, name), key


def wrong_values(key, value):
    """Values that a key does not allow, by its schema."""
    if key.get("type") == "array":
        item = key["items"] if "items" in key else key["prefixItems"][0]
        yield from ([wrong, *value[1:]] for wrong in wrong_values(item, value[0]))
        yield value[: key["minItems"] - 1]
        if key.get("maxItems"):
            yield [value[0] + 1e-3 * k if isinstance(value[0], float) else k for k in range(key["maxItems"] + 1)]
        return
    yield from (None, [value], {"a": value})
    kind = key.get("type")
    if kind == "string":
        yield from (7, *(["other"] if "enum" in key else []), *(["../x", "a b", "/x", ""] if "pattern" in key else []))
    if kind in ("number", "integer"):
        yield from ("1e-4", True, float("nan"), float("inf"), 10**30)
        yield from (key[name] for name in ("exclusiveMinimum", "exclusiveMaximum") if name in key)
        yield from (key[name] + step for name, step in (("minimum", -1), ("maximum", 1)) if name in key)
    if kind == "integer":
        yield from (1.5, 60.0)
    if kind == "boolean":
        yield from (1, "yes")


def at(config, path):
    for name in path:
        config = config[name]
    return config


@pytest.mark.parametrize(("path", "key"), [*keys()], ids=lambda each: ".".join(each) if isinstance(each, tuple) else "")
def test_a_value_that_a_key_does_not_allow_is_one_line(monkeypatch, path, key):
    monkeypatch.setattr("repro.config.check.read_yaml", READ_ONCE)
    config = load(BASE)
    section = at(config, path[:-1])
    for wrong in wrong_values(key, section.get(path[-1], key.get("default"))):  # a new key may be absent
        spoilt = copy.deepcopy(config)
        at(spoilt, path[:-1])[path[-1]] = wrong
        file, field, *_ = refusal(spoilt, BASE)
        assert file == "command line"  # which is where the value must come from: no file contains it
        assert field.split("[")[0] == ".".join(path), wrong


@pytest.mark.parametrize(
    ("path", "model"), [*sections(Configuration)], ids=lambda x: ".".join(x) if isinstance(x, tuple) else ""
)
def test_missing_and_unknown_keys_are_one_line(monkeypatch, path, model, tmp_path):
    monkeypatch.setattr("repro.config.check.read_yaml", READ_ONCE)
    config, file = load(BASE), tmp_path / "config.yaml"
    for name in at(config, path):
        spoilt = copy.deepcopy(config)
        del at(spoilt, path)[name]
        if is_dataclass(model):  # its class has a default
            check_config(spoilt, [BASE])
            continue
        assert refusal(spoilt, BASE)[:3] == (str(BASE), ".".join((*path, name)), "nothing")
    at(config, path)["colour"] = 1
    file.write_text(yaml.safe_dump(config), encoding="utf-8")
    *error, expected = refusal(config, file)
    assert error == [str(file), ".".join((*path, "colour")), "an unknown key"]
    assert next(iter(at(config, path))) in expected


# --- Values against each other, and the file at fault --------------------------------------------------------------

NETWORK = "networks.tracked."
BAD = {
    "results: src/mine": ("results", "src/mine", "results/mine"),
    "figures: config": ("figures", "config", "paper_figures/mine"),
    "results: .snakemake/x": ("results", ".snakemake/x", "results/mine"),
    "results: out\nfigures: out": ("results", "out", "two folders"),
    "training:": ("training", "None", "a section"),
    # Snakemake's loader has accepted this before it is checked.
    "training:\n  steps: 5\n  steps: 50\n": ("line 3", "'steps' twice", "each key once"),
    "data: {guess_low: 5.0}": ("data.guess_low", "5.0", "below data.guess_high"),
    "algorithm1: {guess_low: 5.0}": ("algorithm1.guess_low", "5.0", "below algorithm1.guess_high"),
    "data: {near_high: 0.003}": ("data.near_high", "0.003", "data.near_low (0.003) below"),
    "data: {exact_share: 0.6, near_share: 0.6}": ("data.exact_share", "0.6", "add up to 1"),
    "refinement: {passes: 0}": ("refinement.passes", "0", "at least 1"),
    "signals: {duration_s: 0.1}": ("signals.duration_s", "0.1", "image_samples (100) sampling periods"),
    "signals: {duration_s: 30.0}": ("signals.duration_s", "30.0", "memory holds, 19.53 s"),
    "signals: {sampling_period_s: 0.002}": ("signals.sampling_period_s", "0.002", "0.0025 s, the board's clock"),
    "experiment: {duration_s: 0.2}": ("experiment.duration_s", "0.2", "image_samples (100)"),
    "coverage: {levels: [0.9, 0.5]}": ("coverage.levels", "[0.9, 0.5]", "rising shares"),
    "training: {steps: 2e3}": ("training.steps", "'2e3'", "an integer, written 2000"),
    "signals: {filter_coefficient: 2e-4}": ("signals.filter_coefficient", "'2e-4'", "a number, written 0.0002"),
    "coverage: {levels: [1.0]}": ("coverage.levels[0]", "1.0", "less than 1"),
    "coverage: {levels: [0.999]}": ("coverage.levels", "[0.999]", "0.9967 at most"),
    "experiment: {lead_in_s: 100.0}": ("experiment.lead_in_s", "100.0", "one sampling period"),
    "results: a\nexperiment: {captures: a/experiment}": ("experiment.captures", "a/experiment", "does not write"),
    "training: {networks: results/model}": ("training.networks", "results/model", "does not write"),
    "training: {paper: {images: 10, train_share: 0.01}}": ("training.paper.images", "10", "one image to train"),
    "arm: {link_lengths_m: [0.2, 0.01]}": ("arm.link_lengths_m", "[0.2, 0.01]", "circle of T2"),
    "arm: {parameters: [0.1, 0.1, 0.2, 1, 1, 1, 1, 1, 1]}": ("arm.parameters", "[0.1, 0.1", "positive definite"),
    "board: {pwm_hz: [1.0e-46, 1000.0]}": ("board.pwm_hz[0]", "1e-46", "at least 1"),
    "experiment: {search_seeds: [3, 3]}": ("experiment.search_seeds", "[3, 3]", "differ"),
    "experiment: {t1: {bands: 1.0e-160}}": ("experiment.t1.bands", "1e-160", "at least 0.1"),
    "board: {kp_nm_per_rad: [1.0e+9,1], full_torque_nm: [1.0e-38,1]}": ("board.kp_nm_per_rad", "1000000000", "single"),
    "networks: {third: {image: {scale: constant}}}": ("networks.third", "an unknown key", "tracked-measured"),
    "networks: {tracked: {metric: {exponent: 1.0}}}": (NETWORK + "metric", "an unknown key", "image"),
    "networks: {tracked: {image: {constant: .nan}}}": (NETWORK + "image.constant", "nan", "finite"),
    "networks: {tracked: {data: {guess_low: 5.0}}}": (NETWORK + "data.guess_low", "5.0", "below data.guess_high"),
    "networks: {tracked: {data: {tracked: {arms: 3}}}}": (NETWORK + "data.tracked", "a key", "share these arms"),
    "networks: {tracked: {refinement: {passes: 2}}}": (NETWORK + "refinement.passes", "2", "0"),
}


@pytest.mark.parametrize(("text", "field", "found", "expected"), [(text, *line) for text, line in BAD.items()], ids=BAD)
def test_a_contradiction_is_one_line_that_names_the_overlay(tmp_path, capsys, text, field, found, expected):
    file = tmp_path / "my.yaml"
    file.write_text(text, encoding="utf-8")
    error = refused(check_config, load(BASE, file), (BASE, file))
    assert error.place == f"{file}: {field}"
    assert found in error.found and expected in error.expected
    with pytest.raises(SystemExit) as stop:
        accept_config(load(BASE, file), [BASE, file])
    assert stop.value.code == 2
    assert capsys.readouterr() == ("", f"{error}\n")


@pytest.mark.parametrize("beyond", [0, 1])
def test_a_motion_may_fill_the_memory_of_the_board(beyond):
    config = load(BASE)
    edges = round(config["experiment"]["lead_in_s"] / 0.0025) + 2 * config["experiment"]["margin_samples"]
    config["signals"]["duration_s"] = (MEMORY_SAMPLES - edges + beyond) * 0.0025
    with pytest.raises(InputError) if beyond else nullcontext():
        check_config(config, [BASE])


def test_the_last_file_with_the_value_is_named(tmp_path):
    base, overlay = tmp_path / "config.yaml", tmp_path / "my.yaml"
    config = load(BASE)
    config["training"]["steps"] = -1
    base.write_text(yaml.safe_dump(config), encoding="utf-8")
    overlay.write_text("training: {batch: 8}", encoding="utf-8")
    assert refusal(load(base, overlay), base, overlay)[0] == str(base)
    overlay.write_text("training: {steps: -1}", encoding="utf-8")
    assert refusal(load(base, overlay), base, overlay)[0] == str(overlay)


@pytest.mark.parametrize("name", ["src/x", ".git", "Data", "benchmarks"])
def test_a_run_does_not_write_into_folders_of_the_project(name):
    for key in ("results", "figures"):
        assert refusal(load(BASE) | {key: name}, BASE)[1] == key


def test_an_environment_in_a_folder_with_a_blank_is_refused_before_any_job(monkeypatch, capsys):
    monkeypatch.setattr("sys.executable", "/home/my user's/.venv/bin/python")
    with pytest.raises(SystemExit) as stop:
        accept_config(load(BASE), [BASE])
    assert stop.value.code == 2 and capsys.readouterr().err.startswith(
        "/home/my user's/.venv/bin/python: found a blank"
    )


@pytest.mark.parametrize("place", ["top", "arms"])
def test_a_key_that_is_not_text_is_refused_in_one_line(place):
    config = load(BASE)
    (config if place == "top" else config["numeric"]["arms"])[1] = [1.0] * 9
    assert refusal(config, BASE)[-2] == "the key 1"


@pytest.mark.parametrize("name", ["missing", "folder", "empty", "list"])
def test_a_file_that_cannot_be_read_is_refused_in_one_line(tmp_path, name):
    (tmp_path / "folder").mkdir()
    (tmp_path / "empty").touch()
    (tmp_path / "list").write_text("- 1\n", encoding="utf-8")
    assert refused(load_config, tmp_path / name).place.startswith(str(tmp_path / name))
