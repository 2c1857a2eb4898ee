"""Hostile inputs as a user would give them: exit code, output, time and memory of each.

Usage: ``python benchmarks/bad_inputs.py [NAME ...]``. Makes its inputs in a temporary folder (0.5 GB), runs the
command on each with a limit of 60 s and 2 GB, and prints a line. The exit code is 1 if an input takes more, does not
end with exit code 2 and one line, or leaves a file behind.
"""

import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
CAPTURE = ROOT / "data" / "captures" / "T1.bin"
CONFIG = ROOT / "config" / "config.yaml"
SECONDS, MEGABYTES = 60.0, 2000.0


@dataclass(frozen=True)
class Case:
    """A command line, and how to make its input."""

    name: str
    arguments: tuple[object, ...]
    make: Callable[[], object] = lambda: None


def cases(folder: Path) -> Iterator[Case]:
    """Inputs, the largest last."""
    out, file, arm = folder / "out", folder / "log.csv", folder / "arm.yaml"
    identify = ("identify", file, "--method", "ordinary", "-o", out)
    on_arm = ("identify", CAPTURE, "--method", "ordinary", "--arm", arm, "-o", out)
    bomb = "k0: &k0 [x, x, x, x, x, x, x, x, x]\n" + "".join(
        f"k{k}: &k{k} [{', '.join([f'*k{k - 1}'] * 9)}]\n" for k in range(1, 9)
    )
    for name, text in {
        "alias bomb": f"zero: [0, 0]\n{bomb}",
        "deep list": "zero: " + "[" * 100_000,
        "400 digits": f"gravity: 1{'0' * 400}\n",
        "long list": f"zero: [{'0,' * 130_000}0]\n",
        "many keys": "".join(f"k{k}: 1\n" for k in range(20_000)),
        "duplicate key": "gravity: 9.8\ngravity: 9.9\n",
    }.items():
        yield Case(f"arm file, {name}", on_arm, lambda text=text: arm.write_text(text))
        yield Case(f"configuration, {name}", ("check", arm, "--config", CONFIG), lambda text=text: arm.write_text(text))
    yield Case("arm file /dev/zero", ("identify", CAPTURE, "--arm", "/dev/zero", "-o", out))
    yield Case("log /dev/zero", ("identify", CAPTURE, "--validate", "/dev/zero", "-o", out))
    yield Case("log that is a pipe", ("identify", folder / "pipe", "-o", out), lambda: os.mkfifo(folder / "pipe"))
    for name, text in {"deep JSON": "[" * 500_000, "list in JSON": f"[{'0,' * 250_000}0]"}.items():
        yield Case(
            name, ("excite", "--arm", arm, "--guess", file, "-o", out), lambda text=text: _guess(arm, file, text)
        )
    yield Case("capture, long list", ("decode", folder / "T1.bin"), lambda: _long_sidecar(folder))
    wide = ",".join(f"c{k}" for k in range(100_000))
    yield Case("100,000 columns", identify, lambda: file.write_text(f"{wide}\n{'0,' * 99_999}0\n"))
    yield Case("one line of 300 MB", identify, lambda: repeat(file, "time,q1\n", "1" * 1000, 300_000))
    row = "0.1,0.2,0.3\n"
    yield Case("10 million rows without torque", identify, lambda: repeat(file, "time,q1,q2\n", row, 10**7))
    yield Case("1 million rows that stand still", identify, lambda: still(file, 10**6))


def repeat(path: Path, header: str, text: str, times: int) -> None:
    """A file of the same text again and again; written in parts, because a new process counts its parent's memory."""
    with path.open("w", encoding="ascii") as file:
        file.write(header)
        for _ in range(times // 1000):
            file.write(text * 1000)


def still(path: Path, rows: int) -> None:
    """A log of an arm that does not move."""
    with path.open("w", encoding="ascii") as file:
        file.write("time,q1,q2,tau1,tau2\n")
        file.writelines(f"{0.001 * k:.3f},0,0,1,1\n" for k in range(rows))


def _guess(arm: Path, file: Path, text: str) -> None:
    arm.write_text("position_limit: [[-1, 1], [-1, 1]]\nspeed_limit: [6, 6]\ntorque_limit: [2, 2]\n")
    file.write_text(text)


def _long_sidecar(folder: Path) -> None:
    for suffix in (".bin", ".program"):
        (folder / f"T1{suffix}").write_bytes(CAPTURE.with_suffix(suffix).read_bytes())
    text = CAPTURE.with_suffix(".json").read_text(encoding="utf-8")
    begin, end = text.index('"chunks": [') + 11, text.index('"port"')
    (folder / "T1.json").write_text(f"{text[:begin]}{'0,' * 240_000}0],{text[end:]}", encoding="utf-8")


def run(case: Case) -> tuple[str, bool]:
    """What came of a case, and whether it is as it should be."""
    command = [sys.executable, "-m", "repro", *map(str, case.arguments)]
    began = time.monotonic()
    with tempfile.TemporaryFile("w+") as said:
        process = subprocess.Popen(command, stdout=said, stderr=said, cwd=ROOT)
        _, status, usage = _wait(process, began)
        said.seek(0)
        lines = said.read().splitlines()
    seconds, megabytes = time.monotonic() - began, usage.ru_maxrss / 1000.0
    code = os.waitstatus_to_exitcode(status)
    one_line = len(lines) == 1 and ": found " in lines[0] and ", expected " in lines[0]
    good = code == 2 and one_line and seconds < SECONDS and megabytes < MEGABYTES
    line = lines[-1][:120] if lines else "nothing"
    return f"{case.name:<32} exit code {code}, {seconds:5.1f} s, {megabytes:5.0f} MB: {line}", good


def _wait(process: "subprocess.Popen[bytes]", began: float) -> tuple[int, int, resource.struct_rusage]:
    """Wait for a process, and kill it after the limit."""
    while (ended := os.wait4(process.pid, os.WNOHANG))[0] == 0:
        if time.monotonic() - began > SECONDS:
            process.kill()
            return os.wait4(process.pid, 0)
        time.sleep(0.05)
    return ended


def main() -> None:
    """Run all cases, or those whose name contains a word of the command line."""
    bad = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for case in cases(folder):
            if sys.argv[1:] and not any(word in case.name for word in sys.argv[1:]):
                continue
            case.make()
            before = sorted(folder.iterdir())
            line, good = run(case)
            if sorted(folder.iterdir()) != before:
                line, good = f"{line} (left a file)", False
            print(line if good else f"{line}  <-- NOT AS PROMISED", flush=True)
            bad += not good
    sys.exit(bad > 0)


if __name__ == "__main__":
    main()
