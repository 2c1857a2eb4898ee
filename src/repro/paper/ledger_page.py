"""The claims ledger for readers: a summary, the Markdown page, and one cause for each number that differs."""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import Any

import pandas as pd

from repro.paper.claims import DIFFERS, EXTENSION, VERDICTS, Basis, broken


@dataclass(frozen=True)
class Cause:
    """A cause, and the page or table that shows it."""

    title: str
    why: str
    evidence: str  # page of docs/ with its anchor, or target of the workflow


CAUSES: dict[str, Cause] = {
    "closed-loop motion": Cause(
        "Algorithm 1 as listed on a motion that an arm has tracked",
        "The network is trained on Eq. 10 itself. Line 18 gives it the measured motion, whose acceleration has spikes "
        "where friction reverses, and the torque contains effects that Eq. 1 does not model. Closed-loop training, the "
        "desired motion in line 18, back-EMF and the reader each change the result on T1 to T4.",
        "explanation/experiment.md#the-factorial-of-causes",
    ),
    "image reader": Cause(
        "What closed-loop training and the desired motion leave",
        "A plain network that reads the torque samples instead of the image of Eq. 9 is better by more than what is "
        "left here.",
        "explanation/experiment.md#the-factorial-of-causes",
    ),
    "another arm": Cause(
        "A simulated arm in place of the published one",
        "The arm is calibrated on the least-squares cells of ID, and the bands of T1 were chosen by those of T1. Its "
        "friction, ripple and motors are not the published arm's, so all other cells are predictions for another arm.",
        "explanation/experiment.md#four-numbers-calibrate-the-simulated-arm",
    ),
    "another network": Cause(
        "One trained network in place of another",
        "The interval is over the seeds of the guesses. Estimates and similarities of a network of another training "
        "seed differ by more, and the paper's weights are not available.",
        "numbers.md#how-networks-scatter",
    ),
    "lag of the gains": Cause(
        "The lag of joint 1 that its gains imply",
        "With the gains as printed joint 1 follows with a lag of K_v h / K_p = 17.6 ms, twice that of joint 2.",
        "explanation/experiment.md#gains-and-arithmetic-of-the-controller",
    ),
    "unlisted memory": Cause(
        "Memory that the paper does not list",
        "The count is of the stored trajectory alone. Gains and buffers come on top.",
        "reference/tables/audit.md",
    ),
}

_COLUMNS = ("id", "quantity", "published", "ours", "tolerance", "verdict", "asserted", "target", "note")
_HEADER = tuple("made by" if name == "target" else name for name in _COLUMNS)
#: Column of `by_basis` for rows of extensions, whatever they rest on.
EXTENSIONS = "extensions"


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
    shown = claims.assign(
        published=[_published(row) for row in claims.to_dict("records")],
        ours=claims["ours"].map(_number),
        tolerance=claims["tolerance"].map(_number),
    )
    return list(shown[list(_COLUMNS)].itertuples(index=False, name=None))


def by_basis(claims: pd.DataFrame) -> pd.DataFrame:
    """Count the verdicts (rows) by what the comparison rests on (columns); extensions of ours are counted apart."""
    extension = claims["id"].str.contains(EXTENSION, regex=False)
    groups = {str(basis): ~extension & (claims["basis"] == basis) for basis in Basis} | {EXTENSIONS: extension}
    counts = {name: claims.loc[chosen, "verdict"].value_counts() for name, chosen in groups.items()}
    return pd.DataFrame(counts).reindex(list(VERDICTS)).fillna(0).astype(int)


def _listed(counts: "pd.Series[int]") -> str:
    return ", ".join(f"{number} {verdict}" for verdict, number in counts.items() if number)


def _asserted(claims: pd.DataFrame) -> tuple[int, int]:
    """How many claims are asserted, and how many of them have the asserted verdict."""
    asserted = int((claims["asserted"] != "").sum())
    return asserted, asserted - len(broken(claims))


def summary(claims: pd.DataFrame) -> list[str]:
    """How many claims have each verdict, by what the comparison rests on, and every asserted claim that fails."""
    counted = by_basis(claims)
    width = max(map(len, counted.columns))
    lines = [f"{name:<{width}}  {counted[name].sum():4d}  {_listed(counted[name])}" for name in counted.columns]
    asserted, satisfied = _asserted(claims)
    lines.append(f"{satisfied} of {asserted} asserted claims are as asserted")
    lines += [
        f"not as asserted: {row['id']}: {row['verdict']} instead of {row['asserted']}, "
        f"published {_published(row)}, ours {_number(row['ours'])}"
        for row in broken(claims).to_dict("records")
    ]
    return lines


def _counts(claims: pd.DataFrame) -> list[str]:
    counted = by_basis(claims)
    return _table(
        ("verdict", *counted.columns),
        [(name, *row) for name, row in zip(counted.index, counted.to_numpy(), strict=True)],
    )


def _differences(claims: pd.DataFrame) -> list[str]:
    lines = ["## What differs, by cause", ""]
    differing = claims[claims["verdict"] == DIFFERS]
    for name, cause in CAUSES.items():
        own = differing[differing["cause"] == name]
        if len(own):
            lines += [
                f"### {cause.title}",
                "",
                f"{cause.why} Evidence: {cause.evidence}.",
                "",
                *_table(_HEADER, _rows(own)),
            ]
    return lines


def markdown(claims: pd.DataFrame, specific: pd.DataFrame) -> str:
    """The ledger as a page."""
    asserted, satisfied = _asserted(claims)
    failed = broken(claims)
    lines = ["# Claims", "", "Every number that the paper prints as its own, next to ours.", ""]
    lines += [
        "A match is evidence only in the columns *numeric* (the paper's own arms N1 to N4) and *simulated arm* "
        "(another arm than the paper's). The other columns could not have come out otherwise.",
        f"An id with `{EXTENSION}` compares an extension of ours with the same number.",
        "",
        *_counts(claims),
        "## Specificity",
        "",
        "Of the numbers that are called reproduced: how often the published value of another case lies outside the "
        "tolerance.",
        "",
        *_table(
            ("basis", "of", "numbers", "pairs", "outside"),
            [tuple(row) for row in specific.itertuples(index=False)],
        ),
        "## Asserted claims",
        "",
        f"{satisfied} of {asserted} have the asserted verdict. Those about results, and those that fail:",
        "",
    ]
    of_results = (claims["asserted"] != "") & claims["basis"].isin([str(Basis.NUMERIC), str(Basis.ARM)])
    lines += _table(_HEADER, _rows(claims[of_results | claims.index.isin(failed.index)]))
    lines += [*_differences(claims), "## Every number", ""]
    for place in dict.fromkeys(claims["place"]):
        lines += [f"### {place}", "", *_table(_HEADER, _rows(claims[claims["place"] == place]))]
    return "\n".join(lines)
