"""Compare the small run of config/golden.yaml with its kept numbers: tables, cells of pages, parameters of rules.

``make golden`` does the run and this; with ``--write`` the run becomes what is kept. Numbers are compared by class, as
``repro compare`` does. The networks are stored and read in float32, so trained numbers do not scatter over trainings
here: they agree within `TRAINED`. What simulates chattering arms again has the measured spread.
"""

import argparse
import base64
import difflib
import gzip
import hashlib
import json
import math
import re
import shutil
import sys
import tempfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from repro.comparison import Difference, Kind, compare_runs
from repro.exhibits.catalogue import tolerances
from repro.files import read_rows

RUN, FIGURES, KEPT = Path("results/golden"), Path("paper_figures/golden"), Path("tests/golden")
#: Largest relative and absolute difference of a number that a network had a part in.
TRAINED = 2e-3
#: Factor on it for methods that select among moved candidates: here too few passes for them to converge, so that last
#: bits of another processor change what survives (0.004 of a total measured).
SEARCHED, WIDER = ("refinement", "local-search", "differential-evolution"), 10.0
#: Further factor for spreads of a few seeds, and for the prediction intervals that follow from them.
SPREADS, OF_SPREADS = ("tolerance", "total_sd", "estimate_sd"), 5.0
#: The same for numbers in a row of a page that names such a method: its interval may be one of a few seeds.
IN_A_ROW = 0.5
#: A table with more rows than the first number is kept as about the second number of them.
LONG, ROWS = 1000, 60
#: Tables whose arms are simulated again, whose loops may be chaotic (docs/numbers.md).
SIMULATED_AGAIN = ("accepted/", "tables/verdict", "figures/spread", "study/", "tables/study", "figures/study")
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
#: A spread of a few seeds in a cell of a page, and its largest difference: 0.15 was measured between two processors.
SPREAD_IN_A_CELL = re.compile(r"(?:±|\\pm)\s*(" + NUMBER.pattern + ")")
IN_A_SPREAD = 0.2
#: What marks an element of a page besides its text.
MARK = re.compile(r'(<[a-z]\w*\b[^>]*?)\b(?:class|data-\w+)="([^"]*)"')
#: What ends a line of a page, and the size of a file that is offered there.
BLOCK_END, SIZE = re.compile(r"</(tr|p|li|h\d|dt|dd|div|option|caption|summary)>"), re.compile(r"[\d.]+ [kM]B")


def parameters() -> dict[str, dict[str, list[str]]]:
    """Rule, inputs and parameters of each file of the run, as Snakemake recorded them; digests of code are left out."""
    here = f"{Path.cwd()}/"
    recorded = {}
    for path in sorted(Path(".snakemake/metadata").rglob("*")):
        if not path.is_file():
            continue
        name = base64.urlsafe_b64decode(str(path.relative_to(".snakemake/metadata")).replace("/", "")).decode()
        if name.startswith((str(RUN), str(FIGURES))) and Path(name).exists():  # not of an earlier run
            record = json.loads(path.read_text(encoding="utf-8"))
            digest = re.compile(r"(['\"]).+ [0-9a-f]{12}\1")
            given = sorted(value.replace(here, "") for value in record["params"] if not digest.fullmatch(value))
            inputs = sorted(file.replace(here, "") for file in record["input"])
            recorded[name] = {"rule": [record["rule"]], "input": inputs, "params": given}
    return recorded


def pages(folder: Path) -> dict[str, list[str]]:
    """Lines of the run's tables for reading and of its check sums, and blocks of text of its report but provenance."""
    found = {}
    for path in sorted([*folder.glob("*.[ms]*"), *folder.glob("tables/*.[mt]*"), *folder.glob("report/*.html")]):
        text = re.sub(r"[0-9a-f]{64}", "", path.read_text(encoding="utf-8"))
        if path.suffix == ".html":
            text = " ".join(re.sub(r"<(style|script)\b.*?</\1>", "", text, flags=re.DOTALL).split())
            text = re.sub(r'<p class="provenance">.*?</p>', "", text)
            text = MARK.sub(r"\2 \1", text.partition('<section id="provenance"')[0])
            text = BLOCK_END.sub("\n", text)
            text = SIZE.sub("", re.sub(r"<[^>]+>", " ", text))
        found[str(path.relative_to(folder))] = [" ".join(line.split()) for line in text.splitlines() if line.strip()]
    return found


