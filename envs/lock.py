"""Make the locks of running, of the tests, of the board in logic and of the site from ``pyproject.toml``.

Usage: ``python envs/lock.py python3.11 python3.12 python3.13`` (or ``make lock``).

Each interpreter resolves the dependencies with pip-tools in a throw-away environment. The first one's versions bind
the others, so that a package has one version everywhere; a package that only some interpreters need gets a marker.
Two things differ from what the resolver says: the CUDA libraries that the registry's build of PyTorch asks for are
left out, and PyTorch's CPU wheels (``requirements-cpu.lock``), which the registry does not hold, are allowed beside
its own files. Pip's configuration files and further indexes are ignored, so that the lock says the same everywhere.
"""

import os
import re
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
#: Extras that a reproduction needs.
RUNTIME_EXTRAS = ("cnn", "workflow")
PIP_TOOLS = "pip-tools==7.6.2"
CUDA = re.compile(r"(nvidia|cuda)-.*|triton")
ONE_REGISTRY = {k: v for k, v in os.environ.items() if k not in {"PIP_FIND_LINKS", "PIP_EXTRA_INDEX_URL"}}
ONE_REGISTRY["PIP_CONFIG_FILE"] = os.devnull
HEADERS = {
    "requirements.lock": (
        "What running the project needs.",
        "python -m pip install --no-deps --require-hashes -r requirements-cpu.lock -r requirements.lock",
    ),
    "requirements-test.lock": (
        "What the tests and checks need besides requirements.lock.",
        "python -m pip install --no-deps --require-hashes -r requirements-test.lock",
    ),
    "requirements-rtl.lock": (
        "What the board in logic needs besides requirements.lock and requirements-test.lock.",
        "python -m pip install --no-deps --require-hashes -r requirements-rtl.lock",
    ),
    "requirements-site.lock": (
        "What the site of the pages needs, in an environment of its own.",
        "python -m pip install --no-deps --require-hashes -r requirements-site.lock",
    ),
}


@dataclass
class Pin:
    """One locked package: its version, the files allowed, who asks for it and which Pythons need it."""

    version: str
    hashes: set[str] = field(default_factory=set)
    wanted_by: set[str] = field(default_factory=set)
    pythons: set[str] = field(default_factory=set)


def parse_compiled(text: str) -> dict[str, Pin]:
    """Read what pip-compile wrote.

    Parameters
    ----------
    text : str
        Requirements with ``--hash`` options and ``# via`` comments.

    Returns
    -------
    dict of str to Pin
        By package name; the local part of a version (``+cpu``) is dropped.
    """
    pins: dict[str, Pin] = {}
    for block in re.split(r"\n(?=[a-z0-9])", text):
        head = re.match(r"([a-z0-9._-]+)==([^\s;+]+)", block)
        if head is None:
            continue
        words = " ".join(re.findall(r"^ +# +(.*)$", block, flags=re.MULTILINE)).removeprefix("via").split()
        wanted_by = {word for word in words if re.fullmatch(r"[a-z0-9][a-z0-9._-]*", word)}
        pins[head[1]] = Pin(head[2], set(re.findall(r"--hash=(sha256:[0-9a-f]{64})", block)), wanted_by)
    return pins


def resolve(interpreter: str, folder: Path, constraints: Path) -> tuple[str, dict[str, Pin]]:
    """Resolve the project with its extras for one interpreter.

    Parameters
    ----------
    interpreter : str
        Command that starts it.
    folder : Path
        Empty folder for the throw-away environment.
    constraints : Path
        Requirements that bind the result.

    Returns
    -------
    python : str
        Version of the interpreter, such as ``3.11``.
    pins : dict of str to Pin
        What the resolver chose.
    """
    subprocess.run([interpreter, "-m", "venv", folder], check=True)
    python = folder / "bin" / "python"
    output = folder / "compiled.txt"
    subprocess.run([python, "-m", "pip", "install", "--quiet", PIP_TOOLS], check=True, env=ONE_REGISTRY)
    options = [
        *(f"--extra={extra}" for extra in (*RUNTIME_EXTRAS, "test", "rtl", "site")),
        "--generate-hashes",
        "--allow-unsafe",
        "--strip-extras",
        "--no-header",
        "--quiet",
    ]
    options += ["--no-emit-options", f"--constraint={constraints}", f"--output-file={output}"]
    command = [str(python), "-m", "piptools", "compile", *options, "pyproject.toml"]
    subprocess.run(command, cwd=ROOT, check=True, env=ONE_REGISTRY)
    show = "import sys; print('%d.%d' % sys.version_info[:2])"
    version = subprocess.run([python, "-c", show], check=True, capture_output=True, text=True).stdout.strip()
    return version, parse_compiled(output.read_text(encoding="utf-8"))


