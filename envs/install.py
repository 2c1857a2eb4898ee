"""Install ``requirements.lock`` into the environment that runs this, with PyTorch's CPU build where it can be had.

The package registry has only PyTorch's CUDA build. The CPU build is where pip is configured to find it, or in PyTorch's
index, whose address uv knows. All packages are checked by hash, except the CUDA libraries, which no lock names.
Usage: ``.venv/bin/python envs/install.py`` (``make setup`` does it).
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LOCK, CPU, UV = (ROOT / f"requirements{part}.lock" for part in ("", "-cpu", "-uv"))
# Python compiles what it imports; compiling all of it first takes a third of the set-up.
INSTALL = (sys.executable, "-m", "pip", "--disable-pip-version-check", "install", "--quiet", "--no-compile")
LOCKED = ("--no-deps", "--require-hashes", "-r")


def run(*command: object) -> tuple[bool, str]:
    """Whether a command succeeded, and what it printed."""
    done = subprocess.run(
        [str(part) for part in command], check=False, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    return done.returncode == 0, done.stdout


def is_importable(package: str) -> bool:
    """Whether the environment has a package that works."""
    return run(sys.executable, "-c", f"import {package}")[0]


def require(place: str, succeeded: bool, printed: str) -> None:
    """End the set-up with the errors of pip and one line, unless an installation succeeded."""
    if not succeeded:
        errors = [line for line in printed.splitlines() if not line.startswith("WARNING")]  # of each attempt to connect
        expected = "the packages in a registry (PIP_INDEX_URL, HTTPS_PROXY) or a folder of wheels (PIP_FIND_LINKS)"
        sys.exit("\n".join([*errors, f"error: {place}: found the errors of pip above, expected {expected}"]))


def install_cpu_build(folder: Path) -> str:
    """Install PyTorch's CPU build with pip or with uv; the last error if neither can, else nothing."""
    installed, printed = run(*INSTALL, *LOCKED, CPU)
    if not installed:
        installed, printed = run(*INSTALL, "--target", folder / "uv", *LOCKED, UV)
        if installed:
            options = ("--quiet", "--python", sys.executable, "--cache-dir", folder / "cache", "--torch-backend", "cpu")
            installed, printed = run(folder / "uv/bin/uv", "pip", "install", *options, *LOCKED, CPU)
    return "" if installed else printed.strip().splitlines()[-1].strip()


def main() -> None:
    """Install everything but PyTorch, then PyTorch."""
    text = LOCK.read_text(encoding="utf-8")
    (torch,) = re.findall(r"^torch==.*(?:\n .*)*\n", text, re.MULTILINE)
    version = torch.split()[0]
    print("Downloading packages of requirements.lock, 190 MB", flush=True)
    with tempfile.TemporaryDirectory(dir=sys.prefix) as name:
        others = Path(name) / LOCK.name
        others.write_text(text.replace(torch, ""), encoding="utf-8")
        require(LOCK.name, *run(*INSTALL, *LOCKED, others))
        print(f"Downloading PyTorch's CPU build ({version}), 190 MB", flush=True)
        failure = install_cpu_build(Path(name))
    if failure:
        print(f"The CPU build cannot be had ({failure}).")
        print("Downloading the registry's build, on Linux 2.7 GB: .venv takes 5.2 GB instead of 1.4", flush=True)
    require(LOCK.name, *run(*INSTALL, *LOCKED, LOCK))
    if not is_importable("torch"):  # the CUDA build without its libraries, which are named by its own metadata
        require(version, *run(*INSTALL, version))


if __name__ == "__main__":
    main()
