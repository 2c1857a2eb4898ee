"""The classes of number, and two tables or two results folders compared by them.

exact
    Text, integers, counts, the bytes of recordings: equal.
computed
    Floats that no network had a part in: equal but for what rounding makes of another order of sums,
    ``|a - b| <= ABSOLUTE + RELATIVE max(|a|, |b|)``. Zero is so compared absolutely.
simulated
    The same, of arms that a run simulates again, whose closed loops may be chaotic.
trained
    What depends on a network or a random search.

The class belongs to row and column. Hosts with one fingerprint make the same bits, so that all classes are compared as
computed there. Elsewhere a trained number may differ by the smallest of three limits: `MARGIN` times the widest
difference that networks of other seeds and processors made for its method and column (`spread.csv`, written by
``benchmarks/training_spread.py``); `OF_SEEDS` times the standard deviation of this very number over its seeds of
guesses, where its row has it; and, of a similarity, `LARGEST`, which is the limit of a simulated similarity too.
"""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path

from repro.errors import InputError
from repro.files import read_rows
from repro.fingerprint import OF_NETWORKS

#: Files have ten digits, so rounding alone may change a number by 1e-9 of itself. The tolerance is ten times that. The
#: rounding of computations is smaller. It is largest in least squares: 4e-14 of an estimate, which is 1.1e-16 times the
#: square of the regressor's condition number (11 on ID, 18 on the slow run).
RELATIVE = 1e-8
#: The difference of two numbers of size 1 to 1000 has a rounding error of 1e-16 to 1e-13. The smallest printed number
#: that is compared with ours is 7e-8.
ABSOLUTE = 1e-12
#: Factor on the measured spread over networks, because few were measured.
MARGIN = 2.0
#: Factor on the standard deviation over seeds of guesses. The one over networks is up to 2.2 times as large (Table 5 of
#: the numeric tests), so a difference of two networks is within three of its standard deviations.
OF_SEEDS = 9.0
#: Largest difference of two similarities on any hosts. Last bits alone move that of an arm that chatters by as much.
LARGEST = 0.1

Row = Mapping[str, str]


class Kind(StrEnum):
    """Class of a number."""

    EXACT = "exact"
    COMPUTED = "computed"
    SIMULATED = "simulated"
    TRAINED = "trained"


#: Columns that name the origin of a number, and those of them that name all methods that had a part in it.
ORIGIN = ("method", "series", "network")
METHODS = ("method", "opponent", "reader")
#: Beginnings of the origins that depend on a network. The ablation without the network is one of them, because a last
#: bit changes which of two equal candidates its selection keeps.
TRAINED_ORIGINS = ("algorithm1", "differential-evolution", "rebuilt", "posterior", "flow", "cnn", "plain")
#: The ledger of published numbers.
LEDGER = "claims"
#: Columns of a trained row that do not depend on the network: counts, and values that the paper prints.
COUNTED = frozenset({"seed", "seeds", "joint", "step", "runs", "arms", "arm", "bin", "number", "level"})
PRINTED = frozenset({"true", "published"})
#: Columns of similarities and their differences, 0 to 1, in rows that name methods. Ends of intervals are none of them:
#: one arm that chatters moves the end of an interval over the arms further.
SIMILARITIES = re.compile(
    r"time|frequency|total|((numeric|frequency)_)?(id|validation)|(id1|id2|mean)(_median)?|median|difference"
)
#: Column with the standard deviation of a column over seeds of guesses.
DEVIATION = dict.fromkeys(("time", "frequency", "total"), "total_sd") | {"estimate": "estimate_sd", "value": "spread"}


def origin(row: Row) -> str:
    """Return what a row is about: the first of the columns `ORIGIN` that it has, or its id if it is a claim."""
    if not {"id", "published"} <= row.keys():
        return next((row[column] for column in ORIGIN if column in row), "")
    # Without the cell of its table: ``table10/ID/algorithm1/time/joint2`` is of ``table10/algorithm1/time``.
    return re.sub(r"^(table\w*)/[^/]+/([^/@]+)(/[^/@]+(?=/))?/[^@]*", r"\1/\2\3", row["id"])


