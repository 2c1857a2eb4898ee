"""Digests of the code that a job reaches: what changes them, and what does not."""

import pytest

from repro.experiments.code import CodeDigests

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
from pack.deep import _helper as helper

def twice(x):
    \"""Double.\"""
    return 2 * helper(x)

def unused(x):
    return 4 * x

assert 1 < 2
""",
    "low": "LOW = 1\nHIGH = 2\n",
    "deep": "FACTOR = 5\n\ndef _helper(x):\n    return FACTOR * x\n",
    "kinds": "class Kind:\n    size = 1\n",
    "effect": "import math\nmath.tau\n",
    "aside": "ASIDE = 1\n",
}


@pytest.fixture
def package(tmp_path):
    folder = tmp_path / "pack"
    folder.mkdir()
    for name, text in FILES.items():
        (folder / f"{name}.py").write_text(text, encoding="utf-8")
    return folder


def digest(package, *modules):
    return CodeDigests(package).of(*modules)


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


def test_a_table_that_a_definition_names_counts(package):
    change(package, "deep", "FACTOR = 5", 'FACTOR = read("factors.csv")')
    table = package / "factors.csv"
    table.write_text("5\n", encoding="utf-8")
    before = digest(package, "pack.top:run"), digest(package, "pack.low")
    table.write_text("6\n", encoding="utf-8")
    after = digest(package, "pack.top:run"), digest(package, "pack.low")
    assert after[0] != before[0] and after[1] == before[1]


def test_a_script_counts_with_what_it_imports(package, tmp_path):
    script = tmp_path / "script.py"
    script.write_text("from pack.low import LOW\n\nprint(LOW)\n", encoding="utf-8")
    alone, more = (CodeDigests(package).of_script(script, *names) for names in ((), ("pack.aside",)))
    assert alone != more
    (package / "low.py").write_text("LOW = 3\n", encoding="utf-8")
    assert CodeDigests(package).of_script(script) != alone
