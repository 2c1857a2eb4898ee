"""The record of a run: every file with its hash, by the job that wrote it, and what a claim costs."""

import base64
import hashlib
import json
import subprocess
from pathlib import Path

import pandas as pd
import pytest

from repro.experiments.record import changed_files, recorded_jobs, write_costs, write_crate
from repro.provenance import commit

RESULTS = Path("results")
LONG = "results/data/" + "/".join(["long" * 20] * 4) + "/ä b.csv"  # more than a file name holds
RECORDED, DRAWN = ["results/experiment/ID.bin", LONG], ["results/tables/table10.csv", "paper_figures/t.png"]
#: Name, files read, files written, benchmark.
JOBS = (
    ("acquire-ID", ["data/ID.bin"], RECORDED, "60.0\t200.5\t50"),
    ("table10", RECORDED, DRAWN, "30\t100\t25"),
    ("claims", DRAWN[:1], ["results/claims.csv"], "6\tNA\tNA"),
)
CLAIMS = "id,target,note\na,table10,\nb,config/config.yaml,\nc,,\nd,claims,\n"


def write(path, text):
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    Path(path).write_text(text, encoding="utf-8")


def note(name, inputs, outputs, results="results"):
    """Say what Snakemake says of a job that it ran."""
    said = {"rule": name.split("-")[0], "input": inputs, "log": [f"{results}/logs/{name}.log"]}
    for output in outputs:
        code = base64.urlsafe_b64encode(output.encode()).decode()
        *first, last = (code[i : i + 254] for i in range(0, len(code), 254))
        path = Path(".snakemake/metadata", *(f"@{part}" for part in first), last)
        write(path, json.dumps({**said, "starttime": 1e9, "endtime": 1e9 + 61}))


@pytest.fixture(autouse=True)
def run(tmp_path, monkeypatch):
    """A folder with a small run in it."""
    monkeypatch.chdir(tmp_path)
    for name, inputs, outputs, measured in JOBS:
        note(name, inputs, outputs)
        write(f"results/benchmarks/{name}.tsv", f"s\tmax_rss\tcpu_time\n{measured}\n")
        for path in (*inputs, *outputs):
            write(path, f"content of {path}")
    write("results/claims.csv", CLAIMS)
    said = {"commit": "abc", "finished": "2026-01-01T00:00:00+00:00", "packages": {"snakemake": "9", "torch": "2"}}
    write("results/logs/provenance.json", json.dumps(said))
    write("config/config.yaml", "results: results")
    write("workflow/Snakefile", "include: 'rules/x.smk'")
    write("workflow/rules/x.smk", "")


def record(results=RESULTS):
    write_crate(results, Path("workflow").absolute(), [Path("config/config.yaml")], recorded_jobs(results))
    content = json.loads((results / "ro-crate-metadata.json").read_text(encoding="utf-8"))
    return content["@context"], {entity["@id"]: entity for entity in content["@graph"]}


def files(graph):
    return {entity["name"]: entity for entity in graph.values() if "sha256" in entity}


def ids(references):
    return {reference["@id"] for reference in references}


def test_a_file_that_the_workflow_no_longer_has_leaves_the_record():
    write("workflow/rules/old.smk", "")
    record()
    Path("workflow/rules/old.smk").unlink()
    record()
    assert [path.name for path in (RESULTS / "workflow/rules").iterdir()] == ["x.smk"]


def test_every_file_is_there_with_its_hash_and_size():
    found = files(record()[1])
    of_the_run = {"results/logs/provenance.json", "results/workflow/Snakefile", "results/workflow/rules/x.smk"}
    of_the_run |= {"config/config.yaml"}
    assert found.keys() == {"data/ID.bin", *RECORDED, *DRAWN, "results/claims.csv", *of_the_run}
    for name, entity in found.items():
        content = Path(name).read_bytes()
        assert (entity["sha256"], int(entity["contentSize"])) == (hashlib.sha256(content).hexdigest(), len(content))


def test_a_job_says_what_it_read_and_made_and_what_that_took():
    _, graph = record()
    job = graph["#job-table10"]
    found = files(graph)
    assert ids(job["object"]) == {found[path]["@id"] for path in RECORDED}
    assert ids(job["result"]) == {found[path]["@id"] for path in DRAWN}
    assert graph[job["instrument"]["@id"]]["name"] == "table10"
    assert (job["startTime"], job["endTime"]) == ("2001-09-09T01:46:40+00:00", "2001-09-09T01:47:41+00:00")
    usage = {graph[key]["propertyID"]: graph[key]["value"] for key in ids(job["resourceUsage"])}
    assert usage == {"s": 30.0, "max_rss": 100.0, "cpu_time": 25.0}
    assert ids(graph["#run"]["object"]) == {found[path]["@id"] for path in ("data/ID.bin", "config/config.yaml")}
    assert ids(graph["#job-claims"]["resourceUsage"]) == {"#job-claims-s"}  # too short for its memory to be seen


