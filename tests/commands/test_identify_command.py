"""`repro identify` as a user runs it: on a table, on captures, on a port; and refused without a trace."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import torch
from experiment_example import CAPTURES, ROOT, refusal_in
from fitting_problem import FILES, write_log
from log_example import BETA, motion

from repro.cli import main
from repro.cnn import architecture
from repro.identification.algorithm1 import own_network as algorithm1
from repro.identification.algorithm1.search import SearchSettings
from repro.model.parameters import NAMES

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("no_figures")]


@pytest.fixture
def log(tmp_path):
    """A good log as a file."""
    return write_log(tmp_path / "log.csv")


def identify(*arguments):
    return main(["identify", *map(str, arguments)])


def found(folder, method):
    """Estimates of a method from the JSON file, shape (9,)."""
    result = json.loads((folder / "parameters.json").read_text())
    rows = next(m for m in result["methods"] if m["method"] == method)["parameters"]
    assert [row["name"] for row in rows] == list(NAMES)
    return np.array([row["estimate"] for row in rows])


@pytest.mark.parametrize(
    ("role", "name", "content"),
    [
        ("log", "scores.csv", None),
        ("--validate", "residuals.csv", None),
        ("--arm", "no-links.txt", "gravity: 9.81\n"),
        ("--prior", "parameters.json", '{"g1": {"value": 3.2, "sd": 0.1}}'),
    ],
)
def test_an_input_in_the_output_folder_is_not_replaced(log, tmp_path, capsys, role, name, content):
    out = tmp_path / "out"
    out.mkdir()
    own = out / name
    own.write_text(content or log.read_text().rpartition("\n11.")[0])  # less one sample, so that it is another log
    before = own.read_bytes()
    given = [own] if role == "log" else [log, role, own]
    assert identify(*given, "--method", "ordinary", "-o", out, "--overwrite") == 2
    assert refusal_in(capsys.readouterr().err.splitlines()[-1]).place == str(own)
    assert [path.name for path in out.iterdir()] == [name]
    assert own.read_bytes() == before


def test_every_option_reaches_the_function(log, tmp_path, monkeypatch):
    given, arm, prior = {}, tmp_path / "arm.yaml", tmp_path / "prior.json"
    arm.write_text("gravity: 9.7\n")
    monkeypatch.setattr("repro.commands.boards.record", lambda _: 0)
    monkeypatch.setattr(
        "repro.fitting.api.identify", lambda log, **options: given.update(options, log=log) or sys.exit(7)
    )
    options = [
        "--validate",
        log,
        "--arm",
        arm,
        "--filter",
        "butterworth",
        "--cutoff",
        7.5,
        "--no-friction",
        "--seed",
        6,
    ]
    options += [
        "--prior",
        prior,
        "--self-test",
        "--steps",
        9,
        "--cache",
        tmp_path,
        "--method",
        "weighted",
        "--earlier",
        prior,
    ]
    with pytest.raises(SystemExit, match="7"):
        identify("socket://a:1", "socket://b:1", *options, "-o", tmp_path / "out")
    kept = {"log": [tmp_path / f"out-recording-{k}.bin" for k in (1, 2)]}  # of each port
    kept |= {
        "validate": [log],
        "arm": arm,
        "filter": "butterworth",
        "cutoff": 7.5,
        "friction": False,
        "seed": 6,
        "earlier": prior,
    }
    kept |= {"prior": prior, "self_test": True, "steps": 9, "cache": tmp_path, "method": ["weighted"]}
    assert given == kept


def test_a_table_gives_back_the_parameters_that_made_it(log, tmp_path, capsys):
    out = tmp_path / "out"
    assert identify(log, "--method", "ordinary", "--method", "consistent", "--self-test", "-o", out) == 0
    assert sorted(path.name for path in out.iterdir()) == FILES
    for method in ("ordinary", "consistent"):
        assert found(out, method) == pytest.approx(BETA, rel=0.02)
    told = capsys.readouterr().out
    assert all(f"  {name} = " in told for name in NAMES)
    unseen = re.search("could contain these calibration errors undetected: zero of joint 1 up to .* degrees", told)
    assert unseen
    assert unseen[0] in re.sub("<[^>]+>", "", (tmp_path / "out/report.html").read_text(encoding="utf-8"))
    test = json.loads((out / "parameters.json").read_bytes())["selftest"]
    assert [row["true"] for row in test["parameters"]] == pytest.approx(found(out, test["method"]))


def test_no_links_are_exported_from_a_parameter_that_the_motion_does_not_excite(tmp_path):
    log = write_log(tmp_path / "log.csv", lambda t: motion(t) * np.array([[1.0], [0.0]]), seconds=10.0)
    assert identify(log, "--method", "weighted", "-o", tmp_path / "out") == 0
    assert not (tmp_path / "out" / "arm.urdf").exists()
    assert (tmp_path / "out" / "no-links.txt").exists()


@pytest.fixture
def small_budgets(monkeypatch):
    """A network tested on few images, and a short search with it."""
    few = SearchSettings(executions=4, inner_limit=3, threshold=0.9237, feasibility="positive-definite")
    short = algorithm1.RefinementSettings(passes=60)
    small = partial(architecture.TrainingSettings, test_samples=64, batch=16)
    monkeypatch.setattr(architecture, "TrainingSettings", small)
    monkeypatch.setattr(algorithm1, "NetworkSearch", partial(algorithm1.NetworkSearch, search=few, refinement=short))


def test_a_network_is_trained_once_for_each_arithmetic(log, tmp_path, capsys, small_budgets, monkeypatch):
    monkeypatch.setattr(algorithm1, "on_this_processor", lambda precision: "float32")
    changes = [None, None]  # the network of the first run is read again
    changes += [(torch, "__version__", "1.0"), (torch.backends.cpu, "get_cpu_capability", lambda: "DEFAULT")]
    changes += [(algorithm1, "on_this_processor", lambda precision: "bfloat16")]
    common = (log, "--method", "algorithm1", "--steps", 2, "--cache", tmp_path / "cache")
    for number, change in enumerate(changes):
        if change:
            monkeypatch.setattr(*change)
        assert identify(*common, "-o", tmp_path / f"{number}") == 0
        assert ("training the CNN" in capsys.readouterr().err) == (number != 1)
        assert len(list((tmp_path / "cache").iterdir())) == max(number, 1)
    assert (tmp_path / "0" / "parameters.json").read_bytes() == (tmp_path / "1" / "parameters.json").read_bytes()


def test_algorithm_1_and_its_refinement_share_one_run(log, tmp_path, small_budgets, monkeypatch):
    runs, run = [], algorithm1.Algorithm1.run
    monkeypatch.setattr(algorithm1.Algorithm1, "run", lambda *given: runs.append(run(*given)) or runs[-1])
    seeds, stream = set(), algorithm1.stream
    monkeypatch.setattr(algorithm1, "stream", lambda seed, kind: seeds.add(seed) or stream(seed, kind))
    out, both = tmp_path / "out", ("--method", "algorithm1", "--method", "algorithm1+refinement")
    assert identify(log, "--steps", 2, "--seed", 6, "--cache", tmp_path / "cache", *both, "-o", out) == 0
    assert seeds == {6}
    ((estimates, *_),) = runs
    for method in both[1::2]:
        assert found(out, method).tolist() == estimates[method].beta.tolist()
    assert found(out, "algorithm1").tolist() != found(out, "algorithm1+refinement").tolist()
    content = json.loads((out / "parameters.json").read_text())
    (note,) = next(m["notes"][:1] for m in content["methods"] if m["method"] == "algorithm1+refinement")
    reached = [estimates[f"algorithm1+{name}"].details["similarity"] for name in ("refinement", "local-search")]
    assert [float(number) / 100 for number in re.findall(r"[\d.]+(?= %)", note)] == pytest.approx(reached, abs=5.1e-5)


def test_a_port_is_recorded_from_and_the_recording_kept(tmp_path):
    link = tmp_path / "board"
    command = [sys.executable, "-m", "repro", "simulate", "--as-fast-as-possible", "--link", str(link)]
    board = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, cwd=ROOT)
    out = tmp_path / "out"
    try:
        port = board.stdout.readline().strip()
        assert identify(port, "--config", ROOT / "config/config.yaml", "--method", "ordinary", "-o", out) == 0
    finally:
        board.send_signal(signal.SIGTERM)
        board.communicate(timeout=10)
    assert (tmp_path / "out-recording.bin").read_bytes() == (CAPTURES / "ID.bin").read_bytes()
    assert (out / "report.html").exists()


@pytest.mark.parametrize(
    ("arguments", "place", "found"),
    [
        (["nothing.csv", "-o", "out"], "nothing.csv", ""),
        (["log.csv", "-o", "full"], "full", ""),
        (["log.csv", "-o", "out", "--arm", "degrees.yaml"], "degrees.yaml: zero[0]", "180"),
        (["/dev/ttyNOPE", "-o", "out", "--config", "gone.yaml"], "/dev/ttyNOPE", "no such port"),
        (["socket://127.0.0.1:1", "-o", "out"], "port socket://127.0.0.1:1", "one that cannot be opened"),
        (["log.csv", "-o", "out", "--cutoff", "90"], "--cutoff", "90 Hz"),
        (["short.csv", "-o", "out"], "short.csv", ""),
        (["validate_run.csv", "-o", "out"], "validate_run.csv", "no such file"),
        (["log.csv", "-o", "out", "--validate", "copy.csv"], "--validate: copy.csv", "the samples of log.csv"),
        (["log.csv", "copy.csv", "-o", "out"], "copy.csv", "the samples of log.csv"),
        (["log.csv", "short.csv", "-o", "out", "--method", "algorithm1"], "--method", ""),
        (["log.csv", "-o", "out", "--method", "algorithm1", "--cache", "log.csv"], "--cache: log.csv", ""),
    ],
)
def test_bad_input_is_one_line_and_leaves_nothing(log, tmp_path, monkeypatch, capsys, arguments, place, found):
    monkeypatch.chdir(tmp_path)
    Path("full").mkdir()
    Path("full/kept.txt").write_text("mine")
    Path("degrees.yaml").write_text("zero: [180, 0]\nunits: {position: deg}\n")
    Path("copy.csv").write_bytes(log.read_bytes())
    Path("short.csv").write_text("".join(log.read_text().splitlines(keepends=True)[:10]))
    before = sorted(Path().rglob("*"))
    assert identify(*arguments, "--method", "ordinary") == 2
    lines = capsys.readouterr().err.strip().splitlines()
    error = refusal_in(lines[-1])
    assert error.place == place and error.found.startswith(found) and "Traceback (most recent call last):" not in lines
    assert sorted(Path().rglob("*")) == before
    assert Path("full/kept.txt").read_text() == "mine"


def test_a_log_too_short_for_an_image_is_reported_without_a_traceback(log, tmp_path, capsys):
    brief = tmp_path / "brief.csv"
    brief.write_text("".join(log.read_text().splitlines(keepends=True)[:442]))
    low = ("--cutoff", 1.5)  # leaves few samples that differ
    assert identify(brief, *low, "--method", "algorithm1", "--cache", tmp_path / "cache", "-o", tmp_path / "out") == 2
    assert "100" in capsys.readouterr().err  # samples of an image
    assert not (tmp_path / "out").exists()


def test_a_method_is_a_function_and_an_entry(log, tmp_path):
    """The example of docs/architecture.md in a copy of the package."""
    shutil.copytree(ROOT / "src" / "repro", tmp_path / "repro", ignore=shutil.ignore_patterns("__pycache__"))
    guide = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    function = re.search(r"^def ridge.*?^    return [^\n]*\n", guide, re.M | re.S)[0]
    entry = re.search(r"^\((Method\(\"ridge\".*,)\)$", guide, re.M)[1].replace("hoerl1970ridge", "gautier1992exciting")
    folder = tmp_path / "repro" / "identification"
    code = (folder / "least_squares.py").read_text()
    code = code.replace("METHODS: dict", f"{function}\n\nMETHODS: dict")
    (folder / "least_squares.py").write_text(code.replace("    for method in (\n", f"    for method in (\n{entry}\n"))
    names = (folder / "method.py").read_text()
    (folder / "method.py").write_text(names.replace("LEAST_SQUARES = (", 'LEAST_SQUARES = ("ridge", '))
    without = "from repro.fitting import outputs; outputs.figures_of = lambda *_: {}; from repro.cli import main; "
    options = [str(log), "--method", "ridge", "-o", str(tmp_path / "out")]
    command = [sys.executable, "-c", f"{without}raise SystemExit(main(['identify', *{options}]))"]
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    run = subprocess.run(command, env=environment, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    assert found(tmp_path / "out", "ridge")[3:5] == pytest.approx(BETA[3:5], rel=0.05)


@pytest.mark.skipif(not Path("/dev/shm").is_dir(), reason="no folder below /dev to write to")
def test_a_file_below_dev_is_read_and_its_sidecar_not_replaced(tmp_path):
    with tempfile.TemporaryDirectory(dir="/dev/shm") as folder:
        for file in CAPTURES.glob("T3.*"):
            shutil.copy(file, Path(folder) / f"parameters{file.suffix}")
        for out, code in ((tmp_path / "out", 0), (folder, 2)):
            capture = Path(folder) / "parameters.bin"
            assert identify(capture, "--method", "ordinary", "-o", out, "--overwrite") == code
