"""Tampering: one thing changed at a time, and `repro verify` names it; exit codes of the command and of the stage."""

import hashlib
import io
import os
import re
import shutil
import subprocess
from pathlib import Path

import pandas as pd
import pytest
from claims_example import make_project
from experiment_example import refused

from repro.cli import main
from repro.config.check import load_config, read_config
from repro.config.sections import changed
from repro.experiments.record import changed_settings, config_digest
from repro.files import write_json
from repro.paper import ledger
from repro.paper.ledger import CLAIMS, PAGE, PUBLISHED_NAME, SOURCES, read_sources, write_ledger

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
    monkeypatch.setattr(ledger, "PUBLISHED_FILE", root / "published.csv")
    return root


def verify(capsys, *options):
    code = main(["verify", *options])
    printed = capsys.readouterr()
    assert "Traceback" not in printed.out + printed.err
    return code, printed.out, printed.err


def change(path, old, new):
    content = path.read_bytes()
    assert old.encode() in content
    path.write_bytes(content.replace(old.encode(), new.encode(), 1))


def committed(folder):
    """Commit everything in a folder; return the commit."""
    git = ["git", "-C", str(folder), "-c", "user.name=test", "-c", "user.email=test@localhost"]
    for command in (["init", "-q"], ["add", "-A"], ["commit", "-q", "-m", "test"]):
        subprocess.run([*git, *command], check=True)
    return subprocess.run([*git, "rev-parse", "HEAD"], check=True, capture_output=True, text=True).stdout.strip()


def test_a_ledger_that_agrees_is_summarised_and_ends_with_0(project, capsys):
    code, out, _ = verify(capsys)
    assert code == 0 and "disagrees" not in out
    claims = pd.read_csv("results/claims.csv")
    own = claims[~claims["id"].str.contains("@")]
    for basis, of in own.groupby("basis"):
        line = re.search(rf"^{basis} +{len(of)}  (.*)$", out, re.MULTILINE)[1]
        counts = dict(reversed(part.split(" ", 1)) for part in line.split(", "))
        assert {name: int(number) for name, number in counts.items()} == of["verdict"].value_counts().to_dict()


#: One text changed in each of six files; what is named besides files whose check sum differs.
CHANGES = [
    ("published.csv", "total,ID,algorithm1,1,,%,is,93.55", "total,ID,algorithm1,1,,%,is,93.45"),
    ("results/model/training.csv", "0.00025", "0.00024"),
    ("results/tables/table09.csv", "0.12", "0.13"),  # a number that the ledger does not use
    ("data/captures/ID.bin", "\x11", "\x10"),
    (f"results/{PAGE}", "| better |", "| worse |"),
    ("config/config.yaml", "[180.4817, 30.6819]", "[180.4817, 30.6818]"),
]
NAMED = [
    "disagrees: results/claims.csv: table10/ID/algorithm1/total/joint1: published: found 93.55, expected 93.45",
    "disagrees: results/claims.csv: section5a/loss: ours: found 0.00025, expected 0.00024",
    "disagrees: results/claims.csv: table08/kp/joint2: ours: found 30.6819, expected 30.6818",
    "not as asserted: table08/kp/joint2",
    *(f"disagrees: results/claims.csv: abstract/joints: {name}: found 1, expected" for name in ("note", "ours")),
]


def test_each_changed_text_and_cell_of_the_ledger_is_named(project, capsys):
    for file, old, new in CHANGES:
        change(project / file, old, new)
    table = pd.read_csv("results/claims.csv", dtype=str, keep_default_na=False)
    table.loc[table["id"] == "abstract/joints", ["note", "ours"]] = "1"
    table.to_csv("results/claims.csv", index=False)
    code, out, _ = verify(capsys)
    assert code == 1
    assert [text for text in NAMED if text not in out] == []
    files = {PUBLISHED_NAME, "results/claims.csv", *(file for file, _, _ in CHANGES[1:-1])}
    assert set(re.findall("^disagrees: (.*): SHA-256", out, re.MULTILINE)) == files


