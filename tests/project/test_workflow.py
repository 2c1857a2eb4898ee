"""The workflow as Snakemake sees it: all targets are there, rules are complete, scripts thin, bad input one line.

Each time that Snakemake loads it takes seconds, so it is loaded a few times, in folders of their own.
"""

import io
import itertools
import os
import re
import runpy
import subprocess
import sys
from collections import Counter
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from importlib import import_module
from inspect import signature
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml
from claims_example import write_results
from experiment_example import changed, full_config, refusal_in
from kept import same
from snakemake.api import ConfigSettings, DAGSettings, OutputSettings, ResourceSettings, SnakemakeApi
from snakemake.cli import main

from repro.exhibits import catalogue
from repro.paper.ledger import compute
from repro.paper.our_results import Results
from repro.paper.published import load_published
from repro.signals.programs import PROGRAMS
from repro_studies.factorial import CELLS

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[2]
WORKFLOW = ROOT / "workflow"
FIGURES = [exhibit.name for exhibit in catalogue.FIGURES if not exhibit.optional]
TABLES = ["audit", *(exhibit.name for exhibit in catalogue.TABLES if not exhibit.optional)]
EXHIBITS = {exhibit.target: exhibit for exhibit in catalogue.EXHIBITS}
DECLARED = {exhibit.definition: exhibit for exhibit in catalogue.EXHIBITS}
CONFIG = full_config()
SEEDS, SEARCH_SEEDS = CONFIG.numeric.seeds, CONFIG.experiment.search_seeds
QUICK = ROOT / "config" / "quick.yaml"
#: Networks of Tables 4 to 7, and those of the arm, by the suffix of their files.
NETWORKS = ("", "-tracked")
ARM_NETWORKS = (*NETWORKS, "-desired", "-tracked-measured")
#: Rules that only name other rules' files.
COLLECTIONS = {"all", "training", "tutorials", *EXHIBITS, *(exhibit.name for exhibit in catalogue.EXHIBITS)}


def project(folder):
    """Make a folder a working directory, so that no run in the checkout is disturbed."""
    for name in ("config", "data"):
        (folder / name).symlink_to(ROOT / name)
    return folder


def plan(folder, targets, *files):
    """The workflow with further configuration files, and the jobs of its targets, as Snakemake has them."""
    with pytest.MonkeyPatch.context() as patch, SnakemakeApi(OutputSettings()) as api:
        patch.chdir(folder)
        patch.setattr(os, "environ", os.environ.copy())
        given = {"config_settings": ConfigSettings(configfiles=files), "snakefile": ROOT / "Snakefile"}
        loaded = api.workflow(ResourceSettings(cores=4), workdir=folder, **given)
        loaded.dag(DAGSettings(targets=targets))
        loaded._workflow._prepare_dag(forceall=True, ignore_incomplete=True, lock_warn_only=True)
        loaded._workflow._build_dag()
        return loaded._workflow


@pytest.fixture(scope="module")
def full(tmp_path_factory):
    """The default workflow, with every target."""
    return plan(project(tmp_path_factory.mktemp("full")), {*COLLECTIONS, "study", "synthesise_board", "match"})


@contextmanager
def others_names():
    """Put back the names of the workflow loaded before: Snakemake keeps those of all in one module."""
    module = vars(import_module("snakemake.workflow"))
    names = module.copy()
    yield
    module.update(names)


@pytest.fixture(scope="module")
def quick(full, tmp_path_factory):
    """The workflow from stored networks, with a board on a port."""
    folder = project(tmp_path_factory.mktemp("quick"))
    overlay = folder / "my.yaml"
    overlay.write_text("experiment: {source: serial, port: ./none}", encoding="utf-8")
    with others_names():
        return plan(folder, {"all"}, QUICK, overlay)


@pytest.fixture(scope="module")
def rules(full):
    return {rule.name: rule for rule in full.rules}


@pytest.fixture(scope="module")
def working(rules):
    return [rule for name, rule in rules.items() if name not in COLLECTIONS]


def needed(workflow, *targets):
    """Jobs of these targets and all that they need."""
    dag = workflow.dag
    return list(dag.bfs(dag.dependencies, *(job for job in dag.jobs if job.rule.name in targets)))


def outputs(workflow, target):
    """Output file -> the rule that makes it, of everything that a target needs."""
    return {str(file): job.rule.name for job in needed(workflow, target) for file in job.output}


def test_trainings_have_the_keys_by_which_their_history_is_written(full):
    trainings = [job.params.config["training"] for job in full.dag.jobs if job.rule.name == "train"]
    assert len(trainings) > 2 and all({"log_every", "test_samples"} <= keys.keys() for keys in trainings)


