"""The workflow as Snakemake sees it: all targets are there, rules are complete, scripts thin, bad input one line.

Each run of Snakemake takes seconds, so there are few, all in folders of their own.
"""

import hashlib
import io
import json
import os
import re
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from importlib import import_module
from inspect import signature
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml
from claims_example import write_results
from kept import same
from snakemake.api import OutputSettings, ResourceSettings, SnakemakeApi
from snakemake.cli import main

from repro.exhibits import catalogue
from repro.paper.ledger import compute
from repro.paper.our_values import Results
from repro.paper.published import load_published
from repro.pipeline.factorial import CELLS
from repro.signals.programs import PROGRAMS

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[2]
WORKFLOW = ROOT / "workflow"
FIGURES = [exhibit.name for exhibit in catalogue.FIGURES if not exhibit.optional]
TABLES = ["audit", *(exhibit.name for exhibit in catalogue.TABLES if not exhibit.optional)]
EXHIBITS = {exhibit.target: exhibit for exhibit in catalogue.EXHIBITS}
DECLARED = {exhibit.definition: exhibit for exhibit in catalogue.EXHIBITS}
CONFIG = yaml.safe_load((ROOT / "config" / "config.yaml").read_text(encoding="utf-8"))
SEEDS, SEARCH_SEEDS = CONFIG["numeric"]["seeds"], CONFIG["experiment"]["search_seeds"]
QUICK = str(ROOT / "config" / "quick.yaml")
#: Networks of Tables 4 to 7, and those of the arm, by the suffix of their files.
NETWORKS = ("", "-tracked")
ARM_NETWORKS = (*NETWORKS, "-desired", "-tracked-measured")
#: Needs the extra rtl.
SYNTHESIS = "synthesise_board"
#: Rules that only name other rules' files.
COLLECTIONS = {"all", "training", "tutorials", *EXHIBITS, *(exhibit.name for exhibit in catalogue.EXHIBITS)}


def project(folder):
    """Make a folder a working directory, so that no run in the checkout is disturbed."""
    for name in ("config", "data"):
        (folder / name).symlink_to(ROOT / name)
    return folder


@pytest.fixture(scope="module")
def rules(tmp_path_factory):
    """Every rule by its name, as Snakemake has it."""
    folder = project(tmp_path_factory.mktemp("rules"))
    with pytest.MonkeyPatch.context() as patch, SnakemakeApi(OutputSettings()) as api:
        patch.chdir(folder)
        patch.setattr(os, "environ", os.environ.copy())
        loaded = api.workflow(ResourceSettings(cores=1), snakefile=ROOT / "Snakefile", workdir=folder)
        return {rule.name: rule for rule in loaded._workflow.rules}


@pytest.fixture(scope="module")
def working(rules):
    return [rule for name, rule in rules.items() if name not in COLLECTIONS]


@pytest.fixture
def folder(tmp_path):
    return project(tmp_path)


def options(*arguments):
    return ["--snakefile", str(ROOT / "Snakefile"), "--cores", "1", *arguments]


