"""What a report says first: the headline similarities, and whether Algorithm 1 is better than least squares."""

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import pandas as pd

from repro.drawing.markup import Table, plain
from repro.drawing.style import title_of
from repro.errors import InputError
from repro.experiments import monte_carlo
from repro.files import read_csv
from repro.paper.claims import summary
from repro.paper.published import load_published, similarity_cells
from repro.signals.programs import SPAN, VALIDATION

_MINUS = "\N{MINUS SIGN}"
NUMERIC: Final = ("N1", "N2", "N3", "N4")
#: Columns of the headline: the table that each is of, and its cases.
COLUMNS: Final = {
    "N1-N4, ID": ("table06", NUMERIC),
    "N1-N4, new motion": ("table07", NUMERIC),
    "arm, ID": ("table10", ("ID",)),
    f"arm, {SPAN}": ("table10", tuple(VALIDATION)),
}
#: Methods of the headline, and published rows, each before the method that it is compared with.
METHODS: Final = ("algorithm1", "algorithm1/one-run", "least-squares", "bounded", "differential-evolution", "true")
PRINTED: Final = {"algorithm1": "Published, Algorithm 1", "least-squares": "Published, least squares"}
#: Mean total of N1 to N4 that the abstract prints; the cells of Table 6 are lost.
_ABSTRACT = "abstract/numeric/total"


def means(scores: pd.DataFrame, column: str) -> pd.Series:
    """Mean total over the cases and joints of a column by method; NaN for one that lacks a cell."""
    cases = COLUMNS[column][1]
    own = scores[scores["case"].isin(cases)].groupby("method")["total"].agg(["mean", "size"])
    return own["mean"].where(own["size"] == 2 * len(cases))


def headline(tables: Path) -> pd.DataFrame:
    """Similarities as fractions, columns of the headline by methods of Tables 6, 7 and 10 in this folder."""
    scores = {
        name: read_csv(tables / f"{name}.csv", ("case", "method", "joint", "total")) for name, _ in COLUMNS.values()
    }
    return pd.DataFrame({column: means(scores[table], column) for column, (table, _) in COLUMNS.items()})


def published_headline() -> pd.DataFrame:
    """What the paper prints of them, as text in %, empty where nothing."""
    numbers = load_published()
    cells = similarity_cells(numbers)
    shown = {}
    for column, (table, _) in COLUMNS.items():
        own = means(cells[cells["place"] == f"Table {int(table[-2:])}"], column)
        shown[column] = own.dropna().map("{:.2f}".format)
    total = numbers[_ABSTRACT]
    shown["N1-N4, ID"] = pd.Series({"algorithm1": f"{total.relation} {total}"})
    return pd.DataFrame(shown).fillna("")


def shares(results: Path) -> dict[str, dict[str, str]]:
    """The headline of a run as text in %: of each method, by column."""
    own = headline(results / "tables").reindex(METHODS)
    return {method: dict(zip(COLUMNS, map(_percent, own.loc[method]), strict=True)) for method in METHODS}


def headline_table(results: Path) -> Table:
    """The headline of a run in %, each method below what the paper prints of it."""
    printed, rows = published_headline(), []
    for method, own in shares(results).items():
        if method in PRINTED:
            rows.append([PRINTED[method], *printed.loc[method]])
        rows.append([title_of(method), *own.values()])
    laid_out = [[plain(cell) for cell in row] for row in rows]
    caption = plain("Similarity of measured and rebuilt torque in %: means over cases and joints.")
    return Table(caption, "l" + "r" * len(COLUMNS), [plain(""), *map(plain, COLUMNS)], [(None, laid_out)])


def _percent(value: float, decimals: int = 2) -> str:
    """A fraction in percent; empty where there is none."""
    return "" if pd.isna(value) else f"{100.0 * value:.{decimals}f}"


_WORDS = {
    monte_carlo.BETTER: "Yes",
    monte_carlo.WORSE: "No",
    monte_carlo.SAME: "Neither",
    monte_carlo.OPEN: "Undecided",
}


@dataclass(frozen=True)
class Answer:
    """Whether Algorithm 1 is better than least squares, tested over the accepted experiments."""

    word: str
    why: str  # a sentence with the difference and its interval
    pairs: Sequence[Mapping[Hashable, Any]]  # comparisons of all methods


