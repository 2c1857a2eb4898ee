"""The report as a text: what it holds, where it comes from, and what is refused."""

import base64
import hashlib
import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from exhibit_examples import ROOT
from experiment_example import refused
from html_page import Page
from PIL import Image
from report_example import TRICKY, claim_rows, make_example

from repro.drawing.embed import link
from repro.exhibits.catalogue import FIGURES, TABLES
from repro.files import write_csv
from repro.paper.claims import Basis
from repro.report import page as page_module
from repro.report.headline import shares
from repro.report.page import HEADLINE_FIGURE, build_report, made_on_request, read_claims


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    return make_example(tmp_path_factory.mktemp("report"))


@pytest.fixture(scope="module")
def text(inputs):
    return build_report(inputs)


@pytest.fixture(scope="module")
def page(text):
    return Page(text)


def decode(uri):
    return base64.b64decode(uri.partition(";base64,")[2])


def test_the_same_inputs_give_the_same_bytes_wherever_they_lie(inputs, text, tmp_path):
    assert build_report(inputs) == text
    assert build_report(make_example(tmp_path / "else where")) == text


def test_nothing_is_loaded_from_outside(page, text):
    assert all(image["src"].startswith("data:image/png;base64,") for image in page.all("img"))
    assert [item["href"] for item in page.all("link")] == ["data:,"]
    assert not any("src" in script for script in page.all("script"))
    for element in page.elements:
        assert not any(name.startswith("on") or name == "style" for name in element), "the policy would block it"
    assert not re.search(r"@import|url\(", page.all("style")[0]["text"])
    assert not re.search("https?:", text)


def test_the_policy_allows_the_style_and_the_script_that_are_there(page):
    policy = next(meta["content"] for meta in page.all("meta") if "http-equiv" in meta)
    assert policy.startswith("default-src 'none'; img-src data:; style-src 'sha256-")
    assert policy.endswith("'; base-uri 'none'; form-action 'none'")
    for tag in ("style", "script"):
        (element,) = page.all(tag)
        digest = base64.b64encode(hashlib.sha256(element["text"].encode()).digest()).decode()
        assert f"{tag}-src 'sha256-{digest}'" in policy


def test_results_made_on_request_make_the_report_again(tmp_path):
    (tmp_path / "tables").mkdir()
    table, seen = tmp_path / "tables/study.csv", [made_on_request(tmp_path, tmp_path)]
    for content in ("a\n1\n", "a\n2\n"):
        table.write_text(content, encoding="utf-8")
        seen += [made_on_request(tmp_path, tmp_path)] * 2
    (tmp_path / "tables/table10.csv").write_text(content, encoding="utf-8")  # its rule tells of it
    assert made_on_request(tmp_path, tmp_path) == seen[-1]
    assert len(set(seen)) == 3


def test_every_exhibit_is_shown_with_caption_data_and_command(inputs, page):
    simulated = {exhibit.target for exhibit in (*TABLES, *FIGURES) if exhibit.simulated}
    assert {exhibit.target for exhibit in FIGURES if exhibit.simulated} <= simulated
    assert {exhibit.target for exhibit in TABLES if exhibit.name in ("table08", "table10", "study")} <= simulated
    for exhibit in (*TABLES, *FIGURES):
        article = page.one(exhibit.target)["text"]
        for words in (exhibit.label, f"snakemake --cores 2 {exhibit.target}", exhibit.caption):
            assert words in article
        assert ("simulated" in article) == (exhibit.target in simulated)
        assert ("Not part of this run" in article) == exhibit.optional
    shown = [exhibit for exhibit in FIGURES if not exhibit.optional]
    for image, exhibit in zip(page.all("img"), shown, strict=True):
        assert decode(image["src"]) == (inputs.figures / f"{exhibit.name}.png").read_bytes()
        assert image["alt"] == exhibit.caption
        width, height = Image.open(inputs.figures / f"{exhibit.name}.png").size
        np.testing.assert_allclose([int(image["width"]), int(image["height"])], [0.4 * width, 0.4 * height], atol=0.5)