def thinned(run: Path, folder: Path) -> dict[str, str]:
    """Copy tables, of long ones a sample of rows; return what the copies do not hold: lengths, and hashes of bytes."""
    rest = {}
    for path in sorted([*run.glob("*.csv"), *run.glob("*/*.csv"), *run.glob("experiment/*.[bp]*")]):
        name = path.relative_to(run)
        if name.parts[0] in ("benchmarks", "logs"):
            continue
        if path.suffix != ".csv":
            rest[str(name)] = hashlib.sha256(path.read_bytes()).hexdigest()
            continue
        header, *rows = path.read_text(encoding="utf-8").splitlines(keepends=True)
        rest[str(name)] = str(len(rows))
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        sample = [header, *rows[:: len(rows) // ROWS if len(rows) > LONG else 1]]
        (folder / name).write_text("".join(sample), encoding="utf-8")
    return rest


def kept_numbers(folder: Path) -> dict[str, dict]:
    """Everything that is compared besides the sampled tables, which go into the folder."""
    return {"files": thinned(RUN, folder), "pages": pages(RUN), "rules": parameters()}


def keep() -> None:
    """Make the run what later ones are compared with."""
    shutil.rmtree(KEPT, ignore_errors=True)
    for name, content in kept_numbers(KEPT).items():
        text = json.dumps(content, indent=0, sort_keys=True, ensure_ascii=False)
        (KEPT / f"{name}.json.gz").write_bytes(gzip.compress(text.encode(), mtime=0))


def like(a: str, b: str) -> bool:
    """Whether two lines have the same words, and numbers within what `TRAINED` allows."""
    if NUMBER.sub("#", a) != NUMBER.sub("#", b):
        return False
    allowed = IN_A_ROW if any(word in a for word in SEARCHED) else TRAINED * WIDER
    return _near(a, b, SPREAD_IN_A_CELL, IN_A_SPREAD) and _near(
        SPREAD_IN_A_CELL.sub("", a), SPREAD_IN_A_CELL.sub("", b), NUMBER, allowed
    )


def _near(a: str, b: str, pattern: re.Pattern[str], allowed: float) -> bool:
    """Whether the numbers that a pattern finds in two lines are as near as is allowed."""
    pairs = zip(pattern.findall(a), pattern.findall(b), strict=True)
    return all(abs(float(x) - float(y)) <= allowed * max(abs(float(x)), 1.0) for x, y in pairs)


def kept_json(name: str) -> dict:
    """What was kept as compressed JSON."""
    return json.loads(gzip.decompress((KEPT / f"{name}.json.gz").read_bytes()))


def faults(folder: Path) -> Iterator[str]:
    """One line for each thing that is not as it was kept."""
    found = kept_numbers(folder)
    alone = compare_runs(KEPT, folder, tolerances())[1]
    yield from (f"{name}: in one of the two runs alone" for names in alone for name in names)
    for name, each, allowed in changed_cells(folder):
        if each.size > allowed:
            yield f"{name}: {each.place}: found {each.b}, kept {each.a}"
    for name in found:
        kept, now = kept_json(name), found[name]
        yield from (f"{name}: {key}: in one of the two runs alone" for key in sorted(kept.keys() ^ now.keys()))
        for key in sorted(kept.keys() & now.keys()):
            if name == "rules":
                yield from changes(key, kept[key], now[key])
            elif name == "files":
                if kept[key] != now[key]:
                    yield f"{key}: found {now[key]}, kept {kept[key]}"
            elif len(kept[key]) != len(now[key]):
                yield f"{key}: found {len(now[key])} lines, kept {len(kept[key])}"
            else:
                lines = zip(kept[key], now[key], strict=True)
                yield from (f"{key}: found {b!r}, kept {a!r}" for a, b in lines if not like(a, b))


def changed_cells(folder: Path) -> Iterator[tuple[str, Difference, float]]:
    """Each cell that differs, with its table and what is allowed here; NaN where no limit is known."""
    for table in compare_runs(KEPT, folder, tolerances())[0]:
        yield from ((table.name, each, _allowed(table.name, each, rows(table.name))) for each in table.found)


def changes(file: str, kept: dict[str, list[str]], now: dict[str, list[str]]) -> Iterator[str]:
    """One line for each input or parameter of a file's rule that came or went."""
    for kind, before in kept.items():
        for values, others, change in ((now[kind], before, "new"), (before, now[kind], "gone")):
            for value in (value for value in values if value not in others):
                other = difflib.get_close_matches(value, others, 1, 0.5)
                at = next((k for k, (a, b) in enumerate(zip(value, *other, strict=False)) if a != b), 0) if other else 0
                yield f"{file}: {kind}: {change}: {'...' * (at > 30)}{value[max(at - 30, 0) : at + 90]}"


@cache
def rows(table: str) -> list[dict[str, str]]:
    """Rows of a kept table."""
    return read_rows(KEPT / table)


def _allowed(table: str, difference: Difference, kept: list[dict[str, str]]) -> float:
    if difference.kind not in (Kind.SIMULATED, Kind.TRAINED) or table.startswith(SIMULATED_AGAIN):
        return difference.allowed
    line, column = re.fullmatch(r"line (\d+), (.*)", difference.place).groups()
    row = kept[int(line) - 2]
    try:
        size = max(abs(float(row.get(name) or 0.0)) for name in (column, "ours"))
    except ValueError:
        return 0.0  # the same network and guesses end with the same words
    wider = WIDER if any(word in value for word in SEARCHED for value in row.values()) else 1.0
    return TRAINED * max(size, 1.0) * wider * (OF_SPREADS if column in SPREADS else 1.0)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--write", action="store_true", help="keep this run's numbers")
    if parser.parse_args().write:
        keep()
    with tempfile.TemporaryDirectory() as folder:
        wrong = list(faults(Path(folder)))
        unjudged = sum(math.isnan(allowed) for _, _, allowed in changed_cells(Path(folder)))
    print("\n".join(wrong[:60]) if wrong else "the small run has the kept numbers, cells and parameters")
    if unjudged:
        print(f"{unjudged} cells differ for which no limit is known")
    sys.exit(bool(wrong))