def merge(per_python: dict[str, dict[str, Pin]]) -> dict[str, Pin]:
    """Join the pins of all interpreters, leaving the CUDA libraries out.

    Raises
    ------
    SystemExit
        If two interpreters need different versions of a package.
    """
    merged: dict[str, Pin] = {}
    for python, pins in per_python.items():
        for name in sorted(n for n in pins if not CUDA.fullmatch(n)):
            known = merged.setdefault(name, Pin(pins[name].version))
            if known.version != pins[name].version:
                sys.exit(f"error: {name}: found {pins[name].version} for {python}, expected {known.version} as before")
            known.hashes |= pins[name].hashes
            known.wanted_by |= pins[name].wanted_by
            known.pythons.add(python)
    return merged


def needed_by(roots: Iterable[str], pins: dict[str, Pin]) -> dict[str, Pin]:
    """Pins of the packages named and of everything that they ask for, directly or not."""
    found: set[str] = set()
    new = {re.sub(r"[-_.]+", "-", re.split(r"[^\w.-]", root)[0]).lower() for root in roots}
    while new:
        found |= new
        new = {name for name, pin in pins.items() if pin.wanted_by & found} - found
    return {name: pins[name] for name in sorted(found)}


def render(pins: dict[str, Pin], pythons: Iterable[str], file: str) -> str:
    """Write pins as a requirements file, in the order of their names."""
    title, command = HEADERS[file]
    lines = [f"# {title}", f"# Made by `make lock` for Python {', '.join(pythons)}; install with", f"#   {command}"]
    for name, pin in pins.items():
        marker = ""
        if pin.pythons != set(pythons):
            marker = " ; " + " or ".join(f'python_version == "{python}"' for python in sorted(pin.pythons))
        lines.append(" \\\n    ".join([f"{name}=={pin.version}{marker}", *(f"--hash={h}" for h in sorted(pin.hashes))]))
        lines.append(f"    # via {', '.join(sorted(pin.wanted_by & {*pins, 'repro'}))}")
    return "\n".join(lines) + "\n"


def main(interpreters: Sequence[str]) -> None:
    """Resolve with every interpreter named and write the locks."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    per_python: dict[str, dict[str, Pin]] = {}
    with tempfile.TemporaryDirectory() as folder:
        constraints = Path(folder) / "constraints.txt"
        constraints.touch()
        for interpreter in interpreters:
            version, pins = resolve(interpreter, Path(folder) / f"environment{len(per_python)}", constraints)
            if not per_python:
                constraints.write_text("".join(f"{n}=={p.version}\n" for n, p in pins.items()), encoding="utf-8")
            per_python[version] = pins
    pins = merge(per_python)
    cpu = parse_compiled((ROOT / "requirements-cpu.lock").read_text(encoding="utf-8"))["torch"]
    if cpu.version != pins["torch"].version:
        sys.exit(f"error: requirements-cpu.lock: torch: found {cpu.version}, expected {pins['torch'].version}")
    pins["torch"].hashes |= cpu.hashes
    extras = project["optional-dependencies"]
    needed = [*project["dependencies"], *(text for name in RUNTIME_EXTRAS for text in extras[name])]
    runtime, everything = needed_by(needed, pins), needed_by([*needed, *extras["test"]], pins)
    extra = {name: pin for name, pin in everything.items() if name not in runtime}
    logic = {name: pin for name, pin in needed_by(extras["rtl"], pins).items() if name not in everything}
    site = needed_by(extras["site"], pins)
    for file, locked in zip(HEADERS, (runtime, extra, logic, site), strict=True):
        (ROOT / file).write_text(render(locked, sorted(per_python), file), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