def _methods(row: Row) -> list[str]:
    return [row[name] for name in METHODS if name in row]


#: Columns that name a row.
NAMES_OF_ROWS = {"case", "method", "opponent", "joint", "parameter", "id", "target"}


@dataclass(frozen=True)
class Tolerances:
    """Which results depend on a network, and how far networks of other seeds and processors differ in them."""

    folders: tuple[str, ...] = ()  # beginnings of the names of tables that networks or arms simulated again made
    tables: frozenset[str] = frozenset()  # names of further tables of that kind
    targets: frozenset[str] = frozenset()  # claims about these depend on a network, except those of least squares
    widest: Mapping[tuple[str, str, str], float] = field(default_factory=dict)  # by table, origin and column
    reproducible: frozenset[Kind] = frozenset()  # classes that are compared as computed, by the hosts of both runs

    def kind(self, table: str, row: Row, column: str) -> Kind:
        """Class of the floats in a cell."""
        if column in COUNTED | PRINTED:
            return Kind.COMPUTED
        if table == LEDGER:
            trained = row["target"] in self.targets and "least-squares" not in row["id"].split("/")
            return Kind.TRAINED if trained else Kind.COMPUTED
        methods = _methods(row)
        if any(name.startswith(TRAINED_ORIGINS) for name in (*methods, origin(row))):
            return Kind.TRAINED
        if table not in self.tables and not table.startswith(self.folders):
            return Kind.COMPUTED
        return Kind.SIMULATED if methods else Kind.TRAINED

    def allowed(self, table: str, row: Row, column: str) -> float:
        """Largest difference of two numbers that depend on the host; NaN where nothing was measured."""
        limits = []
        if self.kind(table, row, column) is Kind.TRAINED:
            limits = [MARGIN * self.widest[key]] if (key := (table, origin(row), column)) in self.widest else []
            deviation = _number(row.get(DEVIATION.get(column, ""), ""))
            limits += [OF_SEEDS * deviation] if deviation else []
        percent = row.get("unit") == "%"
        if percent or (_methods(row) and SIMILARITIES.fullmatch(column)):
            limits.append(100.0 * LARGEST if percent else LARGEST)
        return min(limits, default=math.nan)


def reproducible(a: Mapping[str, str] | None, b: Mapping[str, str] | None) -> frozenset[Kind]:
    """Classes whose numbers two hosts make to the same bits, by their fingerprints."""
    if not a or not b:
        return frozenset()
    apart = [name for name in a.keys() | b.keys() if a.get(name) != b.get(name)]
    if not apart:
        return frozenset({Kind.SIMULATED, Kind.TRAINED})
    return frozenset({Kind.SIMULATED}) if all(name.startswith(OF_NETWORKS) for name in apart) else frozenset()


def measured_spread() -> dict[tuple[str, str, str], float]:
    """Widest differences of the default networks, as ``benchmarks/training_spread.py`` measured them."""
    rows = read_rows(Path(__file__).with_name("spread.csv"))
    return {(row["table"], row["origin"], row["column"]): float(row["widest"]) for row in rows}


@dataclass(frozen=True)
class Difference:
    """A cell that is not the same text."""

    kind: Kind  # class of the cell
    place: str  # row and column
    a: str  # the two texts
    b: str
    size: float = math.inf  # absolute difference; infinite if one is no number
    allowed: float = 0.0  # how much its class allows; NaN if that was not measured

    @property
    def broken(self) -> bool:
        """Whether the class does not allow it."""
        return self.size > self.allowed

    @property
    def judged(self) -> bool:
        """Whether a limit is known."""
        return not math.isnan(self.allowed)

    @property
    def rank(self) -> tuple[float, float]:
        """Size in units of what is allowed, small where nothing was measured; then the size itself."""
        return self.size / self.allowed if self.allowed > 0 else math.inf if self.broken else 0.0, self.size


