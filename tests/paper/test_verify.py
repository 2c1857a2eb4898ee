"""Tampering: one thing changed at a time, and `repro verify` names it; exit codes of the command and of the stage."""

import hashlib
import logging
import re
import shutil
import subprocess
from pathlib import Path

import pandas as pd
import pytest
from claims_example import make_project
from scripts_run import run_script

from repro.cli import main
from repro.config import load_config
from repro.errors import InputError
from repro.exhibits import paper_audit
from repro.paper import verification
from repro.paper.verification import CLAIMS, PAGE, PUBLISHED_NAME, SOURCES, read_sources, write_ledger

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    root = tmp_path_factory.mktemp("made")
    make_project(root)
    return root


@pytest.fixture
def project(made, tmp_path, monkeypatch):
    """A copy of the project to tamper with; the working directory, as for a user."""
    root = tmp_path / "project"
    shutil.copytree(made, root)
    monkeypatch.chdir(root)
    for module, function in ((verification, "verify_ledger"), (verification, "write_ledger")):
        defaults = list(getattr(module, function).__defaults__)
        defaults[-1] = root / "published.csv"
        monkeypatch.setattr(getattr(module, function), "__defaults__", tuple(defaults))
    return root


def verify(capsys, *options):
    code = main(["verify", *options])
    said = capsys.readouterr()
    assert "Traceback" not in said.out + said.err
    return code, said.out, said.err


def change(path, old, new):
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")


def test_what_agrees_is_told_in_short_and_ends_with_0(project, capsys):
    code, out, _ = verify(capsys)
    assert code == 0
    assert "disagrees" not in out and "broken" not in out
    claims = pd.read_csv("results/claims.csv")
    own = claims[~claims["id"].str.contains("@")]
    for basis, of in own.groupby("basis"):
        line = re.search(rf"^{basis} +{len(of)}  (.*)$", out, re.MULTILINE)[1]
        told = dict(reversed(part.split(" ", 1)) for part in line.split(", "))
        assert {name: int(number) for name, number in told.items()} == of["verdict"].value_counts().to_dict()


def test_one_changed_published_number(project, capsys):
    change(
        project / "published.csv",
        "joint1,Table 10,total,ID,algorithm1,1,,%,is,93.55",
        "joint1,Table 10,total,ID,algorithm1,1,,%,is,93.45",
    )
    code, out, _ = verify(capsys)
    assert code == 1
    assert f"disagrees: {PUBLISHED_NAME}: SHA-256" in out
    assert "table10/ID/algorithm1/total/joint1: published: found 93.55, expected 93.45" in out


def test_a_published_number_that_is_removed(project, capsys):
    path = project / "published.csv"
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    (row,) = [line for line in lines if line.startswith("section4b/biases,")]
    change(path, row, "")
    code, out, _ = verify(capsys)
    assert code == 1
    assert f"disagrees: {PUBLISHED_NAME}: SHA-256" in out
    assert "results/claims.csv: section4b/biases: found a row, expected none" in out


def test_one_changed_result(project, capsys):
    change(project / "results/model/training.csv", "0.00025", "0.00024")
    code, out, _ = verify(capsys)
    assert code == 1
    assert "disagrees: results/model/training.csv: SHA-256" in out
    assert "section5a/loss: ours: found 0.00025, expected 0.00024" in out


def test_one_changed_capture_byte(project, capsys):
    path = project / "data/captures/ID.bin"
    content = bytearray(path.read_bytes())
    content[17] ^= 1
    path.write_bytes(content)
    code, out, _ = verify(capsys)
    assert code == 1
    assert "disagrees: data/captures/ID.bin: SHA-256" in out


def test_a_file_among_the_captures_that_is_not_listed(project, capsys):
    shutil.copy(project / "data/captures/ID.bin", project / "data/captures/T1.bin")
    code, out, _ = verify(capsys)
    assert code == 1
    assert re.findall("^disagrees: (.*): found", out, re.MULTILINE) == ["data/captures/T1.bin"]


def test_a_changed_capture_with_its_check_sum_made_to_fit(project, capsys):
    path, listed = project / "data/captures/ID.bin", project / "data/captures/SHA256SUMS"
    before = hashlib.sha256(path.read_bytes()).hexdigest()
    path.write_bytes(bytes(64))
    change(listed, before, hashlib.sha256(bytes(64)).hexdigest())
    code, out, _ = verify(capsys)
    assert code == 1
    assert "disagrees: data/captures/SHA256SUMS: SHA-256" in out


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        ("table10.csv", "T3,algorithm1+refinement,2,0.99", "T3,algorithm1+refinement,2,0.98"),
        ("table09.csv", "0.12", "0.13"),
    ],
)
def test_one_changed_table_cell(project, capsys, file, old, new):
    """Also in a table that the ledger holds no number of."""
    change(project / "results/tables" / file, old, new)
    code, out, _ = verify(capsys)
    assert code == 1
    assert f"disagrees: results/tables/{file}: SHA-256" in out