def run(folder, *arguments):
    """Exit code and output of a run with jobs."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "src"), "OMP_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "snakemake", *options(*arguments)]
    ended = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    return ended.returncode, ended.stdout + ended.stderr


def snakemake(folder, *arguments):
    """Exit code and output of a run without jobs, in this process: another one would take seconds to load."""
    said = io.StringIO()
    with (
        pytest.MonkeyPatch.context() as patch,
        redirect_stdout(said),
        redirect_stderr(said),
        pytest.raises(SystemExit) as ended,
    ):
        patch.chdir(folder)
        patch.setattr(os, "environ", os.environ.copy())
        main(options(*arguments))
    return ended.value.code, said.getvalue()


def summary(folder, *arguments):
    """Output file -> the rule that makes it, of everything that the default target needs."""
    code, said = snakemake(folder, "--summary", *arguments)
    assert code == 0, said
    lines = said[said.index("output_file\t") :].splitlines()
    header = lines[0].split("\t")
    rows = [dict(zip(header, line.split("\t"), strict=False)) for line in lines[1:] if "\t" in line]
    return {row["output_file"]: row["rule"] for row in rows}


@pytest.fixture(scope="module")
def full(tmp_path_factory):
    """What the default target makes."""
    return summary(project(tmp_path_factory.mktemp("full")))


def test_the_default_target_makes_every_table_and_figure(full):
    expected = {f"results/identification/numeric{s}-seed{k}.json" for s in NETWORKS for k in SEEDS}
    expected |= {f"results/identification/experiment{s}-seed{k}.json" for s in ARM_NETWORKS for k in SEARCH_SEEDS}
    expected |= {f"results/identification/{name}-least-squares.json" for name in ("numeric", "experiment")}
    assert {name for name in full if "/identification/" in name} == expected
    assert not [name for name in full if "paper-recipe" in name]  # a target that must be named
    figures = {f"paper_figures/{name}.{end}" for name in FIGURES for end in ("pdf", "png")}
    numbers = {f"results/figures/{name}.csv" for name in FIGURES}
    tables = {f"results/tables/{name}.{end}" for name in TABLES for end in ("csv", "tex", "md")}
    drawn = {file: rule for file, rule in full.items() if rule.startswith("draw_")}
    assert drawn.keys() == figures | numbers | tables
    assert len({*drawn.values()}) < len(EXHIBITS) / 2
    others = ("model/cnn.safetensors", "model/training.csv", "model/model-card.md", "report/index.html")
    ledger = ("claims.csv", "claims.md", "claims.sha256", "verified.txt")
    assert {f"results/{name}" for name in (*others, *ledger)} <= full.keys()
    recordings = {f"results/experiment/{motion}.{end}" for motion in PROGRAMS for end in ("bin", "program", "json")}
    assert {name for name, rule in full.items() if rule == "acquire"} == recordings
    scores = {f"results/spread/scores-{k}.csv" for k, _ in enumerate(CONFIG["spread"]["durations_s"])}
    assert {name for name, rule in full.items() if rule == "score_spread"} == scores


def test_the_quick_run_makes_all_of_the_full_one_from_stored_networks(full, folder):
    quick = summary(folder, "--configfile", QUICK)
    moved = {re.sub("^(results|paper_figures)/", r"\1/quick/", name) for name in full}
    assert set(quick) == {name for name in moved if name.startswith(("results/", "paper_"))}
    (folder / "data").unlink()
    assert snakemake(folder, "--dry-run", "results/model/training.csv")[0] == 0  # what is trained needs none
    said = refused(folder, "results/quick/model/training.csv", "--configfile", QUICK)
    assert "quick.yaml: training.source: found stored, expected a folder with the stored networks" in said


def test_each_target_can_be_asked_for_by_its_rule_name(folder):
    names = [name for name in sorted(COLLECTIONS - {"all"}) if "ablation" not in name]
    code, said = snakemake(folder, "--dry-run", *names)
    assert code == 0, said
    counts = dict(re.findall(r"^(\w+) +(\d+)$", said, re.MULTILINE))
    assert {counts.get(name) for name in names} == {"1"}
    # "desired" reads with the published network; the paper's recipe has two more.
    assert counts["train"] == str(len({*NETWORKS, *ARM_NETWORKS} - {"-desired"}) + 2)
    assert counts["identify_numeric"] == str(len(NETWORKS) + 2)  # every seed in one job
    assert counts["identify_experiment"] == str(len(ARM_NETWORKS) + 2)
    assert counts["identify_numeric_least_squares"] == counts["identify_least_squares"] == "1"
    assert counts["acquire"] == "5"


def test_every_number_of_the_ledger_is_made_by_a_target(rules, tmp_path):
    write_results(tmp_path)
    claims = compute(load_published(), CONFIG, Results(tmp_path))
    targets = {name for name, rule in rules.items() if not rule.has_wildcards()}  # as --list-target-rules has it
    computed = claims["ours"].notna()
    assert set(claims.loc[computed, "target"]) <= targets
    assert set(claims.loc[~computed, "target"]) <= {*targets, ""}


def test_a_serial_port_is_opened_by_one_job_at_a_time(folder):
    """However many cores there are."""
    overlay = folder / "my.yaml"
    overlay.write_text("experiment: {source: serial, port: ./none}", encoding="utf-8")
    wanted = [f"results/experiment/{motion}.bin" for motion in ("ID", "T1")]
    code, said = run(folder, "--configfile", str(overlay), "--cores", "4", "--", *wanted)
    assert code != 0  # there is no such port, so the first job is the last
    assert re.findall(r"^Execute (\d+) jobs", said, re.MULTILINE) == ["1"]


def test_a_table_is_made_alone_with_its_log_and_benchmark(folder):
    """Unless its job draws others too."""
    code, said = run(folder, "audit")
    assert code == 0, said
    made = {str(p.relative_to(folder)) for p in (folder / "results").rglob("*") if p.is_file()}
    expected = {f"results/tables/audit.{e}" for e in ("csv", "tex", "md")}
    expected |= {"results/logs/draw_paper_audit.log", "results/benchmarks/draw_paper_audit.tsv"}
    assert expected <= made
    assert not [name for name in made if "/tables/" in name and "audit" not in name]
    record = json.loads((folder / "results/ro-crate-metadata.json").read_text(encoding="utf-8"))
    sums = {entity["name"]: entity["sha256"] for entity in record["@graph"] if "sha256" in entity}
    tables = {name for name in expected if "/tables/" in name}
    assert tables == {name for name in sums if name.startswith("results/tables/")}
    assert all(sums[name] == hashlib.sha256((folder / name).read_bytes()).hexdigest() for name in tables)
    assert not (folder / "paper_figures").exists()


def refused(folder, *arguments):
    """The one line that a run ends with, and exit code 2."""
    code, said = snakemake(folder, "--dry-run", *arguments)
    assert code == 2, said
    (line,) = (line for line in said.splitlines() if ": found " in line)
    assert not re.search(r"Traceback|Error in|Exception|File \"", said)
    assert not (folder / "results").exists()
    return line


def test_a_bad_configuration_ends_the_run_with_one_line(folder):
    overlay, captures = folder / "my.yaml", folder / "mine"
    overlay.write_text("training: {stepz: 5}", encoding="utf-8")
    assert refused(folder, "--configfile", str(overlay)).startswith(f"{overlay}: training.stepz: found an unknown key")
    assert refused(folder, "--config", "stepz=3").startswith("command line: stepz: found an unknown key")
    captures.mkdir()  # without check sums
    for file in (ROOT / "data/captures").glob("*.[bpj]*"):
        (captures / file.name).symlink_to(file)
    overlay.write_text("experiment: {captures: mine}", encoding="utf-8")
    line = refused(folder, "claims", "--configfile", str(overlay))
    assert line.startswith(f"{overlay}: experiment.captures: found ") and "SHA256SUMS" in line


#: Jobs of a cluster, in the order in which they can run; those that train, and a port's, share none.
STAGES = {"prepare": 0, "train": 1, "identify": 2, "evaluate": 3}


def test_what_shares_a_job_of_the_cluster_can_run_in_one(folder, working):
    """Each rule has its stage, and no input of a stage is made in a later one."""
    profile = yaml.safe_load((WORKFLOW / "profiles" / "slurm" / "config.yaml").read_text(encoding="utf-8"))
    stage = dict(entry.split("=") for entry in profile["groups"])
    assert len(stage) == len(profile["groups"])
    alone = {"acquire": "prepare", "study_cells": "identify"}
    alone |= dict.fromkeys(("train", "ablation_train", "train_factorial", "study_train"), "train")
    assert stage.keys() == {rule.name for rule in working} - alone.keys()
    stage |= alone
    targets = ("all", "ablation", "paper_recipe", "factorial", "tutorials", "study", SYNTHESIS)
    code, said = snakemake(folder, "--rulegraph", "dot", "--", *targets)
    assert code == 0, said
    names = dict(re.findall(r'(\d+)\[label = "(\w+)"', said))
    edges = [(names[a], names[b]) for a, b in re.findall(r"(\d+) -> (\d+)", said)]
    assert set(names.values()) >= stage.keys()
    for maker, user in edges:
        assert user in COLLECTIONS or STAGES[stage[maker]] <= STAGES[stage[user]], (maker, user)


def test_logs_and_benchmarks_of_two_jobs_never_meet(working):
    """Both carry the rule's name and every wildcard of the output."""
    for rule in working:
        for path, end in ((rule.log[0], ".log"), (rule.benchmark, ".tsv")):
            stem = Path(re.sub(r"\{.*\}", "", str(path))).name
            assert stem.startswith(rule.name), rule.name
            assert str(path).endswith(end), rule.name
            assert set(re.findall(r"\{(\w+)", str(path))) == rule.wildcard_names, rule.name