def test_page_and_settings_that_are_kept_with_results_are_checked_under_a_new_seal(project, capsys):
    commit, config = committed(project), read_config(project / "config/config.yaml")
    kept = {"commit": commit, "config_sha256": config_digest(config)}
    write_json("results/factorial.json", kept)
    assert changed_settings(Path("results"), config, project) == []
    (line,) = changed_settings(Path("results"), {**config, "claims": {}}, project)[:1]
    assert "claims.enforce: found True, expected nothing" in line
    (line,) = changed_settings(Path("results"), {**config, "more": 1}, project)[:1]
    assert "more: found nothing, expected 1" in line
    changes = [
        ("claims.md", "| better |", "| worse |", "found another text"),
        ("config.yaml", "margin_samples: 40", "margin_samples: 41", "numeric.margin_samples"),
        ("config.yaml", "enforce: true", "", "claims"),
        ("factorial.json", '"config_sha256": "', '"config_sha256": "0', "config_sha256"),
        ("factorial.json", '"commit": "', '"commit": "x', "commit"),
    ]
    for file, old, new, _ in changes:
        change(project / "results" / file, old, new)
    ledger.write_sources(Path("results", SOURCES), [], [Path("results"), Path("data/captures")])
    code, out, _ = verify(capsys)
    assert code == 1 and "SHA-256:" not in out
    assert [field for file, _, _, field in changes if f"disagrees: results/{file}: {field}" not in out] == []


def test_rows_that_are_removed_added_or_moved_are_named(made):
    text = (made / "results" / CLAIMS).read_text(encoding="utf-8")
    claims = pd.read_csv(io.StringIO(text), dtype=str, keep_default_na=False)
    assert ledger.compare(text, claims, CLAIMS) == []
    lines = text.splitlines(keepends=True)
    for other, named in (
        (lines[:5] + lines[6:], f"{lines[5].split(',')[0]}: found no row"),
        ([*lines, lines[5].replace(lines[5].split(",")[0], "table99/x")], "table99/x: found a row"),
        ([*lines[:5], lines[6], lines[5], *lines[7:]], "found rows in another order"),
        ([*lines, lines[5]], "found rows in another order or twice"),
        (["id,place\n"], "header: found id,place"),
    ):
        (problem,) = ledger.compare("".join(other), claims, CLAIMS)
        assert problem.startswith(f"{CLAIMS}: {named}")


def test_a_listed_file_that_is_missing(project, capsys):
    table = project / "results/tables/table10.csv"  # without Table 10 the ledger cannot be computed either
    table.unlink()
    for why in ("no such file", "too many levels of symbolic links"):
        code, out, _ = verify(capsys)
        assert code == 1 and f"disagrees: results/tables/table10.csv: found {why}" in out
        if not table.is_symlink():
            table.symlink_to(table.name)


def test_without_a_ledger_there_is_nothing_to_verify(project, capsys):
    for name in (SOURCES, PAGE, CLAIMS):  # each is read before the ones that are missing already
        (project / "results" / name).unlink()
        code, _, err = verify(capsys)
        assert code == 2 and f"results/{name}" in err and err.count("\n") == 1
        os.mkfifo(project / "results" / name)
        code, _, err = verify(capsys)
        assert code == 2 and f"results/{name}: found a pipe or a device" in err and err.count("\n") == 1


def test_the_run_that_has_a_ledger_is_named(project, capsys):
    (project / "results/quick").mkdir()
    (project / "results" / CLAIMS).rename(project / "results/quick" / CLAIMS)
    (project / "config/quick.yaml").touch()
    code, _, err = verify(capsys)
    assert code == 2 and err.startswith(f"results/{CLAIMS}: found no such file, expected ") and err.count("\n") == 1
    assert err.endswith(" repro verify --results results/quick --config config/config.yaml config/quick.yaml\n")