def test_the_default_target_makes_every_table_and_figure(full):
    made = outputs(full, "all")
    expected = {f"results/identification/numeric{s}-seed{k}.json" for s in NETWORKS for k in SEEDS}
    expected |= {f"results/identification/experiment{s}-seed{k}.json" for s in ARM_NETWORKS for k in SEARCH_SEEDS}
    expected |= {f"results/identification/{name}-least-squares.json" for name in ("numeric", "experiment")}
    assert {name for name in made if "/identification/" in name} == expected
    assert not [name for name in made if "paper-recipe" in name]  # a target that must be named
    figures = {f"paper_figures/{name}.{end}" for name in FIGURES for end in ("pdf", "png")}
    numbers = {f"results/figures/{name}.csv" for name in FIGURES}
    tables = {f"results/tables/{name}.{end}" for name in TABLES for end in ("csv", "tex", "md")}
    drawn = {file: rule for file, rule in made.items() if rule.startswith("draw_")}
    assert drawn.keys() == figures | numbers | tables
    assert len({*drawn.values()}) < len(EXHIBITS) / 2
    others = ("model/cnn.safetensors", "model/training.csv", "model/model-card.md", "report/index.html")
    ledger = ("claims.csv", "claims.md", "claims.sha256", "verified.txt")
    assert {f"results/{name}" for name in (*others, *ledger)} <= made.keys()
    recordings = {f"results/experiment/{motion}.{end}" for motion in PROGRAMS for end in ("bin", "program", "json")}
    assert {name for name, rule in made.items() if rule == "acquire"} == recordings


def test_the_quick_run_makes_all_of_the_full_one(full, quick):
    moved = {re.sub("^(results|paper_figures)/", r"\1/quick/", name) for name in outputs(full, "all")}
    assert set(outputs(quick, "all")) == {name for name in moved if name.startswith(("results/", "paper_"))}


def test_a_table_is_made_alone(full):
    """Unless its job draws others too."""
    assert set(outputs(full, "audit")) == {f"results/tables/audit.{end}" for end in ("csv", "tex", "md")}


def test_each_target_can_be_asked_for_by_its_rule_name(full):
    names = [name for name in sorted(COLLECTIONS - {"all"}) if "ablation" not in name]
    counts = Counter(job.rule.name for job in needed(full, *names))
    assert {counts[name] for name in names} == {1}
    # "desired" reads with the published network; the paper's recipe has two more.
    assert counts["train"] == len({*NETWORKS, *ARM_NETWORKS} - {"-desired"}) + 2
    assert counts["identify_numeric"] == len(NETWORKS) + 2  # every seed in one job
    assert counts["identify_experiment"] == len(ARM_NETWORKS) + 2
    assert counts["identify_numeric_least_squares"] == counts["identify_least_squares"] == 1
    assert counts["acquire"] == 5


def test_every_number_of_the_ledger_is_made_by_a_target(rules, tmp_path):
    write_results(tmp_path)
    claims = compute(load_published(), CONFIG, Results(tmp_path))
    targets = {name for name, rule in rules.items() if not rule.has_wildcards()}  # as --list-target-rules has it
    computed = claims["ours"].notna()
    assert set(claims.loc[computed, "target"]) <= targets
    assert set(claims.loc[~computed, "target"]) <= {*targets, ""}


def test_a_serial_port_is_opened_by_one_job_at_a_time(full, quick):
    """However many cores there are."""
    assert quick.global_resources["serial_port"].value == 1
    for workflow, ports in ((quick, 1), (full, 0)):
        recordings = [job for job in workflow.dag.jobs if job.rule.name == "acquire"]
        assert [job.resources["serial_port"] for job in recordings] == [ports] * 5


def refused(folder, *arguments):
    """The error of the one line that a run ends with, and exit code 2."""
    options = ["--snakefile", str(ROOT / "Snakefile"), "--cores", "1", "--dry-run", *arguments]
    said = io.StringIO()
    with (
        others_names(),
        pytest.MonkeyPatch.context() as patch,
        redirect_stdout(said),
        redirect_stderr(said),
        pytest.raises(SystemExit) as ended,
    ):
        patch.chdir(folder)
        patch.setattr(os, "environ", os.environ.copy())
        main(options)
    assert ended.value.code == 2, said.getvalue()
    (line,) = (line for line in said.getvalue().splitlines() if ": found " in line)
    assert not re.search(r"Traceback|Error in|Exception|File \"", said.getvalue())
    assert not (folder / "results").exists()
    return refusal_in(line)


