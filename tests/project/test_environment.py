"""The locks, the conda environment and pyproject.toml name the same versions; set-up refuses what cannot work."""

import os
import re
import runpy
import shutil
import subprocess
import sys
import tomllib
import warnings
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet
from packaging.utils import canonicalize_name
from packaging.version import Version

ROOT = Path(__file__).resolve().parents[2]
LOCK_FILES = [f"requirements{part}.lock" for part in ("-cpu", "-uv", "", "-test", "-rtl", "-site")]
PYTHONS = ["3.11", "3.12", "3.13"]
CONDA_NAMES = {"matplotlib-base": "matplotlib", "pytorch": "torch", "snakemake-minimal": "snakemake"}
CONDA_ONLY = ("python=", "pip")


def read_lock(name):
    """Requirements of a lock and the hashes of each, by name; fails on a line that is not a requirement."""
    requirements, hashes = {}, {}
    text = re.sub(r"^ *#.*\n", "", (ROOT / name).read_text(encoding="utf-8"), flags=re.MULTILINE)
    for line in text.replace(" \\\n", " ").splitlines():
        head, *options = line.split("    --hash=sha256:")
        requirement = Requirement(head)
        key = canonicalize_name(requirement.name)
        assert key not in requirements, f"{name}: {key} is listed twice"
        assert all(re.fullmatch(r"[0-9a-f]{64} ?", option) for option in options), f"{name}: {key} has a broken hash"
        requirements[key], hashes[key] = requirement, {option.strip() for option in options}
    return requirements, hashes


def pinned(requirement):
    """Version of a requirement of the form ``name==version``."""
    (specifier,) = requirement.specifier
    assert specifier.operator == "==", requirement
    return Version(specifier.version)


LOCKS = {file: read_lock(file) for file in LOCK_FILES}
(CPU, CPU_HASHES), (UV, _), (RUNTIME, RUNTIME_HASHES), (TEST, _), (RTL, _), (SITE, _) = LOCKS.values()
LOCK = {**RUNTIME, **TEST}
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
BUILD = [*map(Requirement, PYPROJECT["build-system"]["requires"])]
EXTRAS = {name: [*map(Requirement, texts)] for name, texts in PYPROJECT["project"]["optional-dependencies"].items()}
DIRECT = [*map(Requirement, PYPROJECT["project"]["dependencies"]), *EXTRAS["cnn"], *EXTRAS["workflow"]]


def test_every_file_of_the_package_is_installed():
    folder, patterns = ROOT / "src/repro", PYPROJECT["tool"]["setuptools"]["package-data"]["repro"]
    others = {path for path in folder.rglob("*.*") if path.suffix != ".py" and "__pycache__" not in path.parts}
    assert others == {path for pattern in patterns for path in folder.glob(pattern)}


def conda_pins():
    """Versions of ``envs/repro.yaml`` by the name that pip knows them by."""
    *conda, pip = yaml.safe_load((ROOT / "envs" / "repro.yaml").read_text(encoding="utf-8"))["dependencies"]
    pins = dict(line.split("==") for line in pip["pip"])
    for name, version in (entry.split("=")[:2] for entry in conda if not entry.startswith(CONDA_ONLY)):
        pins[CONDA_NAMES.get(name, name)] = version
    return {canonicalize_name(name): Version(version) for name, version in pins.items()}


def test_every_locked_package_is_pinned_and_has_hashes():
    for file, (requirements, hashes) in LOCKS.items():
        for name, requirement in requirements.items():
            local = pinned(requirement).local
            assert local is None or file == "requirements-cpu.lock", f"{name}: a local version fits one index only"
            assert requirement.url is None
            assert hashes[name], f"{name}: no hash"
    assert not RUNTIME.keys() & TEST.keys()


@pytest.mark.parametrize("file", LOCK_FILES)
def test_the_lock_names_no_place_and_no_cuda_library(file):
    text = (ROOT / file).read_text(encoding="utf-8")
    assert not re.search(r"://|--(extra-)?index-url|--find-links|--trusted-host|(^|\s)-[ifce]\s|/", text, re.MULTILINE)
    assert not [name for name in LOCKS[file][0] if name.startswith(("nvidia-", "cuda-")) or name == "triton"]


@pytest.mark.parametrize("python", PYTHONS)
def test_direct_dependencies_are_locked_within_their_range(python):
    others = (BUILD, RUNTIME), (EXTRAS["test"], LOCK), (EXTRAS["rtl"], {**LOCK, **RTL}), (EXTRAS["site"], SITE)
    for requirements, lock in ((DIRECT, RUNTIME), *others):
        for requirement in requirements:
            locked = lock[canonicalize_name(requirement.name)]
            assert requirement.specifier.contains(pinned(locked)), f"{locked} does not satisfy {requirement}"
            marker = locked.marker
            assert marker is None or marker.evaluate({"python_version": python, "python_full_version": python + ".1"})