@pytest.mark.parametrize("column", ["published", "ours", "difference", "basis", "verdict", "asserted", "note"])
def test_one_changed_cell_of_the_ledger(project, capsys, column):
    path = project / "results" / CLAIMS
    table = pd.read_csv(path, dtype=str, keep_default_na=False)
    table.loc[table["id"] == "section5a/loss", column] = "1"
    table.to_csv(path, index=False)
    code, out, _ = verify(capsys)
    assert code == 1
    file, cell = re.findall(r"^disagrees: .*", out, re.MULTILINE)
    assert file.startswith("disagrees: results/claims.csv: SHA-256")
    assert re.match(rf"disagrees: results/claims.csv: section5a/loss: {column}: found 1, expected ", cell)


def test_the_last_digit_of_a_cell_of_the_ledger(project, capsys):
    """Less than rounding may make of it on another processor, but the file is not the one that was written."""
    path = project / "results" / CLAIMS
    table = pd.read_csv(path, dtype=str, keep_default_na=False)
    row = table["ours"].str.len().idxmax()
    digits = table.loc[row, "ours"]
    table.loc[row, "ours"] = digits[:-1] + str((int(digits[-1]) + 1) % 10)
    table.to_csv(path, index=False)
    code, out, _ = verify(capsys)
    assert code == 1
    assert re.findall(r"^disagrees: (.*): SHA-256", out, re.MULTILINE) == ["results/claims.csv"]


def test_rows_taken_out_put_in_or_moved(project, capsys):
    path = project / "results" / CLAIMS
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    for changed, named in (
        (lines[:5] + lines[6:], f"{lines[5].split(',')[0]}: found no row"),
        ([*lines, lines[5].replace(lines[5].split(",")[0], "table99/x")], "table99/x: found a row"),
        ([*lines[:5], lines[6], lines[5], *lines[7:]], "rows in another order"),
        ([*lines, lines[5]], "rows in another order or twice"),
        (["id,place\n"], "header: found id,place"),
    ):
        path.write_text("".join(changed), encoding="utf-8")
        code, out, _ = verify(capsys)
        assert code == 1 and named in out


def test_a_changed_page(project, capsys):
    change(project / "results" / PAGE, "| better |", "| worse |")
    code, out, _ = verify(capsys)
    assert code == 1 and "disagrees: results/claims.md" in out


def test_a_changed_configuration(project, capsys):
    change(project / "config/config.yaml", "[180.4817, 30.6819]", "[180.4817, 30.6818]")
    code, out, _ = verify(capsys)
    assert code == 1
    assert "table08/kp/joint2: ours: found 30.6819, expected 30.6818" in out
    assert "not as asserted: table08/kp/joint2" in out


def test_a_listed_file_that_is_gone(project, capsys):
    (project / "results/tables/table09.csv").unlink()
    code, out, _ = verify(capsys)
    assert code == 1 and "disagrees: results/tables/table09.csv: found No such file" in out
    (project / "results/tables/table10.csv").unlink()
    code, out, _ = verify(capsys)  # the ledger cannot be computed again either
    assert code == 1 and "disagrees: results/tables/table10.csv: found No such file" in out


@pytest.mark.parametrize("name", [CLAIMS, PAGE, SOURCES])
def test_without_a_ledger_there_is_nothing_to_verify(project, capsys, name):
    (project / "results" / name).unlink()
    code, _, err = verify(capsys)
    assert code == 2 and f"results/{name}" in err and err.count("\n") == 1


@pytest.mark.parametrize("number", [0, 1, 2])
def test_a_line_taken_out_of_the_list(project, capsys, number):
    """Its own check sum, a folder that it covers, and a file."""
    path = project / "results" / SOURCES
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    path.write_text("".join(lines[:number] + lines[number + 1 :]), encoding="utf-8")
    code, _, err = verify(capsys)
    assert code == 2 and f"results/{SOURCES}" in err and err.count("\n") == 1


@pytest.mark.parametrize("line", ["", "not a sum\n", f"{'0' * 64}  \n", f"{'0' * 64}  results/x.csv\n"])
def test_a_list_that_is_no_list(project, capsys, line):
    (project / "results" / SOURCES).write_text(line, encoding="utf-8")
    code, _, err = verify(capsys)
    assert code == 2 and SOURCES in err and err.count("\n") == 1


def test_a_missing_configuration(project, capsys):
    code, _, err = verify(capsys, "--config", "config/mine.yaml")
    assert code == 2 and "config/mine.yaml" in err and err.count("\n") == 1


def test_a_claim_that_fails_ends_with_1_though_all_agree(project, capsys):
    change(project / "results/model/training.csv", "0.00025", "0.0025")
    remake(project)
    code, out, _ = verify(capsys)
    assert code == 1
    assert "disagrees" not in out
    assert "not as asserted: section5a/loss: differs instead of reproduced, published 1e-3, ours 0.0025" in out


