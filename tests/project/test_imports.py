"""Only what runs a network loads torch, which takes longer to load than most jobs take to run."""

import ast
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[2]
RULES = "".join(file.read_text(encoding="utf-8") for file in (ROOT / "workflow" / "rules").glob("*.smk"))
#: Modules of functions that rules call, and those that run a network.
CALLED = set(re.findall(r'"(repro[\w.]+):\w+"', RULES))
WITH_NETWORK = {"repro.pipeline.networks", "repro.pipeline.coverage", "repro.study.readers", "repro.study.outcomes"}
SCRIPTS = (ROOT / "workflow" / "scripts").glob("*.py")
#: What the Snakefile and the command line load.
LOADED = ("job", "provenance", "experiment", "factorial", "interpretations", "stored_networks")
OUTSIDE_JOBS = ("repro.cli", "repro.study.design", *(f"repro.pipeline.{name}" for name in LOADED))


def modules_of(script):
    """Modules that a script imports."""
    body = ast.parse(script.read_text(encoding="utf-8")).body
    return [node.module for node in body if isinstance(node, ast.ImportFrom)]


def loads_torch(modules):
    """Whether a process that imports these modules has torch loaded."""
    code = f"import sys, {', '.join(modules)}; print('torch' in sys.modules)"
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "src")}
    run = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    return run.stdout == "True\n"


def test_what_runs_no_network_loads_no_torch():
    assert CALLED > WITH_NETWORK
    without = CALLED - WITH_NETWORK | {module for script in SCRIPTS for module in modules_of(script)}
    assert len(without) > 5
    assert not loads_torch(sorted(without.union(OUTSIDE_JOBS)))


def test_the_check_sees_torch_where_it_is_loaded():
    assert loads_torch(WITH_NETWORK)