def test_a_bad_configuration_ends_the_run_with_one_line(tmp_path):
    folder = project(tmp_path)
    overlay, captures = folder / "my.yaml", folder / "mine"
    overlay.write_text("training: {stepz: 5}", encoding="utf-8")
    assert refused(folder, "--configfile", str(overlay)).place == "my.yaml: training.stepz"
    captures.mkdir()
    for file in (ROOT / "data/captures").glob("*.[bpj]*"):
        (captures / file.name).symlink_to(file)
    overlay.write_text("experiment: {captures: mine}", encoding="utf-8")
    (captures / "T2.json").unlink()
    error = refused(folder, "claims", "--configfile", str(overlay))
    assert error.place == "my.yaml: experiment.captures" and "T2.json" in str(error)
    (folder / "data").unlink()
    error = refused(folder, "results/quick/model/training.csv", "--configfile", str(QUICK))
    assert error.place.endswith("quick.yaml: training.source") and error.found == "stored"


def test_no_job_depends_on_the_folder_of_its_configuration(tmp_path):
    """A copy of a finished run has nothing to do."""
    plans = []
    for name in ("first", "second"):
        (tmp_path / name).mkdir()
        folder = project(tmp_path / name)
        (folder / "my.yaml").write_text("experiment: {margin_samples: 39}", encoding="utf-8")
        with others_names():
            jobs = plan(folder, {"report"}, folder / "my.yaml").dag.jobs
        plans.append({job.rule.name: repr(job.params) for job in jobs})
    assert len(plans[0]) > 10
    assert plans[0] == plans[1]


#: Jobs of a cluster, in the order in which they can run; those that train, and a port's, share none.
STAGES = {"prepare": 0, "search": 0, "train": 1, "identify": 2, "evaluate": 3}


def test_the_page_shows_ways_of_the_graph(full):
    page = (ROOT / "docs/workflow.md").read_text(encoding="utf-8")
    lines = re.findall(r"^(\w+ -> .+)$", page, re.MULTILINE)
    edges = {(maker.rule.name, job.rule.name) for job in full.dag.jobs for maker in full.dag.dependencies[job]}
    ways = [list(itertools.pairwise(line.split(" -> "))) for line in lines]
    assert len(ways) == 5 and set(itertools.chain(*ways)) <= edges


def test_a_dry_run_needs_no_home_and_removes_nothing(tmp_path):
    folder = project(tmp_path)
    half = folder / "results/.claims-x1.partial.csv"
    half.parent.mkdir()
    half.touch()
    command = [sys.executable, "-m", "snakemake", "--snakefile", ROOT / "Snakefile", "--dry-run", "table01"]
    environment = os.environ | {"HOME": "/proc", "XDG_CACHE_HOME": "/proc/cache"}  # where not even root can write
    run = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    assert "draw_schematics_diagrams" in run.stdout + run.stderr
    assert half.exists()


def test_what_shares_a_job_of_the_cluster_can_run_in_one(full, working):
    """Each rule has its stage, and no input of a stage is made in a later one."""
    profile = yaml.safe_load((WORKFLOW / "profiles" / "slurm" / "config.yaml").read_text(encoding="utf-8"))
    stage = dict(entry.split("=") for entry in profile["groups"])
    assert len(stage) == len(profile["groups"])
    alone = {"acquire": "prepare", "study_cells": "identify"}
    alone |= dict.fromkeys(("train", "ablation_train", "train_factorial", "study_train"), "train")
    assert stage.keys() == {rule.name for rule in working} - alone.keys()
    stage |= alone
    assert {job.rule.name for job in full.dag.jobs} >= stage.keys()
    for job in full.dag.jobs:
        for maker in full.dag.dependencies[job]:
            names = (maker.rule.name, job.rule.name)
            assert job.rule.name in COLLECTIONS or STAGES[stage[names[0]]] <= STAGES[stage[names[1]]], names


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
    "suffix": "-tracked", "motion": "T3", "reading": "tracked-guesses", "trained": "tracked-few",
    "cell": "plain-tracked", "seed": "2", "search": "3", "tutorial": "board", "job": "random-narrow-1",
    "excitation": "slow", "law": "wide", "network": "posterior", "number": "1", "hypothesis": "2", "start": "1",
}  # fmt: skip


def of_a_job(rule, value):
    """A parameter of a rule, or what a function of wildcards and input gives for one job."""
    if callable(value):
        value = value(*(SimpleNamespace(**ONE), rule.input)[: len(signature(value).parameters)])
    return value


def described(rule):
    """A rule in lines: files, parameters without values of the configuration, resources."""
    digests = " ".join(str(of_a_job(rule, value)) for value in rule.params)
    trainers = [name for name in ("repro.cnn.train", "repro_studies.plain") if f"{name}:train" in digests]
    yield f"rule {rule.name}: {Path(rule.script).name}; {rule.message}; priority {rule.priority}; trains by {trainers}"
    if rule.name in rule.workflow._localrules:
        yield "  no job of a cluster"
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


