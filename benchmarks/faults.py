"""Small faults put into a copy of the project, one at a time: does a test notice?

Usage: ``python benchmarks/faults.py OUT.csv [--seed 1] [--scale 1.0] [ROOM ...]``. Faults are drawn from all places
where one can be made, so many a room; each is tried by the tests of its room, the quick ones first. A fault that no
test notices is told with its line, and either gets a test or is named in `EQUIVALENT` with the reason why it changes
nothing. A file OUT.csv that is there already is continued.
"""

import argparse
import ast
import csv
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SOURCE = ROOT / "src" / "repro"
#: Faults a room, and the tests that are asked: folders and files of tests/.
ROOMS: dict[str, tuple[int, tuple[str, ...]]] = {
    "model": (8, ("model", "identification")),
    "signals": (10, ("signals", "pipeline")),
    "cnn": (14, ("cnn", "identification/algorithm1", "pipeline")),
    "fpga": (14, ("fpga", "pipeline")),
    "logs": (10, ("logs", "ownarm")),
    "identification": (20, ("identification", "pipeline", "ownarm")),
    "pipeline": (28, ("pipeline", "exhibits", "test_settings.py", "project")),
    "exhibits": (12, ("exhibits", "project", "pipeline")),
    "render": (24, ("render", "exhibits", "ownarm")),
    "paper": (10, ("paper",)),
    "report": (5, ("report",)),
    "ownarm": (12, ("ownarm", "commands")),
    "commands": (8, ("commands", "project")),
    "comparison": (4, ("comparison", "project")),
    "export": (4, ("export", "ownarm")),
    "rules": (14, ("project",)),
}
#: Faults that change nothing that anybody could see, by file and new text of the line, with the reason.
EQUIVALENT: dict[tuple[str, str], str] = {}