def test_an_overlay_is_merged_as_the_workflow_merges_it(project, capsys):
    overlay = project / "config/mine.yaml"
    overlay.write_text("results: other\nboard:\n  kp_nm_per_rad: [180.4817, 30.0]\n", encoding="utf-8")
    shutil.copytree("results", "other")
    files = [path.relative_to(project) for path in sorted((project / "other").rglob("*.csv")) if path.name != CLAIMS]
    write_ledger(Path("other"), load_config(Path("config/config.yaml"), overlay), files)
    code, out, _ = verify(capsys, "--config", "config/config.yaml", "config/mine.yaml")
    assert code == 1 and "disagrees" not in out
    assert out.count("not as asserted") == 1 and "not as asserted: table08/kp/joint2" in out


def test_a_reference_folder_of_the_same_layout_from_another_place(project, capsys, monkeypatch):
    shutil.move("results", "docs/reference")
    remake(project, Path("docs/reference"))
    assert verify(capsys, "--results", "docs/reference")[0] == 0
    monkeypatch.chdir("docs")
    code, out, _ = verify(capsys, "--results", "reference", "--config", "../config/config.yaml")
    assert code == 0
    change(project / "docs/reference/tables/table07.csv", "0.975", "0.974")
    code, out, _ = verify(capsys, "--results", "reference", "--config", "../config/config.yaml")
    assert code == 1 and "disagrees: docs/reference/tables/table07.csv" in out


def test_the_list_is_what_sha256sum_checks(project):
    shutil.copy("published.csv", project / "results")
    (project / PUBLISHED_NAME).parent.mkdir(parents=True)
    shutil.copy("published.csv", project / PUBLISHED_NAME)
    command = ["sha256sum", "--check", "--strict", "--quiet", "results/claims.sha256"]
    assert subprocess.run(command, check=False).returncode == 0
    change(project / "results/tables/table04.csv", "N1", "N7")
    said = subprocess.run(command, check=False, capture_output=True, text=True)
    assert said.returncode != 0 and "results/tables/table04.csv: FAILED" in said.stdout


def remake(project, results=Path("results")):
    """The ledger of the results as they are."""
    write_ledger(results, load_config(project / "config/config.yaml"), [], folders=[results])


def test_the_ledger_is_the_same_to_the_byte_when_made_again(project):
    before = {name: (project / "results" / name).read_bytes() for name in (CLAIMS, PAGE)}
    remake(project)
    assert before == {name: (project / "results" / name).read_bytes() for name in (CLAIMS, PAGE)}


def verify_run(project, config):
    run_script("verify", {}, {"txt": "results/verified.txt"}, project, config=config)


def test_the_stage_writes_a_ledger_whose_claims_fail_and_its_verification_fails_only_if_enforced(project, caplog):
    change(project / "results/model/training.csv", "0.00025", "0.0025")
    config = load_config(project / "config/config.yaml")
    inputs = [
        ("captures", ["data/captures/SHA256SUMS"]),
        ("tables", [str(path) for path in sorted(Path("results/tables").iterdir())]),
        ("training", "results/model/training.csv"),
        ("scores", ["results/validation/numeric.csv", "results/validation/experiment.csv"]),
    ]
    run_script("claims", dict(inputs), {"csv": "results/claims.csv"}, project, config=config)
    folders, listed = read_sources(Path("results/claims.sha256"))
    assert folders == ["data/captures"]
    sources = [name for _, names in inputs for name in ([names] if isinstance(names, str) else names)]
    captures = [f"data/captures/{name}" for name in ("ID.bin", "ID.json")]
    assert set(listed) == {*sources, *captures, "results/claims.csv", "results/claims.md", PUBLISHED_NAME}
    assert config["claims"]["enforce"]
    with caplog.at_level(logging.ERROR), pytest.raises(InputError, match="1 claims that fail"):
        verify_run(project, config)
    assert "not as asserted: section5a/loss" in caplog.text
    assert not Path("results/verified.txt").exists()
    verify_run(project, {**config, "claims": {"enforce": False}})
    assert "not as asserted: section5a/loss" in Path("results/verified.txt").read_text(encoding="utf-8")


def test_the_stage_fails_on_tampering_even_if_claims_are_not_enforced(project, caplog):
    change(project / "results/tables/table09.csv", "0.04", "0.045")  # g2, which no claim is about
    config = {**load_config(project / "config/config.yaml"), "claims": {"enforce": False}}
    with caplog.at_level(logging.ERROR), pytest.raises(InputError, match="1 disagreements"):
        verify_run(project, config)
    assert "results/tables/table09.csv" in caplog.text


def test_a_source_that_is_missing_is_named_when_the_list_is_written(tmp_path):
    with pytest.raises(InputError, match=r"gone\.csv"):
        verification.write_sources(tmp_path / SOURCES, [Path("gone.csv")], [], tmp_path)


def test_the_audit_is_laid_out():
    made = paper_audit.audit_findings
    table = made.numbers({}, {})
    assert {"id", "place", "what", "arithmetic", "found", "printed", "verdict", "note"} <= set(table.columns)
    assert len(table) > 60
    assert "88.479" in made.draw(table).md("")