def test_jobs_depend_on_the_source_of_captures_and_networks_if_they_use_it(rules, monkeypatch):
    assert "source" not in rules["train"].params.config(SimpleNamespace(suffix="-paper-recipe"))["training"]
    with_logic = changed(CONFIG, experiment={"source": "rtl"})
    monkeypatch.setitem(vars(import_module("snakemake.workflow")), "SETTINGS", with_logic)
    assert f"{ROOT}/rtl/pwm_gen.py" in of_a_job(rules["acquire"], rules["acquire"].input[0])
    assert of_a_job(rules["report"], rules["report"].input.captures) == []


def test_each_job_depends_on_its_code_and_on_sections_of_the_configuration(working):
    for rule in working:
        digests = " ".join(str(of_a_job(rule, value)) for value in rule.params)
        assert len(re.findall(r"repro[\w.]+:\S* [0-9a-f]{12}\b", digests)) > 5, rule.name
        config = of_a_job(rule, rule.params.get("config", {}))
        assert set(config) <= set(type(CONFIG).model_fields), rule.name
        if rule.name != "report":  # one more seed changes nothing for jobs that work on one motion or one arm
            assert "seeds" not in config.get("numeric", {}), rule.name
            assert "search_seeds" not in {**config.get("experiment", {}), **config.get("factorial", {})}, rule.name
        if rule.name in ("train", "ablation_train", "train_factorial"):  # study_train reads its samples from a file
            assert "dataset:sample_motion " in digests and "dynamics:regressor " in digests, rule.name
        if rule.name in ("study_arms", "study_train"):  # nor does a level of the study, or the size of its jobs
            assert not {"discrepancies", "cells_per_job"} & set(config["study"]), rule.name


@pytest.mark.parametrize(("reader", "other"), [("plain", "cnn"), ("cnn", "plain")])
def test_a_network_of_the_factorial_depends_on_its_own_training(rules, reader, other):
    trainers = {"plain": "repro_studies.plain:train", "cnn": "repro.cnn.train:train"}
    cell = next(name for name, cell in CELLS.items() if cell.reader == reader)
    digests = rules["train_factorial"].params.code(SimpleNamespace(cell=cell))
    assert trainers[reader] in digests
    assert trainers[other] not in digests


def test_each_function_is_given_what_it_names(working):
    assert len(working) > 20
    for rule in working:
        module, _, name = rule.params[0].partition(":")
        parameters = signature(getattr(import_module(module), name)).parameters
        given = {*rule.wildcard_names, "files", "inputs", "outputs"}
        given |= {*rule.input.keys(), *rule.output.keys(), *rule.params.keys()}
        assert {name for name, one in parameters.items() if one.default is one.empty} <= given, rule.name


def test_inputs_are_named_as_files(rules):
    """A job of a cluster would check the rule of an input that is named as a rule's output, and run it again."""
    assert [name for name, rule in rules.items() if rule.dependencies] == []


def test_every_job_runs_the_one_script(working):
    scripts = {script.name for script in (WORKFLOW / "scripts").glob("*.py")}
    assert {Path(rule.script).name for rule in working} == scripts == {"call.py"}


def test_emulated_hosts_run_tests_that_exist_with_their_variables():
    hosts = runpy.run_path(str(ROOT / ".ci" / "hosts.py"))
    names = {name for host in hosts["HOSTS"] for name in host.tests}
    assert len(names) > 10
    assert [name for name in names if not list((ROOT / "tests").rglob(f"test_{name}.py"))] == []
    host = hosts["Host"]("another", {"OPENBLAS_CORETYPE": "Zen"}, program=("env", "KEPT=1"))
    printed = hosts["run"](host, "-c", "import os; print(os.environ['OPENBLAS_CORETYPE'], os.environ['KEPT'])").stdout
    assert printed.split() == ["Zen", "1"]
    assert "FAILED: no message" in hosts["visit"](hosts["Host"]("broken", program=("false",)))[0]


def test_each_rule_that_the_page_of_results_names_is_there():
    rules = {
        rule for path in ROOT.glob("workflow/**/*.smk") for rule in re.findall(r"^rule (\w+):", path.read_text(), re.M)
    }
    drawn = {name for exhibit in catalogue.EXHIBITS for name in (exhibit.name, exhibit.target)}
    page = (ROOT / "results/README.md").read_text(encoding="utf-8")
    named = {name for row in re.findall(r"^\|.*\|(.*)\|$", page, re.M) for name in re.findall(r"`(\w+)`", row)}
    assert len(named) > 15
    assert named - {"tableNN", "figNN"} <= rules | drawn
