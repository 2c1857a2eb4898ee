"""The list of check sums of the committed reference names every file that is edited, removed or added."""

import random
from importlib import import_module
from pathlib import Path

import pytest

from repro.errors import InputError
from repro.paper import ledger
from repro.paper.ledger import PUBLISHED_NAME, SOURCES, changed_sources, read_sources

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def tampering(monkeypatch):
    monkeypatch.chdir(ROOT)
    monkeypatch.syspath_prepend(ROOT / "benchmarks")
    return import_module("tampering")


def problems_of(root):
    try:
        return changed_sources(root / "docs/reference" / SOURCES, root)
    except InputError as error:
        return [str(error)]


def test_every_file_of_reference_gallery_and_data_is_listed(tampering):
    folders, listed = read_sources(Path("docs/reference") / SOURCES)
    assert folders == sorted(tampering.FOLDERS)
    kept = {path.as_posix() for name in folders for path in Path(name).rglob("*") if path.is_file()}
    assert set(listed) == kept - {f"docs/reference/{SOURCES}"} | {PUBLISHED_NAME}


def test_random_edits_are_named(tampering, tmp_path, monkeypatch):
    tampering.copy_kept(tmp_path)
    monkeypatch.setattr(ledger, "PUBLISHED_FILE", tmp_path / PUBLISHED_NAME)
    assert problems_of(tmp_path) == []
    rng = random.Random(28)
    for _ in range(30):
        with tampering.one_edit(tmp_path, rng) as (what, edited):
            name = edited.relative_to(tmp_path).as_posix()
            (problem,) = problems_of(tmp_path)
            assert name in problem, (what, name)
    assert problems_of(tmp_path) == []
