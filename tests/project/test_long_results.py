"""Long results: the code and settings that made what is kept have not changed since they were recorded."""

import shutil
from importlib import import_module

import pytest
from experiment_example import ROOT

#: What the digests of the results below read.
READ = ("src", "config", "data/experiments", "data/networks")


@pytest.fixture
def long_results(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "docs")
    return import_module("long_results")


def test_kept_results_have_the_code_and_settings_that_are_recorded(long_results):
    assert long_results.changes() == []


def test_every_kept_result_names_its_commit_and_every_exception_its_reason(long_results):
    records = {path.stem: long_results.recorded(path.stem) for path in long_results.RECORDS.glob("*.json")}
    assert set(records) == set(long_results.kept())
    for entry in records.values():
        assert len(entry["commit"]) == 40
        assert len(entry.get("older", "as recorded")) > 10


@pytest.mark.parametrize(
    ("file", "old", "new", "which", "names"),
    [
        (
            "src/repro_studies/arms.py",
            "NARROW = 1.5",
            "NARROW = 1.6",
            "code changed (repro_studies.arms:NARROW)",
            {"study"},
        ),
        ("config/config.yaml", "  arms: 30\n", "  arms: 31\n", "settings changed", {"study"}),
        ("config/config.yaml", "inner_limit: 1000\n", "inner_limit: 1001\n", "settings changed", {"accepted"}),
        ("data/experiments/accepted.csv", "index", "Index", "settings changed", {"accepted"}),
    ],
)
def test_a_changed_constant_or_setting_names_the_results_that_depend_on_it(
    tmp_path, long_results, file, old, new, which, names
):
    for folder in READ:
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__"))
    text = (tmp_path / file).read_text(encoding="utf-8")
    assert old in text
    (tmp_path / file).write_text(text.replace(old, new, 1), encoding="utf-8")
    found = long_results.changes("accepted", "study", root=tmp_path)
    assert {line.partition(" ")[0] for line in found} == names
    assert all(which in line for line in found)
