"""Check that a run left nothing which no rule makes.

Usage, after the run: ``python .ci/every_file_has_a_rule.py config/smoke.yaml results/smoke paper_figures/smoke``
"""

import subprocess
import sys
from pathlib import Path

#: Written by a run that succeeded, not by a rule: who made it, and when.
SIDECARS = {"logs/provenance.json"}


def outputs(overlay: str) -> set[str]:
    """Files that the rules of the default target name as outputs."""
    command = [sys.executable, "-m", "snakemake", "--cores", "1", "--summary", "--configfile", overlay]
    said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    lines = said[said.index("output_file\t") :].splitlines()[1:]
    return {line.split("\t")[0] for line in lines if "\t" in line}


def strays(overlay: str, folders: list[Path]) -> list[str]:
    """Files in the folders that are no rule's output, log or benchmark."""
    made = outputs(overlay)
    found = []
    for folder in folders:
        for path in sorted(folder.rglob("*")):
            name = str(path.relative_to(folder))
            beside = name.startswith(("logs/", "benchmarks/")) and path.suffix in (".log", ".tsv")
            if path.is_file() and str(path) not in made and name not in SIDECARS and not beside:
                found.append(f"{path}: found a file, expected none, because no rule makes it")
    return found


if __name__ == "__main__":
    problems = strays(sys.argv[1], [Path(name) for name in sys.argv[2:]])
    print("\n".join(problems) if problems else "every file comes from a rule")
    sys.exit(bool(problems))
