"""The ledger in words: a summary, and the Markdown page."""

from collections.abc import Hashable, Mapping
from typing import Any

import pandas as pd

from repro.paper.claims import DIFFERS, EXTENSION, SETTING, VERDICTS, broken

_HEADER = ("id", "quantity", "published", "ours", "tolerance", "verdict", "must", "target", "note")


def _number(value: object) -> str:
    return "" if pd.isna(value) else f"{value:.6g}"  # type: ignore[call-overload]


def _published(row: Mapping[Hashable, Any]) -> str:
    return f"{row['published']} {row['unit']}".removesuffix(" 1").removesuffix(" not printed")


def _cell(text: object) -> str:
    return str(text).replace("|", r"\|")


def _table(header: tuple[str, ...], rows: list[tuple[object, ...]]) -> list[str]:
    lines = [f"| {' | '.join(header)} |", f"|{'---|' * len(header)}"]
    return [*lines, *(f"| {' | '.join(_cell(c) for c in row)} |" for row in rows), ""]


def _rows(claims: pd.DataFrame) -> list[tuple[object, ...]]:
    return [
        (
            row["id"],
            row["quantity"],
            _published(row),
            _number(row["ours"]),
            _number(row["tolerance"]),
            row["verdict"],
            "must" if row["must"] else "",
            row["target"],
            row["note"],
        )
        for row in claims.to_dict("records")
    ]


def by_verdict(claims: pd.DataFrame) -> pd.DataFrame:
    """How many settings, results and results by an extension of ours have each verdict: rows of `VERDICTS`.

    Settings are counted apart: a reproduction that adopts them cannot come out otherwise.
    """
    setting = claims["kind"] == SETTING
    extension = claims["id"].str.contains(EXTENSION, regex=False)
    groups = {"settings": setting, "results": ~setting & ~extension, "extensions": ~setting & extension}
    counts = {name: claims.loc[chosen, "verdict"].value_counts() for name, chosen in groups.items()}
    return pd.DataFrame(counts).reindex(list(VERDICTS)).fillna(0).astype(int)


def summary(claims: pd.DataFrame) -> list[str]:
    """How many claims have each verdict, and every promise that does not hold."""
    counted = by_verdict(claims)
    kept, failed = claims["must"].sum(), broken(claims)
    totals = counted.sum()
    lines = [
        f"{totals['settings']} settings of the paper: "
        + ", ".join(f"{n} {verdict}" for verdict, n in counted["settings"].items() if n),
        f"{totals['results']} results of the paper, and {totals['extensions']} rows of extensions of ours beside them:",
    ]
    lines += [f"{row.results:5d}  {row.Index} (extensions: {row.extensions})" for row in counted.itertuples()]
    lines.append(f"{kept - len(failed):5d}  of {kept} promises hold")
    lines += [
        f"promise broken: {row['id']}: published {_published(row)}, ours {_number(row['ours'])}"
        for row in failed.to_dict("records")
    ]
    return lines


def markdown(claims: pd.DataFrame) -> str:
    """The ledger as a page."""
    failed = broken(claims)
    promises = claims[claims["must"]]
    by_kind = promises.groupby("kind", sort=True)["id"].size()
    kept = [(kind, number, number - int((failed["kind"] == kind).sum())) for kind, number in by_kind.items()]
    lines = ["# Claims", "", "Every number that the paper prints as its own, beside ours."]
    lines += ["What is measured on the arm is simulated: better means an easier arm there as much as a better method."]
    lines += [f"An id with `{EXTENSION}` holds an extension of ours against the same number.", ""]
    lines += ["Settings are what the authors chose and we adopt: they could not have come out otherwise.", ""]
    header = ("verdict", "results", "rows of extensions", "settings")
    rows = by_verdict(claims)[["results", "extensions", "settings"]].itertuples()
    lines += _table(header, [(row.Index, row.results, row.extensions, row.settings) for row in rows])
    lines += ["## Promises", ""]
    lines += _table(("kind", "promised", "hold"), list(kept))
    results = promises[promises["kind"].isin(["stochastic", "hardware-only"])]
    shown = claims[claims.index.isin(results.index.union(failed.index))]
    lines += ["Those about results, and those that do not hold:", "", *_table(_HEADER, _rows(shown))]
    lines += ["## What differs", "", *_table(_HEADER, _rows(claims[claims["verdict"] == DIFFERS]))]
    lines += ["## Every number", ""]
    for place in dict.fromkeys(claims["place"]):
        lines += [f"### {place}", "", *_table(_HEADER, _rows(claims[claims["place"] == place]))]
    return "\n".join(lines)