COMPARED = {ast.Lt: "<=", ast.LtE: "<", ast.Gt: ">=", ast.GtE: ">", ast.Eq: "!=", ast.NotEq: "=="}
OPERATORS = {ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*"}
#: Names and words that are easily taken for each other.
SWAPPED = (
    ("time", "frequency"), ("joint1", "joint2"), ("torque1", "torque2"), ("low", "high"), ("min", "max"),
    ("dq", "ddq"), ("estimate", "true"), ("table06", "table07"), ("scores", "identifications"), ("ID", "T1"),
    ("measured", "desired"), ("position", "velocity"), ("train", "test"), ("argmin", "argmax"), ("floor", "ceil"),
    ("first", "second"), ("rows", "columns"), ("width", "height"), ("n1", "n2"), ("any", "all"), ("x", "y"),
)  # fmt: skip
#: Calls that only tell how far something is.
SAID = r"(^|\.)(_LOG|warnings|[Pp]rogress|report)$|_LOG\."
SWAP = {a: b for pair in SWAPPED for a, b in (pair, pair[::-1])}


@dataclass(frozen=True)
class Fault:
    """A line and what stands in its place."""

    room: str
    file: str
    line: int
    old: str
    new: str


def _changes(node: ast.AST, text: str) -> Iterator[tuple[ast.AST, str]]:
    """Ways to get one node wrong: the node to replace and its new text."""
    source = lambda part: ast.get_source_segment(text, part) or ""  # noqa: E731
    match node:
        case ast.Compare(ops=[op], left=left, comparators=[right]) if type(op) in COMPARED:
            yield node, f"{source(left)} {COMPARED[type(op)]} {source(right)}"
        case ast.BinOp(op=op, left=left, right=right) if type(op) in OPERATORS and not isinstance(left, ast.Constant):
            yield node, f"{source(left)} {OPERATORS[type(op)]} {source(right)}"
        case ast.Constant(value=bool(value)):
            yield node, str(not value)
        case ast.Constant(value=int(value)):
            yield node, str(value + 1 if value != 1 else 0)
        case ast.Constant(value=float(value)):
            yield node, repr(1.1 * value or 0.1)
        case ast.Constant(value=str(value)) if value in SWAP:
            yield node, f'"{SWAP[value]}"'
        case ast.Attribute(value=value, attr=attr) if attr in SWAP:
            yield node, f"{source(value)}.{SWAP[attr]}"
        case ast.UnaryOp(op=ast.Not() | ast.USub(), operand=operand):
            yield node, source(operand)
        case ast.Call(func=func, args=[a, b, *rest], keywords=keywords) if source(a) != source(b):
            told = [source(b), source(a), *map(source, rest), *map(source, keywords)]
            yield node, f"{source(func)}({', '.join(told)})"


def _outside(tree: ast.Module) -> set[int]:
    """Nodes that are no arithmetic: annotations, decorators, what errors and the log say, defaults of dataclasses."""
    skipped: set[int] = set()
    for node in ast.walk(tree):
        parts: list[ast.AST | None] = []
        if isinstance(node, ast.Raise | ast.Assert | ast.Import | ast.ImportFrom | ast.JoinedStr):
            parts = [node]
        elif isinstance(node, ast.FunctionDef):
            parts = [node.returns, *node.decorator_list, *(arg.annotation for arg in node.args.args)]
        elif isinstance(node, ast.ClassDef):
            parts = [*node.decorator_list]
        elif isinstance(node, ast.AnnAssign):
            parts = [node.annotation]
        elif isinstance(node, ast.Call) and re.search(
            r"(^|\.)(_LOG|warnings|[Pp]rogress|report)$|_LOG\.", ast.unparse(node.func)
        ):
            parts = [node]
        for part in parts:
            skipped |= {id(inner) for inner in ast.walk(part)} if part is not None else set()
    return skipped


def python_faults(room: str) -> list[Fault]:
    """Every fault that can be made in a room, on one line each."""
    found = []
    for path in sorted((SOURCE / room).rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        tree, lines = ast.parse(text), text.splitlines()
        skipped = _outside(tree)
        for node in ast.walk(tree):
            if id(node) in skipped:
                continue
            for place, new in _changes(node, text):
                if place.lineno != place.end_lineno:  # type: ignore[attr-defined]
                    continue
                line = lines[place.lineno - 1].encode()  # type: ignore[attr-defined]  # columns are bytes
                changed = (line[: place.col_offset] + new.encode() + line[place.end_col_offset :]).decode()  # type: ignore[attr-defined]
                found.append(Fault(room, str(path.relative_to(ROOT)), place.lineno, line.decode(), changed))  # type: ignore[attr-defined]
    return found


def rule_faults() -> list[Fault]:
    """Faults of rules: a value of the neighbour, a part of the configuration or the code's digest left out."""
    found = []
    for path in sorted((ROOT / "workflow" / "rules").glob("*.smk")):
        lines, file = path.read_text(encoding="utf-8").splitlines(), str(path.relative_to(ROOT))
        for k, line in enumerate(lines):
            changed = []
            if "code=code(" in line:
                changed.append(re.sub(r"code=code\(.*\),", 'code="",', line))
            if 'sections("' in line:
                changed.append(re.sub(r'sections\("\w+", ', "sections(", line))
            for a, b in (("cnn", "cnn-tracked"), ("numeric", "experiment"), ('["seeds"]', '["search_seeds"]')):
                if f"/{a}" in line or (a.startswith("[") and a in line):
                    changed.append(line.replace(a, b, 1))
            if '"ID"' in line:
                changed.append(line.replace('"ID"', '"T1"'))
            if "PROGRAMS" in line:
                changed.append(line.replace("PROGRAMS", "VALIDATION"))
            found += [Fault("rules", file, k + 1, line, new) for new in changed if new != line]
    return found


def noticed(fault: Fault, copy: Path) -> bool:
    """Whether a test of the fault's room fails, or nothing can be loaded."""
    path = copy / fault.file
    kept = path.read_text(encoding="utf-8")
    lines = kept.splitlines(keepends=True)
    lines[fault.line - 1] = fault.new + "\n"
    path.write_text("".join(lines), encoding="utf-8")
    environment = {**os.environ, "PYTHONPATH": str(copy / "src"), "PYTHONDONTWRITEBYTECODE": "1"}
    tests = [str(copy / "tests" / name) for name in ROOMS[fault.room][1]]
    try:
        for which in ["not slow", "slow"] if fault.room != "rules" else ["slow or not slow"]:
            command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-m", which, *tests]
            try:
                run = subprocess.run(command, cwd=copy, env=environment, capture_output=True, check=False, timeout=900)
            except subprocess.TimeoutExpired:
                return True  # a loop that does not end is seen by everybody
            if run.returncode not in (0, 5):  # 5: no test with this mark
                return True
        return False
    finally:
        path.write_text(kept, encoding="utf-8")


def main() -> None:
    """Try the faults and tell those that nobody noticed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path)
    parser.add_argument("rooms", nargs="*", default=[*ROOMS])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--scale", type=float, default=1.0, help="times the faults of each room")
    args = parser.parse_args()
    done = set()
    if args.out.exists():
        with args.out.open(newline="", encoding="utf-8") as f:
            done = {(row["file"], int(row["line"]), row["new"]) for row in csv.DictReader(f)}
    with tempfile.TemporaryDirectory() as folder, args.out.open("a", newline="", encoding="utf-8") as f:
        copy = Path(folder) / "copy"
        listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
        for name in listed.splitlines():
            (copy / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, copy / name, follow_symlinks=False)
        rows = csv.writer(f)
        if not done:
            rows.writerow(("room", "file", "line", "noticed", "old", "new"))
        for room in args.rooms:
            pool = rule_faults() if room == "rules" else python_faults(room)
            count = min(len(pool), round(args.scale * ROOMS[room][0]))
            for fault in random.Random(f"{args.seed} {room}").sample(pool, count):
                if (fault.file, fault.line, fault.new) in done:
                    continue
                seen = (
                    "equivalent" if (fault.file, fault.new.strip()) in EQUIVALENT else str(noticed(fault, copy)).lower()
                )
                rows.writerow((room, fault.file, fault.line, seen, fault.old, fault.new))
                f.flush()
                print(f"{seen:10} {fault.file}:{fault.line}: {fault.old.strip()}  ->  {fault.new.strip()}", flush=True)


if __name__ == "__main__":
    main()