def differences(table: str, a: Sequence[Row], b: Sequence[Row], tolerances: Tolerances) -> Iterator[Difference]:
    """Yield the cells of two tables that are not the same text, and rows or columns that only one has."""
    if len(a) != len(b):
        yield Difference(Kind.EXACT, "number of rows", str(len(a)), str(len(b)))
        return
    for number, (x, y) in enumerate(zip(a, b, strict=True), start=2):
        if list(x) != list(y):
            yield Difference(Kind.EXACT, "header", ", ".join(x), ", ".join(y))
            return
        changed = [column for column in x if x[column] != y[column]]
        moved = any(_number(x[column]) is not None and _number(y[column]) is not None for column in changed)
        for column in changed:
            kind, size, allowed = _judge(table, x, column, y[column], tolerances, moved)
            yield Difference(kind, f"line {number}, {column}", x[column], y[column], size, allowed)


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def _judge(
    table: str, row: Row, column: str, other: str, tolerances: Tolerances, moved: bool
) -> tuple[Kind, float, float]:
    """Class of a cell, its difference from another text, and what is allowed; `moved`: a number of its row differs."""
    kind = tolerances.kind(table, row, column)
    numbers = [number for number in map(_number, (row[column], other)) if number is not None]
    if len(numbers) == 1 and math.isfinite(numbers[0]):
        return kind, math.inf, 0.0
    # A text cell may change only if a number of its row changed, and never if it names the row.
    if len(numbers) < 2:
        exact = kind is Kind.COMPUTED or column in NAMES_OF_ROWS or not moved
        return (Kind.EXACT, math.inf, 0.0) if exact else (kind, math.inf, math.nan)
    a, b = numbers
    if not math.isfinite(a - b):
        return kind, 0.0 if str(a) == str(b) else math.inf, 0.0
    allowed = ABSOLUTE + RELATIVE * max(abs(a), abs(b))
    if kind is not Kind.COMPUTED and kind not in tolerances.reproducible:
        measured = tolerances.allowed(table, row, column)
        allowed = measured if math.isnan(measured) else max(allowed, measured)
    return kind, abs(a - b), allowed


#: Files that are compared byte by byte: recordings and their programs.
BYTES = ("experiment/*.bin", "experiment/*.program")
#: Folders that are not compared, because they describe the run and not its results.
LEFT_OUT = ("benchmarks", "logs")
#: Most files that are named of those that only one folder has.
SHOWN = 5


@dataclass(frozen=True)
class Compared:
    """What became of one file."""

    name: str  # path in the results folder
    cells: int  # cells, or bytes, that were compared
    found: tuple[Difference, ...]  # every cell whose text differs

    def largest(self) -> list[Difference]:
        """The difference of each class that lies furthest towards or beyond what is allowed."""
        by_kind = {kind: [each for each in self.found if each.kind is kind] for kind in Kind}
        return [max(each, key=lambda d: d.rank) for each in by_kind.values() if each]

    @property
    def broken(self) -> bool:
        """Whether a class is broken."""
        return any(each.broken for each in self.found)

    @property
    def judged(self) -> bool:
        """Whether a limit is known for each cell that differs."""
        return all(each.judged for each in self.found)


def compare_runs(a: Path, b: Path, tolerances: Tolerances) -> tuple[list[Compared], tuple[list[str], list[str]]]:
    """Compare every table and recording that both folders have; name those that only the first or the second has."""
    first, second = _files(a), _files(b)
    if not first & second:
        raise InputError.at(f"{a} and {b}", "no table in common", "two results folders")
    alone = sorted(first - second), sorted(second - first)
    return [_compare(a, b, name, tolerances) for name in sorted(first & second)], alone