def test_every_exhibit_has_its_rule_and_hands_it_its_sections(rules):
    drawing = [rule for name, rule in rules.items() if name.startswith("draw_")]
    assert sorted(name for rule in drawing for name in rule.params.exhibits) == sorted(DECLARED)
    for rule in drawing:
        exhibits = [DECLARED[name] for name in rule.params.exhibits]
        assert len({(one.definition.partition(":")[0], one.inputs) for one in exhibits}) == 1
        assert {name.rpartition("_")[0] for name, _ in rule.output.items()} == {one.target for one in exhibits}
        assert set(rule.params.config) == {section for one in exhibits for section in one.sections}
        captions = [file.flags["report"].caption for file in rule.output if "report" in file.flags]
        names = {Path(caption.get_path_or_uri(secret_free=True)).stem for caption in captions}
        assert names == {one.target for one in exhibits}
        for one in exhibits:
            own = [file for name, file in rule.output.items() if name.rpartition("_")[0] == one.target]
            assert {Path(file).stem for file in own} == {one.name}
            assert [str(file) for file in rules[one.target].input] == own
            assert set(own) <= {str(file) for file in rules[one.name].input}


#: Values of every wildcard, for what depends on one.
ONE = {
    "suffix": "-tracked",
    "motion": "T3",
    "index": "1",
    "reading": "tracked-guesses",
    "trained": "tracked-few",
    "cell": "plain-tracked-index",
    "seed": "2",
    "search": "3",
    "tutorial": "board",
    "job": "random-narrow-1",
    "excitation": "slow",
    "law": "wide",
    "network": "posterior",
}