def test_a_list_that_was_edited_or_names_what_lies_outside_is_refused(project, capsys):
    path = project / "results" / SOURCES
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    edited = ["".join(lines[:k] + lines[k + 1 :]) for k in (0, 1, 3)]  # its own check sum, a folder, and a file
    for line in ("# every file in data/../..", "# every file in /usr", f"{'0' * 64}  src/a", f"{'0' * 64}  src/a\0b"):
        text = f"{''.join(lines[1:])}{line}\n"
        seal = hashlib.sha256(text.encode()).hexdigest()
        edited.append(f"# SHA-256 of the lines below: {seal}\n{text}")
    for text in edited:
        path.write_text(text, encoding="utf-8")
        code, _, err = verify(capsys)
        assert code == 2 and f"results/{SOURCES}" in err and err.count("\n") == 1
    assert f"line {len(lines) + 1}: " in err


def test_a_claim_that_fails_under_an_overlay_ends_a_run_only_if_enforced(project, capsys, monkeypatch):
    overlay = project / "config/mine.yaml"
    overlay.write_text("results: other\nboard:\n  kp_nm_per_rad: [180.4817, 30.0]\n", encoding="utf-8")
    shutil.copytree("results", "other", ignore=shutil.ignore_patterns("config.yaml"))
    config = load_config(Path("config/config.yaml"), overlay)
    sources = ["data/captures/ID.bin", "other/model/training.csv", "other/tables/table10.csv"]
    for source, read in (("simulated", []), ("stored", ["data/captures"])):
        own = changed(config, {"experiment": {"source": source}})
        write_ledger(Path("other"), own, [Path(name) for name in sources])
        folders, listed = read_sources(Path("other/claims.sha256"))
        assert folders == read
    captures = [f"data/captures/{name}" for name in ("ID.bin", "ID.json")]
    assert set(listed) == {*sources, *captures, "other/claims.csv", "other/claims.md", PUBLISHED_NAME}

    verify_ledger, found = ledger.verify_ledger, []

    def verify_once(*given):
        if not found:
            found.extend(verify_ledger(*given))
        return found

    monkeypatch.setattr(ledger, "verify_ledger", verify_once)
    code, out, _ = verify(capsys, "--config", "config/config.yaml", "config/mine.yaml")
    assert code == 1 and "disagrees" not in out
    assert out.count("not as asserted") == 1 and "not as asserted: table08/kp/joint2" in out
    assert config.claims.enforce
    assert refused(ledger.verified, Path("other"), config).found.startswith("1 ")
    assert "not as asserted: table08/kp/joint2" in capsys.readouterr().err
    lenient = changed(config, {"claims": {"enforce": False}})
    assert "not as asserted: table08/kp/joint2" in ledger.verified(Path("other"), lenient)
    found[1].append("results/tables/table09.csv: found another text")
    assert refused(ledger.verified, Path("other"), lenient).found.startswith("1 ")
    assert "results/tables/table09.csv: found another text" in capsys.readouterr().err


def test_a_copy_of_the_results_is_checked_itself_from_another_place(project, capsys, monkeypatch):
    copy = project / "docs/reference"
    shutil.copytree("results", copy)
    monkeypatch.chdir("docs")
    change(copy / "tables/table07.csv", "0.975", "0.974")
    (copy / "tables/more.csv").write_text("a\n", encoding="utf-8")
    (copy / "config.yaml").unlink()
    code, out, _ = verify(capsys, "--results", "reference", "--config", "../config/config.yaml")
    named = re.findall(r"^disagrees: (\S+): (?:found|SHA-256)", out, re.MULTILINE)
    assert code == 1
    assert named == [f"reference/{name}" for name in ("config.yaml", "tables/more.csv", "tables/table07.csv")]


def test_the_list_is_what_sha256sum_checks(project):
    (project / PUBLISHED_NAME).parent.mkdir(parents=True)
    shutil.copy("published.csv", project / PUBLISHED_NAME)
    command = ["sha256sum", "--check", "--strict", "--quiet", "results/claims.sha256"]
    assert subprocess.run(command, check=False).returncode == 0
    change(project / "results/tables/table04.csv", "N1", "N7")
    failed = subprocess.run(command, check=False, capture_output=True, text=True)
    assert failed.returncode != 0 and "results/tables/table04.csv: FAILED" in failed.stdout


def test_a_source_that_is_missing_is_named_when_the_list_is_written(tmp_path):
    error = refused(ledger.write_sources, tmp_path / SOURCES, [Path("gone.csv")], [], tmp_path)
    assert "gone.csv" in error.place
