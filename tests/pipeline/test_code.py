"""Digests of the code that a job reaches: what changes them, and what does not."""

import hashlib
import json

import pytest

from repro.pipeline.code import CodeDigests

FILES = {
    "__init__": '"""Package."""\n',
    "top": """
from typing import TYPE_CHECKING
from pack import middle
from pack.low import LOW
from pack.kinds import Kind
import pack.effect
if TYPE_CHECKING:
    from pack.aside import ASIDE

def run(kind: Kind) -> "ASIDE":
    \"""Run.\"""
    return middle.twice(LOW)

def idle():
    return middle.unused(LOW)
""",
    "middle": """
import math
from importlib import import_module
from pack.deep import _helper as helper

def twice(x):
    \"""Double.\"""
    return 2 * helper(x)

def unused(x):
    return 4 * x

def found(name):
    return import_module(f"pack.plugins.{name}")

def place(name):
    return f"pack.plugins.{name}"

TABLE = {("figure", "one"): twice, ("figure", "two"): unused}
assert 1 < 2
""",
    "low": "LOW = 1\nHIGH = 2\n",
    "deep": "FACTOR = 5\n\ndef _helper(x):\n    return FACTOR * x\n",
    "kinds": "class Kind:\n    size = 1\n",
    "effect": "import math\nmath.tau\n",
    "aside": "ASIDE = 1\n",
    "plugins/__init__": "",
    "plugins/first": "VALUE = 1\n",
}


@pytest.fixture
def package(tmp_path):
    folder = tmp_path / "pack"
    (folder / "plugins").mkdir(parents=True)
    for name, text in FILES.items():
        (folder / f"{name}.py").write_text(text, encoding="utf-8")
    return folder


def digest(package, *modules):
    return CodeDigests(package.parent / "kept.json", package).of(*modules)


def change(package, name, old, new):
    file = package / f"{name}.py"
    text = file.read_text(encoding="utf-8")
    assert old in text
    file.write_text(text.replace(old, new), encoding="utf-8")


@pytest.mark.parametrize(
    ("name", "old", "new", "changes"),
    [
        pytest.param("top", '"""Run."""', '"""Runs all of it."""', False, id="docstring"),
        pytest.param("middle", '"""Double."""', '"""Double."""\n    # why', False, id="comment"),
        pytest.param("middle", "2 * helper", "3 * helper", True, id="function of another module"),
        pytest.param("deep", "FACTOR = 5", "FACTOR = 6", True, id="constant of an imported function"),
        pytest.param("low", "LOW = 1", "LOW = 2", True, id="imported constant"),
        pytest.param("low", "HIGH = 2", "HIGH = 3", False, id="constant that is not used"),
        pytest.param("middle", "4 * x", "5 * x", False, id="function that is not used"),
        pytest.param("middle", "assert 1 < 2", "assert 1 < 3", True, id="statement that defines nothing"),
        pytest.param("top", "middle.twice(LOW)", "middle.twice(LOW + 1)", True, id="the definition itself"),
        pytest.param("top", "middle.unused(LOW)", "middle.unused(0)", False, id="its neighbour"),
        pytest.param("kinds", "size = 1", "size = 2", False, id="annotation"),
        pytest.param("aside", "ASIDE = 1", "ASIDE = 2", False, id="import for types"),
        pytest.param("effect", "math.tau", "math.pi", True, id="module imported for its effect"),
        pytest.param("plugins/first", "VALUE = 1", "VALUE = 2", False, id="module found by a name that is not used"),
        pytest.param("__init__", '"""Package."""', "STATE = []\nSTATE.append(1)", True, id="package"),
    ],
)
def test_a_definition_counts_with_what_it_names(package, name, old, new, changes):
    before = digest(package, "pack.top:run")
    change(package, name, old, new)
    assert (digest(package, "pack.top:run") != before) == changes


def test_a_module_counts_whole(package):
    before = digest(package, "pack.top")
    change(package, "middle", "4 * x", "5 * x")
    assert digest(package, "pack.top") != before


def test_modules_found_by_name_count_with_who_finds_them(package):
    before = digest(package, "pack.middle:found")
    change(package, "plugins/first", "VALUE = 1", "VALUE = 2")
    assert digest(package, "pack.middle:found") != before


def test_a_text_that_begins_like_a_module_imports_nothing(package):
    before = digest(package, "pack.middle:place")
    change(package, "plugins/first", "VALUE = 1", "VALUE = 2")
    assert digest(package, "pack.middle:place") == before


@pytest.mark.parametrize(("entry", "changes"), [("one", False), ("two", True)])
def test_an_entry_of_a_table_counts_alone(package, entry, changes):
    name = f"pack.middle:TABLE[{('figure', entry)!r}]"
    before = digest(package, name)
    change(package, "middle", "4 * x", "5 * x")
    assert (digest(package, name) != before) == changes


def test_a_script_counts_with_what_it_imports(package, tmp_path):
    script = tmp_path / "script.py"
    script.write_text("from pack.low import LOW\n\nprint(LOW)\n", encoding="utf-8")
    of = CodeDigests(tmp_path / "kept.json", package).of_script
    alone, more = of(script), of(script, "pack.aside")
    assert alone != more
    (package / "low.py").write_text("LOW = 3\n", encoding="utf-8")
    assert CodeDigests(tmp_path / "kept.json", package).of_script(script) != alone


def test_what_was_read_is_kept_and_changes_no_digest(package, tmp_path):
    first = CodeDigests(tmp_path / "kept.json", package)
    found = first.of("pack.top")
    first.keep()
    assert (tmp_path / "kept.json").is_file()
    assert CodeDigests(tmp_path / "kept.json", package).of("pack.top") == found
    other = {hashlib.sha256((package / "top.py").read_bytes()).hexdigest(): ["another version's", []]}
    for text in ("{", json.dumps(other)):  # damaged, or written by another version: read anew
        (tmp_path / "kept.json").write_text(text, encoding="utf-8")
        assert CodeDigests(tmp_path / "kept.json", package).of("pack.top") == found