def of_a_job(rule, value):
    """A parameter of a rule, or what a function of wildcards and input gives for one job."""
    if callable(value):
        value = value(*(SimpleNamespace(**ONE), rule.input)[: len(signature(value).parameters)])
    return value


def described(rule):
    """A rule in lines: files, parameters without values of the configuration, resources."""
    digests = " ".join(str(of_a_job(rule, value)) for value in rule.params)
    trainers = [name for name in ("repro.cnn.train", "repro.cnn.plain") if f"{name}:train" in digests]
    yield f"rule {rule.name}: {Path(rule.script).name}; {rule.message}; priority {rule.priority}; trains by {trainers}"
    for kind in ("input", "output", "params"):
        given = getattr(rule, kind)
        names, found = {id(value): name for name, value in given.items()}, {}
        for value in given:
            one = of_a_job(rule, value)
            many = sorted(one) if isinstance(one, dict) else one if isinstance(one, (list, tuple)) else [one]
            texts = [text for text in map(str, many) if not re.search(r" [0-9a-f]{12}\b", text)]  # digests of code
            found.setdefault(names.get(id(value), ""), []).extend(texts)
        yield from (f"  {kind} {name}: {', '.join(texts)}".replace(str(ROOT), "") for name, texts in found.items())
    yield from (f"  {value}" for name, value in sorted(rule.resources.items()) if name in ("mem_mb", "runtime"))


def test_rules_are_those_kept(working, file_regression):
    kept = "\n".join(line for rule in sorted(working, key=lambda rule: rule.name) for line in described(rule)) + "\n"
    file_regression.check(kept, check_fn=same, basename="rules")


def test_each_job_depends_on_its_code_and_on_sections_of_the_configuration(working):
    for rule in working:
        digests = " ".join(str(of_a_job(rule, value)) for value in rule.params)
        assert len(re.findall(r"repro[\w.]+:\S* [0-9a-f]{12}\b", digests)) > 5, rule.name
        config = of_a_job(rule, rule.params.get("config", {}))
        assert set(config) <= set(CONFIG), rule.name
        if rule.name != "report":  # one more seed changes nothing for jobs that work on one motion or one arm
            assert "seeds" not in config.get("numeric", {}), rule.name
            assert "search_seeds" not in config.get("experiment", {}), rule.name


@pytest.mark.parametrize(("reader", "other"), [("plain", "cnn"), ("cnn", "plain")])
def test_a_network_of_the_factorial_depends_on_its_own_training(rules, reader, other):
    trainers = {"plain": "repro.cnn.plain:train", "cnn": "repro.cnn.train:train"}
    cell = next(name for name, cell in CELLS.items() if cell.reader == reader)
    digests = rules["train_factorial"].params.code(SimpleNamespace(cell=cell))
    assert trainers[reader] in digests
    assert trainers[other] not in digests


def test_each_function_is_given_what_it_names(working):
    called = [rule for rule in working if Path(rule.script).name == "call.py"]
    assert len(called) > 20
    for rule in called:
        module, _, name = rule.params[0].partition(":")
        parameters = signature(getattr(import_module(module), name)).parameters
        given = {*rule.wildcard_names, "files", "inputs", "outputs"}.union(
            rule.input.keys(), rule.output.keys(), rule.params.keys()
        )
        assert {name for name, one in parameters.items() if one.default is one.empty} <= given, rule.name


def test_inputs_are_named_as_files(rules):
    """A job of a cluster would check the rule of an input that is named as a rule's output, and run it again."""
    assert [name for name, rule in rules.items() if rule.dependencies] == []


def test_no_script_is_left_over(working):
    assert {Path(rule.script).name for rule in working} == {
        script.name for script in (WORKFLOW / "scripts").glob("*.py")
    }


def test_emulated_hosts_run_tests_that_exist():
    text = (ROOT / ".ci" / "hosts.py").read_text(encoding="utf-8")
    names = re.findall(r'"(\w+)"', text[text.index("PORTABLE = (") : text.index("@dataclass")])
    assert len(names) > 12
    assert [name for name in names if not list((ROOT / "tests").rglob(f"test_{name}.py"))] == []