def answer(results: Path, guesses: int) -> Answer:
    """The answer of a run with so many guesses in each experiment."""
    method, opponent = "algorithm1", "least-squares"  # as listed in the paper, and the opponent that the paper chose
    path = results / "tables" / "verdict.csv"
    table = read_csv(path, monte_carlo.COMPARISON_COLUMNS)
    table = table.assign(points=[_points(row) for row in table.to_dict("records")])
    asked = table[(table["method"] == method) & (table["opponent"] == opponent)]
    if asked.empty:
        found = f"no {method!r} against {opponent!r} on {SPAN}"
        raise InputError.at(f"{path}: method", found, f"rows of {method}")
    row = asked.iloc[0]
    why = f"over {row['experiments']} simulated experiments that the printed numbers do not rule out"
    why += f", with one run of at most {guesses:,} guesses each, Algorithm 1 as listed is {_compared(row)} on {SPAN}."
    titles = {name: table[name].map(title_of) for name in ("method", "opponent")}
    return Answer(_WORDS[row["conclusion"]], why, table.assign(**titles).to_dict("records"))


def lowest_cells(results: Path, method: str = "algorithm1") -> int:
    """How many cells of the new motions of the arm have the lowest similarity, 0."""
    column = [*COLUMNS][-1]
    scores = read_csv(results / "tables" / f"{COLUMNS[column][0]}.csv", ("case", "method", "joint", "total"))
    own = scores[(scores["method"] == method) & scores["case"].isin(COLUMNS[column][1])]
    return int((own["total"] == 0.0).sum())


def trained_as_printed(recipe: Path) -> str:
    """Mean total of N1 to N4 in %, by a network that is trained as the paper prints: from its table."""
    scores = read_csv(recipe, ("case", "method", "joint", "total"))
    return _percent(means(scores, next(iter(COLUMNS)))["algorithm1+paper-recipe-ranges"])


def longer_searches(accepted: Path) -> dict[str, str]:
    """Medians over the accepted experiments, in %, with the most guesses that all of them have: from their table."""
    table = read_csv(accepted, ("unit", "method", "guesses", "experiments", "mean_median"))
    table = table[(table["unit"] == "all") & (table["experiments"] == table["experiments"].max())]
    last = table.sort_values("guesses").groupby("method").tail(1).set_index("method")
    searched, level = last.loc["algorithm1"], last.loc["least-squares"]
    return {
        "guesses": f"{searched['guesses']:,}",
        "experiments": str(searched["experiments"]),
        "algorithm1": _percent(searched["mean_median"], 1),
        "least_squares": _percent(level["mean_median"], 1),
    }


def _compared(row: pd.Series) -> str:
    """How much better or worse, in points of a percent, with the simultaneous interval."""
    difference, low, high = (100.0 * float(row[name]) for name in ("difference", "low", "high"))
    word = monte_carlo.BETTER if difference > 0.0 else monte_carlo.WORSE
    ends = (low, high) if difference > 0.0 else (-high, -low)
    interval = "{:.1f} to {:.1f}".format(*ends).replace("-", _MINUS)
    return f"{abs(difference):.1f} points {word} than least squares (95 % interval {interval})"


def _points(row: Mapping[Hashable, Any]) -> str:
    """Points of a percent, with the simultaneous interval."""
    difference, low, high = (100.0 * float(row[name]) for name in ("difference", "low", "high"))
    return f"{difference:+.2f} points ({low:+.2f} to {high:+.2f})".replace("-", _MINUS)


def closing_lines(results: Path, figures: Path, config_files: Sequence[str | Path] = ()) -> list[str]:
    """Give what a run of every target ends with on the screen; nothing where the ledger was not made."""
    if not (results / "claims.csv").exists() or not (results / "tables/table10.csv").exists():
        return []
    table = headline_table(results)
    rows = [table.header, *table.blocks[0][1]]
    widths = [max(len(row[column].md) for row in rows) for column in range(len(table.header))]
    lines = ["", table.caption.md]
    for first, *others in rows:
        cells = (f"{cell.md:>{width}}" for cell, width in zip(others, widths[1:], strict=True))
        lines.append("  ".join(["", f"{first.md:<{widths[0]}}", *cells]))
    claims = pd.read_csv(results / "claims.csv", keep_default_na=False)
    numbers = claims.assign(ours=pd.to_numeric(claims["ours"], errors="coerce"))
    page = results / "report/index.html"
    overlaid = f" --config {' '.join(map(str, config_files))}" if len(config_files) > 1 else ""
    check = f"check: .venv/bin/repro verify --results {results}{overlaid}"
    return [*lines, "", *summary(numbers), "", f"report: {page}", f"figures: {figures}", check]
