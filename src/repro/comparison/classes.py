"""The three classes of number, the one definition for ledger, `verify`, `compare` and tests.

exact
    Text, integers, counts, the bytes of recordings: equal.
computed
    Floats that no network had a part in: equal but for what rounding makes of another order of sums,
    ``|a - b| <= ABSOLUTE + RELATIVE max(|a|, |b|)``. Zero is so compared absolutely.
trained
    What depends on a network, a random search or specimens simulated again. Another processor, or another seed, trains
    another network; such a number agrees within `MARGIN` times the widest difference that networks of other seeds and
    processors were seen to make in its table, method and column (`spread.csv`, written by
    ``benchmarks/training_spread.py``).

A hash of floats tells that they are equal, never that they disagree.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from repro.files import read_rows

#: Ten digits are written, so numbers a hair apart may be printed one unit of the tenth apart: 1e-9 of them at most.
#: Least squares is the worst that is computed: rounding (1.1e-16) times the square of the regressor's condition number
#: (11 on ID, 18 on the slow run) is 4e-14 of its estimates. One digit of room.
RELATIVE = 1e-8
#: A difference of two numbers of size 1 to 1000 carries 1e-16 to 1e-13 of rounding; the smallest printed number that
#: is held against ours is 7e-8.
ABSOLUTE = 1e-12
#: How far beyond the measured spread a trained number may lie: it was measured on few seeds.
MARGIN = 2.0


class Kind(StrEnum):
    """Class of a number."""

    EXACT = "exact"
    COMPUTED = "computed"
    TRAINED = "trained"


#: How the names of tables begin all of whose floats hang on a network, without a column that says so. Figures 14 to 17
#: show the validation motion of the seed that is the median of what a network found.
TRAINED_TABLES = (
    *("model/", "figures/paper_recipe", "tables/ablation", "figures/ablation", "figures/fig10", "figures/fig11"),
    *("tables/why", "figures/why", "factorial/", "tables/factorial", "figures/factorial"),
    *("coverage/", "tables/coverage", "tables/intervals", "figures/coverage"),
    *(f"figures/fig{n}" for n in (14, 15, 16, 17)),
    # Specimens are simulated anew, and the loop of a light arm is chaotic: another last bit of tanh, of a C library for
    # processors without FMA, moves single scores of any method by up to a tenth (docs/numbers.md).
    *("spread/", "tables/verdict", "figures/spread"),
)
#: Columns that say where a number comes from, and how those begin that a network had a part in.
ORIGIN = ("method", "series", "network")
#: The control without a network is among them: one last bit changes which of two equal candidates its selection keeps.
TRAINED_ORIGINS = ("algorithm1", "differential-evolution", "rebuilt")
#: Claims that are read off a trained table say so by their target; the ledger's own arithmetic is computed.
LEDGER = "claims"
TRAINED_TARGETS = frozenset({"training", "table04", "table05", "table06", "table07", "table09", "table10"})
#: Columns of a trained row that are exact all the same: they say how much was done.
COUNTED = frozenset({"seed", "seeds", "joint", "step", "runs", "arms", "arm", "bin", "number", "level", "true"})


def rounding(a: float, b: float) -> float:
    """How far two computed numbers may lie apart."""
    return ABSOLUTE + RELATIVE * max(abs(a), abs(b))


def origin(row: Mapping[str, str]) -> str:
    """What a row is about: the first of the columns `ORIGIN` that it has, or of a claim that; empty if it has none."""
    if "published" in row:
        return _claimed(row["id"])
    return next((row[column] for column in ORIGIN if column in row), "")


def _claimed(claim: str) -> str:
    """A claim without its table's cell: ``table10/ID/algorithm1/time/joint2`` is of ``table10/algorithm1/time``."""
    place, at, variant = claim.partition("@")
    table, *rest = place.split("/")
    if not (table.startswith("table") and len(rest) > 2):
        return claim
    _, method, quantity, *joint = rest
    return "/".join([table, method, *([quantity] if joint else [])]) + at + variant


def kind_of(table: str, row: Mapping[str, str], column: str) -> Kind:
    """Class of the floats in a cell."""
    if column in COUNTED:
        return Kind.COMPUTED
    if table == LEDGER:
        trained = row["target"] in TRAINED_TARGETS and "least-squares" not in row["id"]
    else:
        trained = table.startswith(TRAINED_TABLES) or origin(row).startswith(TRAINED_ORIGINS)
    return Kind.TRAINED if trained else Kind.COMPUTED


@dataclass(frozen=True)
class Spread:
    """Widest differences between networks of other seeds and processors."""

    widest: Mapping[tuple[str, str, str], float]  # by table, origin and column

    def allowed(self, table: str, row: Mapping[str, str], column: str) -> float:
        """How far two trained numbers may lie apart; NaN where no spread was measured."""
        return MARGIN * self.widest.get((table, origin(row), column), float("nan"))


def measured_spread() -> Spread:
    """The spread of the default networks, as ``benchmarks/training_spread.py`` measured it."""
    rows = read_rows(Path(__file__).with_name("spread.csv"))
    return Spread({(row["table"], row["origin"], row["column"]): float(row["widest"]) for row in rows})