def test_published_rows_stand_before_ours(page):
    for target, first in (("table07", "97.10"), ("table10", "93.55")):
        ours = pd.read_csv(ROOT / f"docs/reference/tables/{target}.csv").query("method == 'algorithm1' and joint == 1")
        article, second = page.one(target)["text"], f"{100.0 * ours['total'].iloc[0]:.2f}"
        assert article.index("Published, Algorithm 1") < article.index(first) < article.index(second)
    assert "Published, Least squares" in page.one("table10")["text"]
    assert "above 97.38 %" in page.one("table06")["text"]


def test_better_numbers_are_not_counted_as_reproduced(inputs):
    path, rows = inputs.results / "claims.csv", pd.DataFrame(claim_rows())
    own = rows.index[(rows["basis"] == "numeric") & ~rows["id"].str.contains("@")]
    rows.loc[own, "verdict"] = ["better", "better", "better", "differs", *["inconclusive"] * (len(own) - 4)]
    rows.loc[rows["basis"] == "simulated arm", "basis"] = "setting"
    whole = path.read_bytes()
    try:
        write_csv(path, rows)
        sentences = Page(build_report(inputs)).one("short")["text"]
    finally:
        path.write_bytes(whole)
    assert f"can test: 3 better, 1 differs, {len(own) - 4} inconclusive" in " ".join(sentences.split())


def test_the_headline_of_the_run_stands_first(inputs, page):
    section, own = page.one("short")["text"], shares(inputs.results)
    for method in ("algorithm1", "least-squares"):
        assert f"{own[method]['arm, T1 to T4']} %" in section
        assert all(number in section for number in own[method].values())
    assert "91.74" in section


def test_results_come_before_settings(text):
    rows = re.findall(r'<tr id="claim-[^"]+".*?data-basis="([^"]+)"', text)
    assert list(dict.fromkeys(rows))[:2] == ["numeric", "simulated arm"]
    assert rows == sorted(rows, key=[*Basis, "extension"].index)


def test_results_made_on_request_are_shown_as_kept_ones(inputs):
    kept = Page(build_report(replace(inputs, docs=ROOT / "docs")))
    shown = {e.target: kept.one(e.target)["text"] for e in (*TABLES, *FIGURES) if e.optional}
    assert "89.7 (88.1 to 92.1)" in shown["accepted_table"]
    for target, article in shown.items():
        assert "Not part of this run" in article
        assert ("CSV" in article) == ("earlier full run" in article) == (not target.startswith("ablation"))
    pictures = [e for e in FIGURES if not e.optional or e.name != "ablation"]
    first = [e for e in pictures if e.name == HEADLINE_FIGURE]
    assert [image["alt"] for image in kept.all("img")] == [e.caption for e in (*first, *pictures)]
    ways = [a["href"] for a in kept.all("a") if ".md" in a.get("href", "")]
    assert ways and all((inputs.page.parent / way.partition("#")[0]).resolve().is_file() for way in ways)


def test_downloads_hold_the_files_and_links_lead_to_them(inputs, page):
    links = page.all("a")
    held = {item["download"]: decode(item["href"]) for item in links if "download" in item}
    for path in (*(inputs.results / "tables").glob("*.tex"), inputs.results / "claims.csv"):
        assert held[path.name] == path.read_bytes()
    beside = [item["href"] for item in links if not item["href"].startswith(("#", "data:"))]
    assert sorted(beside) == sorted(f"../../paper_figures/{e.name}.pdf" for e in FIGURES if not e.optional)
    assert all((inputs.page.parent / href).resolve().is_file() for href in beside)


