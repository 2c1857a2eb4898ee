"""Other machines, emulated on this one: tests, the five recordings and the kept reference under each, one line a host.

Usage: ``.venv/bin/python .ci/hosts.py [NAME ...]``. A host that this processor cannot imitate is told as not run. Exit
code 1 if one fails.
"""

import os
import shutil
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PYTHON = str(ROOT / ".venv/bin/python")
NO_AVX512 = "X86_V4 AVX512_ICL AVX512_SPR"
#: Tests in which a float has a part.
PORTABLE = ("compare", "contract", "dct", "dynamics", "fingerprint", "least_squares", "metric", "networks", "programs")
#: The same with those of tampering, for two hosts.
TAMPERED = (*PORTABLE, "verify")
#: The same with those of arms simulated as one batch, whose sums are NumPy's.
BATCHES = (*PORTABLE, "simulated_arms")
#: What a whole emulated processor can run in a minute.
FEW = ("compare", "contract", "fingerprint")


@dataclass(frozen=True)
class Host:
    """One emulated machine: variables of its processes, a program that runs them, flags that this processor needs."""

    name: str
    variables: dict[str, str] = field(default_factory=dict)
    program: tuple[str, ...] = ()
    needs: str = ""
    tests: tuple[str, ...] = PORTABLE


#: The longest first: two are visited at a time.
HOSTS = (
    Host("Intel Haswell", program=("qemu-x86_64", "-cpu", "Haswell-v4"), tests=FEW),
    Host("AMD Rome", program=("qemu-x86_64", "-cpu", "EPYC-Rome-v2"), tests=FEW),
    Host("OpenBLAS SkylakeX", {"OPENBLAS_CORETYPE": "SkylakeX"}, needs="avx512vl", tests=TAMPERED),
    Host("glibc without FMA", {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX512F"}, needs="fma", tests=TAMPERED),
    Host("OpenBLAS Haswell", {"OPENBLAS_CORETYPE": "Haswell"}, needs="avx2"),
    Host("OpenBLAS Zen", {"OPENBLAS_CORETYPE": "Zen"}, needs="avx2"),
    Host("OpenBLAS Nehalem", {"OPENBLAS_CORETYPE": "Nehalem"}, needs="sse4_2"),
    Host("NumPy with AVX-512", {"NPY_DISABLE_CPU_FEATURES": ""}, needs="avx512vl"),
    Host("NumPy without AVX2", {"NPY_DISABLE_CPU_FEATURES": f"X86_V3 {NO_AVX512}"}, needs="avx2", tests=BATCHES),
)

#: Probes, recordings, verification and tests in one process: a whole emulated processor loads libraries slowly.
VISIT = """
import json, os, sys, tempfile
from pathlib import Path
from repro import contract
contract.hold(os.environ)
import pytest
from repro.cli import main
from repro.config.check import load_config
from repro.config.sections import changed
from repro.fingerprint import differing, fingerprint
from repro.experiments.arm import acquire, read_recording
recorded = json.loads(Path("docs/reference/provenance.json").read_text())["fingerprint"]
print(len(differing(recorded, fingerprint())))
config = load_config(Path("config/config.yaml"))
simulated = changed(config, {"experiment": {"source": "simulated"}})
runs = [(motion, config) for motion in ("ID", "T1", "T2", "T3", "T4")]
with tempfile.TemporaryDirectory() as folder:
    for motion, settings in [*runs, ("ID", simulated)]:
        out = Path(folder) / f"{motion}.bin"
        acquire(motion, out, settings)
        read_recording(out, config)
if main(["verify", "--results", "docs/reference"]):
    sys.exit("verify failed")
if pytest.main(["-q", "-p", "no:cacheprovider", "-p", "no:xdist", *sys.argv[1:]]):
    sys.exit("tests failed")
"""


def flags() -> set[str]:
    """Flags of this processor."""
    lines = Path("/proc/cpuinfo").read_text().splitlines()
    return set(next((line for line in lines if line.startswith("flags")), "").split())


def cannot(host: Host) -> str:
    """Why this machine cannot imitate a host; empty if it can."""
    if host.needs and host.needs not in flags():
        return f"this processor has no {host.needs}"
    if host.program and shutil.which(host.program[0]) is None:
        return f"no {host.program[0]}"
    return ""


def run(host: Host, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run python as on that host."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("OPENBLAS", "NPY_", "GLIBC_TUNABLES"))}
    command = [*host.program, PYTHON, *arguments]
    return subprocess.run(
        command, check=False, cwd=ROOT, env=environment | host.variables, capture_output=True, text=True
    )


def visit(host: Host) -> tuple[str, str]:
    """Do everything on one host; its line, and what a failure printed."""
    if why := cannot(host):
        return f"{host.name:22} not run: {why}", ""
    tests = [str(next((ROOT / "tests").rglob(f"test_{name}.py"))) for name in host.tests]
    began = time.monotonic()
    done = run(host, "-c", VISIT, *tests)
    if done.returncode:
        reason = (done.stderr.strip().splitlines() or ["no message"])[-1][:80]
        return f"{host.name:22} FAILED: {reason}", f"{done.stdout[-6000:]}\n{done.stderr[-3000:]}"
    probes, seconds = done.stdout.split()[0], time.monotonic() - began
    return f"{host.name:22} passed, {probes} probes unlike the reference's, {seconds:.0f} s", ""


def main() -> int:
    """Visit every host, or those named, two at a time; 1 if one fails."""
    wanted = sys.argv[1:]
    failures = []
    with ThreadPoolExecutor(2) as pool:
        for line, failure in pool.map(visit, [host for host in HOSTS if not wanted or host.name in wanted]):
            print(line, flush=True)
            failures += [failure] if failure else []
    print(*failures, sep="\n")
    return int(bool(failures))


if __name__ == "__main__":
    sys.exit(main())