def test_python_range_is_the_one_locked():
    pythons = PYPROJECT["project"]["requires-python"]
    allowed = SpecifierSet(pythons)
    assert [minor for minor in range(8, 20) if allowed.contains(f"3.{minor}.1")] == [11, 12, 13]
    for file in LOCK_FILES[2:]:
        assert f"for Python {pythons};" in (ROOT / file).read_text(encoding="utf-8").splitlines()[1]


def test_conda_has_every_direct_dependency_in_the_version_of_the_lock():
    pins = conda_pins()
    assert {name: pinned(LOCK[name]) for name in pins} == pins
    assert {canonicalize_name(requirement.name) for requirement in [*DIRECT, *EXTRAS["test"], *BUILD]} == pins.keys()


def test_torch_is_pinned_everywhere_and_its_cpu_wheels_are_allowed():
    (direct,) = [requirement for requirement in DIRECT if requirement.name == "torch"]
    assert pinned(direct) == pinned(RUNTIME["torch"]) == conda_pins()["torch"] == Version("2.13.0")
    assert {name: str(pinned(requirement)) for name, requirement in CPU.items()} == {"torch": "2.13.0+cpu"}
    assert len(CPU_HASHES["torch"]) == len(PYTHONS)
    assert CPU_HASHES["torch"] < RUNTIME_HASHES["torch"], "the registry's own wheels are missing"


needs_make = pytest.mark.skipif(shutil.which("make") is None, reason="make is not installed")


def make(folder, *arguments):
    """Run `make` as a user does, also where `make` itself runs this test."""
    environment = {key: value for key, value in os.environ.items() if not key.startswith(("MAKE", "MFLAGS"))}
    command = ["make", *arguments]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)


def planned(folder, target):
    """Commands that `make` would run."""
    return make(folder, "--dry-run", target).stdout


@pytest.fixture
def folder(tmp_path):
    """What `make` needs to set the environment up."""
    for name in ("Makefile", *LOCK_FILES, "pyproject.toml"):
        shutil.copy(ROOT / name, tmp_path)
    return tmp_path


@needs_make
@pytest.mark.parametrize("file", ["requirements-cpu.lock", *LOCK_FILES[2:4], "pyproject.toml"])
def test_another_lock_makes_another_environment(folder, file):
    before = planned(folder, "setup-test")
    with (folder / file).open("a", encoding="utf-8") as changed:
        changed.write("#\n")
    assert planned(folder, "setup-test") != before


@needs_make
def test_every_check_is_one_of_make_test():
    commands = planned(ROOT, "test")
    checks = ("ruff check", "ruff format --check", "mypy", "lint-imports", "snakefmt --check", "--lint", "pytest")
    assert [name for name in checks if name not in commands] == []
    assert planned(ROOT, "golden").rstrip().endswith(".ci/golden.py")


@needs_make
@pytest.mark.parametrize(("answer", "found"), [("Python 3.10.4", "Python 3.10.4"), ("", "()")])
def test_set_up_refuses_an_interpreter_that_cannot_work_in_one_line(folder, answer, found):
    interpreter = folder / "old-python"
    interpreter.write_text(f'#!/bin/sh\n[ "$1" = -V ] && echo "{answer}"\nexit 1\n', encoding="utf-8")
    interpreter.chmod(0o755)
    run = make(folder, "--silent", "reproduce", f"PYTHON={interpreter}")
    (line,) = (line for line in run.stderr.splitlines() if not line.startswith("make:"))
    assert run.returncode != 0
    assert line.startswith("error: PYTHON: found ")
    assert found in line and "expected Python 3.11 to 3.13" in line
    assert not (folder / ".venv").exists()


@needs_make
@pytest.mark.parametrize(
    ("version", "accepted"), [((3, 10, 9), False), ((3, 11, 0), True), ((3, 13, 5), True), ((3, 14, 0), False)]
)
def test_set_up_accepts_the_versions_that_it_names(folder, version, accepted):
    interpreter, code = folder / "python", f"import sys; sys.version_info = {version}; exec(sys.argv[1])"
    call = f'[ "$1" = -c ] && exec {sys.executable} -c "{code}" "$2"\nexec {sys.executable} "$@"\n'
    interpreter.write_text(f"#!/bin/sh\n{call}", encoding="utf-8")
    interpreter.chmod(0o755)
    assert (make(folder, "--silent", "check-python", f"PYTHON={interpreter}").returncode == 0) is accepted


