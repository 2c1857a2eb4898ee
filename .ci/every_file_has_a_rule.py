"""Check that a run left nothing which no rule makes, and that its record has all that the rules made.

Usage, after the run with ``config/golden.yaml``: ``python .ci/every_file_has_a_rule.py golden study all``
"""

import hashlib
import json
import subprocess
import sys
from pathlib import Path

from repro.experiments.record import RECORD, SEAL

#: Written by a run that succeeded, not by a rule: who made it, when, from what, at what cost, and by which workflow.
SIDECARS = {"logs/provenance.json", "logs/costs.csv", RECORD, SEAL}


def outputs(run: str, targets: list[str]) -> set[str]:
    """Files that the rules of the targets name as outputs."""
    overlay = f"config/{run}.yaml"
    command = [sys.executable, "-m", "snakemake", "--cores", "1", "--summary", "--configfile", overlay, "--", *targets]
    said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    lines = said[said.index("output_file\t") :].splitlines()[1:]
    return {line.split("\t")[0] for line in lines if "\t" in line}


def strays(made: set[str], folders: list[Path]) -> list[str]:
    """Files in the folders that are no rule's output, log or benchmark."""
    found = []
    for folder in folders:
        for path in sorted(folder.rglob("*")):
            name = str(path.relative_to(folder))
            beside = name.startswith(("logs/", "benchmarks/")) and path.suffix in (".log", ".tsv")
            beside |= name.startswith("workflow/")
            if path.is_file() and str(path) not in made and name not in SIDECARS and not beside:
                found.append(f"{path}: found a file, expected none, because no rule makes it")
    return found


def unrecorded(made: set[str], results: Path) -> list[str]:
    """Outputs and sidecars that are not there, or outputs that the record does not have as they are."""
    graph = json.loads((results / RECORD).read_text(encoding="utf-8"))["@graph"]
    recorded = {entity["name"]: entity["sha256"] for entity in graph if "sha256" in entity}
    found = [f"{results / name}: found no file" for name in sorted(SIDECARS) if not (results / name).is_file()]
    for name in sorted(made):
        there = hashlib.sha256(Path(name).read_bytes()).hexdigest() if Path(name).is_file() else "no file"
        if recorded.get(name) != there:
            found.append(f"{results / RECORD}: {name}: found {recorded.get(name, 'nothing')}, expected {there}")
    return found


if __name__ == "__main__":
    rules = outputs(sys.argv[1], sys.argv[2:])
    places = [Path(folder) / sys.argv[1] for folder in ("results", "paper_figures")]
    problems = strays(rules, places) + unrecorded(rules, places[0])
    print("\n".join(problems) if problems else "every file comes from a rule, and is recorded")
    sys.exit(bool(problems))
