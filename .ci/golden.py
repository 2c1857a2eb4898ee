"""Compare the small run of config/golden.yaml with its kept numbers: tables, cells of pages, parameters of rules.

``make golden`` does the run and this; with ``--write`` the run becomes what is kept. Numbers are compared by class, as
``repro compare`` does. The networks are stored and read in float32, so trained numbers do not scatter over trainings
here: they agree within `TRAINED`. What simulates chattering arms again has the measured spread.
"""

import argparse
import base64
import gzip
import json
import re
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

from repro.comparison.runs import compare_runs
from repro.comparison.tolerances import Kind, Tolerances
from repro.exhibits.catalogue import tolerances

RUN, FIGURES, KEPT = Path("results/golden"), Path("paper_figures/golden"), Path("tests/golden")
#: Largest relative and absolute difference of a number that a search or a network had a part in.
TRAINED = 2e-3
#: Tables whose arms are simulated again, whose loops may be chaotic (docs/numbers.md).
SIMULATED_AGAIN = ("spread/", "tables/verdict", "figures/spread")
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def parameters() -> dict[str, dict[str, object]]:
    """Rule and parameters of each file of the run, as Snakemake recorded them; digests of code are left out."""
    recorded = {}
    for path in sorted(Path(".snakemake/metadata").rglob("*")):
        if not path.is_file():
            continue
        name = base64.urlsafe_b64decode(str(path.relative_to(".snakemake/metadata")).replace("/", "")).decode()
        if name.startswith((str(RUN), str(FIGURES))):
            record = json.loads(path.read_text(encoding="utf-8"))
            given = [value for value in record["params"] if not re.fullmatch(r"'[0-9a-f]{16,64}'", value)]
            recorded[name] = {"rule": record["rule"], "input": sorted(record["input"]), "params": sorted(given)}
    return recorded


def pages(folder: Path) -> dict[str, list[str]]:
    """Cells of the run's tables for reading and of its report, line by line."""
    found = {}
    for path in sorted([*folder.glob("*.md"), *folder.glob("tables/*.md"), *folder.glob("report/*.html")]):
        text = path.read_text(encoding="utf-8")
        if path.suffix == ".html":
            text = "\n".join(re.sub(r"<[^>]+>", " ", row) for row in re.findall(r"<tr.*?</tr>", text, re.DOTALL))
        found[str(path.relative_to(folder))] = [" ".join(line.split()) for line in text.splitlines() if line.strip()]
    return found


def keep(run: Path, kept: Path) -> None:
    """Make the run what later ones are compared with."""
    shutil.rmtree(kept, ignore_errors=True)
    for path in sorted([*run.glob("*.csv"), *run.glob("*/*.csv")]):
        name = path.relative_to(run)
        if name.parts[0] not in ("benchmarks", "logs"):
            (kept / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, kept / name)
    for name, content in (("pages", pages(run)), ("rules", parameters())):
        text = json.dumps(content, indent=0, sort_keys=True, ensure_ascii=False)
        (kept / f"{name}.json.gz").write_bytes(gzip.compress(text.encode(), mtime=0))


def like(a: str, b: str) -> bool:
    """Whether two lines have the same words, and numbers within `TRAINED` or one unit of the last digit."""
    if NUMBER.sub("#", a) != NUMBER.sub("#", b):
        return False
    return all(
        abs(float(x) - float(y)) <= max(TRAINED * max(abs(float(x)), 1.0), 1.01 * _unit(x))
        for x, y in zip(NUMBER.findall(a), NUMBER.findall(b), strict=True)
    )


def _unit(number: str) -> float:
    mantissa, _, exponent = number.partition("e")
    return 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))


def kept_json(name: str) -> dict:
    """What was kept as compressed JSON."""
    return json.loads(gzip.decompress((KEPT / f"{name}.json.gz").read_bytes()))


def faults() -> Iterator[str]:
    """One line for each thing that is not as it was kept."""
    classes: Tolerances = tolerances()
    compared, alone = compare_runs(KEPT, RUN, classes)
    yield from (f"{name}: in one of the two runs alone" for name in alone)
    for table in compared:
        for each in table.found:
            allowed = each.allowed
            if each.kind is Kind.TRAINED and not table.name.startswith(SIMULATED_AGAIN):
                try:
                    allowed = TRAINED * max(abs(float(each.a)), 1.0)
                except ValueError:
                    allowed = 0.0  # words are the same words here
            if each.size > allowed:
                yield f"{table.name}: {each.place}: found {each.b}, kept {each.a}"
    for name, (kept, found) in (
        ("pages", (kept_json("pages"), pages(RUN))),
        ("rules", (kept_json("rules"), parameters())),
    ):
        yield from (f"{name}: {key}: in one of the two runs alone" for key in sorted(kept.keys() ^ found.keys()))
        for key in sorted(kept.keys() & found.keys()):
            if name == "rules":
                if kept[key] != found[key]:
                    yield f"rules: {key}: found {found[key]}, kept {kept[key]}"
            elif len(kept[key]) != len(found[key]):
                yield f"{key}: found {len(found[key])} lines, kept {len(kept[key])}"
            else:
                lines = zip(kept[key], found[key], strict=True)
                yield from (f"{key}: found {b!r}, kept {a!r}" for a, b in lines if not like(a, b))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--write", action="store_true", help="keep this run's numbers")
    if parser.parse_args().write:
        keep(RUN, KEPT)
    wrong = list(faults())
    print("\n".join(wrong[:60]) if wrong else "the small run has the kept numbers, cells and parameters")
    sys.exit(bool(wrong))