@needs_make
def test_a_path_that_the_shell_would_split_is_refused_in_one_line(folder):
    blank = folder / "my user's folder"
    blank.mkdir()
    shutil.copy(ROOT / "Makefile", blank)
    run = make(blank, "--silent", "setup", f"PYTHON={sys.executable}")
    (line,) = (line for line in run.stderr.splitlines() if not line.startswith("make:"))
    assert run.returncode != 0
    assert line.startswith(f"error: folder: found {blank}, expected ")
    assert not (blank / ".venv").exists()


@pytest.fixture
def set_up(tmp_path, monkeypatch, capsys):
    """Run the set-up, where programs that match `failing` fail; commands, output, and why it ended."""

    def run(failing="never", torch=True):
        module, commands = runpy.run_path(str(ROOT / "envs/install.py")), []

        def fake(*command):
            text = " ".join(map(str, command))
            commands.append(text)
            if "import torch" in text:
                return torch, ""
            failed = re.search(failing, text)
            return not failed, "WARNING: slow\nERROR: a first line\nERROR: not there" if failed else ""

        monkeypatch.setitem(module["main"].__globals__, "run", fake)
        monkeypatch.setattr(sys, "prefix", str(tmp_path))
        try:
            module["main"]()
        except SystemExit as ended:
            return commands, capsys.readouterr().out, str(ended)
        return commands, capsys.readouterr().out, ""

    return run


def test_the_cpu_build_comes_from_pip_else_from_uv(set_up):
    commands, printed, ended = set_up()
    installed = [Path(text).name for text in commands[:3]]
    assert installed == ["requirements.lock", "requirements-cpu.lock", "requirements.lock"]
    assert "190 MB" in printed and "2.7 GB" not in printed and not ended
    commands, printed, ended = set_up("-m pip .*requirements-cpu.lock")
    assert commands[2].endswith("requirements-uv.lock")
    assert "--torch-backend cpu" in commands[3] and "--require-hashes" in commands[3]
    assert "2.7 GB" not in printed and not ended


def test_without_the_cpu_build_its_size_is_printed_and_its_libraries_are_added(set_up):
    commands, printed, ended = set_up("requirements-(cpu|uv).lock", torch=False)
    assert "2.7 GB" in printed and "ERROR: not there" in printed and not ended
    assert commands[-1].endswith("--no-compile torch==2.13.0")
    assert not any("--torch-backend" in text for text in commands)


def test_a_set_up_without_packages_ends_with_one_line(set_up):
    commands, _, ended = set_up(r"requirements\.lock")
    assert len(commands) == 1
    assert ended.splitlines()[:2] == ["ERROR: a first line", "ERROR: not there"]
    assert ended.splitlines()[2].startswith("error: requirements.lock: found ")


@pytest.mark.parametrize(
    ("make", "last"),
    [
        ('[ "$1" != test ]', "== checks and tests"),
        ("true", "error: the second golden run had"),
        ("echo 'Nothing to be done'", "error: the second golden run had"),  # one of its two calls of Snakemake alone
    ],
)
def test_ci_ends_at_the_first_check_that_fails(tmp_path, make, last):
    programs = tmp_path / "programs"
    (tmp_path / ".ci").mkdir()
    programs.mkdir()
    script = Path(shutil.copy(ROOT / ".ci" / "run", tmp_path / ".ci"))
    for name in ("make", "g++", "chromium", "qemu-x86_64"):
        (programs / name).write_text(f"#!/bin/sh\n{make}\n", encoding="utf-8")
        (programs / name).chmod(0o755)
    environment = {**os.environ, "PATH": f"{programs}:{os.environ['PATH']}", "PYTHON": sys.executable}
    run = subprocess.run([script], env=environment, capture_output=True, text=True, check=False)
    assert run.returncode != 0
    assert run.stdout.splitlines()[-1].startswith(last)
    # A test that is skipped without a browser is looked for in what pytest names.
    assert len(re.findall("-m pytest.* tests/browser .*-rs 2>&1", script.read_text(encoding="utf-8"))) == 2


def test_a_numerical_warning_of_the_package_is_an_error():
    with pytest.raises(RuntimeWarning):
        warnings.warn_explicit("overflow", RuntimeWarning, "dynamics.py", 1, module="repro.model.dynamics")


def test_the_container_runs_the_first_command_of_the_readme():
    (target,) = re.findall(r"^make (\w+)", (ROOT / "README.md").read_text(encoding="utf-8"), re.MULTILINE)[:1]
    lines = (ROOT / "Containerfile").read_text(encoding="utf-8").splitlines()
    run = [line for line in lines if line.startswith(("ENTRYPOINT", "CMD"))]
    assert run == ['ENTRYPOINT ["make"]', f'CMD ["{target}"]']
    assert [line for line in lines if line.startswith("USER")][-1:] == ["USER repro"]  # who does not own the system
