"""Only what runs a network loads torch, which takes longer to load than most jobs take to run."""

import ast
import os
import re
import subprocess
import sys

import pytest
from experiment_example import ROOT

pytestmark = pytest.mark.slow

RULES = "".join(file.read_text(encoding="utf-8") for file in (ROOT / "workflow" / "rules").glob("*.smk"))
#: Modules of functions that rules call, and those that run a network.
CALLED = set(re.findall(r'"(repro[\w.]+):\w+"', RULES))
WITH_NETWORK = {
    "repro.experiments.networks",
    "repro.experiments.coverage",
    "repro.experiments.guesses",
    "repro.experiments.training",
    "repro_studies.ablation",
    "repro_studies.factorial_networks",
    "repro_studies.methods",
}
SCRIPTS = (ROOT / "workflow" / "scripts").glob("*.py")
#: What the Snakefile and the command line load.
STUDIES = (f"repro_studies.{name}" for name in ("design", "factorial", "interpretations"))
EXPERIMENTS = (f"repro.experiments.{name}" for name in ("job", "record", "arm", "stored_networks"))
OUTSIDE_JOBS = ("repro.cli", *STUDIES, *EXPERIMENTS)


def test_what_runs_no_network_loads_no_torch():
    assert CALLED > WITH_NETWORK
    nodes = [node for script in SCRIPTS for node in ast.parse(script.read_text(encoding="utf-8")).body]
    by_scripts = {node.module for node in nodes if isinstance(node, ast.ImportFrom)}
    without = {*(CALLED - WITH_NETWORK), *by_scripts, *OUTSIDE_JOBS}
    loaded = "print('torch' in sys.modules)"
    code = f"import sys, {', '.join(without)}; {loaded}; import {', '.join(WITH_NETWORK)}; {loaded}"
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "src")}
    run = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert run.stdout == "False\nTrue\n"
