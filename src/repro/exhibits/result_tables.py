"""Tables of results: identified parameters (Tables 4, 5) and similarities (Tables 6, 7, 10)."""

from collections.abc import Hashable, Mapping, Sequence
from itertools import chain, product
from typing import Any

import pandas as pd

from repro.drawing.markup import Block, Table, Text, formula, number, plain, with_unit
from repro.drawing.style import METHODS, key_to, title_of

_FACTORS = {"time": "Time", "frequency": "Freq.", "total": "Total"}


def methods_of(table: pd.DataFrame) -> list[str]:
    """Methods of a table in the order of their blocks."""
    known = list(METHODS)
    return sorted(table["method"].unique(), key=lambda name: known.index(name) if name in known else len(known))


def heading_of(method: str) -> Text:
    """What a method is called."""
    return plain(title_of(method))


def by_method(frame: pd.DataFrame) -> list[Block]:
    """A block for each method."""
    return [(heading_of(method), frame[frame["method"] == method]) for method in methods_of(frame)]


def parameter_cells(frame: pd.DataFrame) -> tuple[dict[str, Text], dict[tuple[str, str, str], list[Text]], str]:
    """Name of each parameter, true and estimated value by method, case and parameter, and words on the spread."""
    names = {name: with_unit(formula(name), si) for name, si in zip(frame["parameter"], frame["unit"], strict=True)}
    cells = {
        (row["method"], row["case"], row["parameter"]): [
            number(row["true"], 4),
            number(row["estimate"], 4, row["estimate_sd"] or None),
        ]
        for row in frame.to_dict("records")
    }
    return names, cells, ", ± the standard deviation over the seeds" if frame["estimate_sd"].any() else ""


def parameters(frame: pd.DataFrame, cases: Sequence[str]) -> Table:
    """Lay out true and identified parameters, cases side by side, a block for each method."""
    names, cells, spread = parameter_cells(frame)
    blocks = []
    for method in methods_of(frame):
        rows = [
            [label, *chain.from_iterable(cells[method, case, name] for case in cases)] for name, label in names.items()
        ]
        blocks.append((heading_of(method), rows))
    caption = f"True and identified parameters of the numeric tests {' and '.join(cases)}: median seed{spread}. "
    caption += key_to(methods_of(frame))
    header = [plain("Parameter"), *(plain(f"{case} {word}") for case in cases for word in ("true", "identified"))]
    return Table(plain(caption.strip()), "l" + "rr" * len(cases), header, blocks)


def similarities(frame: pd.DataFrame, cases: Sequence[str], of_what: str) -> Table:
    """Lay out similarities in percent: rows by joint and factor, columns by case, a block for each method."""
    found = frame.set_index(["method", "case", "joint"]).to_dict("index")
    blocks = []
    for method in methods_of(frame):
        rows = []
        for joint, (factor, word) in product((1, 2), _FACTORS.items()):
            cells = [plain(word) + Text("~", " ") + formula(f"tau{joint}")]
            for case in cases:
                row = found[method, case, joint]
                spread = 100.0 * row["total_sd"] if factor == "total" and row["seeds"] > 1 else None
                cells.append(number(100.0 * row[factor], 2, spread))
            rows.append(cells)
        blocks.append((heading_of(method), rows))
    seeds = frame["seeds"].max()
    of_seeds = "one seed."
    if seeds > 1:
        of_seeds = f"median of {seeds:.0f} seeds, ± the standard deviation of the total over the seeds."
        if (frame["seeds"] == 1).any():
            of_seeds += " All cells of a block without ± have the same seed."
    caption = f"Similarity (%) of the torques rebuilt {of_what}: {of_seeds} {key_to(methods_of(frame))}"
    return Table(plain(caption.strip()), "l" + "r" * len(cases), [plain("Similarity (%)"), *map(plain, cases)], blocks)


def percent_interval(row: Mapping[Hashable, Any]) -> Text:
    """Cell of an interval in per cent; none if it cannot be computed."""
    if pd.isna(row["low"]):
        return plain("none")
    return plain(f"{100.0 * row['low']:.2f} to {100.0 * row['high']:.2f}")
