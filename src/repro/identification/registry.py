"""The methods of the paper's tables: names, titles, looks and order, in one place.

What a method computes stands with the method; everything that lists, orders, labels or draws methods takes this.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Entry:
    """How a method appears.

    Attributes
    ----------
    title : str
        In tables.
    solver : str or None
        Name in `repro.identification.methods` of the method that gives it, where it is least squares.
    label : str
        In legends.
    stroke, mark : mapping
        Of curves and points, as matplotlib names them.
    """

    title: str
    label: str
    stroke: Mapping[str, Any]
    mark: Mapping[str, Any]
    solver: str | None = None


def _look(
    color: str, dashes: tuple[float, ...], width: float, marker: str, size: float, *, hollow: bool = False
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Stroke and mark of one colour."""
    mark: dict[str, Any] = {
        "marker": marker,
        "markersize": size,
        "markeredgewidth": {"x": 0.9, "+": 0.8}.get(marker, 0.0),
    }
    if hollow:
        mark |= {"fillstyle": "none", "markeredgewidth": 0.7}
    return {"color": color, "linestyle": (0, dashes) if dashes else "-", "linewidth": width}, mark


_DASH_DOT, _SHORT = (6.0, 1.2, 1.2, 1.2), (2.0, 1.2)

#: By name, in the order of tables and legends; the first is the paper's as listed.
METHODS: dict[str, Entry] = {
    "algorithm1": Entry("Algorithm 1", "Algorithm 1", *_look("#5ab8ea", _DASH_DOT, 1.1, "o", 3.4)),
    "algorithm1/one-run": Entry(
        "Algorithm 1, one run", "Algorithm 1, one run", *_look("#5ab8ea", _SHORT, 1.1, "d", 3.4)
    ),
    "algorithm1+desired": Entry(
        "Algorithm 1, f of line 18 on the desired motion (extension)",
        "Algorithm 1, desired motion",
        *_look("#3b7dbd", _SHORT, 1.0, "*", 4.2),
    ),
    "algorithm1+tracked-measured": Entry(
        "Algorithm 1, trained on closed-loop motions, f on the measured motion (extension)",
        "Algorithm 1, closed-loop training",
        *_look("#c080c4", _SHORT, 1.0, "P", 3.6),
    ),
    "algorithm1+tracked": Entry(
        "Algorithm 1, trained on closed-loop motions, f on the desired motion (extension)",
        "Algorithm 1, both",
        *_look("#8a3a8f", _DASH_DOT, 1.1, "p", 3.6),
    ),
    "algorithm1+tracked/one-run": Entry(
        "Algorithm 1, trained on closed-loop motions, f on the desired motion, one run (extension)",
        "Algorithm 1, both, one run",
        *_look("#8a3a8f", _SHORT, 1.1, "8", 3.4),
    ),
    "algorithm1+refinement": Entry(
        "Algorithm 1 + refinement (extension)",
        "Algorithm 1 + refinement",
        *_look("#004a78", (), 0.9, "D", 3.2, hollow=True),
    ),
    "algorithm1+local-search": Entry(
        "Algorithm 1 + the refinement's selection without the network (control)",
        "Algorithm 1 + selection alone",
        *_look("#a6761d", _SHORT, 1.0, "v", 3.4),
    ),
    "differential-evolution": Entry(
        "Differential evolution from uniform guesses, no network (control)",
        "Differential evolution, no network",
        *_look("#44aa99", (3.5, 2.5), 1.0, "X", 3.4),
    ),
    "algorithm1+paper-recipe": Entry(
        "Algorithm 1, the paper's own training",
        "Algorithm 1, the paper's training",
        *_look("#666666", _DASH_DOT, 1.1, "h", 3.4),
    ),
    "least-squares": Entry("Least squares", "Least squares", *_look("#d1490a", (3.5, 2.5), 1.1, "x", 3.4), "ordinary"),
    "bounded": Entry(
        "Least squares, no parameter below zero (line 22's constraint)",
        "Least squares, bounded",
        *_look("#e7a03c", (3.5, 2.5), 1.1, "<", 3.4),
        "bounded",
    ),
    "consistent": Entry(
        "Least squares, positive-definite inertia",
        "Least squares, consistent",
        *_look("#7a2a00", (1.5, 1.0), 1.1, ">", 3.4),
        "consistent",
    ),
    "true": Entry("True parameters", "True parameters", *_look("0.0", (1.0, 2.0), 1.1, "+", 4.0)),
    "appendix": Entry(
        "True parameters without back-EMF", "Without back-EMF", *_look("0.45", (1.0, 2.0), 1.1, "1", 4.0)
    ),
}

#: What Algorithm 1 is held against, with the method that solves it.
OPPONENTS: dict[str, str] = {name: entry.solver for name, entry in METHODS.items() if entry.solver}
