"""The comparison of the small run with its kept numbers reports what is new, what is gone and what differs."""

import gzip
import json
from importlib import import_module
from pathlib import Path
from unittest.mock import Mock

import pytest

#: Lines of a page, lengths or hashes of files, and the rule of an output.
KEPT = {
    "pages": {"tables/a.md": ["an arm of 12.5 kg", "3 of 7"], "b.md": ["a line"]},
    "files": {"experiment/a.bin": "5f1d", "tables/a.csv": "31"},
    "rules": {"tables/a.csv": {"rule": ["score"], "input": ["x.csv"], "params": ["11"]}},
}


@pytest.fixture
def golden(monkeypatch):
    monkeypatch.syspath_prepend(Path(__file__).resolve().parents[2] / ".ci")
    return import_module("golden")


def report(golden, monkeypatch, tmp_path, run):
    """What the comparison says of a run whose one sampled table is as it was kept."""
    kept, folder = tmp_path / "kept", tmp_path / "run"
    for each in (kept, folder):
        each.mkdir(parents=True)
        (each / "claims.csv").write_text("claim,ours\nfirst,2.5\n", encoding="utf-8")
    for name, content in KEPT.items():
        (kept / f"{name}.json.gz").write_bytes(gzip.compress(json.dumps(content).encode()))
    monkeypatch.setattr(golden, "KEPT", kept)
    monkeypatch.setattr(golden, "kept_numbers", lambda _: run)
    return list(golden.faults(folder))


@pytest.mark.parametrize("kind", KEPT)
def test_what_is_new_or_gone_is_reported(golden, monkeypatch, tmp_path, kind):
    first, content = next(iter(KEPT[kind].items()))
    for name, run in (("c.md", {**KEPT[kind], "c.md": content}), (first, dict(list(KEPT[kind].items())[1:]))):
        (line,) = report(golden, monkeypatch, tmp_path / name, {**KEPT, kind: run})
        assert name in line


@pytest.mark.parametrize(
    ("kind", "name", "value", "reported"),
    [
        ("pages", "b.md", ["a line"], 0),
        ("pages", "tables/a.md", ["an arm of 12.5 kg", "4 of 7"], 1),
        ("pages", "tables/a.md", ["an arm of 12.501 kg", "3 of 7"], 0),
        ("pages", "tables/a.md", ["an arm of 12.5 g", "3 of 7"], 1),
        ("pages", "tables/a.md", ["3 of 7"], 1),
        ("files", "experiment/a.bin", "5f1e", 1),
        ("rules", "tables/a.csv", {"rule": ["score"], "input": ["x.csv"], "params": ["12"]}, 2),
    ],
)
def test_a_difference_is_reported(golden, monkeypatch, tmp_path, kind, name, value, reported):
    found = report(golden, monkeypatch, tmp_path, {**KEPT, kind: {**KEPT[kind], name: value}})
    assert len(found) == reported
    assert all(name in line for line in found)


@pytest.mark.parametrize("changes", [{"b.csv": None}, {"c.csv": "3"}, {"b.csv": "5"}])
def test_a_continued_run_must_have_the_files_of_an_undisturbed_one(monkeypatch, changes):
    monkeypatch.syspath_prepend(Path(__file__).resolve().parents[2] / ".ci")
    killed_run = import_module("killed_run")
    for name in ("shutil", "run_and_kill", "subprocess"):
        monkeypatch.setattr(killed_run, name, Mock())
    undisturbed = {"a.csv": "1", "b.csv": "2"}
    again = {name: digest for name, digest in {**undisturbed, **changes}.items() if digest}
    monkeypatch.setattr(killed_run, "digests", Mock(side_effect=[undisturbed, {}, again]))
    with pytest.raises(SystemExit, match=r"1 files differ: [bc]\.csv"):
        killed_run.main()