def _files(folder: Path) -> set[str]:
    if not folder.is_dir():
        raise InputError.at(str(folder), "no folder", "a results folder")
    for entry in folder.iterdir():
        if entry.is_symlink() and not entry.exists():
            raise InputError.at(str(entry), "a link that leads nowhere", "a folder or a file of a run")
    found = {path for pattern in ("*.csv", "*/*.csv", "*/*/*.csv", *BYTES) for path in folder.glob(pattern)}
    files = {path for path in found if path.relative_to(folder).parts[0] not in LEFT_OUT}
    for path in files:
        if not path.is_file():
            raise InputError.at(str(path), "no regular file", "a table or a recording of a run")
    return {path.relative_to(folder).as_posix() for path in files}


def _compare(a: Path, b: Path, name: str, tolerances: Tolerances) -> Compared:
    if not name.endswith(".csv"):
        x, y = ((folder / name).read_bytes() for folder in (a, b))
        first = next((k for k, (p, q) in enumerate(zip(x, y, strict=False)) if p != q), min(len(x), len(y)))
        changed = Difference(Kind.EXACT, f"byte {first}", f"{len(x)} bytes", f"{len(y)} bytes", 1.0, 0.0)
        return Compared(name, len(x), (changed,) if x != y else ())
    rows = read_rows(a / name), read_rows(b / name)
    return Compared(name, sum(map(len, rows[0])), tuple(differences(name.removesuffix(".csv"), *rows, tolerances)))


def report(compared: Sequence[Compared], alone: Sequence[Sequence[str]], tolerances: Tolerances) -> list[str]:
    """Lines for a reader: a line for each file and class that differs, then the largest of each class."""
    lines = []
    for each in compared:
        for d in each.largest():
            number = sum(other.kind is d.kind for other in each.found)
            lines.append(f"{each.name}: {_describe(d)}; {number} of {each.cells} cells")
    same = sum(not each.found for each in compared)
    lines.append(f"{len(compared)} files compared, {same} the same to the last digit")
    for which, names in zip(("first", "second"), alone, strict=True):
        rest = f", {len(names) - SHOWN} more" if len(names) > SHOWN else ""
        lines += [f"{len(names)} in the {which} folder alone: {', '.join(names[:SHOWN])}{rest}"] if names else []
    for kind in Kind:
        own = [(d.rank, f"{each.name}: {_describe(d)}") for each in compared for d in each.largest() if d.kind is kind]
        alike = " (as computed: both hosts make the same bits)" if kind in tolerances.reproducible else ""
        lines.append(f"largest {kind}{alike}: {max(own, key=lambda entry: entry[0])[1] if own else 'none differs'}")
    if names := [each.name for each in compared if not each.judged]:
        lines.append(f"not judged, as no limit is known: cells of {', '.join(names)}")
    broken = [each.name for each in compared if each.broken]
    lines.append(f"broken: {', '.join(broken)}" if broken else "no class is broken")
    return [*lines, _counts([d for each in compared for d in each.found])]


def _counts(found: Sequence[Difference]) -> str:
    if not found:
        return "no cell differs"
    trained, unknown = sum(d.broken and d.kind is Kind.TRAINED for d in found), sum(not d.judged for d in found)
    faults = sum(d.broken for d in found) - trained
    within = len(found) - faults - trained - unknown
    beyond = f"beyond them {trained} that depend on a network and {faults} that do not (faults)"
    return f"cells that differ: {within} within the limits, {beyond}, {unknown} not judged"


def _describe(d: Difference) -> str:
    allowed = f"{d.allowed:.2g} allowed" if d.judged else "not judged"
    by = f", by {d.size:.2g}" if d.kind is not Kind.EXACT and math.isfinite(d.size) else ""
    return f"{d.kind}: {d.place}: {d.a or 'nothing'} and {d.b or 'nothing'}{by} ({allowed})"
