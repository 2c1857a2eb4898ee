"""Small faults put into a copy of the project, one at a time: does a test notice?

Usage: ``python benchmarks/faults.py OUT.csv [--seed 1] [--scale 1.0] [ROOM ...]``. Which test reaches which line is
measured once (kept as OUT.coverage and OUT.xml; 10 to 20 minutes). Faults are drawn from all places where one can be
made, so many a room; each is tried by the tests that reach its line, the quickest first. A fault that no test notices
is told with its line, and either gets a test or is named in `EQUIVALENT` with the reason why it changes nothing. A file
OUT.csv that is there already is continued.
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
from xml.etree import ElementTree

from coverage import CoverageData

ROOT = Path(__file__).resolve().parent.parent
SOURCE = ROOT / "src" / "repro"
#: Faults a room.
ROOMS = {
    **{"model": 8, "signals": 10, "cnn": 14, "fpga": 14, "logs": 10, "identification": 20, "pipeline": 28},
    **{"exhibits": 12, "render": 24, "paper": 10, "report": 5, "ownarm": 12, "commands": 8, "comparison": 4},
    **{"export": 4, "rules": 14},
}
#: Faults that change nothing that anybody could see, by file and new text of the line, with the reason.
EQUIVALENT: dict[tuple[str, str], str] = {
    (
        "src/repro/exhibits/arm_experiment.py",
        "series |= {method: rebuild_torque(estimates[method], y) for method in methods}",
    ): "the torque is linear in both, and shapes tell them apart",
    (
        "src/repro/pipeline/why.py",
        "rebuilt = rebuild_torque(select(found.beta, signals, algorithm1.search).beta, signals.regression.y)",
    ): "the torque is linear in both, and shapes tell them apart",
    (
        "src/repro/pipeline/identified.py",
        "return pd.concat(frames, ignore_index=False)",
    ): "numbers of rows are written nowhere",
    (
        "src/repro/ownarm/parameters.py",
        "bars = [p.high - p.low for p in found if p.low is not None and p.low is not None]",
    ): "an interval has both ends or none",
    (
        "src/repro/exhibits/panels.py",
        "(0.55, _BOX_ROW),",
    ): "an arrow begins where it leaves its box, at the same height",
    (
        "src/repro.pipeline.job.py",
        '"MALLOC_MMAP_THRESHOLD_": str(32 << 21),',
    ): "changes the speed alone, and hardly",
    (
        "src/repro/identification/bootstrap.py",
        "if len(drawn) < max(replicates // 2, 3):",
    ): "there are never fewer than six replicates",
    (
        "src/repro/identification/least_squares.py",
        'z = lsq_linear(r, c, bounds=(0.0, np.inf), method="bvls").x * determined(c, r)',
    ): "a right side of exactly zero leaves a parameter at zero either way",
    (
        "src/repro/identification/regression.py",
        "begins = np.cumsum([0.1, *(part.t[-1] - part.t[0] + part.h for part in parts[:-1])])",
    ): "only differences of these times are used",
    (
        "src/repro/ownarm/selftest.py",
        "return make_ready(made_log(log, beta, rng), same, "
        "replace(options, cutoff=log.settings.cutoff, friction=True))",
    ): "a log made by Eq. 1 has no friction beyond it to find",
    (
        "src/repro/paper/checks/hardware.py",
        "CONSISTENT if full.value < motor.value else OUTSIDE,",
    ): "the two are not equal",
    (
        "src/repro/paper/checks/proof.py",
        "CONSISTENT if condition <= 1.0 / scale else CONTRADICTS,",
    ): "the two are not equal",
    (
        "src/repro/paper/metric_candidates.py",
        '("cosine", "1 - cos(x, y)", lambda x, y: 1.0 - _cosine(y, x)),',
    ): "a cosine is symmetric",
    (
        "src/repro/comparison/runs.py",
        "return next((k for k, (p, q) in enumerate(zip(y, x, strict=False)) if p != q), min(len(x), len(y)))",
    ): "where two differ is symmetric",
}

COMPARED = {ast.Lt: "<=", ast.LtE: "<", ast.Gt: ">=", ast.GtE: ">", ast.Eq: "!=", ast.NotEq: "=="}
OPERATORS = {ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*"}
#: Names and words that are easily taken for each other.
SWAPPED = (
    ("time", "frequency"), ("joint1", "joint2"), ("torque1", "torque2"), ("low", "high"), ("min", "max"),
    ("dq", "ddq"), ("estimate", "true"), ("table06", "table07"), ("scores", "identifications"), ("ID", "T1"),
    ("measured", "desired"), ("position", "velocity"), ("train", "test"), ("argmin", "argmax"), ("floor", "ceil"),
    ("first", "second"), ("rows", "columns"), ("width", "height"), ("n1", "n2"), ("any", "all"), ("x", "y"),
)  # fmt: skip
#: Calls whose arguments may stand in any order.
COMMUTATIVE = ("max", "min", "maximum", "minimum", "hypot", "isclose")
#: Calls that only tell how far something is.
SAID = re.compile(r"(^|\.)(_LOG|warnings|[Pp]rogress|report)$|_LOG\.")
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
        case ast.Call(func=func, args=[a, b, *rest], keywords=keywords) if source(a) != source(b) and not source(
            func
        ).endswith(COMMUTATIVE):
            told = [source(b), source(a), *map(source, rest), *map(source, keywords)]
            yield node, f"{source(func)}({', '.join(told)})"


def _outside(tree: ast.Module) -> set[int]:
    """Nodes that are no arithmetic: annotations, decorators, guards, what errors and the log say."""
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
        elif isinstance(node, ast.Call) and SAID.search(ast.unparse(node.func)):
            parts = [node]
        elif isinstance(node, ast.Call):  # a guard: lengths agree
            parts = [keyword for keyword in node.keywords if keyword.arg == "strict"]
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


def measure(copy: Path, reached: Path, times: Path) -> None:
    """Runs every test once and notes which lines it reaches and how long it takes."""
    options = [
        "--cov=src/repro",
        "--cov-context=test",
        "--cov-report=",
        f"--junitxml={times}",
        "-n2",
        "--dist=loadfile",
    ]
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *options]
    environment = {**_environment(copy), "COVERAGE_FILE": str(reached)}
    if subprocess.run(command, cwd=copy, env=environment, check=False).returncode:
        sys.exit("the tests fail without any fault")


class Reach:
    """Which tests reach a line, the quickest first."""

    def __init__(self, copy: Path, reached: Path, times: Path) -> None:
        self._copy, self._data = copy, CoverageData(str(reached))
        self._data.read()
        self._root = next(file for file in self._data.measured_files() if file.endswith("src/repro/__init__.py"))[:-21]
        self._seconds: dict[str, float] = {}
        for case in ElementTree.parse(times).iter("testcase"):
            name = f"{case.get('classname')}.{case.get('name')}"
            self._seconds[name] = float(case.get("time") or 0)

    def _cost(self, test: str) -> float:
        file, name = test.split("::", 1)
        return self._seconds.get(f"{file.removesuffix('.py').replace('/', '.')}.{name.replace('::', '.')}", 60.0)

    def tests(self, fault: Fault) -> list[str]:
        """Those that run the line's statement; for what runs at import, those that run anything of its file."""
        if fault.room == "rules":
            return ["tests/project"]
        contexts = self._data.contexts_by_lineno(self._root + fault.file)
        tree = ast.parse((self._copy / fault.file).read_text(encoding="utf-8"))
        spans = [range(s.lineno, (s.end_lineno or s.lineno) + 1) for s in ast.walk(tree) if isinstance(s, ast.stmt)]
        inner = min((span for span in spans if fault.line in span), key=len, default=range(0))
        reached, anything = (
            {context.split("|")[0] for line in lines for context in contexts.get(line, ()) if context}
            for lines in (inner, contexts)
        )
        room = [f"tests/{fault.room}"]
        return sorted(reached, key=self._cost) or [*sorted(anything, key=self._cost), *room]