def test_the_record_defines_its_words_and_knows_whom_it_names():
    context, graph = record()
    words = {word for entity in graph.values() for word in entity if not word.startswith("@")}
    values = [v if isinstance(v, list) else [v] for entity in graph.values() for v in entity.values()]
    types = set(pd.Series([entity["@type"] for entity in graph.values()]).explode())
    assert words | types == context.keys()
    named = {part["@id"] for value in values for part in value if isinstance(part, dict)}
    assert named - graph.keys() == {"https://w3id.org/ro/crate/1.1"}


def test_another_run_in_the_folder_below_is_another_record():
    note("fig01", [], ["results/smoke/fig01.csv"], "results/smoke")
    write("results/smoke/fig01.csv", "1")
    write("results/smoke/logs/provenance.json", Path("results/logs/provenance.json").read_text(encoding="utf-8"))
    assert "#job-fig01" not in record()[1]
    other = record(Path("results/smoke"))[1]
    assert [key for key in other if key.startswith("#job")] == ["#job-fig01", "#job-fig01-s"]


def test_a_claim_costs_all_that_its_number_hangs_on():
    write_costs(RESULTS, recorded_jobs(RESULTS))
    costs = pd.read_csv("results/logs/costs.csv", index_col="id")
    table = costs.loc["a"]
    assert (table["target"], table["jobs"], table["memory_mib"]) == ("table10", 2, 200.5)
    assert table[["minutes", "cpu_minutes"]].tolist() == pytest.approx([(60 + 30) / 60, (50 + 25) / 60])
    written = [Path(path).stat().st_size for path in (*RECORDED, *DRAWN)]
    assert table["disk_mb"] == pytest.approx(sum(written) / 1e6)
    assert costs.loc["b", "minutes"] == costs.loc["d", "minutes"] == pytest.approx(6 / 60)  # the ledger's own job
    assert costs.loc["c"].isna().all()


def test_the_commit_is_that_of_the_checkout_and_says_if_files_changed(tmp_path):
    def git(*arguments):
        name = ("-c", "user.name=A", "-c", "user.email=a@example.org")
        return subprocess.run(["git", *name, *arguments], check=True, capture_output=True, text=True).stdout.strip()

    assert commit(tmp_path) == "unknown"
    git("init", "-q")
    git("add", "config")
    git("commit", "-q", "-m", "one")
    assert commit(tmp_path) == git("rev-parse", "HEAD")
    write("config/config.yaml", "results: elsewhere")
    assert commit(tmp_path) == git("rev-parse", "HEAD") + "-dirty"


#: A file of a run, what happens to it, and what the message names.
TAMPERINGS = {
    "a capture": ("results/experiment/ID.bin", "x", "SHA-256: found"),
    "a file whose name is long": (LONG, "x", "SHA-256: found"),
    "a table": ("results/tables/table10.csv", "x", "SHA-256: found"),
    "a figure": ("paper_figures/t.png", "x", "SHA-256: found"),
    "an input": ("data/ID.bin", "x", "SHA-256: found"),
    "the provenance": ("results/logs/provenance.json", "{}", "SHA-256: found"),
    "the workflow": ("results/workflow/rules/x.smk", "x", "SHA-256: found"),
    "a missing table": ("results/tables/table10.csv", None, "found no file"),
    "a table more": ("results/tables/table11.csv", "x", "found a file"),
    "a missing figure": ("paper_figures/t.png", None, "found no file"),
    "a figure more": ("paper_figures/u.png", "x", "found a file"),
    "a folder more": ("results/new/further/table.csv", "x", "found a file"),
    "what a claim costs": ("results/logs/costs.csv", "x", "SHA-256: found"),
    "a file more": ("results/verified.txt", "x", "found a file"),
    "the record": ("results/ro-crate-metadata.json", "{}", "SHA-256: found"),
    "the seal": ("results/ro-crate-metadata.sha256", "0", "SHA-256: found"),
}


@pytest.mark.parametrize(("file", "text", "said"), TAMPERINGS.values(), ids=TAMPERINGS)
def test_each_change_of_a_finished_run_is_named(file, text, said):
    write_costs(RESULTS, recorded_jobs(RESULTS))
    record()
    write("results/logs/table10.log", "a log is no result")
    write("paper_figures/README.md", "of the project")
    assert changed_files(RESULTS, Path()) == []
    if text is None:
        Path(file).unlink()
    else:
        write(file, text)
    named = [line for line in changed_files(RESULTS, Path()) if line.startswith(("results/ro-crate", file))]
    assert named and said in named[0]


def test_a_run_without_a_record_and_another_one_within_it_are_left_alone():
    assert changed_files(RESULTS, Path()) == []
    record()
    write("results/quick/claims.csv", "another run")
    write("results/killed/logs/train.log", "a run that was killed")
    write("results/killed/model/training.csv", "step\n")
    assert changed_files(RESULTS, Path()) == []
