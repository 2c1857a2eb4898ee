"""What the project says of itself agrees: its two citation files, and the names that its pages send readers to."""

import ast
import json
import pydoc
import re
import tomllib

import pytest
import yaml
from experiment_example import ROOT

import repro

PAGES = [ROOT / name for name in ("README.md", "CITATIONS.md", "CONTRIBUTING.md", "benchmarks/README.md")]
PAGES += [page for folder in ("docs", "docs/explanation") for page in sorted((ROOT / folder).glob("*.md"))]


def test_both_citation_files_say_the_same():
    cff = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    meta = json.loads((ROOT / "codemeta.json").read_text(encoding="utf-8"))
    assert (meta["name"], meta["description"]) == (cff["title"], cff["abstract"])
    assert meta["license"].rsplit("/", 1)[1] == cff["license"]
    assert meta["keywords"] == cff["keywords"]
    assert [author["name"] for author in meta["author"]] == [author["name"] for author in cff["authors"]]
    assert meta["version"] == cff["version"] == repro.__version__
    assert meta["datePublished"] == cff["date-released"]
    changes, citations = ((ROOT / name).read_text(encoding="utf-8") for name in ("CHANGELOG.md", "CITATIONS.md"))
    assert re.search(r"^## (\d.*)$", changes, re.MULTILINE)[1] == f"{cff['version']} - {cff['date-released']}"
    assert f"version = {{{cff['version']}}}" in citations
    assert f"date    = {{{cff['date-released']}}}" in citations


def test_each_package_that_is_asked_for_has_a_citation():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    asked_for = [
        *project["dependencies"],
        *(text for extra in project["optional-dependencies"].values() for text in extra),
    ]
    citations = (ROOT / "CITATIONS.md").read_text(encoding="utf-8")
    names = {re.split("[<>=]", text)[0] for text in asked_for}
    assert not [name for name in sorted(names) if not re.search(rf"(?<![\w-]){name}(?![\w-])", citations)]


@pytest.mark.parametrize(
    "page",
    sorted({*PAGES, *ROOT.glob("*/README.md"), *ROOT.glob("data/*/README.md")}),
    ids=lambda page: page.relative_to(ROOT).as_posix(),
)
def test_each_table_has_a_heading_and_as_many_cells_in_each_row(page):
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    for table in re.findall(r"(?:^ *\|.*\n)+", text, re.MULTILINE):
        heading, rule, *rows = (line.strip() for line in table.splitlines())
        assert re.fullmatch(r"\|(?: *:?-+:? *\|)+", rule), heading
        cells = [len(re.findall(r"(?<!\\)\|", row)) for row in (heading, rule, *rows)]
        assert len(set(cells)) == 1, heading


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_names_of_the_package_are_there(page):
    names = set(re.findall(r"`(repro(?:\.\w+)+)`", page.read_text(encoding="utf-8")))
    assert not [name for name in names if pydoc.locate(name) is None]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_within_the_project_lead_somewhere(page):
    targets = re.findall(r"\]\((?!https?:|#)([^)#]+)", page.read_text(encoding="utf-8"))
    assert not [target for target in targets if not (page.parent / target).is_file()]


def test_each_benchmark_is_listed_and_what_it_imports_is_there(monkeypatch):
    page = (ROOT / "benchmarks/README.md").read_text(encoding="utf-8")
    for folder in ("tests", "benchmarks", "benchmarks/slurm"):
        monkeypatch.syspath_prepend(ROOT / folder)
    for path in (ROOT / "benchmarks").rglob("*.py"):
        assert f"`{path.relative_to(ROOT / 'benchmarks').as_posix()}" in page
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                assert not [a.name for a in node.names if pydoc.locate(f"{node.module}.{a.name}") is None], path.name


def test_each_page_is_in_the_navigation_of_the_site():
    shown = re.findall(r"[:-] (\S+\.md)$", (ROOT / "docs/mkdocs.yml").read_text(encoding="utf-8"), re.MULTILINE)
    pages = {page.relative_to(ROOT).as_posix() for page in PAGES} - {"benchmarks/README.md"}
    assert pages <= set(shown)
    assert not [page for page in shown if not (ROOT / page).is_file()]
