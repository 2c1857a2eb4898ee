"""Digests of the code that a job reaches: what changes them, and what does not."""

import pytest

from repro.pipeline.code import CodeDigests

FILES = {
    "__init__": '"""Package."""\n',
    "top": "from pack import middle\nfrom pack.low import LOW\n\n\n"
    'def run():\n    """Run."""\n    return middle.twice(LOW)\n',
    "middle": 'import math\n\n\ndef twice(x):\n    """Double."""\n    return 2 * x\n',
    "low": "LOW = 1\n",
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
    return CodeDigests(package.parent / "kept.json", package).of(*modules)


@pytest.mark.parametrize(
    ("name", "old", "new", "changes"),
    [
        ("top", '"""Run."""', '"""Runs all of it."""', False),
        ("middle", '"""Double."""\n    return', '"""Double."""\n    # why\n    return', False),
        ("middle", "2 * x", "3 * x", True),
        ("low", "LOW = 1", "LOW = 2", True),
        ("aside", "ASIDE = 1", "ASIDE = 2", False),
        ("top", "middle.twice(LOW)", "middle.twice(LOW + 1)", True),
    ],
)
def test_code_that_is_reached_counts_and_docstrings_do_not(package, name, old, new, changes):
    before = digest(package, "pack.top")
    file = package / f"{name}.py"
    text = file.read_text(encoding="utf-8")
    assert old in text
    file.write_text(text.replace(old, new), encoding="utf-8")
    assert (digest(package, "pack.top") != before) == changes


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
    (tmp_path / "kept.json").write_text("{", encoding="utf-8")  # damaged: read anew
    assert CodeDigests(tmp_path / "kept.json", package).of("pack.top") == found