def _environment(copy: Path) -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(copy / "src")}


def noticed(fault: Fault, copy: Path, tests: list[str]) -> bool:
    """Whether a test fails, or nothing can be loaded."""
    path = copy / fault.file
    kept = path.read_text(encoding="utf-8")
    lines = kept.splitlines(keepends=True)
    lines[fault.line - 1] = fault.new + "\n"
    path.write_text("".join(lines), encoding="utf-8")
    try:
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *tests]
        run = subprocess.run(command, cwd=copy, env=_environment(copy), capture_output=True, check=False, timeout=900)
        return run.returncode != 0
    except subprocess.TimeoutExpired:
        return True  # a loop that does not end is seen by everybody
    finally:
        path.write_text(kept, encoding="utf-8")
        for compiled in path.parent.glob(f"__pycache__/{path.stem}.*.pyc"):  # known by seconds and size alone
            compiled.unlink()


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
        reached, times = args.out.with_suffix(".coverage").resolve(), args.out.with_suffix(".xml").resolve()
        if not (reached.exists() and times.exists()):
            measure(copy, reached, times)
        reach = Reach(copy, reached, times)
        rows = csv.writer(f)
        if not done:
            rows.writerow(("room", "file", "line", "noticed", "old", "new"))
        for room in args.rooms:
            pool = rule_faults() if room == "rules" else python_faults(room)
            count = min(len(pool), round(args.scale * ROOMS[room]))
            for fault in random.Random(f"{args.seed} {room}").sample(pool, count):
                if (fault.file, fault.line, fault.new) in done:
                    continue
                if (fault.file, fault.new.strip()) in EQUIVALENT:
                    seen = "equivalent"
                else:
                    seen = str(noticed(fault, copy, reach.tests(fault))).lower()
                rows.writerow((room, fault.file, fault.line, seen, fault.old, fault.new))
                f.flush()
                print(f"{seen:10} {fault.file}:{fault.line}: {fault.old.strip()}  ->  {fault.new.strip()}", flush=True)


if __name__ == "__main__":
    main()