def test_a_large_file_is_linked_and_a_small_one_held(tmp_path):
    large, small = tmp_path / "figures" / "a b.csv", tmp_path / "small.csv"
    large.parent.mkdir()
    large.write_bytes(b"1234567\n" * 30_000)
    small.write_bytes(b"x\n1\n")
    (tmp_path / "small.pdf").write_bytes(b"%PDF-1.4\n")
    assert link(tmp_path / "small.pdf", tmp_path / "report" / "index.html").href == "../small.pdf"
    found = link(large, tmp_path / "report" / "index.html")
    assert (found.href, found.download) == ("../figures/a%20b.csv", "")
    assert "0.2 MB" in found.text
    found = link(small, tmp_path / "report" / "index.html")
    assert (decode(found.href), found.download) == (b"x\n1\n", "small.csv")


def test_what_comes_from_a_file_is_escaped(text, page):
    assert "<script>alert" not in text
    assert len(page.all("script")) == 1
    assert [name for name in ("claims", "audit") if TRICKY not in page.one(name)["text"]] == []


@pytest.mark.parametrize(
    "name",
    [
        "results/claims.csv", "results/tables/table01.tex", "results/tables/table10.csv", "results/tables/audit.csv",
        "results/tables/verdict.csv", "results/figures/fig24.csv", "paper_figures/fig01.png",
        "paper_figures/spread.pdf", "ID.bin",
    ],
)  # fmt: skip
def test_a_whole_report_refuses_a_missing_or_empty_file_in_one_line(inputs, name):
    path = inputs.results.parent / name
    whole = path.read_bytes()
    try:
        for spoil in (path.unlink, lambda: path.write_bytes(b" \n")):
            spoil()
            assert str(path) in refused(build_report, inputs).place
    finally:
        path.write_bytes(whole)


@pytest.mark.parametrize(
    ("change", "place", "found"),
    [
        ({"verdict": "fine"}, "row 3: verdict", "'fine'"),
        ({"asserted": "perhaps"}, "row 3: asserted", "'perhaps'"),
        ({"basis": "faith"}, "row 3: basis", "'faith'"),
        ({"cause": "bad luck"}, "row 3: cause", "'bad luck'"),
        ({"place": " "}, "row 3: place", "nothing"),
        ({"id": "with blank"}, "row 3: id", "'with blank'"),
        ({"id": claim_rows()[0]["id"]}, "row 3: id", ""),
    ],
)
def test_a_wrong_row_of_the_ledger_is_refused(tmp_path, change, place, found):
    rows = claim_rows()
    rows[2] |= change
    write_csv(tmp_path / "claims.csv", pd.DataFrame(rows))
    error = refused(read_claims, tmp_path / "claims.csv")
    assert error.place == f"{tmp_path / 'claims.csv'}: {place}" and error.found.startswith(found)
    write_csv(tmp_path / "claims.csv", pd.DataFrame(rows).drop(columns="note"))
    assert refused(read_claims, tmp_path / "claims.csv").place.endswith("header")


def test_a_report_without_captures_has_no_sums_of_them(inputs):
    assert "No stored captures" in Page(build_report(replace(inputs, captures=[]))).one("provenance")["text"]


def test_a_report_too_large_to_open_is_refused(inputs, monkeypatch):
    monkeypatch.setattr(page_module, "LARGEST_REPORT", 10_000)
    error = refused(build_report, inputs)
    assert error.place.endswith("index.html") and float(error.found.split()[0]) > 0.01


def test_provenance_is_shown_where_it_was_given(inputs, page, text):
    told = page.one("provenance")["text"]
    for words in (inputs.config_sha256, "packages.numpy", hashlib.sha256(b"run").hexdigest()):
        assert words in told
    assert "Not recorded" in Page(build_report(replace(inputs, provenance={}))).one("provenance")["text"]
    assert "tiny budgets" in build_report(replace(inputs, notice="Made with tiny budgets."))
    assert "tiny budgets" not in text


@pytest.mark.parametrize(
    ("text", "shown"),
    [("-0.0004", "\N{MINUS SIGN}0.0004"), ("12.3456", "12.35"), ("0", "0"), ("123456.7890", "123456.79"), ("nan", "")],
)
def test_numbers_are_shown_with_their_decimals_unless_that_leaves_nothing(text, shown):
    assert page_module._cell(text, 2).text == shown
