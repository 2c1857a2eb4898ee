"""Make the locks of running, of the tests, of the board in logic and of the site from ``pyproject.toml``.

Usage: ``make lock``, or ``python envs/lock.py`` in an environment with uv.

uv resolves the dependencies for all Pythons and platforms at once: a package has one version everywhere, and a marker
if only some of them need it. Two things differ from what uv writes. The CUDA libraries that the registry's build of
PyTorch requires are left out, and its CPU wheels (``requirements-cpu.lock``), which the registry does not have, are
allowed as well. Settings of uv and pip are ignored, so that everyone makes the same locks.
"""

import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterable
from pathlib import Path

import uv

ROOT = Path(__file__).resolve().parent.parent
#: Extras that a reproduction needs.
RUNTIME_EXTRAS = ("cnn", "workflow")
CUDA = re.compile(r"(nvidia|cuda)-.*|triton")


def resolve(python: str) -> dict[str, str]:
    """Lines of each package that the project requires with its extras on a Python and all later ones, by name."""
    options = "--universal --fork-strategy=fewest --all-extras --generate-hashes --annotation-style=line"
    command = [uv.find_uv_bin(), "pip", "compile", "--quiet", "--no-config", "--no-header", *options.split()]
    command += [f"--python-version={python}", "pyproject.toml"]
    environment = {name: value for name, value in os.environ.items() if not name.startswith("UV_")}
    text = subprocess.check_output(command, cwd=ROOT, env=environment, text=True)
    packages = re.split(r"\n(?=\w)", text.strip().replace("repro-arm (pyproject.toml)", "repro-arm"))
    named = {package.partition("==")[0]: package for package in packages}
    if len(named) < len(packages):
        sys.exit("error: pyproject.toml: found a package of which two Pythons need two versions, expected one for all")
    return {name: package for name, package in named.items() if not CUDA.fullmatch(name)}


def needed_by(requirements: Iterable[str], packages: dict[str, str]) -> set[str]:
    """Names of the packages that requirements name and of all that these require, directly or not."""
    found: set[str] = set()
    new = {re.sub(r"[-_.]+", "-", re.split(r"[^\w.-]", requirement)[0]).lower() for requirement in requirements}
    wanted_by = {name: set(lines.partition("# via ")[2].split(", ")) for name, lines in packages.items()}
    while new:
        found |= new
        new = {name for name, users in wanted_by.items() if users & found} - found
    return found


def main() -> None:
    """Resolve the project and write the locks."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras, pythons = project["optional-dependencies"], project["requires-python"]
    packages = resolve(re.findall(r"[\d.]+", pythons)[0])
    cpu = re.findall(r"--hash=\S+", (ROOT / "requirements-cpu.lock").read_text(encoding="utf-8"))
    packages["torch"] = packages["torch"].replace("\n", "".join(f"\n    {each} \\" for each in cpu) + "\n", 1)
    needed = [*project["dependencies"], *(each for extra in RUNTIME_EXTRAS for each in extras[extra])]
    runtime = needed_by(needed, packages)
    tests = needed_by([*needed, *extras["test"]], packages)
    logic, site = (needed_by(extras[extra], packages) for extra in ("rtl", "site"))
    locks = {
        "requirements.lock": ("running the project", runtime),
        "requirements-test.lock": ("the tests, besides requirements.lock", tests - runtime),
        "requirements-rtl.lock": ("the board in logic, besides the two locks above", logic - tests),
        "requirements-site.lock": ("the site of the pages, in an environment of its own", site),
    }
    for file, (what, names) in locks.items():
        command = f"python -m pip install --no-deps --require-hashes -r {file}"
        head = f"# Packages of {what}.\n# Made by `make lock` for Python {pythons}; install with\n#   {command}"
        lines = [packages[name] for name in sorted(names)]
        (ROOT / file).write_text("\n".join([head, *lines]) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
