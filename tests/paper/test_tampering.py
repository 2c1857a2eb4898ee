"""The list of check sums of the committed reference names every file that is edited, removed or added."""

import random
import shutil
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


def test_every_file_of_reference_captures_and_networks_is_listed(tampering):
    folders, listed = read_sources(Path("docs/reference") / SOURCES)
    assert folders == sorted(tampering.FOLDERS)
    kept = {path.as_posix() for name in folders for path in Path(name).rglob("*") if path.is_file()}
    assert set(listed) == kept - {f"docs/reference/{SOURCES}"} | {PUBLISHED_NAME}


def test_sixty_random_edits_are_named(tampering, tmp_path, monkeypatch):
    tampering.copy_kept(tmp_path)
    monkeypatch.setattr(ledger, "PUBLISHED_FILE", tmp_path / PUBLISHED_NAME)
    assert problems_of(tmp_path) == []
    rng = random.Random(28)
    for _ in range(60):
        with tampering.one_edit(tmp_path, rng) as (what, edited):
            name = edited.relative_to(tmp_path).as_posix()
            (problem,) = problems_of(tmp_path)
            assert name in problem, (what, name)
    assert problems_of(tmp_path) == []


def test_a_copy_of_the_reference_is_checked_itself(tampering, tmp_path):
    copy = tmp_path / "elsewhere"
    shutil.copytree(ROOT / "docs/reference", copy)
    assert changed_sources(copy / SOURCES, ROOT) == []
    table = copy / "tables/table10.csv"
    table.write_text(table.read_text(encoding="utf-8").replace("0.9", "nan", 1), encoding="utf-8")
    (copy / "tables/more.csv").write_text("a\n", encoding="utf-8")
    (copy / "config.yaml").unlink()
    assert [problem.partition(":")[0] for problem in changed_sources(copy / SOURCES, ROOT)] == [
        str(copy / name) for name in ("config.yaml", "tables/more.csv", "tables/table10.csv")
    ]
